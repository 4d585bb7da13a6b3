"""Tests in the real Blender application, with Relume installed from its zip.

The environment variable BLENDER is the command that runs Blender (it may hold several words); without it these tests
are skipped. Nothing of the user's Blender is read or written: its settings and extensions live in a temporary folder.

Fixtures
--------
`extension_zip`
    The extension, built for this machine and this Blender.
`blender_app`
    Blender with that zip installed and enabled: `run(*arguments)` for any command line, `python(source)` for a script
    without a window.
`window(source, *arguments)`
    Runs a script in a real window and returns its pictures. The script defines `steps()`, a generator that runs in
    Blender with the window as its context: it yields a file name to have the window photographed as it then looks,
    or nothing to let Blender redraw; an exception fails the test, and so does a picture that shows nothing, or nothing
    new. `arguments` are Blender's, such as a .blend to open.

        def test_panel(window):
            pictures = window('''
                import bpy

                def steps():
                    bpy.context.scene.render.engine = "CYCLES"
                    yield "panel.png"
            ''')
            assert pictures["panel.png"].exists()
"""

import os
import shlex
import subprocess
import sys
import textwrap
from itertools import pairwise
from pathlib import Path

import OpenImageIO as oiio
import pytest

ROOT = Path(__file__).resolve().parents[2]
DRIVER = Path(__file__).with_name("driver.py")
PLATFORM = {"linux": "linux-x64", "darwin": "macos-arm64", "win32": "windows-x64"}[sys.platform]


class Blender:
    """A Blender application whose settings and extensions live in `resources`."""

    def __init__(self, command: list[str], resources: Path):
        self.command = command
        self.resources = resources

    def run(self, *arguments, command: list[str] | None = None, **environment) -> subprocess.CompletedProcess:
        """Run Blender to its end; the result holds `returncode` and, in `stdout`, all that was printed."""
        return subprocess.run(
            [*(command or self.command), *map(str, arguments)],
            cwd=ROOT,
            env=os.environ | {"BLENDER_USER_RESOURCES": str(self.resources)} | environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )

    def check(self, *arguments, **options) -> str:
        """The same, for a run that has to succeed: returns what was printed."""
        done = self.run(*arguments, **options)
        assert done.returncode == 0, done.stdout
        return done.stdout

    def python(self, source: str, *arguments) -> str:
        """Run a script without a window, after `arguments` (such as a .blend); an exception in it fails the test."""
        return self.check("-b", *arguments, "--python-exit-code", 1, "--python-expr", textwrap.dedent(source))

    def window_command(self) -> list[str]:
        """The command that runs a script in a window."""
        *tool, last = self.command
        if tool and Path(tool[-1]).name == "blender-app":  # brings a virtual screen, and takes the pictures from it
            return [*tool, "gui"]
        if sys.platform == "linux" and not {"DISPLAY", "WAYLAND_DISPLAY"} & os.environ.keys():
            pytest.skip("no display to open a window on")
        return [*tool, last, "--python"]


@pytest.fixture(scope="session")
def bare_blender(tmp_path_factory) -> Blender:
    """Blender without extensions."""
    if "BLENDER" not in os.environ:
        pytest.skip("BLENDER is not set to a command that runs Blender")
    return Blender(shlex.split(os.environ["BLENDER"]), tmp_path_factory.mktemp("blender"))


@pytest.fixture(scope="session")
def extension_zip(bare_blender, tmp_path_factory) -> Path:
    printed = bare_blender.python("import sys; print('runs Python %d.%d' % sys.version_info[:2])")
    python = printed.split("runs Python ")[1].split()[0]
    out = tmp_path_factory.mktemp("extension")
    build = ROOT / "tools/build_extension.py"
    subprocess.run([sys.executable, build, "--platform", PLATFORM, "--python", python, "--out", out], check=True)
    (built,) = out.glob("*.zip")
    return built


@pytest.fixture(scope="session")
def blender_app(bare_blender, extension_zip) -> Blender:
    bare_blender.check("--command", "extension", "install-file", "--repo", "user_default", "--enable", extension_zip)
    return bare_blender


@pytest.fixture
def window(blender_app, tmp_path):
    def run(source: str, *arguments) -> dict[str, Path]:
        script = tmp_path / "steps.py"
        script.write_text(textwrap.dedent(source))
        # The driver comes first: it is the value of the command's last word.
        blender_app.check(DRIVER, *arguments, command=blender_app.window_command(), WINDOW_STEPS=str(script))
        taken = sorted(tmp_path.glob("*.png"), key=lambda path: path.stat().st_mtime_ns)
        for path in taken:
            assert _contrast(path) > 0.05, f"{path.name} shows nothing"
        for before, after in pairwise(taken):
            assert before.read_bytes() != after.read_bytes(), f"{after.name} shows what {before.name} does"
        return {path.name: path for path in sorted(taken)}

    return run


def _contrast(picture: Path) -> float:
    """Standard deviation of the picture's values, 0..1: a black or plain window has none."""
    return max(oiio.ImageBufAlgo.computePixelStats(oiio.ImageBuf(str(picture))).stddev[:3])
