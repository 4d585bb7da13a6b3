"""What pyproject.toml cannot say: the version stands in the extension's manifest, the packages are what is there."""

import tomllib
from pathlib import Path

from setuptools import find_packages, setup

ROOT = Path(__file__).parent
PARTS = [part + below for part in ("core", "studies", "addon", "assets", "benchmarks") for below in ("", ".*")]

setup(
    version=tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))["version"],
    packages=["relume", *(f"relume.{name}" for name in find_packages(ROOT, include=PARTS))],
)
