"""Filters that share a weighting: what is exact about them, and the gradient they are optimised by."""

import numpy as np
import pytest

from relume.core.model import relight, training
from relume.core.spectra import library
from relume.studies import partition


@pytest.fixture(scope="module")
def power():
    names = ("D65", "FL11")
    return np.stack([relight.power_weights(library.illuminant(n).sampled(), library.observer()) for n in names])


def test_every_pass_sums_to_the_same_brightness_whatever_the_spectrum():
    shared = partition.Shared.of(np.random.default_rng(1).standard_normal(partition.interleaved().size))
    np.testing.assert_allclose(shared.filters.sum(axis=0), 1.0)  # white comes out as 1
    coefficients = training.reflectances() @ shared.filters
    sums = (coefficients * shared.brightness).reshape(len(coefficients), partition.PASSES, 3).sum(axis=2)
    np.testing.assert_allclose(sums, np.repeat(sums[:, :1], partition.PASSES, axis=1), rtol=1e-12)


def test_the_gradient_is_that_of_the_error(power):
    aim, start = partition.Aim(power, 0.05), partition.interleaved()
    _, gradient = aim(start)
    direction = np.random.default_rng(0).standard_normal(start.size)
    step = 1e-5 * direction
    slope = (aim(start + step)[0] - aim(start - step)[0]) / 2e-5
    assert gradient @ direction == pytest.approx(slope, rel=1e-3)


def test_one_pass_of_three_exact_filters_has_the_noise_of_rgb(power):
    """The XYZ of one illuminant as three filters of one pass: the estimate is then RGB's own."""
    one = power[:1]
    filters = one[0] / one[0].sum(axis=0)
    matrices = np.diag(one[0].sum(axis=0))[None]
    pixels = partition.Pixels.drawn(training.reflectances(), seed=3)
    np.testing.assert_allclose(pixels.variance(filters, matrices, one, None), pixels.rgb_variance(one), rtol=1e-9)
