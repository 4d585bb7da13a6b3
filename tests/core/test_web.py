"""A page's numbers: planes that come back within a ΔE, matrices between temperatures, views, names as text."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from relume.core import bases, library, measure, spaces
from relume.core.errors import LibraryError, MeasureError, ResultError, UsageError
from relume.core.picture import mixing
from relume.core.picture.coefficient_image import CoefficientImage
from relume.core.picture.recombination import relight_matrix
from relume.core.web import encoding, lamps, luts, page

SOME = ("D65", "A", "FL2", "LED-RGB1", "Sodium (low pressure)")
HOSTILE = "<img src=x onerror=alert(1)>\"'&</script><!--\u202e\u2028\u2029"


def picture(channels=6, size=(48, 40), groups=("key", "fill")):
    model = bases.fitted(channels)
    height, width = size
    rng = np.random.default_rng(channels)
    patches = np.stack([model.coefficients(each) for each in library.reflectances("colorchecker")])
    surface = np.kron(patches.reshape(4, 6, channels), np.ones((-(-height // 4), -(-width // 6), 1)))[:height, :width]
    light = np.linspace(0.1, 1.3, width)[None, :, None] * (1 + 0.01 * rng.standard_normal((height, width, 1)))
    images = {name: (surface * light / (g + 1)).astype(np.float32) for g, name in enumerate(groups)}
    lit = {name: library.illuminant("A") for name in groups}
    return CoefficientImage(model, images, lit, np.ones(size, np.float32))


def matrices_of(image, names=SOME):
    return lamps.matrices(image.model, [library.illuminant(name) for name in names], [library.OBSERVER])[0]


@pytest.mark.parametrize("channels", [3, 6, 9, 15])
@pytest.mark.parametrize("wanted", [0.5, 1.0])
def test_what_is_decoded_is_within_what_was_wanted(channels, wanted):
    image = picture(channels)
    matrices = matrices_of(image)
    quality = encoding.quality_for(image.groups, matrices, 0.0, wanted)
    coded, _, reached = encoding.encode_within(wanted, image.groups, matrices, 0.0, quality)
    assert reached <= wanted
    pictures = [
        [each.reshape(-1, channels) for each in groups]
        for groups in (image.groups.values(), encoding.decode(coded).values())
    ]
    for name, matrix in zip(SOME, matrices, strict=True):
        assert np.percentile(encoding.difference(*pictures, [matrix] * len(coded)), 98) <= 1.1 * wanted, name


@pytest.mark.parametrize("values", [0.0, 1.0, 1e-9, 5000.0], ids=["black", "even", "tiny", "far above white"])
def test_even_pictures_come_back(values):
    image = picture(6)
    flat = {"key": np.full_like(image.groups["key"], values)}
    back = encoding.decode(encoding.encode(flat, matrices_of(image), 0.0, 90))["key"]
    np.testing.assert_allclose(back, values, rtol=0.03, atol=1e-6)
    np.testing.assert_allclose(back, back[..., :1].repeat(6, axis=2), rtol=1e-3, err_msg="grey stays grey")


def test_a_little_below_zero_stays_there():
    image = picture(6)
    groups = {**image.groups, "rest": np.full_like(image.groups["key"], -1e-4)}
    back = encoding.decode(encoding.encode(groups, matrices_of(image), 0.0, 90))["rest"]
    np.testing.assert_allclose(back, -1e-4, atol=1e-3)


def test_one_channel_is_one_plane():
    image = picture(3)
    grey = {"key": image.groups["key"][..., :1]}
    matrices = np.repeat(matrices_of(image).sum(axis=2, keepdims=True), 1, axis=2)
    coded = encoding.encode(grey, matrices, 0.0, 95)
    assert len(coded["key"].planes) == 1
    np.testing.assert_allclose(encoding.decode(coded)["key"], grey["key"], rtol=0.1, atol=0.02)


def test_a_quality_that_is_not_positive_is_refused():
    image = picture(3)
    with pytest.raises(MeasureError, match="more than 0"):
        encoding.quality_for(image.groups, matrices_of(image), 0.0, 0.0)


@pytest.mark.parametrize("kind", lamps.KINDS)
def test_between_temperatures_matrices_are_interpolated(kind):
    model = bases.fitted(9)
    known = lamps.matrices(model, lamps.temperature_spectra(kind), [library.OBSERVER])[0].astype(float)
    mireds = 1e6 / lamps.temperatures(kind)
    reflectances = np.stack([model.coefficients(each) for each in library.reflectances("ces")])
    word, coldest, hottest, _ = lamps.KINDS[kind]
    for kelvin in np.geomspace(coldest, hottest, 17):
        true = relight_matrix(model, library.illuminant(f"{word} {kelvin:.4f} K"))
        place = np.interp(1e6 / kelvin, mireds, np.arange(len(mireds)))
        first = min(int(place), len(mireds) - 2)
        between = known[first] + (place - first) * (known[first + 1] - known[first])
        assert measure.delta_E_2000(reflectances @ between.T, reflectances @ true.T, true.sum(axis=1)).max() < 0.15


def test_a_blend_is_the_mean_of_its_matrices():
    model = bases.fitted(9)
    reflectances = np.stack([model.coefficients(each) for each in library.reflectances("ces")])
    one, other = library.illuminant("FL2"), library.illuminant("Sodium (low pressure)")
    true = relight_matrix(model, mixing.blend(((one, 0.3), (other, 0.7))))
    mean = 0.3 * relight_matrix(model, one) + 0.7 * relight_matrix(model, other)
    assert measure.delta_E_2000(reflectances @ mean.T, reflectances @ true.T, true.sum(axis=1)).max() < 0.2


def test_a_view_transform_comes_back_from_its_table():
    def show(rgb):
        return spaces.srgb_encoded(rgb / (1 + np.maximum(rgb, 0)))

    lut = luts.bake(show)
    rgb = np.exp2(np.random.default_rng(0).uniform(-7, 4, (500, 3)))
    shown = luts.sampled(lut, rgb @ spaces.rgb_to_xyz().T)
    assert np.percentile(luts.difference(shown, show(rgb)), 98) < 0.8


def test_plain_views_need_no_table():
    assert luts.is_plain({}) and luts.is_plain({"view_transform": "Standard", "look": "None", "exposure": 2.0})
    assert not luts.is_plain({"view_transform": "AgX"})
    assert not luts.is_plain({"view_transform": "Standard", "look": "High Contrast"})


def test_names_mean_nothing_to_html(tmp_path):
    image = picture(3)
    spectrum = replace(library.illuminant("A"), name=HOSTILE, values=library.illuminant("A").values ** 2)
    hostile = replace(image, groups={HOSTILE: image.groups["key"]}, illuminants={HOSTILE: spectrum})
    out = tmp_path / "page.html"
    page.write(out, [page.Picture(HOSTILE, {1: lambda: hostile})], names=["A"], title=HOSTILE)
    text = out.read_text(encoding="utf-8")
    assert "<img" not in text
    data = re.search(r'<script type="application/json" id="data">(.*?)</script>', text)[1]
    assert not set("<>&\u2028\u2029\u202e") & set(data)
    content = json.loads(data)
    assert content["title"] == content["pictures"][0]["name"] == content["pictures"][0]["groups"][0]["name"] == HOSTILE
    assert content["lamps"][1]["name"] == HOSTILE and content["lamps"][1]["own"]


def test_a_page_needs_nothing_else(tmp_path):
    out = tmp_path / "page.html"
    image = picture(3)
    page.write(out, [page.Picture("key", {1: lambda: image})], names=["A", "D65"])
    text = out.read_text(encoding="utf-8")
    assert set(re.findall(r"https?://[^\s\"'`]+", text)) == {"http://www.w3.org/2000/svg"}
    assert "default-src 'none'" in text and "unsafe" not in text
    assert not re.search(r"<(?:script|link|img|iframe)[^>]+(?:src|href)=\"(?!data:,)", text)


def test_pages_are_the_same_twice_and_smaller_where_less_is_wanted(tmp_path):
    image = picture(6, (96, 96))
    shown = [page.Picture("key", {1: lambda: image})]
    for name, quality in (("one", 1.0), ("two", 1.0), ("rough", 4.0)):
        page.write(tmp_path / name, shown, names=["A", "D65"], quality=quality)
    one, two, rough = ((tmp_path / name).read_bytes() for name in ("one", "two", "rough"))
    assert one == two and len(rough) < len(one)


def test_a_smaller_picture_keeps_the_mean(tmp_path):
    image = picture(3, (64, 48))
    small = page.shrunk(image, 16)
    assert small.size == (12, 16)
    for name, each in image.groups.items():
        np.testing.assert_allclose(small.groups[name].mean(axis=(0, 1)), each.mean(axis=(0, 1)), rtol=1e-3)
    assert page.shrunk(image, None) is image and page.shrunk(image, 64) is image


def test_what_cannot_be_written_says_so_and_leaves_nothing(tmp_path):
    image = picture(3)
    shown = [page.Picture("key", {1: lambda: image})]
    with pytest.raises(LibraryError, match="Sodiu"):
        page.write(tmp_path / "page.html", shown, names=["Sodiu"])
    with pytest.raises(UsageError, match="no picture"):
        page.write(tmp_path / "page.html", [])
    with pytest.raises(ResultError):
        page.write(tmp_path / "nowhere" / "page.html", shown, names=["A"])
    other = replace(image, groups={"key": image.groups["key"]}, illuminants={"key": library.illuminant("A")})
    with pytest.raises(ValueError, match="frame 2: other light groups"):
        page.write(tmp_path / "page.html", [page.Picture("key", {1: lambda: image, 2: lambda: other})], names=["A"])
    assert not list(tmp_path.iterdir())
