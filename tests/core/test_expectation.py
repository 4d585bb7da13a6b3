"""The error that is always said: of this scene's surfaces, under the lights chosen now, against full spectra."""

import json
from dataclasses import replace

import numpy as np
import pytest

from relume.core.colour import differences
from relume.core.errors import MeasureError
from relume.core.model import bases, integration
from relume.core.picture import expectation, finish, header
from relume.core.picture.coefficient_image import CoefficientImage
from relume.core.picture.content import MOST, Content, kept
from relume.core.picture.mix import Light, Mix
from relume.core.spectra import library
from relume.core.spectra.spectrum import Spectrum

PATCHES = library.reflectances("colorchecker")


def light(name, gain=1.0):
    return Light(library.illuminant(name), gain)


def advice(*arguments):
    """What `advising` comes to."""
    steps = expectation.advising(*arguments)
    while True:
        try:
            next(steps)
        except StopIteration as done:
            return done.value


@pytest.fixture
def chart():
    return Content(PATCHES, lights=[library.illuminant("A")], bounces=0)


def test_it_is_what_the_surfaces_themselves_differ_by(chart):
    """One surface after the other by hand, full spectra at 1 nm under a line: the same median and 98th percentile."""
    model, lamp = bases.fitted(9), library.line(532)
    samples = np.stack([patch.sampled(integration.FINE) for patch in PATCHES])
    weights = integration.fine_weights(lamp)
    weights = weights / weights[:, 1].sum()
    matrix = model.relight(lamp)
    even = np.linspace(0.02, 1, 25)
    levels = np.outer(even, even).ravel()  # far from lamps to near them, hidden from them or not
    seen, true = (np.concatenate([each * level for level in levels])
                  for each in (model.coefficients(PATCHES) @ matrix.T, samples @ weights))  # fmt: skip
    found = differences.picture_delta_E(seen, true, weights.sum(axis=0))
    told = expectation.expected_of(model, chart, Light(lamp))
    assert told.median == pytest.approx(np.median(found), rel=0.15)
    assert told.p98 == pytest.approx(np.percentile(found, 98), rel=0.15)


def test_lights_that_are_off_do_not_count_and_gains_weigh(chart):
    model = bases.fitted(6)
    alone = expectation.expected(model, chart, Mix({"a": light("D65")}))
    laser = expectation.expected(model, chart, Mix({"a": light("D65"), "b": light("532 nm")}))
    faint = expectation.expected(model, chart, Mix({"a": light("D65"), "b": light("532 nm", 1e-4)}))
    off = expectation.expected(model, chart, Mix({"a": light("D65"), "b": light("532 nm", 0.0)}))
    assert off == alone
    assert faint.p98 == pytest.approx(alone.p98, rel=0.05)
    assert laser.p98 > 1.5 * alone.p98
    assert expectation.expected(model, chart, Mix({"a": light("A", 0.0)})).p98 == 0


def test_a_medium_is_what_its_spectrum_lets_through():
    """Behind a medium of many depths stands a white: the errors of exponentials, wavelength by wavelength."""
    model, lamp = bases.fitted(6), library.illuminant("D65")
    weights = integration.light_weights(lamp) / integration.light_weights(lamp)[:, 1].sum()
    errors = []
    for depth in (1.0, 6.0):
        shown = Content(PATCHES[14:15], [[1.0] * 3], shares=[1.0, 1.0], depths=[depth, 0.0], lights=[lamp], bounces=0)
        told = expectation.expected_of(model, shown, Light(lamp))
        through = depth * np.linspace(0.25, 1.75, 40)[:, None]
        full, seen = (
            np.exp(-through * (1 - each)) for each in (PATCHES[14].sampled(), model.coefficients(PATCHES[14]))
        )
        white = np.ones((40, 1))  # half of what is seen is white: it sets the exposure
        found = differences.delta_E_2000(
            np.concatenate([full @ weights, white * weights.sum(axis=0)]),
            np.concatenate([seen @ model.relight(lamp).T, white * weights.sum(axis=0)]),
            weights.sum(axis=0),
        )
        assert told.p98 == pytest.approx(np.percentile(found, 98), rel=0.5)
        errors.append(told.p98)
    assert errors[1] > 3 * errors[0]


def test_rough_surfaces_reflect_light_more_than_once():
    """A single colour, met once: matrices that are exact for it smooth are not where it is rough."""
    lamp = library.illuminant("LED-B3")
    smooth = Content(PATCHES[:1], lights=[lamp], bounces=0)
    rough = replace(smooth, again=[finish.rough_diffuse(1.0), 0.0])
    model = bases.fitted(3)
    assert expectation.expected_of(model, rough, Light(lamp)) != expectation.expected_of(model, smooth, Light(lamp))
    white = np.ones((1, 5))
    assert finish.reflected(white, np.array([[0.166]])) == pytest.approx(white)  # it loses nothing


def test_a_gel_the_reference_and_the_exact_model():
    """Boxes of 20 nm under A and FL11: no model of ours is the truth for them, and each says by how much."""
    nm = np.arange(380, 781, 1.0)
    gels = [Spectrum(nm, 0.02 + 0.9 * (abs(nm - middle) < 10), f"{middle} nm") for middle in range(430, 680, 25)]
    shown = Content(gels, lights=[library.illuminant("A")], bounces=0)
    mix = Mix({"a": light("A"), "b": light("FL11")})
    bands, exact = (expectation.expected(bases.bands(n), shown, mix) for n in (36, 81))
    assert bands.level == "red"
    assert exact.p98 < 0.2 * bands.p98
    assert "channels" in advice(bases.fitted(6), shown, mix)


def test_what_is_black_is_told():
    black = Content(colours=[[0.0, 0.0, 0.0]], lights=[library.illuminant("A")])
    with pytest.raises(MeasureError, match="black"):
        expectation.expected(bases.fitted(6), black, Mix({"a": light("A")}))


def test_advice_is_for_what_is_not_green_and_names_what_it_would_reach(chart):
    model = bases.fitted(3)
    assert advice(bases.fitted(15), chart, Mix({"a": light("D65")})) == ""
    mix = Mix({"a": light("FL11")})
    channels, reached = advice(model, chart, mix).split(" channels: ")
    better = expectation.expected(bases.fitted(int(channels)), chart, mix)
    assert better.p98 < expectation.expected(model, chart, mix).p98
    assert float(reached) == pytest.approx(better.p98, abs=0.2)


def test_what_shines_through_a_line_in_the_group_of_others_is_told_to_leave_it():
    """A filter as narrow as a laser, over a lamp of a group in daylight; of its own, the same light is integrated."""
    nm = np.arange(380, 781, 1.0)
    narrow = Spectrum(nm, np.exp(-(((nm - 532) / 3) ** 2)), "narrow filter")
    content = Content(PATCHES, lights=[library.illuminant("D65")], bounces=0, filtered=[("Laser", "room", narrow)])
    shown = replace(content, reflectances=[*PATCHES, narrow], shares=None, again=None, depths=None, right_at=None)
    mix = Mix({"room": light("D65")})
    said = advice(bases.fitted(6), shown, mix)
    assert "give Laser a light group of its own" in said
    own, inside = (float(word) for word in said.split(": ")[1].split(" in place of "))
    assert own < 0.5 * inside
    assert "light group" not in advice(bases.fitted(6), shown, Mix({"room": light("D65", 0.0), "b": light("FL11")}))


def test_a_file_says_what_it_shows(chart):
    deep = [*[0.0] * 24, 3.0]
    more = {"again": [*[0.1] * 25, 0.2], "depths": deep, "right_at": deep}
    shown = replace(chart, colours=[[0.1, 0.2, 0.3]], shares=[*[0.5] * 24, 2.0], textures=0.25, **more)
    image = CoefficientImage(
        bases.fitted(9), {}, {"key": library.illuminant("FL11")}, np.empty((0, 0), np.float32), shows=shown
    )
    back = header.parse(json.dumps(header.to_dict(image, ["key"])))[0]
    before, after = (expectation.expected(each.model, each.shows, each.mix()) for each in (image, back))
    assert after.median == pytest.approx(before.median, rel=1e-6)
    assert after.p98 == pytest.approx(before.p98, rel=1e-6)
    older = header.parse(json.dumps(header.to_dict(replace(image, shows=None), ["key"])))[0]
    assert older.shows is None
    said = expectation.words(expectation.expected(older.model, None, older.mix()), None)
    assert "surfaces in general" in said


def test_a_file_keeps_the_surfaces_that_are_seen_most():
    colours = np.random.default_rng(0).random((3 * MOST, 3))
    shares = np.arange(3 * MOST + 24)
    less = kept(Content(PATCHES, colours, shares, lights=[library.illuminant("A")]))
    assert len(less.reflectances) == 0
    assert len(less.rgb) == len(less.parts) == MOST
    assert less.parts.min() == 2 * MOST + 24
    odd = [[0.5, 0.5, 0.5], [np.nan, 0, 0], [np.inf, 1, 1], [1e9, 0, 0]]
    shown = kept(Content(PATCHES, odd, np.arange(28), lights=[library.illuminant("A")]))
    assert len(shown.reflectances) == 24
    assert shown.rgb.tolist() == [[0.5, 0.5, 0.5]]
    assert shown.parts.tolist() == list(range(25))


@pytest.mark.parametrize(
    "wrong",
    [
        {"again": [0.5]},
        {"depths": [1.0]},
        {"shares": [1.0]},
        {"space": "Rec. 1"},
        {"bounces": -1},
        {"colours": [[1, 2]]},
    ],
)
def test_a_damaged_description_of_what_is_shown_is_told(chart, wrong):
    from relume.core.errors import CoefficientImageError

    image = CoefficientImage(
        bases.fitted(6), {}, {"key": library.illuminant("A")}, np.empty((0, 0), np.float32), shows=chart
    )
    described = header.to_dict(image, ["key"])
    described["shows"] |= wrong
    with pytest.raises(CoefficientImageError, match="shows"):
        header.parse(json.dumps(described))
