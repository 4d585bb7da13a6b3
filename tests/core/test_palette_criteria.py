"""Each criterion of a design against the quantity that it stands for, by finite differences and as [BMD] prints it."""

from dataclasses import replace

import numpy as np
import pytest

from relume.core.colour import differences
from relume.core.model import bases
from relume.core.palette import Cell, Constancy, Criteria, Difference, Entry, Palette, colours, criteria, solve
from relume.core.spectra import library
from relume.core.spectra.spectrum import WAVELENGTHS

from .conftest import tristimulus

SMALL = 1e-6
LIGHTS = tuple(Entry(name, library.illuminant(name)) for name in ("D65", "A"))
random = np.random.default_rng(4)


def reflectance(name):
    return Entry(name, library.reflectance(name))


@pytest.fixture
def design():
    """A designed reflectance under two lights, and a designed light on a given one."""
    return Palette(
        (*LIGHTS, Entry("lamp", designed=True)),
        (Entry("paint", library.reflectance("CES 30"), designed=True), reflectance("CES 70"), reflectance("CES 12")),
        (Cell(0, 0, (0.2, 0.25, 0.3)), Cell(0, 1, free="A"), Cell(1, 1, free="A"), Cell(1, 2, (0.1, 0.2, 0.1), 0.5)),
        differences=(Difference(0, 0, 1, least=20.0),),
        constancies=(Constancy(0, (0, 1)), Constancy(0, (0, 1), adapted=True)),
        criteria=Criteria("rgb", bases.fitted(7)),
    )


def blocks(palette, criterion, state=None):
    state = state or solve.start(palette)
    found = [b for b in criteria.system(palette, state, palette.designed()).blocks if b.criterion == criterion]
    assert found
    return found, state


def derivative(block, key, quantity, values):
    """That of `quantity` of a spectrum (81,), weighted as the block is, column by column, against the block's rows."""
    matrix = dict(block.parts)[key]
    for index in (3, 20, 40, 60):
        step = np.zeros(81)
        step[index] = SMALL
        slope = (quantity(values + step) - quantity(values - step)) / (2 * SMALL)
        np.testing.assert_allclose(matrix[:, index], slope, rtol=2e-5, atol=1e-9)


def test_target_rows_are_the_colour(design):
    for paint_or_lamp in blocks(design, "target")[0]:
        state = solve.start(design)
        (key, _), *_ = paint_or_lamp.parts
        if key == ("reflectance", 0):
            values, other = state.reflectances[0], state.lights[0]
            # Independently of the palette: XYZ by plain summation, white at Y = 1
            truth = colours.display_from_xyz() @ tristimulus(values, LIGHTS[0].spectrum.sampled())
            target, weight = (0.2, 0.25, 0.3), 1.0
        else:
            values, other = state.lights[2], state.reflectances[1]
            truth = colours.display_from_xyz() @ colours.xyz_weights() @ (values * other)
            target, weight = (0.1, 0.2, 0.1), 0.5
        wanted = weight / np.sqrt(3) * (truth - colours.display_from_xyz() @ target)
        np.testing.assert_allclose(paint_or_lamp.residual({key: values}), wanted, atol=1e-9)

        def colour(spectrum, other=other, weight=weight):
            return weight / np.sqrt(3) * colours.display_from_xyz() @ colours.xyz_weights() @ (spectrum * other)

        derivative(paint_or_lamp, key, colour, values)


@pytest.mark.parametrize("model", [bases.fitted(6), bases.fitted(9), bases.sharpened(7), bases.block(9)], ids=str)
def test_model_rows_are_the_models_colour(design, model):
    design = replace(design, criteria=Criteria("xyz", model, use_model=True, model_error=0.0))
    (paint, lamp), state = blocks(design, "target")
    values = state.reflectances[0]

    def colour(spectrum):
        return model.relight(LIGHTS[0].spectrum) @ model.coefficients(spectrum) / np.sqrt(3)

    residual = colour(values) - np.array([0.2, 0.25, 0.3]) / np.sqrt(3)
    np.testing.assert_allclose(paint.residual({("reflectance", 0): values}), residual, atol=1e-9)
    derivative(paint, ("reflectance", 0), colour, values)
    # Of a designed light the value is exact where it is now; its slope is that of rebuilt spectra
    seen = model.relight(np.ones(81)) @ model.coefficients(library.reflectance("CES 70"))
    residual = 0.5 / np.sqrt(3) * (seen - [0.1, 0.2, 0.1])
    np.testing.assert_allclose(lamp.residual({("light", 2): state.lights[2]}), residual, atol=1e-9)
    rebuilt = model.reconstruct(model.coefficients(library.reflectance("CES 70")))
    derivative(lamp, ("light", 2), lambda e: 0.5 / np.sqrt(3) * colours.xyz_weights() @ (e * rebuilt), state.lights[2])


def test_model_error_rows_are_the_difference_of_both_colours(design):
    model, state = design.criteria.model, solve.start(design)
    block = blocks(design, "model error")[0][0]

    def error(spectrum):
        full = tristimulus(spectrum, LIGHTS[0].spectrum.sampled())
        reduced = model.relight(LIGHTS[0].spectrum) @ model.coefficients(spectrum)
        return 0.1 / np.sqrt(3) * colours.display_from_xyz() @ (full - reduced)

    values = state.reflectances[0]
    np.testing.assert_allclose(block.residual({("reflectance", 0): values}), error(values), atol=1e-9)
    derivative(block, ("reflectance", 0), error, values)


def test_smoothness_is_normalised_as_printed(design):
    rows = criteria.smoothness_rows()
    scale = 1 / (np.sqrt(81) * np.sqrt(6))
    assert rows[40, 39:42] == pytest.approx(np.array([-1, 2, -1]) * scale)
    assert rows[0, :3] == pytest.approx(np.array([2, -1, 0]) * scale)
    assert np.array_equal(rows, rows.T) and np.count_nonzero(rows) == 3 * 81 - 2
    block = blocks(design, "smoothness")[0][0]
    curve = WAVELENGTHS**2 * 1e-4
    inside = block.residual({block.own: curve})[1:-1]
    np.testing.assert_allclose(inside, -0.001 * scale * 2 * 25e-4, atol=1e-12)  # the second difference of a parabola


def test_free_colours_are_unknowns(design):
    """[BMD] eq. 24: minus the free colour, plus the colour of what has it."""
    (paint, given), state = blocks(design, "free colour")
    rgb = colours.display_from_xyz() @ state.colours()[0, 1]
    x = {("reflectance", 0): state.reflectances[0], ("free", "A"): rgb}
    np.testing.assert_allclose(paint.residual(x), 0, atol=1e-12)
    assert np.array_equal(dict(paint.parts)["free", "A"], -np.eye(3))
    assert given.hard and paint.hard
    np.testing.assert_allclose(
        given.residual({("free", "A"): np.zeros(3)}), colours.display_from_xyz() @ state.colours()[1, 1], atol=1e-12
    )


def test_constancy_is_one_colour_under_several_lights(design):
    found, state = blocks(design, "constancy")
    plain, adapted = found[:2], found[2:]
    grey = np.full(81, 0.5)
    whites = state.whites()
    for light, block in enumerate(plain):
        common = dict.fromkeys([("constancy", 0)], 0.5 * whites[light])
        np.testing.assert_allclose(block.residual({("reflectance", 0): grey} | common), 0, atol=1e-12)
    # A grey stays grey for an eye that adapts, so one colour fits both lights
    d65 = 0.5 * colours.xyz_from_rgb((1, 1, 1))
    for block in adapted:
        np.testing.assert_allclose(block.residual({("reflectance", 0): grey, ("constancy", 1): d65}), 0, atol=1e-9)


def test_differences_are_in_ciede2000():
    near = replace(reflectance("CES 30"), name="near", designed=True)
    near = replace(near, spectrum=replace(near.spectrum, values=near.spectrum.values * 1.02))
    palette = Palette(LIGHTS, (reflectance("CES 30"), near), differences=(Difference(0, 0, 1, most=0.0),))
    (block,), state = blocks(palette, "difference")
    xyz = state.colours()[:, 0]
    wanted = differences.delta_E_2000(xyz[0], xyz[1], state.whites()[0])
    length = np.linalg.norm(block.residual({("reflectance", 1): state.reflectances[1]}))
    assert 0.3 < wanted < 3
    assert length == pytest.approx(0.01 / np.sqrt(3) * wanted, rel=0.02)


def test_perceptual_rows_are_ciede2000_of_small_errors(design):
    palette = replace(design, criteria=Criteria("perceptual"))
    block, state = blocks(palette, "target")[0][0], solve.start(palette)
    target = np.array([0.2, 0.25, 0.3])
    for _ in range(5):
        # Any spectrum whose colour is near the target
        change = colours.xyz_weights() * state.lights[0]
        near = np.linalg.lstsq(change, target + 1e-4 * random.standard_normal(3), rcond=None)[0]
        length = np.linalg.norm(block.residual({("reflectance", 0): near}))
        true = differences.delta_E_2000(target, change @ near, state.whites()[0])
        assert length == pytest.approx(0.01 / np.sqrt(3) * true, rel=0.02)
