"""Gains, blends and the light dial; numbered files; the spectrum of a pixel."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from relume.core.colour.spaces import srgb_decoded
from relume.core.model import bases, upsample
from relume.core.picture import drawing, inspection, mixing, recombination, sequences
from relume.core.picture.mix import Light, Mix
from relume.core.spectra import library
from relume.core.spectra.spectrum import SpectrumError


@given(st.integers(3, 12), st.floats(0, 2 * np.pi), st.floats(0, 3))
def test_the_dial_weighs_and_finds_its_handle_again(count, angle, radius):
    position = radius * np.array([np.cos(angle), np.sin(angle)])
    weights = mixing.weights(position, count)
    assert (weights >= 0).all() and abs(weights.sum() - 1) < 1e-9
    handle = mixing.handle(weights)
    if radius < np.cos(np.pi / count):
        assert np.allclose(handle, position, atol=1e-9)
    assert np.allclose(mixing.weights(handle, count), weights, atol=1e-6)


@pytest.mark.parametrize("lamp", ["D65", "FL2", "LED-B3"])
def test_a_gel_passes_what_its_colour_reflects(lamp):
    """Behind a gel, a white has the colour that the gel's colour has as a surface in the lamp, whatever the lamp."""
    illuminant, colour = library.illuminant(lamp), (0.9, 0.4, 0.2)
    behind = mixing.tinted(illuminant, colour)
    passed = upsample.rgb_spectra() @ srgb_decoded(np.array(colour))
    power = illuminant.sampled() * passed
    assert np.allclose(behind.sampled() / behind.sampled().sum(), power / power.sum(), atol=2e-4)
    assert mixing.tinted(illuminant, (1.0, 1.0, 1.0)) is illuminant, "without a gel it is what it was"


def test_a_line_stays_a_line_behind_a_gel():
    behind = mixing.tinted(library.illuminant("589 nm"), (0.9, 0.4, 0.2))
    assert np.allclose(drawing.swatch(behind), drawing.swatch(library.illuminant("589 nm")))
    assert behind.wavelengths.tolist() == [589.0]


def test_a_black_gel_is_refused():
    with pytest.raises(SpectrumError, match="lets no light through"):
        mixing.tinted(library.illuminant("A"), (0.0, 0.0, 0.0))


@pytest.mark.parametrize("count", [1, 2, 3, 5, 8])
def test_at_an_anchor_its_illuminant_shines_alone_and_between_two_only_they(count):
    corners = mixing.anchors(count)
    for i, corner in enumerate(corners):
        assert np.allclose(mixing.weights(corner, count), np.eye(count)[i], atol=1e-9)
    if count >= 3:
        weights = mixing.weights((corners[0] + corners[1]) / 2, count)
        assert np.allclose(weights[:2], 0.5) and np.allclose(weights[2:], 0)


def test_a_blend_has_each_lamp_by_its_luminance():
    tungsten, line = library.illuminant("A"), library.illuminant("589 nm")
    cmfs = library.observer()
    mixed = mixing.blend(((tungsten, 1.0), (line, 3.0))).sampled() @ cmfs
    parts = [spectrum.sampled() @ cmfs for spectrum in (tungsten, line)]
    assert np.allclose(mixed / mixed[1], 0.25 * parts[0] / parts[0][1] + 0.75 * parts[1] / parts[1][1])
    with pytest.raises(SpectrumError, match="weights of 0 or more"):
        mixing.blend(((tungsten, 0.0),))


def test_solo_and_mute():
    assert mixing.gains([1, 0, -1], [False] * 3, [False] * 3).tolist() == [2.0, 1.0, 0.5]
    assert mixing.gains([1, 0, -1], [True, True, False], [False, True, False]).tolist() == [2.0, 0.0, 0.0]


def test_numbered_files(tmp_path):
    for frame in (8, 9, 10, 10001):
        (tmp_path / f"shot.{frame:04d}.exr").touch()
    with pytest.raises(sequences.SequenceError, match="frames are missing: 11-10000"):
        sequences.files(tmp_path / "shot.####.exr")
    (tmp_path / "shot.10001.exr").unlink()
    assert list(sequences.files(tmp_path / "shot.####.exr")) == [8, 9, 10]
    with pytest.raises(sequences.SequenceError, match="no such files"):
        sequences.files(tmp_path / "other.####.exr")
    with pytest.raises(sequences.SequenceError, match="one run of #"):
        sequences.files(tmp_path / "shot.##.#.exr")


def test_a_pixel_of_a_grey_wall_has_the_spectrum_of_its_lamp():
    model, lamp = bases.fitted(9), library.illuminant("A")
    mix = Mix({"key": Light(lamp, 0.5), "fill": Light(library.illuminant("HP1"), 0.0)})
    pixel = inspection.inspect(model, mix, [np.full(9, 0.4), np.full(9, 0.7)])
    assert np.allclose(pixel.spectrum, lamp.sampled() / lamp.sampled().max(), atol=1e-6)
    assert np.allclose(pixel.xyz, 0.2 * recombination.mixed_white(model, mix))
    darker = inspection.inspect(model, mix, [np.full(9, 0.1), np.full(9, 0.7)])
    assert inspection.difference(model, mix, pixel, pixel) == 0.0
    assert inspection.difference(model, mix, pixel, darker) > 20


def test_a_surface_is_drawn_and_told_as_it_reflects():
    model, red, other = bases.fitted(9), library.reflectance("ColorChecker: red"), library.reflectance("CES 30")
    carried = model.coefficients(red)
    assert np.array_equal(inspection.reflectance(model, carried, red), red.sampled())
    for shown in (inspection.reflectance(model, carried), inspection.reflectance(model, carried, other)):
        np.testing.assert_allclose(model.coefficients(shown), carried, atol=1e-3)
    assert inspection.range_of(np.linspace(-0.1, 0.7, 81)) == "reflects -0.10 at 380 nm to 0.70 at 780 nm"
    assert inspection.range_of(np.full(81, 0.8)) == "reflects 0.80 of all light"
    assert inspection.range_of(None) == "no colour is carried"


@pytest.mark.parametrize("name", ["D65", "589 nm", "HP1"])
def test_an_icon_shows_the_curve_over_the_swatch(name):
    spectrum = library.illuminant(name)
    values, color = drawing.curve(spectrum), drawing.swatch(spectrum)
    picture = drawing.icon(values, color)
    assert np.allclose(picture[-1, 0, :3], color, atol=0.02), "the swatch, above the curve"
    inked = (np.abs(picture[..., :3] - color).max(axis=-1) > 0.2).sum(axis=0)
    assert abs(int(np.argmax(inked)) - np.argmax(values) * 32 / 81) < 3
