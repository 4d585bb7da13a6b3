"""Coefficient images on disk: what comes back, what half floats cost, what is refused."""

import json
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

from relume.core.model import bases
from relume.core.picture import coefficients
from relume.core.spectra import library


@pytest.fixture
def image():
    model = bases.fitted(6)
    patches = model.coefficients(library.reflectances("colorchecker")).reshape(4, 6, 6).astype(np.float32)
    return coefficients.CoefficientImage(
        model=model,
        groups={"Key": patches, "Fill": 0.3 * patches[::-1]},
        illuminants={"Key": library.illuminant("A"), "Fill": library.illuminant("FL11")},
        alpha=np.ones((4, 6), dtype=np.float32),
    )


def as_half(path):
    """Write an EXR again in half precision."""
    pixels = oiio.ImageBuf(str(path)).get_pixels(oiio.FLOAT)
    spec = oiio.ImageInput.open(str(path)).spec()
    spec.set_format(oiio.HALF)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec) and output.write_image(pixels) and output.close()


def picture(image):
    return coefficients.recombine(
        list(image.groups.values()), [image.model.relight(light) for light in image.illuminants.values()]
    )


def test_comes_back_bit_for_bit(image, tmp_path):
    coefficients.write(tmp_path / "a.exr", image, picture(image))
    again = coefficients.read(tmp_path / "a.exr")
    for name, values in image.groups.items():
        np.testing.assert_array_equal(again.groups[name], values)
    assert json.dumps(again.model.to_dict()) == json.dumps(image.model.to_dict())


def test_half_floats_keep_eleven_bits(image, tmp_path):
    coefficients.write(tmp_path / "a.exr", image, picture(image))
    as_half(tmp_path / "a.exr")
    again = coefficients.read(tmp_path / "a.exr")
    np.testing.assert_allclose(again.groups["Key"], image.groups["Key"], rtol=2.0**-11)
    # Rounding is independent in each channel; a relight matrix has entries of either sign.
    np.testing.assert_allclose(picture(again), picture(image), atol=2e-3)


@pytest.mark.parametrize("bad", [1e6, np.nan, -np.inf])
def test_what_is_not_finite_is_refused_by_name(image, tmp_path, bad):
    image.groups["Fill"][2, 3, 4] = bad
    coefficients.write(tmp_path / "a.exr", image, np.zeros((4, 6, 3), dtype=np.float32))
    as_half(tmp_path / "a.exr")
    with pytest.raises(coefficients.CoefficientImageError, match=r"a.exr: channel .*Fill.* has 1 pixels .* half"):
        coefficients.read(tmp_path / "a.exr")


def test_a_file_of_the_first_version_is_read_for_ever():
    path = Path(__file__).parent / "files/version_1.exr"  # written by Relume 0.1.0
    found, model = coefficients.read(path), bases.fitted(3)
    patches = model.coefficients(library.reflectances("colorchecker")).reshape(4, 6, 3)
    np.testing.assert_allclose(found.groups["Key"], patches, rtol=1e-6)
    np.testing.assert_allclose(found.groups["Everything else"], 0.25 * patches[::-1], rtol=1e-6)
    assert list(found.groups) == ["Key", "Everything else"] and found.gains == {"Key": 2.0, "Everything else": 0.5}
    assert (found.white, found.white_balance, found.observer) == ((1.1, 1.0, 0.35), 0.5, "CIE 1964 10°")
    assert found.view["view_transform"] == "AgX"
    assert coefficients.describe(path).size == found.size == (6, 4)


@pytest.fixture
def tall():
    """More rows than are read at a time, and not a multiple of them."""
    model, random = bases.fitted(6), np.random.default_rng(5)
    groups = {name: random.random((150, 7, 6), dtype=np.float32) for name in ("Key", "Fill")}
    alpha = random.random((150, 7), dtype=np.float32)
    return coefficients.CoefficientImage(model, groups, dict.fromkeys(groups, library.illuminant("A")), alpha)


def as_tiles(path):
    """Write an EXR again in tiles, as other programs do."""
    pixels, spec = oiio.ImageBuf(str(path)).get_pixels(oiio.FLOAT), oiio.ImageInput.open(str(path)).spec()
    spec.tile_width = spec.tile_height = 32
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec) and output.write_image(pixels) and output.close()


@pytest.mark.parametrize("stored", [lambda path: None, as_tiles])
def test_read_a_few_rows_at_a_time_it_is_the_same_picture(tall, tmp_path, stored):
    path = tmp_path / "a.exr"
    coefficients.write(path, tall, picture(tall))
    stored(path)
    again = coefficients.read(path)
    for name, values in tall.groups.items():
        np.testing.assert_array_equal(again.groups[name], values)
    np.testing.assert_array_equal(again.alpha, tall.alpha)
    described, relit = coefficients.relit(path, lambda image: image.matrices())
    np.testing.assert_array_equal(described.alpha, tall.alpha)
    np.testing.assert_array_equal(relit, coefficients.recombine(list(again.groups.values()), again.matrices()))
    assert described.size == again.size and not described.groups


def test_pixels_that_are_not_finite_are_counted_in_all_rows_before_anything_is_made_of_them(tall, tmp_path):
    for row in (70, 140):
        tall.groups["Fill"][row, 1, 2] = np.inf
    coefficients.write(tmp_path / "a.exr", tall, np.zeros((150, 7, 3), dtype=np.float32))
    for read in (coefficients.read, lambda path: coefficients.relit(path, lambda image: image.matrices())):
        with pytest.raises(coefficients.CoefficientImageError, match=r"Fill.* has 2 pixels"):
            read(tmp_path / "a.exr")


def test_a_file_cut_short_below_its_first_rows_is_refused(tall, tmp_path):
    path = tmp_path / "a.exr"
    coefficients.write(path, tall, picture(tall))
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 3 // 4])
    with pytest.raises(coefficients.CoefficientImageError, match="cut short|cannot be read"):
        coefficients.relit(path, lambda image: image.matrices())
