"""Channels are shared out among passes so that noise stays as small as that of an RGB render."""

from itertools import combinations

import numpy as np
import pytest

from relume.core.colour import spaces
from relume.core.model import bases, channel_order, relight
from relume.core.spectra import library


def luminance_shares(model, light):
    """What each pass adds to the luminance of white."""
    return model.relight(library.illuminant(light))[1].reshape(-1, 3).sum(axis=1)


@pytest.mark.parametrize("channels", [6, 9, 12, 15])
@pytest.mark.parametrize("light", ["D65", "D50", "A", "FL2", "LED-B1"])
def test_passes_share_luminance_evenly(channels, light):
    model = bases.fitted(channels)
    shares, before = (luminance_shares(each, light) for each in (channel_order.balanced(model), model))
    variance, variance_before = (len(s) * np.square(s).sum() for s in (shares, before))  # 1 is that of an RGB render
    assert variance < 1.3
    assert variance < variance_before


def ways(channels):
    """Every way to deal channels out to passes of three."""
    if not channels:
        yield []
        return
    first, *others = channels
    for pair in combinations(others, 2):
        for rest in ways([channel for channel in others if channel not in pair]):
            yield [(first, *pair), *rest]


def test_no_other_way_to_share_nine_channels_makes_less_noise_of_colour():
    model = bases.fitted(9)
    found = channel_order.balanced(model)
    surfaces = np.concatenate([model.coefficients(library.reflectances("ces")), np.ones((20, 9))])
    added = []  # by each channel, in units of CIEDE2000
    for name in channel_order.LIGHTS:
        matrix = model.relight(library.illuminant(name))
        metric = relight.local_metric(surfaces @ matrix.T, matrix.sum(axis=1))
        added.append(np.einsum("nij,jk,nk->nik", metric, matrix, surfaces))
    added = np.concatenate(added)

    def noise(groups):
        passes = np.stack([added[..., list(group)].sum(axis=-1) for group in groups])
        return np.sqrt(np.square(passes).sum(axis=(0, 2))).mean()

    all_ways = list(ways(list(range(9))))
    assert len(all_ways) == 280
    order = [int(np.abs(model.filters - column[:, None]).sum(axis=0).argmin()) for column in found.filters.T]
    assert noise(np.reshape(order, (3, 3))) <= min(map(noise, all_ways)) * (1 + 1e-9)


def test_the_model_is_the_same_but_for_the_order_of_its_channels():
    model = bases.fitted(9)
    found = channel_order.balanced(model)
    red, blue = (library.reflectance(f"ColorChecker: {name}") for name in ("red", "blue"))
    for light in ("A", "FL2"):
        illuminant = library.illuminant(light)
        product = found.coefficients(red) * found.coefficients(blue)
        expected = model.relight(illuminant) @ (model.coefficients(red) * model.coefficients(blue))
        assert found.relight(illuminant) @ product == pytest.approx(expected, rel=1e-6)
    assert channel_order.balanced(bases.bands()).reconstruct(np.ones(36)) == pytest.approx(np.ones(81))


def test_rgb_and_part_empty_passes_stay_as_they_are():
    for model in (bases.fitted(5), bases.rgb()):
        assert channel_order.balanced(model) is model


@pytest.mark.parametrize("channels", [3, 9, 12])
def test_an_rgb_colour_that_nothing_upsamples_keeps_its_hue(channels):
    model = channel_order.balanced(bases.fitted(channels))
    to_rgb = spaces.xyz_to_rgb() @ model.relight(library.illuminant("D65"))
    for color in ([0.8, 0.1, 0.1], [0.1, 0.8, 0.1], [0.1, 0.1, 0.8], [0.8, 0.7, 0.1]):
        shown = to_rgb @ np.tile(color, model.passes)
        hue = (np.array(color) - 0.1) / np.linalg.norm(np.array(color) - 0.1)
        assert (shown - 0.1) @ hue / np.linalg.norm(shown - 0.1) > 0.8
