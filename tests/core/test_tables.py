"""The tables of Drew & Finlayson, made again, and the command that prints them."""

import os
import subprocess
import sys

import numpy as np
import pytest

from relume.core import Spectrum
from relume.core.model import bases
from relume.core.spectra import library
from relume.core.spectra.spectrum import WAVELENGTHS
from relume.studies import experiments, tables


@pytest.fixture(scope="module")
def lights():
    return [library.illuminant(name) for name in tables.LIGHTS]


@pytest.mark.parametrize(
    "method, channels, within",
    [("multiply XYZ", 5, 0.1), ("best linear model", 5, 0.1), ("eq. 12", 5, 0.15), ("eq. 12, least area", 9, 0.12)],
)
def test_published_rows_are_approached(method, channels, within, vrhel, lights):
    spectra = [Spectrum(WAVELENGTHS, values) for values in vrhel]
    medians = np.median(experiments.bounces(channels, spectra, lights)[0][method], axis=(0, 1))
    row = method.removesuffix(", least area")
    printed = tables.PRINTED[1, None if method == "multiply XYZ" else channels, row]
    np.testing.assert_allclose(medians, printed, rtol=within)


@pytest.mark.parametrize("outside", ["energy", "area"])
@pytest.mark.parametrize("channels", [3, 5, 7, 9, 12])
def test_eq_12_filters_are_nonnegative_apart_and_in_the_span(channels, outside):
    filters = bases.sharpened(channels, "nonnegative", outside=outside).filters
    assert filters.min() >= 0
    assert np.linalg.cond(filters) < 10
    components = np.linalg.qr(bases.sharpened(channels, "lagrange").filters)[0]
    np.testing.assert_allclose(components @ (components.T @ filters), filters, atol=1e-8)


def test_eq_12_is_the_optimum():
    """No step towards another non-negative filter in the span leaves less outside for the same area inside."""
    channels = 7
    edges = np.linspace(380, 780, channels + 1)
    everything = np.concatenate([bases.sharpened(channels, outside=how).filters.T for how in ("energy", "area")])
    for how, left_over in (("energy", lambda f: (f**2).sum()), ("area", np.sum)):
        for j, column in enumerate(bases.sharpened(channels, outside=how).filters.T):
            inside = (edges[j] <= WAVELENGTHS) & (edges[j + 1] >= WAVELENGTHS)
            best = left_over(column[~inside] / column[inside].sum())
            for other in everything:
                mixed = 0.99 * column / column[inside].sum() + 0.01 * other / other[inside].sum()
                assert left_over(mixed[~inside]) >= best - 1e-9


def test_command_writes_every_table(tmp_path, capsys):
    assert tables.main(["--out", str(tmp_path)]) == 0
    names = {path.name for path in tmp_path.iterdir()}
    expected = {f"table_{n}.csv" for n in range(1, 6)} | {"section_3_d.csv", "tables.md"}
    assert expected | {"figure_1.png", "figure_2.png", "table_1.png"} <= names
    text = capsys.readouterr().out
    assert "| 5 | eq. 12, printed | 2.51 | 2.92 | 3.58 | 4.35 | 6.25 |" in text
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
