"""Designs solved: random ones by the hundred, each kind of demand, and what cannot be had."""

import os
import time
from dataclasses import replace

import numpy as np
import pytest

from relume.core import Spectrum, palette
from relume.core.colour import differences
from relume.core.model import bases
from relume.core.palette import (
    Cell,
    Constancy,
    Criteria,
    Difference,
    Entry,
    FreeColour,
    Palette,
    PaletteError,
    colours,
    criteria,
    programme,
    solve,
)
from relume.core.spectra import library
from relume.core.spectra.spectrum import WAVELENGTHS

SCALE = float(os.environ.get("RELUME_TORTURE", 1))
NAMES = ("D65", "A", "FL11", "LED-B1", "D50", "HP1")
LIGHTS = tuple(Entry(name, library.illuminant(name)) for name in NAMES)


def designed(count):
    return tuple(Entry(f"paint {index}", designed=True) for index in range(count))


def random_design(seed):
    """Up to twelve spectra of random colours, free colours, weights, bounds, models and given reflectances."""
    random = np.random.default_rng(seed)
    lights = tuple(LIGHTS[index] for index in random.choice(len(LIGHTS), random.integers(1, 4), replace=False))
    makes_light = random.random() < 0.3
    rows = designed(random.integers(1, 12 if makes_light else 13))
    given = library.reflectances("ces")
    if makes_light:
        lights = (*lights, Entry("lamp", designed=True))
        rows = (*rows, *(Entry(given[i].name, given[i]) for i in random.choice(99, 2, replace=False)))
    cells = []
    for row, entry in enumerate(rows):
        for column, light in enumerate(lights):
            if (entry.designed and light.designed) or random.random() < 0.3:
                continue
            if random.random() < 0.3:
                cells.append(Cell(row, column, free=str(random.choice(["A", "B"]))))
            else:
                # Of a paint that there is, or of anything at all
                real = colours.xyz_weights() @ given[random.integers(99)].sampled()
                target = real if random.random() < 0.5 else random.uniform(0.02, 0.9, 3)
                cells.append(Cell(row, column, tuple(target), float(random.choice([0.1, 1.0, 10.0]))))
    bounded = (FreeColour("A", (0.1, 0.1, 0.1), (0.6, 0.6, 0.6)),) if random.random() < 0.5 else ()
    model = [None, bases.fitted(6), bases.fitted(9)][random.integers(3)]
    settings = Criteria(
        str(random.choice(["rgb", "xyz", "perceptual"])),
        model,
        use_model=model is not None and bool(random.random() < 0.5),
        smoothness=float(random.choice([0.0, 0.001, 0.1])),
        bounded=bool(random.random() < 0.8),
    )
    return Palette(lights, rows, tuple(cells), bounded, criteria=settings)


def check_random(seed):
    design = random_design(seed)
    if not design.meetings():
        with pytest.raises(PaletteError, match="no targets"):
            palette.create(design)
        return 0.0
    began = time.perf_counter()
    try:
        solution = palette.create(design)
    except PaletteError as error:
        assert "grows without end" in str(error) and not design.criteria.bounded, seed
        return time.perf_counter() - began
    took = time.perf_counter() - began
    for kind, index in design.designed():
        values = (solution.state.lights if kind == "light" else solution.state.reflectances)[index]
        low, high = design.bounds(kind, design.entry(kind, index))
        assert values.min() >= low - 1e-9 and values.max() <= high + 1e-9, seed
    if solution.convex:
        assert solution.kkt < 1e-6, (seed, solution.kkt)
    xyz = solution.state.colours()
    softened = {words.split(":")[0] for words in solution.slack}
    for cell in design.cells:
        if cell.free and f"free colour {cell.free}" not in softened and not design.criteria.use_model:
            seen = colours.display_from_xyz() @ xyz[cell.reflectance, cell.light]
            np.testing.assert_allclose(seen, solution.free[cell.free], atol=1e-6, err_msg=str(seed))
    for one in design.free_colours:
        if one.name in solution.free:
            value = solution.free[one.name]
            assert (value >= np.array(one.lower) - 1e-9).all() and (value <= np.array(one.upper) + 1e-9).all(), seed
    return took


def test_random_designs():
    for seed in range(40):
        check_random(seed)


@pytest.mark.torture
def test_five_hundred_random_designs():
    took = [check_random(1000 + seed) for seed in range(max(int(500 * SCALE), 1))]
    print(f"{len(took)} designs: median {np.median(took):.2f} s, slowest {max(took):.2f} s")


@pytest.mark.parametrize("smoothness", [0.0, 0.001])
def test_without_bounds_it_is_the_pseudo_inverse(smoothness):
    cells = tuple(Cell(row, column, (0.2 + 0.1 * row, 0.3, 0.1 + 0.1 * column)) for row in (0, 1) for column in (0, 1))
    design = Palette(LIGHTS[:2], designed(2), cells, criteria=Criteria("rgb", smoothness=smoothness, bounded=False))
    equations = criteria.system(design, solve.start(design), design.designed())
    keys = list(equations.sizes)
    stacked = np.concatenate(
        [
            np.concatenate([dict(b.parts).get(key, np.zeros((b.right.size, 81))) for key in keys], axis=1)
            for b in equations.blocks
        ]
    )
    least_norm = np.linalg.pinv(stacked, rcond=1e-13) @ np.concatenate([b.right for b in equations.blocks])
    found = programme.unbounded(equations)
    scale = np.abs(least_norm).max()
    np.testing.assert_allclose(np.concatenate([found[key] for key in keys]), least_norm, atol=1e-4 * scale)


def test_what_lies_within_its_bounds_is_not_touched():
    design = Palette(LIGHTS[:1], designed(1), (Cell(0, 0, (0.3, 0.3, 0.3)),))
    free = replace(design, criteria=Criteria(bounded=False))
    a, b = (palette.create(one).state.reflectances for one in (design, free))
    assert a.min() > 0 and a.max() < 1
    np.testing.assert_allclose(a, b, atol=1e-9)


def test_metamers_that_part():
    design = Palette(
        LIGHTS[:2],
        designed(3),
        (Cell(0, 0, (0.2, 0.2, 0.22)),),
        differences=tuple(
            one
            for a, b in ((0, 1), (0, 2), (1, 2))
            for one in (Difference(0, a, b, most=0.0), Difference(1, a, b, least=8.0))
        ),
    )
    solution = palette.create(design)
    assert solution.converged and not solution.convex
    xyz, whites = solution.state.colours(), solution.state.whites()
    for a, b in ((0, 1), (0, 2), (1, 2)):
        assert differences.delta_E_2000(xyz[a, 0], xyz[b, 0], whites[0]) < 0.05
        assert differences.delta_E_2000(xyz[a, 1], xyz[b, 1], whites[1]) > 7.9
    assert all(met for *_, met in palette.report(solution).differences)


def test_a_colour_that_stays():
    lights, cell = LIGHTS[:3], (Cell(0, 0, (0.15, 0.18, 0.22)),)

    def largest(constancy, **criteria):
        solution = palette.create(Palette(lights, designed(1), cell, (), (), (constancy,), Criteria(**criteria)))
        report = palette.report(solution)
        assert report.constancies[0][0] == "'paint 0' under 'D65', 'A', 'FL11'"
        return report.constancies[0][1], report.cells[0].error

    # Z is all in the blue, where A is weaker than D65 at every wavelength: no surface but a black one makes up for that
    assert max(largest(Constancy(0, (0, 1, 2)))) > 3
    assert max(largest(Constancy(0, (0, 1, 2)), bounded=False)) < 0.1
    # For an eye that adapts it need not
    assert max(largest(Constancy(0, (0, 1, 2), adapted=True))) < 1


def test_a_black_that_appears_under_another_light():
    design = Palette(LIGHTS[:2], designed(1), (Cell(0, 0, (0, 0, 0)), Cell(0, 1, (0.5, 0.5, 0.2))))
    seen = palette.create(replace(design, criteria=Criteria(bounded=False))).state
    np.testing.assert_allclose(seen.colours()[0], [[0, 0, 0], [0.5, 0.5, 0.2]], atol=1e-5)
    assert seen.reflectances.min() < 0, "a metameric black that is seen elsewhere is negative somewhere"
    report = palette.report(palette.create(design))
    assert any("bounds that stand in the way" in remark for remark in report.remarks)


def test_lights_and_reflectances_in_turn():
    lamp = Entry("lamp", designed=True)
    cells = (Cell(0, 0, (0.2, 0.2, 0.2)), Cell(0, 1, (0.3, 0.2, 0.1)), Cell(1, 1, (0.1, 0.2, 0.3)))
    solution = palette.create(Palette((LIGHTS[0], lamp), designed(2), cells))
    assert not solution.convex and solution.converged
    assert all(cell.error < 0.1 for cell in palette.report(solution).cells)
    assert "converged" in palette.report(solution).remarks[0]


@pytest.mark.parametrize("use_model", [False, True])
def test_a_light_for_the_models_colours(use_model):
    model = bases.fitted(6)
    lamp, row = Entry("lamp", designed=True), Entry("red", library.reflectance("ColorChecker: red"))
    design = Palette((lamp,), (row,), (Cell(0, 0, (0.2, 0.13, 0.07)),), criteria=Criteria("rgb", model, use_model, 0.0))
    solution = palette.create(design)
    light = solution.palette.lights[0].spectrum
    assert light.kind == "illuminant" and light.values.min() >= 0
    full = colours.xyz_weights() @ (light.values * row.spectrum.sampled())
    reduced = (colours.xyz_weights()[1] @ light.values) * model.relight(light) @ model.coefficients(row.spectrum)
    np.testing.assert_allclose(reduced if use_model else full, [0.2, 0.13, 0.07], atol=2e-4)


def test_near_to_a_real_reflectance():
    real = library.reflectance("CES 30")
    cell = (Cell(0, 0, (0.3, 0.32, 0.2)),)
    distance = []
    for weight in (0.0, 0.01, 1.0):
        row = Entry("paint", designed=True, near=real, near_weight=weight)
        made = palette.create(Palette(LIGHTS[:1], (row,), cell)).state.reflectances[0]
        distance.append(np.abs(made - real.sampled()).mean())
    assert distance[0] > distance[1] > distance[2]
    row = Entry("paint", designed=True, span="ces", span_weight=1.0)
    made = palette.create(Palette(LIGHTS[:1], (row,), cell)).state.reflectances[0]
    basis = criteria._components("ces")
    assert np.abs(made - basis @ basis.T @ made).max() < 1e-3


def test_what_cannot_be_had_is_answered_with_what_can():
    green, cyan = (0.1, 0.6, 0.05), (0.05, 0.1, 0.3)
    report = palette.report(palette.create(Palette(LIGHTS[:2], designed(1), (Cell(0, 0, green), Cell(0, 1, cyan)))))
    first = report.cells[0]
    assert first.error > first.nearest_error > 1
    assert any("alone it could come to #" in remark for remark in report.remarks)
    assert sum(report.shares.values()) == pytest.approx(1)


def test_free_colours_that_cannot_be_equal():
    given = tuple(Entry(name, library.reflectance(name)) for name in ("CES 10", "CES 50"))
    design = Palette(LIGHTS[:1], (*given, *designed(1)), tuple(Cell(row, 0, free="A") for row in range(3)))
    solution = palette.create(design)
    assert any("'CES 10'" in words for words in solution.slack)
    assert any("cannot be equal" in remark for remark in palette.report(solution).remarks)


def test_a_lamp_without_bounds_stays_within_reason():
    """Only a free colour has bounds here, and what is given cannot have it: the programme has nothing to hold it."""
    solution = palette.create(random_design(1220))
    assert "'CES 29' under 'HP1'" in solution.slack[0]
    assert np.abs(solution.state.lights[-1]).max() < 1e3


ROW, LIGHT = Entry("paint", designed=True), LIGHTS[0]
BAD = {
    "nothing is to be designed": lambda: palette.create(
        Palette((LIGHT,), (Entry("x", library.reflectance("CES 01")),), (Cell(0, 0, (0.1, 0.1, 0.1)),))
    ),
    "no targets": lambda: palette.create(Palette((LIGHT,), (ROW,))),
    "no value is at least 0.8 and at most 0.2": lambda: Palette((LIGHT,), (replace(ROW, bounds=(0.8, 0.2)),)),
    "lower bounds": lambda: Palette((LIGHT,), (ROW,), free_colours=(FreeColour("A", (1, 1, 1), (0, 0, 0)),)),
    "no power where the eye sees": lambda: Palette(
        (Entry("ir", Spectrum([800, 900, 1000], [1, 1, 1], "ir", "illuminant")),), (ROW,)
    ),
    "3 samples between": lambda: Palette((LIGHT,), (Entry("x", Spectrum([400, 500, 600], [0.1, 0.2, 0.3])),)),
    "is neither given nor designed": lambda: Palette((Entry("lamp"),), (ROW,)),
    "two reflectances are named": lambda: Palette((LIGHT,), (ROW, ROW)),
    "which are not there": lambda: Palette((LIGHT,), (ROW,), (Cell(1, 0, (0, 0, 0)),)),
    "is given twice": lambda: Palette((LIGHT,), (ROW,), (Cell(0, 0, (0, 0, 0)), Cell(0, 0, free="A"))),
    "and not both": lambda: Palette((LIGHT,), (ROW,), (Cell(0, 0, (0, 0, 0), free="A"),)),
    "three finite numbers": lambda: Palette((LIGHT,), (ROW,), (Cell(0, 0, (0, np.nan, 0)),)),
    "the weight must be from 0": lambda: Palette((LIGHT,), (ROW,), (Cell(0, 0, (0, 0, 0), -1.0),)),
    "exclude each other": lambda: Palette((LIGHT,), designed(2), differences=(Difference(0, 0, 1, 5.0, 1.0),)),
    "does not differ from itself": lambda: Palette((LIGHT,), (ROW,), differences=(Difference(0, 0, 0, 1.0),)),
    "two lights or more": lambda: Palette((LIGHT,), (ROW,), constancies=(Constancy(0, (0,)),)),
    "are compared in": lambda: Palette((LIGHT,), (ROW,), criteria=Criteria("lab")),
    "needs that model": lambda: Palette((LIGHT,), (ROW,), criteria=Criteria(use_model=True)),
    "below black needs": lambda: palette.create(Palette((LIGHT,), (ROW,), (Cell(0, 0, (-0.1, 0, 0)),))),
}


@pytest.mark.parametrize("words", BAD)
def test_designs_that_cannot_mean_anything(words):
    with pytest.raises(PaletteError, match=words) as caught:
        BAD[words]()
    assert "\n" not in str(caught.value)


def test_solved_on_the_working_wavelengths():
    made = palette.create(Palette((LIGHT,), (ROW,), (Cell(0, 0, (0.2, 0.2, 0.2)),))).palette.reflectances[0].spectrum
    assert np.array_equal(made.wavelengths, WAVELENGTHS) and made.name == "paint" and made.source == "designed"
