"""The report on difficult input: complete, free of NaN, and true where it promises a bound."""

import csv
import re

import numpy as np
import pytest

from relume.core.model import bases
from relume.core.picture import coefficients
from relume.core.spectra import library
from relume.studies import stability

HAZARDS = [
    "Conditioning",
    "Data of lower rank than p",
    "Single lines",
    "Extreme values",
    "Negative spectra",
    "Albedo 0.99",
    "Wavelengths",
    "Gels, LEDs and narrow bands",
    "Albedo 0.98, 20 bounces",
    "Absorbing volumes",
    "Half-precision coefficients",
    "What is clamped",
]


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    out = tmp_path_factory.mktemp("stability")
    assert stability.main(["--out", str(out)]) == 0
    return out


def rows(report, name):
    with open(report / f"{name}.csv", newline="", encoding="utf-8") as file:
        return list(csv.reader(file))[1:]


def test_every_hazard_is_reported(report):
    text = (report / "stability.md").read_text(encoding="utf-8")
    sections = re.findall("^## (.*)$", text, re.MULTILINE)
    assert sections == HAZARDS
    for part in ("What happens", "Bound", "Physical limit"):
        assert text.count(f"**{part}.**") == len(sections) - 1  # the last lists what is clamped


def test_each_panel_of_the_plot_has_coloured_curves(report):
    picture = coefficients.read_rgb(report / "stability.png")
    for panel in np.array_split(picture, 3, axis=1):
        assert (np.ptp(panel, axis=2) > 0.3).mean() > 0.001


def test_no_number_is_undefined(report):
    for path in report.glob("*.csv"):
        for line in rows(report, path.stem):
            assert not [cell for cell in line[1:] if re.search(r"\b(nan|inf)\b", cell)], path


def test_every_refusal_is_named(report):
    refused = [line for name in ("extreme_values", "wavelengths") for line in rows(report, name)]
    outcomes = [line[1] for line in refused if "CIEDE2000" not in line[1] and "relative error" not in line[1]]
    named = [words for words in outcomes if re.match(r'"?(Spectrum|Model|Measure|Library)Error: \w', words)]
    assert len(named) >= 16


def test_fitted_models_do_not_amplify_noise(report):
    fitted = [line for line in rows(report, "conditioning") if line[1] == "fitted"]
    assert len(fitted) == len(stability.CHANNELS)
    assert all(float(line[5]) < 1 for line in fitted), "no light makes more noise than there was"


def test_series_of_bounces_converge():
    """Coefficients of what reflects 0.99 at most stay below 1, so 1 / (1 - c) keeps its sign."""
    own = np.stack([spectrum.sampled() for spectrum in library.reflectances("ces")])
    own *= 0.99 / own.max(axis=1, keepdims=True)
    for channels in stability.CHANNELS:
        assert bases.fitted(channels).coefficients(own).max() <= 0.99 + 1e-12


def test_lines_seen_directly_are_exact(report):
    assert all(float(line[3]) < 1e-9 for line in rows(report, "single_lines"))


def test_usage_and_unreadable_files(tmp_path, capsys):
    assert stability.main(["--reflectances", str(tmp_path / "none.csv")]) == 1
    assert "none.csv: no such file" in capsys.readouterr().err
