"""Invariants that every model keeps, whatever the spectra."""

import json

import numpy as np
import pytest

from relume.core import FactorModel, Spectrum, SpectrumError
from relume.core.model import bases
from relume.core.model.factor_model import ModelError
from relume.core.model.rules import Reconstructed
from relume.core.spectra import library

from .conftest import CMFS, difference, tristimulus

MODELS = {
    "rgb": bases.rgb(),
    "prefiltered": bases.prefiltered(library.illuminant("A")),
    "block": bases.block(9),
    "lagrange": bases.sharpened(5, "lagrange"),
    "nonnegative": bases.sharpened(5, "nonnegative"),
    **{f"fitted {p}": bases.fitted(p) for p in (3, 4, 5, 6, 7, 9, 12, 15, 18)},
    "bands": bases.bands(36),
}
NONNEGATIVE = [name for name in MODELS if name.startswith(("fitted", "bands", "block", "nonnegative"))]


@pytest.mark.parametrize("name", MODELS)
def test_filters_sum_to_one_and_white_is_exact(name, cie_lights, lamps):
    model = MODELS[name]
    assert np.abs(model.filters.sum(axis=0) - 1).max() < 1e-12
    assert np.abs(model.coefficients(np.ones(81)) - 1).max() < 1e-12
    for light in (*cie_lights, *lamps):
        np.testing.assert_allclose(model.relight(light).sum(axis=1), tristimulus(np.ones(81), light), atol=1e-9)


@pytest.mark.parametrize("name", NONNEGATIVE)
def test_filters_are_nonnegative(name):
    assert MODELS[name].filters.min() >= 0


@pytest.mark.parametrize("name", MODELS)
def test_survives_json(name):
    model = MODELS[name]
    again = FactorModel.from_dict(json.loads(json.dumps(model.to_dict())))
    light = library.illuminant("FL2")
    assert np.array_equal(again.filters, model.filters)
    # BLAS does not promise the same last bit twice.
    np.testing.assert_allclose(again.relight(light), model.relight(light), rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", ["fitted 9", "bands", "block"])
def test_reconstruction_has_the_coefficients_it_came_from(name):
    model = MODELS[name]
    coefficients = model.coefficients(library.reflectances("colorchecker"))
    np.testing.assert_allclose(model.coefficients(model.reconstruct(coefficients)), coefficients, atol=1e-6)
    np.testing.assert_allclose(model.reconstruct(np.full(model.channels, 0.4)), 0.4, atol=1e-6)


def test_prefiltering_is_exact_for_its_own_light(vrhel):
    light = library.illuminant("A")
    model = bases.prefiltered(light)
    xyz = model.coefficients(vrhel) @ model.relight(light).T
    np.testing.assert_allclose(xyz, tristimulus(vrhel, light.sampled()), atol=1e-12)


def test_published_basis_is_the_best_linear_model():
    """[DF]: filters span the principal components, so rebuilt spectra are the projections on them."""
    signals = np.stack([s.sampled() for s in library.reflectances("ces")])
    model = bases.sharpened(5, "lagrange", lights=[library.illuminant("E")])
    components = np.linalg.svd(signals.T)[0][:, :5]
    np.testing.assert_allclose(
        model.reconstruct(model.coefficients(signals)), signals @ components @ components.T, atol=1e-9
    )


@pytest.mark.parametrize("channels", [6, 9, 12])
def test_emission_of_a_light_in_anothers_group(channels, unseen_reflectances):
    model = bases.fitted(channels)
    tungsten, fluorescent = library.illuminant("A"), library.illuminant("FL2")
    emission = model.emission(fluorescent, tungsten)
    assert emission.min() >= 0
    white = tristimulus(np.ones(81), fluorescent.sampled())
    np.testing.assert_allclose(model.relight(tungsten) @ emission, white, atol=1e-6)
    xyz = model.coefficients(unseen_reflectances) * emission @ model.relight(tungsten).T
    error = difference(xyz, tristimulus(unseen_reflectances, fluorescent.sampled()), white)
    assert np.median(error) < {6: 2.0, 9: 0.6, 12: 0.6}[channels]
    assert (model.emission(tungsten, tungsten) == 1).all()


def test_other_observers():
    model = bases.fitted(9)
    light = library.illuminant("D65")
    ten_degrees = library.observer("CIE 1964 10°")
    expected = light.sampled() @ ten_degrees / (light.sampled() @ ten_degrees[:, 1])
    np.testing.assert_allclose(model.relight(light, "CIE 1964 10°").sum(axis=1), expected, atol=1e-9)
    np.testing.assert_allclose(model.relight(light, CMFS), model.relight(light), atol=1e-10)
    camera = library.camera("Nikon 5100 (NPL)")
    np.testing.assert_allclose(
        model.relight(light, camera).sum(axis=1), light.sampled() @ camera / (light.sampled() @ camera[:, 1]), atol=1e-9
    )


def test_refusals():
    model = bases.fitted(9)
    with pytest.raises(SpectrumError, match="81 values"):
        model.coefficients(np.ones(80))
    with pytest.raises(SpectrumError, match="finite"):
        model.coefficients(np.full(81, np.nan))
    with pytest.raises(ValueError, match="no power"):
        model.relight(np.zeros(81))
    with pytest.raises(ModelError, match="33 to 81"):
        bases.bands(12)
    with pytest.raises(ModelError, match="whole number"):
        bases.fitted(0)
    with pytest.raises(ModelError, match="choose"):
        bases.named("magic", 9)
    with pytest.raises(ModelError, match="independent components"):
        bases.sharpened(40)
    with pytest.raises(ModelError, match="not the description"):
        FactorModel.from_dict({"shape": 3})
    with pytest.raises(ModelError, match="sum to 1"):
        FactorModel("x", np.arange(3), np.ones((3, 2)), rule=Reconstructed(np.ones((3, 2))))


def test_spectrum_objects_and_arrays_agree():
    model = bases.fitted(6)
    patches = library.reflectances("colorchecker")
    table = np.stack([patch.sampled() for patch in patches])
    np.testing.assert_allclose(model.coefficients(patches), model.coefficients(table), rtol=1e-14)
    np.testing.assert_allclose(model.coefficients(patches[3]), model.coefficients(table[3]), rtol=1e-14)
    assert isinstance(patches[0], Spectrum)


@pytest.mark.parametrize(("channels", "parts"), [(3, 6), (9, 4), (36, 1), (81, 1)])
def test_shares_of_a_filter_average_to_its_coefficient(channels, parts):
    model = bases.bands(channels) if channels > 15 else bases.fitted(channels)
    index = library.glass("SF10")
    shares = model.shares(index)
    assert shares.shape == (parts, channels)
    assert shares.mean(axis=0) == pytest.approx(model.coefficients(index), rel=1e-12)
    assert (np.diff(shares, axis=0) < 0).all(), "blue is refracted more than red"
    assert np.ptp(shares, axis=0).max() < np.ptp(index.sampled())
