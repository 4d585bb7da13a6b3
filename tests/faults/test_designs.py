"""Designs of palettes, damaged by chance: each is solved within its bounds, or refused in one sentence."""

import random
from pathlib import Path

import numpy as np
import pytest

from relume.core import palette
from relume.core.palette import PaletteError

from . import outcome

DESIGNS = sorted((Path(__file__).resolve().parents[2] / "assets/palettes").glob("*.toml"))
VALUES = ["nan", "inf", "-1", "0", "1e300", "-1e-300", '""', '"D65"', '"A"', "[]", "[1, 2]", "[0.1, 0.2, nan]", "true"]
VALUES += ['"#ffffff"', "{}", "2", "0.5", '"first"', "1e-9", "[-1, 2]", "[0, 0]", "9", "1000000", '"ces"', "1979-05-27"]
KEYS = [
    "bounds",
    "near",
    "near_weight",
    "span",
    "luminance",
    "planckian",
    "weight",
    "free",
    "rgb",
    "xyz",
    "least",
    "most",
]
KEYS += ["channels", "use_model", "smoothness", "space", "model", "designed", "adapted", "lights", "between", "name"]


def damaged(chance: random.Random) -> str:
    """The text of an example with a few lines changed, dropped, doubled, moved or added."""
    lines = chance.choice(DESIGNS).read_text(encoding="utf-8").splitlines()
    for _ in range(chance.choice([1, 1, 1, 2, 3])):
        at = chance.randrange(len(lines))
        what = chance.randrange(6)
        if what == 0:
            del lines[at]
        elif what == 1:
            lines.insert(at, lines[chance.randrange(len(lines))])
        elif what == 2:
            lines.insert(at, f"{chance.choice(KEYS)} = {chance.choice(VALUES)}")
        elif what == 3:
            a = chance.randrange(len(lines))
            lines[at], lines[a] = lines[a], lines[at]
        elif "=" in lines[at]:
            key = lines[at].partition("=")[0]
            lines[at] = f"{key}= {chance.choice(VALUES)}"
    return "\n".join(lines)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("seed", outcome.seeds(60, 1000))
def test_damaged_designs(seed, tmp_path, settle):
    path = tmp_path / "design.toml"
    path.write_text(damaged(random.Random(seed)), encoding="utf-8")
    try:
        solution = palette.create(palette.read(path))
    except PaletteError as error:
        assert str(error) and "\n" not in str(error)
        settle(outcome.SAID)
        return
    report, made = palette.report(solution), solution.palette
    for kind, index in made.designed():
        values = (solution.state.lights if kind == "light" else solution.state.reflectances)[index]
        low, high = made.bounds(kind, made.entry(kind, index))
        assert np.isfinite(values).all() and values.min() >= low - 1e-9 and values.max() <= high + 1e-9
    assert all(np.isfinite(cell.error) for cell in report.cells)
    settle(outcome.RIGHT)
