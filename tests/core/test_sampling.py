"""Samples are dealt out among passes: all of them, each once, more to the passes that are brighter."""

import numpy as np
import pytest

from relume.core.model import bases, channel_order
from relume.core.picture import sampling
from relume.core.picture.mix import Light
from relume.core.spectra import library


@pytest.mark.parametrize("count", [1, 2, 3, 7, 48, 4096])
@pytest.mark.parametrize("parts", [[1.0], [1 / 3] * 3, [0.27, 0.38, 0.35], [0.001, 0.999], [1 / 12] * 12])
def test_every_sample_is_taken_once(parts, count):
    found = sampling.dealt(parts, 5, count)
    starts, counts = found.driven["sample_offset"], found.driven["sample_subset_length"]
    taken = [s for start, number in zip(starts, counts, strict=True) for s in range(start, start + number)]
    total = max(count, sum(counts)) if min(counts) == 1 else count
    assert taken == list(range(5, 5 + total))
    assert min(counts) >= 1 and set(found.samples) == {5 + total}
    assert total <= count + len(parts)
    assert np.abs(np.array(counts) - np.array(parts) * count).max() <= 1


def test_seeds_follow_each_other_and_stay_seeds():
    assert sampling.independent(3, seed=7).driven["seed"] == (7, 8, 9)
    assert sampling.independent(2, seed=2**31 - 1).driven["seed"] == (2**31 - 1, 0)
    assert sampling.same(3, 16) == sampling.Sampling((16, 16, 16))


@pytest.mark.parametrize("channels", [1, 3, 5, 6, 9, 12, 36])
@pytest.mark.parametrize("light", ["D65", "A", "FL11", "HP1"])
def test_shares_lower_the_variance_of_luminance(channels, light):
    model = channel_order.balanced(bases.fitted(channels))
    lights = [Light(library.illuminant(light))]
    luminance = model.relight(lights[0].illuminant)[1]
    added = np.add.reduceat(luminance, range(0, channels, 3))
    found = sampling.shares(model, lights)
    assert found.sum() == pytest.approx(1)
    assert found.min() >= 0.5 / model.passes, "no pass may become much noisier when the light is changed"
    assert np.sum(added**2 / found) <= np.sum(added**2) * model.passes * (1 + 1e-9)


def test_lights_that_are_off_leave_the_shares_even():
    model = bases.fitted(9)
    assert sampling.shares(model, [Light(library.illuminant("A"), 0.0)]) == pytest.approx([1 / 3] * 3)


def test_passes_may_be_noisier_than_what_they_add_up_to():
    assert sampling.adaptive(0.01, 0, 4096, 1) == (0.01, 0)
    threshold, minimum = sampling.adaptive(0.01, 0, 4096, 3)
    assert 0.01 * 3**0.5 < threshold < 0.01 * 3 and minimum == 22  # a third of the 64 that Cycles chooses for 0.01
    assert sampling.adaptive(0.0, 90, 500, 3) == (pytest.approx(0.002 * 3**0.75), 30)
    assert sampling.adaptive(0.9, 3, 64, 12) == (1.0, 4), "Cycles takes thresholds up to 1"
