"""The numbers of core.spaces are those of the standards, as colour-science has them."""

import colour
import numpy as np
import pytest
from colour.adaptation import CAT_BRADFORD, CAT_SHARP

from relume.core.colour import spaces
from relume.core.spectra import library

THEIRS = {"Linear Rec.709": "ITU-R BT.709", "Linear Rec.2020": "ITU-R BT.2020", "ACEScg": "ACEScg"}


@pytest.mark.parametrize("name", spaces.RGB_SPACES)
def test_primaries_and_whites_are_the_standards(name):
    *primaries, white = spaces.RGB_SPACES[name]
    standard = colour.RGB_COLOURSPACES[THEIRS[name]]
    np.testing.assert_allclose(primaries, standard.primaries, atol=1e-12)
    np.testing.assert_allclose(white, standard.whitepoint, atol=1e-5)


def test_white_balance_is_in_the_published_cone_spaces():
    np.testing.assert_array_equal(spaces.ADAPTATIONS["bradford"], CAT_BRADFORD)
    np.testing.assert_array_equal(spaces.ADAPTATIONS["sharp"], CAT_SHARP)


def test_white_is_d65_as_lights_are_sampled():
    seen = library.illuminant("D65").sampled() @ library.observer()
    np.testing.assert_allclose(spaces.D65_WHITE, seen / seen[1], atol=5e-9)


def test_srgb_encoding_is_the_standard_and_comes_back():
    values = np.linspace(0.0, 1.0, 101)
    np.testing.assert_allclose(spaces.srgb_encoded(values), colour.cctf_encoding(values, "sRGB"), atol=1e-7)
    np.testing.assert_allclose(spaces.srgb_decoded(spaces.srgb_encoded(values)), values, atol=1e-6)


def test_observers_have_the_names_of_colour_science():
    assert all(theirs in colour.MSDS_CMFS for theirs in library.OBSERVERS.values())
