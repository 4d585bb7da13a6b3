"""Designs as TOML, the example designs, the command, and the worked example of [BMD] step by step."""

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from relume.core import palette
from relume.core.palette import PaletteError, colours
from relume.core.picture import coefficients
from relume.core.spectra import files
from relume.studies import palette as command

DESIGNS = Path(__file__).resolve().parents[2] / "assets/palettes"
EXAMPLES = sorted(DESIGNS.glob("*.toml"))

SMALL = """
version = 1
[[lights]]
spectrum = "D65"
[[reflectances]]
name = "paint"
designed = true
[[cells]]
reflectance = "paint"
light = "D65"
colour = "#808080"
"""


@cache
def solved(name):
    """An example, designed once for all tests: its Solution, and the report of it."""
    solution = palette.create(palette.read(DESIGNS / f"{name}.toml"))
    return solution, palette.report(solution)


def roughness(solution):
    values = solution.state.reflectances[0]
    return np.abs(np.diff(values, n=2)).mean()


def test_the_papers_example_step_by_step():
    """[BMD] Figs. 2 to 5: what each criterion does to one brown material under daylight and tungsten."""
    steps = [solved(name) for name in ("1_colours", "2_model_error", "3_smooth", "4_unbounded")]
    of_models = [max(cell.model_error for cell in report.cells) for _, report in steps]
    of_targets = [max(cell.error for cell in report.cells) for _, report in steps]
    assert max(of_targets) < 0.05, "every step has the colours that are asked for"
    assert of_models[0] > 3, "Fig. 2: the box shows two colours, full and model"
    assert max(of_models[1:]) < 1, "Fig. 3: it shows one"
    assert roughness(steps[2][0]) <= roughness(steps[1][0]) < 0.5, "Fig. 4: smoother"
    bounded, unbounded = steps[2][0].state.reflectances, steps[3][0].state.reflectances
    assert bounded.min() >= 0 and bounded.max() <= 1
    assert unbounded.min() < 0, "Fig. 5: without positivity it is negative somewhere"
    seen = [solution.state.colours()[0] for solution, _ in steps[2:]]
    np.testing.assert_allclose(seen[0], seen[1], atol=2e-4)  # and the colours hardly change


def test_equation_23():
    """Surfaces i and j of one colour under light a, and i of a known colour under light b; as eq. 24 stacks it."""
    table = {
        "criteria": {"space": "rgb"},
        "lights": [{"spectrum": "D65"}, {"spectrum": "A"}],
        "reflectances": [{"name": "i", "designed": True}, {"name": "j", "designed": True}],
        "cells": [
            {"reflectance": "i", "light": "D65", "free": "a"},
            {"reflectance": "j", "light": "D65", "free": "a"},
            {"reflectance": "i", "light": "A", "rgb": [0.4, 0.2, 0.05]},
            {"reflectance": "j", "light": "A", "rgb": [0.3, 0.22, 0.06]},
        ],
    }
    solution = palette.create(palette.from_dict(table))
    rgb = solution.state.colours() @ colours.display_from_xyz().T
    np.testing.assert_allclose(rgb[0, 0], rgb[1, 0], atol=1e-6)
    np.testing.assert_allclose(rgb[0, 0], solution.free["a"], atol=1e-6)
    np.testing.assert_allclose(rgb[:, 1], [[0.4, 0.2, 0.05], [0.3, 0.22, 0.06]], atol=1e-4)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_meet_their_demands(path):
    solution, report = solved(path.stem)
    assert solution.converged and not solution.slack
    assert max(cell.error for cell in report.cells) < 0.1
    assert all(met for *_, met in report.differences)
    assert all(largest < 1 for _, largest in report.constancies)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_a_design_survives_as_json(path):
    first = palette.read(path)
    again = palette.from_dict(json.loads(json.dumps(palette.to_dict(first))))
    assert palette.to_dict(again) == palette.to_dict(first)
    np.testing.assert_array_equal(palette.create(again).state.reflectances, solved(path.stem)[0].state.reflectances)


def test_all_that_a_design_can_say(tmp_path):
    (tmp_path / "cloth.csv").write_text("nm,cloth\n400,0.1\n500,0.4\n600,0.8\n700,0.9\n")
    (tmp_path / "all.toml").write_text(
        """
version = 1
title = "All"
[criteria]
space = "xyz"
channels = 9
use_model = true
model_error = 0.2
smoothness = 0.01
bounded = true
reflectance_bounds = [0.02, 0.9]
light_bounds = [0.0, 20.0]
[[lights]]
spectrum = "FL11"
luminance = 0.5
[[lights]]
name = "glow"
planckian = 2700
[[lights]]
name = "pink"
colour = "#ffc0c0"
[[lights]]
name = "lamp"
designed = true
bounds = [0, 5]
[[reflectances]]
file = "cloth.csv"
[[reflectances]]
name = "blue"
colour = "#3050a0"
[[reflectances]]
name = "made"
designed = true
near = "CES 10"
near_weight = 0.01
span = "ces"
span_weight = 0.01
[[cells]]
reflectance = "made"
light = "glow"
xyz = [0.2, 0.2, 0.05]
weight = 2
[[cells]]
reflectance = "made"
light = "pink"
free = "A"
[[cells]]
reflectance = "cloth"
light = "lamp"
rgb = [0.4, 0.3, 0.2]
[[free_colours]]
name = "A"
lower = [0.1, 0.1, 0.1]
[[differences]]
light = "glow"
between = ["made", "blue"]
least = 5
[[constancies]]
reflectance = "made"
lights = ["glow", "FL11"]
adapted = true
weight = 0.1
"""
    )
    design = palette.read(tmp_path / "all.toml")
    assert [entry.name for entry in design.lights] == ["FL11", "glow", "pink", "lamp"]
    assert [entry.name for entry in design.reflectances] == ["cloth", "blue", "made"]
    whites = design.sampled("light") @ colours.xyz_weights()[1]
    assert whites[:2] == pytest.approx([0.5, 1.0])
    blue = colours.xyz_weights() * (design.sampled("light")[2] / design.sampled("light")[2].max())
    assert np.isfinite(blue).all()
    report = palette.report(palette.create(design))
    assert len(report.cells) == 3 and all(met for *_, met in report.differences)


MISTAKES = {
    "no such file": None,
    "not TOML": "version = ",
    "of version 7": SMALL.replace("version = 1", "version = 7"),
    "no 'lightz' is known": SMALL.replace("[[lights]]", "[[lightz]]"),
    "no 'color' is known": SMALL.replace("colour =", "color ="),
    "cells 1: no reflectance is named 'pain'": SMALL.replace('reflectance = "paint"', 'reflectance = "pain"'),
    "cells 1: 'light' is missing": SMALL.replace('light = "D65"\n', ""),
    "cells 1: '#80808' is not a colour": SMALL.replace("#808080", "#80808"),
    "no illuminant named 'D56'": SMALL.replace('spectrum = "D65"', 'spectrum = "D56"'),
    "begin each with": SMALL.replace("[[cells]]", "[cells]"),
    "'weight' is a number": SMALL + 'weight = "much"\n',
    "lights 1: .*no such file": SMALL.replace('spectrum = "D65"', 'file = "nowhere.csv"'),
    "one says what it is": SMALL.replace('spectrum = "D65"', 'spectrum = "D65"\nplanckian = 3000'),
    "no model 'best'": SMALL + '[criteria]\nmodel = "best"\nchannels = 9\n',
}


@pytest.mark.parametrize("words", MISTAKES)
def test_mistakes_in_a_file_are_told_in_one_sentence(tmp_path, words):
    path = tmp_path / "design.toml"
    if MISTAKES[words] is not None:
        path.write_text(MISTAKES[words])
    with pytest.raises(PaletteError, match=words) as caught:
        palette.read(path)
    assert str(caught.value).startswith(str(path)) and "\n" not in str(caught.value)


def shown(path, colour):
    """The part of a picture that has a colour, in sRGB 0..255."""
    return (np.abs(255 * coefficients.read_rgb(path) - colour).max(axis=-1) < 3).mean()


def test_the_command(tmp_path, capsys):
    assert command.main([str(DESIGNS / "appears.toml"), "--out", str(tmp_path / "out")]) == 0
    printed = capsys.readouterr().out
    assert "'writing' under 'lamp'" in printed and "| A | #" in printed
    (lamp,) = files.read(tmp_path / "out/lights.csv", "illuminant")
    assert lamp.name == "lamp" and lamp.values.min() >= 0
    assert [one.name for one in files.read(tmp_path / "out/reflectances.csv")] == ["wall", "writing"]
    assert shown(tmp_path / "out/matrix.png", (0xD0, 0xA0, 0x50)) > 0.05, "the writing as it is wanted under the lamp"
    assert shown(tmp_path / "out/curves.png", (0xD6, 0x27, 0x28)) > 0.001, "the fourth curve, that of the writing"
    assert command.main([str(tmp_path / "nowhere.toml"), "--out", str(tmp_path / "none")]) == 1
    assert capsys.readouterr().err.count("\n") == 1
    assert not (tmp_path / "none").exists()


def test_the_matrix_shows_real_colours():
    solution, _ = solved("1_colours")
    wanted, full, model, lights, reflectances = palette.matrix_colours(solution.palette)
    assert np.rint(255 * wanted[0, 0]).astype(int).tolist() == [0x8A, 0x64, 0x50]
    np.testing.assert_allclose(full, wanted, atol=2e-3)
    assert np.abs(model - wanted).max() > 0.01
    np.testing.assert_allclose(lights[0], 1, atol=1e-6)  # daylight on white
    assert lights[1, 2] < lights[1, 0] and reflectances.shape == (1, 3)
