import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from relume.core import WAVELENGTHS, Spectrum, SpectrumError


def test_reversed_samples_are_sorted():
    spectrum = Spectrum([700, 500, 400], [0.3, 0.2, 0.1])
    assert spectrum.wavelengths.tolist() == [400, 500, 700]
    assert spectrum.values.tolist() == [0.1, 0.2, 0.3]


@pytest.mark.parametrize(
    "wavelengths, values, words",
    [
        ([], [], "no samples"),
        ([400, 500], [1], "one value per wavelength"),
        ([400, 400], [1, 2], "400 nm occurs more than once"),
        ([400, 500], [1, np.nan], "at 500 nm is not a finite number"),
        ([400, np.inf], [1, 1], "positive numbers"),
        ([0, 500], [1, 1], "positive numbers"),
        ([400, 500], ["red", 1], "must be numbers"),
        ([[400, 500]], [[1, 1]], "one value per wavelength"),
    ],
)
def test_bad_samples_are_refused_by_name(wavelengths, values, words):
    with pytest.raises(SpectrumError, match=words):
        Spectrum(wavelengths, values, name="bad")


def test_unknown_kind_is_refused():
    with pytest.raises(SpectrumError, match="transmittance"):
        Spectrum([500], [1], kind="transmittance")


def test_reflectance_keeps_its_end_values_and_illuminant_ends():
    assert Spectrum([500, 600], [0.2, 0.4]).sampled([400, 550, 700]).tolist() == pytest.approx([0.2, 0.3, 0.4])
    illuminant = Spectrum([500, 600], [2, 4], kind="illuminant")
    assert illuminant.sampled([450, 500, 550, 600, 650]).tolist() == [0, 2, 3, 4, 0]


def test_fine_illuminant_keeps_power_and_centroid():
    fine = np.arange(380, 780.5, 1.0)
    power = np.exp(-0.5 * ((fine - 589.3) / 0.6) ** 2)  # a line that plain sampling at 5 nm would miss
    sampled = Spectrum(fine, power, kind="illuminant").sampled()
    assert 5 * sampled.sum() == pytest.approx(power.sum(), rel=1e-3)
    assert WAVELENGTHS @ sampled / sampled.sum() == pytest.approx(fine @ power / power.sum(), abs=1e-3)


def test_single_line_splits_between_neighbours():
    sampled = Spectrum([589], [1], kind="illuminant").sampled()
    assert np.flatnonzero(sampled).tolist() == [41, 42]
    assert 5 * sampled.sum() == pytest.approx(1)
    assert WAVELENGTHS @ sampled / sampled.sum() == pytest.approx(589)


@given(st.lists(st.floats(0, 1), min_size=2, max_size=40), st.floats(390, 500), st.floats(0.5, 20))
def test_sampling_stays_within_the_samples(values, start, step):
    spectrum = Spectrum(start + step * np.arange(len(values)), values)
    assert min(values) <= spectrum.sampled().min() and spectrum.sampled().max() <= max(values)


def test_survives_json():
    spectrum = Spectrum([400.5, 500], [0.1, 1 / 3], name="x", kind="extinction", source="y")
    again = Spectrum.from_dict(json.loads(json.dumps(spectrum.to_dict())))
    assert again.to_dict() == spectrum.to_dict()
    with pytest.raises(SpectrumError, match="wavelengths and values"):
        Spectrum.from_dict({"name": "x"})
