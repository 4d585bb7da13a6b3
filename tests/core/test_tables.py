"""The tables of Drew & Finlayson, made again, and the command that prints them."""

import os
import subprocess
import sys

import numpy as np
import pytest

from relume.core import Spectrum
from relume.core.colour import differences
from relume.core.model import bases, sharpening
from relume.core.model.relight import power_weights
from relume.core.spectra import library
from relume.core.spectra.spectrum import WAVELENGTHS
from relume.studies import levers, multispectral, paper_tables, printed, tables


@pytest.fixture(scope="module")
def vrhel_spectra(vrhel):
    return [Spectrum(WAVELENGTHS, values) for values in vrhel]


# Within what the rows are of the printed ones; where wider, docs/models.md says by how much.
@pytest.mark.parametrize(
    "channels, method, within",
    [
        (3, "multiply XYZ", 0.04),
        (3, "eq. 12", 0.1),
        (5, "best linear model", 0.08),
        (5, "eq. 12", 0.1),
        (7, "eq. 12", 0.12),
        (9, "eq. 12", 0.12),
    ],
)
def test_printed_rows_of_table_1_and_2_are_reached(channels, method, within, vrhel_spectra):
    medians = multispectral.random_bounces(channels, vrhel_spectra, trials=60)[method][0]
    key = (0 if method == "multiply XYZ" else channels, method)
    np.testing.assert_allclose(np.median(medians, axis=0), printed.RANDOM_TABLES[1][key], rtol=within)
    np.testing.assert_allclose(np.percentile(medians, 90, axis=0), printed.RANDOM_TABLES[2][key], rtol=within + 0.1)


def test_printed_rows_of_table_3_are_reached(vrhel_spectra):
    found = multispectral.random_bounces(5, vrhel_spectra, trials=60)
    for method in ("best linear model", "eq. 12"):
        expected = printed.RANDOM_TABLES[3][5, method]
        np.testing.assert_allclose(np.median(found[method][1], axis=0), expected, rtol=0.07)


def test_single_bounces_of_the_paper_are_reached(vrhel_spectra):
    """Section 3.E.1: XYZ in percent, by five channels, of every colour signal."""
    rows = {tuple(row[:3]): row[3:] for row in paper_tables.signal_section(vrhel_spectra).rows}
    for method, what in (("best linear model, p = 5", "signals, XYZ %"), ("eq. 12, p = 5", "products, XYZ %")):
        here, theirs = map(float, rows[what, method, "median"])
        assert here == pytest.approx(theirs, rel=0.03)


def test_the_light_is_one_more_factor():
    """Off flat greys, what eq. 25 makes of a light is its projection on the basis, times the greys."""
    surfaces = multispectral.sampled(library.reflectances("colorchecker"))
    basis = multispectral.components(5, multispectral.paper_light("D65")[None], surfaces)
    model = multispectral.eq_12(basis)
    light = multispectral.paper_light("A")
    series = np.full((2, 31), 0.5)
    made = multispectral.factors(model)(light, series, "last")
    np.testing.assert_allclose(made[0], 0.5 * light @ basis @ basis.T, atol=1e-12)
    np.testing.assert_allclose(made[1], made[0] / 2, atol=1e-12)


@pytest.mark.parametrize("channels", [3, 5, 7, 9, 12])
def test_eq_12_filters_are_nonnegative_apart_and_in_the_span(channels):
    filters = bases.sharpened(channels, "nonnegative").filters
    assert filters.min() >= 0
    assert np.linalg.cond(filters) < 10
    components = np.linalg.qr(bases.sharpened(channels, "lagrange").filters)[0]
    np.testing.assert_allclose(components @ (components.T @ filters), filters, atol=1e-8)


def test_eq_12_is_the_optimum():
    """Of a thousand non-negative filters in the span, all of unit L2 norm, none leaves less outside."""
    surfaces = multispectral.sampled(library.reflectances("ces"))
    basis = multispectral.components(5, multispectral.paper_light("D65")[None], surfaces)
    random = np.random.default_rng(12)
    for low, high in multispectral.INTERVALS[5]:
        inside = (low <= multispectral.WAVELENGTHS) & (high >= multispectral.WAVELENGTHS)
        column = sharpening.nonnegative(basis, inside)
        assert np.linalg.norm(column) == pytest.approx(1)
        others = [sharpening.nonnegative(basis, random.random(31) < 0.3) for _ in range(15)]
        mixed = random.dirichlet(np.full(len(others), 0.3), 500) @ np.array(others)
        mixed = np.concatenate([mixed, 0.97 * column + 0.03 * mixed])
        mixed /= np.linalg.norm(mixed, axis=1, keepdims=True)
        assert (mixed[:, ~inside] ** 2).sum(axis=1).min() >= (column[~inside] ** 2).sum() - 1e-9


def test_eq_11_is_a_bound_for_eq_12():
    basis = np.linalg.qr(np.random.default_rng(0).random((31, 4)))[0]
    inside = np.arange(31) < 8
    free, bound = sharpening.least_energy(basis, inside), sharpening.nonnegative(basis, inside)
    assert (free[~inside] ** 2).sum() <= (bound[~inside] ** 2).sum()


def test_metamer_pairs_match_and_part_as_printed():
    pairs = multispectral.metamer_pairs()
    assert pairs.shape == (3, 2, 81) and pairs.min() >= 0 and pairs.max() <= 1
    for (method, name), expected in printed.PAIR_SPLITS.items():
        if method == "full spectra":
            weights = power_weights(library.illuminant(name).sampled(), library.observer())
            xyz = pairs @ weights
            apart = differences.delta_E_1976(xyz[:, 0], xyz[:, 1], weights.sum(axis=0))
            np.testing.assert_allclose(apart, expected, atol=1e-6)


def test_each_lever_helps_alone():
    """Boxes with a fitted matrix are nearer than boxes, and ours with that matrix are nearer still."""
    values = np.stack([spectrum.sampled() for spectrum in library.reflectances("colorchecker")])
    lights = [library.illuminant(name) for name in ("A", "D65", "FL2", "FL11")]
    box, ours = bases.block(9, levers.LIMITS), bases.fitted(9)
    plain = np.median(levers.way_errors(box, levers.WAYS["pseudo-inverse"], values, lights))
    fitted = np.median(levers.way_errors(box, levers.WAYS["fitted matrix"], values, lights))
    both = np.median(levers.way_errors(ours, levers.WAYS["fitted matrix"], values, lights))
    assert both < fitted / 1.5 < plain / 2.5


def test_command_writes_every_table(tmp_path, capsys):
    assert tables.main(["--out", str(tmp_path)]) == 0
    names = {path.name for path in tmp_path.iterdir()}
    expected = {f"table_{n}.csv" for n in range(1, 6)} | {"section_3_d.csv", "filters_and_matrices.csv", "tables.md"}
    assert expected | {f"figure_{n}.png" for n in (1, 2, 3, 4, 6)} | {"table_1.png"} <= names
    text = capsys.readouterr().out
    assert "| 5 | eq. 12, printed | 2.51 | 2.92 | 3.58 | 4.35 | 6.25 |" in text
    for rows in (*printed.RANDOM_TABLES.values(), *printed.METAMER_TABLES.values(), printed.THREE_BOUNCES):
        for row in rows.values():
            assert " | ".join(f"{value:.2f}" for value in row) in text
    assert (tmp_path / "tables.md").read_text(encoding="utf-8").strip() in text


def test_command_names_what_it_cannot_read(tmp_path, capsys):
    path = tmp_path / "broken.csv"
    path.write_text("380,0.1\n390,green\n", encoding="utf-8")
    assert tables.main(["--reflectances", str(path)]) == 1
    assert "line 2: 'green' is not a number" in capsys.readouterr().err


def test_command_ends_quietly_when_nobody_reads():
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(
        [sys.executable, "-m", "relume.studies.tables"], stdout=write, stderr=subprocess.PIPE, text=True
    )
    os.close(write)
    assert done.returncode == 1 and done.stderr == ""
