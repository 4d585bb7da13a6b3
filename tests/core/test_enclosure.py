"""The room of Ward & Eydelberg-Vileshin without noise: what light in a closed room must do."""

import numpy as np
import pytest

from relume.core.colour import differences
from relume.core.model import bases
from relume.core.model.relight import power_weights
from relume.core.spectra import library
from relume.studies import enclosure

WALLS = ("neutral 8 (.23 D)", "neutral 8 (.23 D)", "neutral 8 (.23 D)", "blue flower", "red", "blue")


def room(bounces: int, radius: float = 0.5, size=(24, 18)) -> enclosure.Room:
    spheres = ((-0.8, 2.9, radius), radius), ((0.8, 2.4, radius), radius)
    lamps = (((-1.0, 2.3, 3.18), 1.2), ((1.0, 2.3, 3.18), 1.2))
    return enclosure.Room((4.0, 4.0, 3.2), bounces, *spheres, lamps, ((0, 0.05, 1.75), (0, 4.0, 1.2), 70.0, size))


def grey(reflectance: float, channels: int = 1) -> enclosure.Surfaces:
    walls = np.full((6, channels), reflectance)
    return enclosure.Surfaces(walls, walls[0], 0.05, lambda cosines: np.ones((len(cosines), channels)))


def coloured(filters: np.ndarray) -> enclosure.Surfaces:
    walls = np.array([library.reflectance(f"ColorChecker: {name}").sampled() for name in WALLS]) @ filters
    plastic = library.reflectance("ColorChecker: green").sampled() @ filters
    return enclosure.Surfaces(walls, plastic, 0.05, lambda cosines: np.ones((len(cosines), filters.shape[1])))


def test_what_a_lamp_sends_out_arrives_on_the_walls():
    _, _, areas = enclosure._centres((4.0, 4.0, 3.2))
    falling = enclosure._falling(room(0), grey(0.0), 0, np.ones(1))[:, 0]
    # A lamp of 1.44 m² that sends out 1 W/m²; the room's ceiling, behind it, gets nothing
    assert falling @ areas == pytest.approx(1.2**2, rel=0.02)
    assert falling[enclosure.PATCHES**2 : 2 * enclosure.PATCHES**2].max() == 0


def test_light_in_a_grey_room_grows_as_a_geometric_series():
    _, _, areas = enclosure._centres((4.0, 4.0, 3.2))
    once, often = (enclosure._falling(room(n), grey(0.5), 0, np.ones(1))[:, 0] @ areas for n in (0, 60))
    assert often / once == pytest.approx(2.0, rel=0.03)


def test_a_mirror_that_takes_nothing_shows_the_walls_as_they_are():
    light, names = enclosure.look(room(3), grey(0.5), 0, np.ones(1))
    gold, walls = light[names == "gold"], light[names == "walls"]
    assert {"walls", "plastic", "gold"} <= set(np.unique(names))
    # But for the lamp, which it mirrors too, nothing in it is brighter than the brightest wall
    assert np.median(gold) < walls.max() and gold.max() == pytest.approx(1.0)


def test_channels_do_not_know_each_other_and_lamps_add():
    surfaces = coloured(np.eye(81))
    both, _ = enclosure.look(room(4), surfaces, 0, np.ones(81))
    one, _ = enclosure.look(room(4), coloured(np.eye(81)[:, [30]]), 0, np.ones(1))
    np.testing.assert_allclose(both[..., 30], one[..., 0], rtol=1e-12)
    twice, _ = enclosure.look(room(4), surfaces, 0, np.full(81, 2.0))
    np.testing.assert_allclose(twice, 2 * both, rtol=1e-12)


def test_prefiltering_is_exact_where_light_comes_off_one_wall():
    light = library.illuminant("A")
    weights, model = power_weights(light.sampled(), library.observer()), bases.prefiltered(light)
    for bounces, below in ((0, 1e-9), (4, 1.5)):
        true, names = enclosure.look(room(bounces), coloured(np.eye(81)), 0, np.ones(81))
        found, _ = enclosure.look(room(bounces), coloured(model.filters), 0, np.ones(3))
        apart = differences.delta_E_1994(true @ weights, found @ model.relight(light).T, weights.sum(axis=0))
        assert apart[names == "walls"].max() < below
    assert apart[names == "walls"].max() > 0.1, "what comes off two walls is a product, and not exact"
