"""Each script of examples/ runs as its first lines say, and does what they say."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from relume.core.model import bases
from relume.core.picture import coefficients
from relume.core.spectra import files, library

EXAMPLES = Path(__file__).parents[1] / "examples"
DOCS = EXAMPLES.parent / "docs"


@pytest.fixture
def shot(tmp_path):
    """A folder with one small coefficient EXR."""
    image = coefficients.CoefficientImage(
        model=bases.fitted(6),
        groups={name: np.full((2, 3, 6), 0.2, np.float32) for name in ("key", "fill")},
        illuminants={"key": library.illuminant("A"), "fill": library.illuminant("D65")},
        alpha=np.ones((2, 3), np.float32),
    )
    coefficients.write(tmp_path / "shot.exr", image, np.zeros((2, 3, 3)))
    return tmp_path


def run(name: str, *arguments) -> str:
    command = [sys.executable, str(EXAMPLES / f"{name}.py"), *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=EXAMPLES.parent)
    assert done.returncode == 0, done.stderr
    return done.stdout


def shown(name: str) -> str:
    """What docs/examples.md shows of a script's output."""
    return (DOCS / f"examples/{name}.txt").read_text(encoding="utf-8")


@pytest.fixture
def tube(tmp_path):
    """The file of docs/measurements.md, as one who reads it saves it."""
    page = (DOCS / "measurements.md").read_text(encoding="utf-8")
    (tmp_path / "tube.csv").write_text(re.search(r":caption: tube.csv\n(.*?)```", page, re.DOTALL)[1])
    return tmp_path / "tube.csv"


def test_relight_an_exr(shot):
    run("relight_an_exr", shot / "shot.exr", shot / "evening.exr")
    red, green, blue = coefficients.read_rgb(shot / "evening.exr")[0, 0]
    assert red > green > blue > 0, "half sodium, half daylight"


def test_fit_a_scene_model():
    printed = run("fit_a_scene_model")
    general, own = (float(line.split()[-1]) for line in printed.splitlines())
    assert own < general and printed == shown("fit_a_scene_model")


def test_see_through_a_camera():
    printed = run("see_through_a_camera")
    eye, camera = (line[19:].split(" and ") for line in printed.splitlines())
    assert eye[0] == eye[1] and camera[0] != camera[1] and printed == shown("see_through_a_camera")


def test_measure_a_lamp(tube, tmp_path):
    run("measure_a_lamp", tube, tmp_path / "paints.csv")
    written = (tmp_path / "paints.csv").read_text(encoding="utf-8")
    assert len(written.splitlines()) == 25 and written.startswith(shown("measure_a_lamp"))


def test_which_lamp_is_this(tube, tmp_path):
    assert run("which_lamp_is_this", tube) == shown("which_lamp_is_this")
    files.write(tmp_path / "lamp.csv", library.illuminant("HP1"))
    assert run("which_lamp_is_this", tmp_path / "lamp.csv").splitlines()[1].split() == ["0.00", "HP1"]


def test_relight_a_batch(shot):
    assert run("relight_a_batch", shot, shot / "out", "D65", "FL2") == shown("relight_a_batch")
    under = [np.load(shot / f"out/shot_{name}.npy")[0, 0] for name in ("D65", "FL2")]
    assert np.ptp(under[0]) <= 1 and np.ptp(under[1]) > 5, "white in daylight, not so under a fluorescent lamp"


def test_every_example_is_run():
    tested = {name.removeprefix("test_") for name in globals() if name.startswith("test_")}
    assert {path.stem for path in EXAMPLES.glob("*.py")} <= tested
