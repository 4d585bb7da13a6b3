"""Reflectances tried on in a picture that is there, against light whose way is known."""

import numpy as np
import pytest

from relume.core import Light, Mix, palette
from relume.core.model import bases
from relume.core.palette import PaletteError, Worn, trial
from relume.core.spectra import library

MODEL = bases.fitted(9)
MIX = Mix({"lamp": Light(library.illuminant("D65"))})
OLD, NEW, WALL, THIRD = (
    MODEL.coefficients(library.reflectance(name)) for name in ("ColorChecker: red", "CES 60", "CES 80", "CES 30")
)
LAMP = np.random.default_rng(2).uniform(0.5, 2.0, (12, 8, 1))  # alike in all channels, as in coefficient passes
TOP = np.broadcast_to(np.arange(12)[:, None] < 6, (12, 8))


def tried(picture, surface, materials, *wanted):
    return trial(MODEL, MIX, {"lamp": picture}, surface, materials, wanted)


def scene(met=0.0, mirrored=0.0, paint=OLD, edge=1.0):
    """The paint above, a wall below; the paint covers a part `edge` of row 5. Part `met` of all light met the paint."""
    covered = TOP * 1.0
    covered[5] = edge
    surface = covered[..., None] * paint + (1 - covered[..., None]) * WALL
    picture = LAMP * ((1 + met * paint) * surface + mirrored * covered[..., None])
    return picture, surface, {"paint": covered, "around": 1.0 - covered}


@pytest.mark.parametrize("way", [{}, {"met": 0.4}, {"edge": 0.3}, {"met": 0.4, "edge": 0.7}], ids=str)
def test_light_that_met_the_paint_before_is_known_by_its_shape(way):
    done = tried(*scene(**way), Worn("paint", NEW))
    np.testing.assert_allclose(done.groups["lamp"], scene(**way, paint=NEW)[0], rtol=1e-6, atol=1e-9)
    assert done.worn == ("paint",) and (done.expected.max() < 1e-6) == (not way.get("met"))


def test_what_is_mirrored_stays_as_it_is():
    picture, surface, materials = scene(mirrored=0.2)
    done = tried(picture, surface, materials, Worn("paint", NEW, mirrors=True))
    np.testing.assert_allclose(done.groups["lamp"], scene(mirrored=0.2, paint=NEW)[0], rtol=1e-6)
    assert done.expected[TOP].min() > 1 and done.expected[~TOP].max() < 1e-6, "what was told apart may be wrong"


def test_light_from_a_grey_is_told_from_other_light_by_nothing():
    grey = np.full(9, 0.5)
    done = tried(*scene(met=0.4, paint=grey), Worn("paint", NEW))
    np.testing.assert_allclose(done.groups["lamp"][~TOP], scene(met=0.4, paint=grey)[0][~TOP], rtol=1e-6)
    assert done.grey == ("paint",) and "a grey leaves no mark" in done.words()
    assert "ΔE" not in done.words(), "what is not known is not small"
    assert tried(*scene(), Worn("paint", NEW)).grey == ()


def test_the_edge_before_the_world_keeps_the_world():
    covered = TOP * 1.0
    covered[5] = 0.5
    surface = covered[..., None] * OLD
    picture = 0.7 * surface + 0.1 * (1 - covered[..., None])
    done = tried(picture, surface, {"paint": covered}, Worn("paint", NEW))
    wanted = 0.7 * covered[..., None] * NEW + 0.1 * (1 - covered[..., None])
    np.testing.assert_allclose(done.groups["lamp"], wanted, rtol=1e-6)


def test_light_of_two_that_are_alike_is_shared_between_them():
    picture, surface, materials = scene(met=0.4)
    twin = np.broadcast_to((np.arange(12)[:, None] >= 6) & (np.arange(12)[:, None] < 9), (12, 8)) * 1.0
    surface = np.where(twin[..., None] > 0, OLD, surface)
    picture = np.where(twin[..., None] > 0, LAMP * OLD, picture)
    found = {"paint": materials["paint"], "twin": twin, "around": materials["around"] - twin}
    done = tried(picture, surface, found, Worn("paint", NEW))
    changed = done.groups["lamp"][9:] - picture[9:]
    wanted = scene(met=0.4, paint=NEW)[0][9:] - picture[9:]
    np.testing.assert_allclose(changed, wanted * 2 / 3, rtol=1e-6)  # six rows are the paint, three its twin


def test_the_world_has_met_nothing():
    picture, surface, materials = scene()
    picture, surface = np.array(picture), np.array(surface)
    picture[9:], surface[9:] = OLD, 0.0
    done = tried(picture, surface, {"paint": materials["paint"]}, Worn("paint", NEW))
    np.testing.assert_allclose(done.groups["lamp"][9:], picture[9:])


def test_what_is_mirrored_of_the_sky_has_its_colour():
    sky = np.linspace(0.4, 1.0, 9)
    picture, surface, materials = scene(mirrored=0.2)
    picture, surface = np.array(picture), np.array(surface)
    picture[9:], surface[9:] = 1.0, 0.0
    seen = {"paint": materials["paint"], "around": materials["around"] * (np.arange(12)[:, None] < 9)}
    done = tried(sky * picture, surface, seen, Worn("paint", NEW, mirrors=True))
    wanted = sky * np.where(np.arange(12)[:, None, None] < 9, scene(mirrored=0.2, paint=NEW)[0], 1.0)
    np.testing.assert_allclose(done.groups["lamp"], wanted, rtol=1e-5)


def test_passes_that_see_less_of_an_edge_stay_light():
    picture, surface, materials = scene(edge=0.5)
    materials["paint"][5] = 0.9
    done = tried(picture, surface, materials | {"around": 1.0 - materials["paint"]}, Worn("paint", 0.05 * OLD))
    assert done.groups["lamp"][5].min() > 0


def test_a_texture_takes_one_colour():
    picture, surface, materials = scene()
    surface = np.array(surface)
    surface[:3] = THIRD
    done = tried(LAMP * surface, surface, materials, Worn("paint", NEW))
    np.testing.assert_allclose(done.groups["lamp"], scene(paint=NEW)[0], rtol=1e-6)


def test_a_metameric_black_is_shown_as_no_render_shows_it():
    black = OLD - 0.3
    assert black.min() < 0
    np.testing.assert_allclose(tried(*scene(), Worn("paint", black)).groups["lamp"], scene(paint=black)[0], rtol=1e-6)


def test_two_at_once():
    picture, surface, materials = scene()
    done = tried(picture, surface, materials, Worn("paint", NEW), Worn("around", THIRD))
    np.testing.assert_allclose(done.groups["lamp"], LAMP * np.where(TOP[..., None], NEW, THIRD), rtol=1e-6)
    assert done.worn == ("paint", "around") and done.covered.all()


def test_channels_that_reflected_nothing_are_filled_by_the_others():
    dark = OLD.copy()
    dark[4] = 0.0
    done = tried(*scene(paint=dark), Worn("paint", NEW))
    np.testing.assert_allclose(done.groups["lamp"], scene(paint=NEW)[0], rtol=1e-6)


def test_what_carries_nothing_is_taken_for_grey():
    picture, surface, materials = scene(met=0.4)
    metal = np.array(surface)
    metal[9:] = 0.0
    mirror = np.array(picture)
    mirror[9:] = LAMP[9:] * OLD  # a mirror image of the paint
    done = tried(mirror, metal, materials, Worn("paint", NEW))
    np.testing.assert_allclose(done.groups["lamp"][9:], LAMP[9:] * NEW, rtol=1e-4)
    assert done.expected[9:].min() > 1


def test_what_is_not_seen_is_told():
    done = tried(*scene(), Worn("paint", NEW), Worn("lid", NEW))
    assert "Not seen in the picture: lid." in done.words() and "Tried on: paint." in done.words()
    with pytest.raises(PaletteError, match="not seen in the picture: lid"):
        tried(*scene(), Worn("lid", NEW))


def test_hatched_where_it_may_be_plainly_off():
    picture = np.full((40, 40, 3), 0.5)
    expected = np.where(np.arange(40)[:, None] < 20, 5.0, 1.0) * np.ones((40, 40))
    drawn = palette.hatched(picture, expected)
    changed = (drawn != picture).any(axis=-1)
    assert 0.1 < changed[:20].mean() < 0.3 and not changed[20:].any()
