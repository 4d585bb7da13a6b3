"""How near the fitted models come to spectral integration, on reflectances and lamps they were not fitted to."""

import numpy as np
import pytest

from relume.core import Spectrum
from relume.core.model import bases
from relume.core.spectra import library
from relume.core.spectra.spectrum import WAVELENGTHS

from .conftest import bounces, difference, tristimulus

# channels: median, 90th, 99th percentile of CIEDE2000 after one bounce; CIE illuminants, then unseen lamps
AIMS = {
    3: ((0.90, 2.2, 4.3), (1.2, 3.2, 5.4)),
    6: ((0.22, 0.70, 1.5), (0.30, 1.0, 1.9)),
    9: ((0.08, 0.23, 0.50), (0.09, 0.28, 0.65)),
    12: ((0.05, 0.14, 0.30), (0.06, 0.19, 0.45)),
    15: ((0.03, 0.08, 0.19), (0.04, 0.12, 0.30)),
}


def errors(model, spectra, lights, count=1):
    chosen = bounces(spectra, count)
    products = spectra[chosen].prod(axis=1)
    coefficients = model.coefficients(spectra)[chosen].prod(axis=1)
    return np.concatenate(
        [
            difference(
                coefficients @ model.relight(light).T,
                tristimulus(products, light),
                np.maximum(tristimulus(np.ones(81), light), 1e-6),
            )
            for light in lights
        ]
    )


@pytest.mark.parametrize("channels", AIMS)
def test_one_bounce_on_unseen_reflectances(channels, vrhel, cie_lights, lamps):
    for lights, aim in zip((cie_lights, lamps), AIMS[channels], strict=True):
        reached = np.percentile(errors(bases.fitted(channels), vrhel, lights), [50, 90, 99])
        assert (reached <= aim).all(), reached


@pytest.mark.parametrize("channels", AIMS)
def test_more_bounces_are_little_worse(channels, vrhel, cie_lights):
    for count in (2, 3):
        reached = np.percentile(errors(bases.fitted(channels), vrhel, cie_lights, count), [50, 90, 99])
        assert (reached <= 1.2 * np.array(AIMS[channels][0])).all(), reached


@pytest.mark.parametrize("channels", AIMS)
def test_another_unseen_chart(channels, unseen_reflectances, cie_lights):
    reached = np.percentile(errors(bases.fitted(channels), unseen_reflectances, cie_lights), [50, 90, 99])
    assert (reached <= 1.2 * np.array(AIMS[channels][0])).all(), reached


def test_the_reference_is_far_better_than_what_it_judges(vrhel, cie_lights):
    for count in (1, 2, 3):
        assert np.percentile(errors(bases.bands(36), vrhel, cie_lights, count), 99) < 0.25


def test_single_lines_keep_hue_and_lightness(unseen_reflectances):
    """Under one line every surface has the line's chromaticity; only its lightness can be wrong."""
    light = library.illuminant("589 nm")
    xyz = bases.fitted(9).coefficients(unseen_reflectances) @ bases.fitted(9).relight(light).T
    line = tristimulus(np.ones(81), light.sampled())
    np.testing.assert_allclose(xyz, xyz[:, 1:2] * line, atol=2e-3)
    truth = tristimulus(unseen_reflectances, light.sampled())
    assert np.abs(np.cbrt(xyz[:, 1]) - np.cbrt(truth[:, 1])).max() * 116 < 8


def metamers(light, count, seed=1):
    """Pairs of reflectances (count, 2, 81) of the same XYZ under `light`: mixtures of CES plus metameric blacks."""
    random = np.random.default_rng(seed)
    ces = np.stack([s.sampled() for s in library.reflectances("ces")])
    weighted = light[:, None] * np.asarray(library.observer())
    projector = np.eye(81) - weighted @ np.linalg.pinv(weighted)
    pairs = []
    while len(pairs) < count:
        base = 0.15 + 0.7 * ces[random.integers(99, size=2)].mean(axis=0)
        black = projector @ (ces[random.integers(99)] - ces[random.integers(99)])
        room = np.where(black > 0, (1 - base) / np.maximum(black, 1e-12), base / np.maximum(-black, 1e-12)).min()
        pair = np.stack([base, base + room * 0.95 * black])
        if room > 0.05:
            pairs.append(pair)
    return np.array(pairs)


@pytest.mark.parametrize("channels, bound", [(9, 0.10), (12, 0.05)])
def test_metamers_split_as_they_should(channels, bound):
    daylight, tungsten = (library.illuminant(name).sampled() for name in ("D65", "A"))
    pairs = metamers(daylight, 414)
    first, second = (tristimulus(pairs[:, side], daylight) for side in (0, 1))
    assert np.abs(first - second).max() < 1e-9
    white = tristimulus(np.ones(81), tungsten)
    split = difference(*(tristimulus(pairs[:, side], tungsten) for side in (0, 1)), white)
    model = bases.fitted(channels)
    seen = model.coefficients(pairs) @ model.relight(tungsten).T
    ours = difference(seen[:, 0], seen[:, 1], white)
    visible = split > 1
    assert visible.sum() > 200
    assert np.median(np.abs(ours - split)[visible] / split[visible]) < bound


@pytest.fixture(scope="module")
def patches():
    return library.reflectances("colorchecker")[:10]


@pytest.fixture(scope="module")
def lit_by():
    return [library.illuminant(name) for name in ("A", "FL2")]


@pytest.fixture(scope="module")
def own_model(patches, lit_by):
    """Six channels for the patches under two lights; finding it takes seconds."""
    return bases.scene(6, patches, lit_by)


def test_scene_is_better_on_its_own_products(own_model, patches, lit_by):
    own, model = np.stack([patch.sampled() for patch in patches]), own_model
    assert model.filters.min() >= 0
    power = [light.sampled() for light in lit_by]
    ours = np.concatenate([errors(model, own, power, count) for count in (1, 2, 3)])
    general = np.concatenate([errors(bases.fitted(6), own, power, count) for count in (1, 2, 3)])
    assert np.percentile(ours, 99) < min(0.5, 0.6 * np.percentile(general, 99))


@pytest.mark.parametrize("channels, names", [(6, ["D65"]), (12, ["A", "FL11"])])
@pytest.mark.parametrize("lobes", [False, True])
def test_known_lights_are_exact_for_every_reflectance(channels, names, lobes, patches, unseen_reflectances):
    lights = [library.illuminant(name) for name in names]
    model = bases.scene(channels, patches, lights, lobes=lobes)
    assert lobes or model.filters.min() >= 0
    assert np.abs(model.filters.sum(axis=0) - 1).max() < 1e-12
    random = np.random.default_rng(0).random((50, 81))
    for light in lights:
        assert errors(model, np.concatenate([unseen_reflectances, random]), [light.sampled()]).max() < 1e-6
    assert model.coefficients(patches).min() > 0


def test_scene_is_no_worse_elsewhere_than_its_bound(own_model, vrhel, cie_lights):
    general = np.percentile(errors(bases.fitted(6), vrhel, cie_lights), 99)
    assert np.percentile(errors(own_model, vrhel, cie_lights), 99) < 2.5 * general


def test_scene_survives_json(own_model):
    model, again = own_model, type(own_model).from_dict(own_model.to_dict())
    light = Spectrum(WAVELENGTHS, np.linspace(0.2, 1, 81), kind="illuminant")
    assert np.array_equal(again.filters, model.filters)
    np.testing.assert_allclose(again.relight(light), model.relight(light), rtol=0, atol=1e-9)
