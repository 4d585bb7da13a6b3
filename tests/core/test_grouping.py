"""Channels are shared out among passes so that noise stays as small as that of an RGB render."""

import numpy as np
import pytest

from relume.core import bases, grouping, library, view


def luminance_shares(model, light):
    """What each pass adds to the luminance of white."""
    return model.relight(library.illuminant(light))[1].reshape(-1, 3).sum(axis=1)


@pytest.mark.parametrize("channels", [6, 9, 12, 15])
@pytest.mark.parametrize("light", ["D65", "D50", "A", "FL2", "LED-B1"])
def test_passes_share_luminance_evenly(channels, light):
    model = bases.fitted(channels)
    shares, before = (luminance_shares(each, light) for each in (grouping.balanced(model), model))
    variance, variance_before = (len(s) * np.square(s).sum() for s in (shares, before))  # 1 is that of an RGB render
    assert variance < 1.3
    assert variance < variance_before


def test_the_model_is_the_same_but_for_the_order_of_its_channels():
    model = bases.fitted(9)
    found = grouping.balanced(model)
    red, blue = (library.reflectance(f"ColorChecker: {name}") for name in ("red", "blue"))
    for light in ("A", "FL2"):
        illuminant = library.illuminant(light)
        product = found.coefficients(red) * found.coefficients(blue)
        expected = model.relight(illuminant) @ (model.coefficients(red) * model.coefficients(blue))
        assert found.relight(illuminant) @ product == pytest.approx(expected, rel=1e-6)
    assert grouping.balanced(bases.bands()).reconstruct(np.ones(36)) == pytest.approx(np.ones(81))


def test_rgb_and_part_empty_passes_stay_as_they_are():
    for model in (bases.fitted(5), bases.rgb()):
        assert grouping.balanced(model) is model


@pytest.mark.parametrize("channels", [3, 9, 12])
def test_an_rgb_colour_that_nothing_upsamples_keeps_its_hue(channels):
    model = grouping.balanced(bases.fitted(channels))
    to_rgb = view.xyz_to_rgb() @ model.relight(library.illuminant("D65"))
    for color in ([0.8, 0.1, 0.1], [0.1, 0.8, 0.1], [0.1, 0.1, 0.8], [0.8, 0.7, 0.1]):
        shown = to_rgb @ np.tile(color, model.passes)
        hue = (np.array(color) - 0.1) / np.linalg.norm(np.array(color) - 0.1)
        assert (shown - 0.1) @ hue / np.linalg.norm(shown - 0.1) > 0.8
