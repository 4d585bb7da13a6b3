"""Invariants that hold for every model and every input, searched by hypothesis for what breaks them."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from scipy.integrate import trapezoid

from relume.core import FactorModel, Spectrum, SpectrumError
from relume.core.colour import differences
from relume.core.model import bases, upsample
from relume.core.model.factor_model import ModelError
from relume.core.spectra import library
from relume.core.spectra.spectrum import WAVELENGTHS

from .conftest import tristimulus

MODELS = {
    "rgb": bases.rgb(),
    "prefiltered": bases.prefiltered(library.illuminant("FL2")),
    "eq. 11": bases.sharpened(6, "lagrange"),
    "eq. 12": bases.sharpened(6, "nonnegative"),
    "block": bases.block(6),
    **{f"fitted {p}": bases.fitted(p) for p in (3, 4, 5, 6, 7, 9, 12, 15, 18)},
    "scene": bases.scene(6, library.reflectances("colorchecker")[:8], [library.illuminant("A")] * 2, exact=False),
    "bands": bases.bands(36),
}
NONNEGATIVE = [name for name in MODELS if name.startswith(("eq. 12", "block", "fitted", "scene", "bands"))]
every_model = pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
nonnegative_model = pytest.mark.parametrize("model", [MODELS[name] for name in NONNEGATIVE], ids=NONNEGATIVE)

reflectances = arrays.arrays(np.float64, (81,), elements=st.floats(0, 1))
signed = arrays.arrays(np.float64, (81,), elements=st.floats(-10, 10))
powers = arrays.arrays(np.float64, (81,), elements=st.floats(0, 1e6))
named_lights = st.sampled_from(["D65", "589 nm"]).map(lambda name: library.illuminant(name).sampled())
few = settings(max_examples=30, deadline=None)


@st.composite
def sampled_spectra(draw, kind="reflectance"):
    """Spectra of 1 to 40 samples at any wavelengths, in any order."""
    nm = draw(st.lists(st.floats(350, 820), min_size=1, max_size=40, unique=True))
    values = draw(st.lists(st.floats(0, 1), min_size=len(nm), max_size=len(nm)))
    return Spectrum(nm, values, "drawn", kind)


@every_model
@given(first=signed, second=signed, scale=st.floats(-1e6, 1e6))
@few
def test_scaling_and_adding_are_exact(model, first, second, scale):
    separate = model.coefficients(first) + scale * model.coefficients(second)
    largest = np.abs(model.filters).sum() * (10 + abs(scale) * 10)
    np.testing.assert_allclose(model.coefficients(first + scale * second), separate, rtol=0, atol=1e-14 * largest)


@every_model
@given(level=st.floats(0, 1e30))
@few
def test_grey_has_equal_coefficients(model, level):
    np.testing.assert_allclose(model.coefficients(np.full(81, level)), level, rtol=1e-12, atol=1e-300)


@every_model
@given(power=powers)
@few
def test_white_is_exact_under_every_light(model, power):
    assume(tristimulus(np.ones(81), power + 1e-300)[1] > 0 and power @ library.observer()[:, 1] > 1e-6)
    np.testing.assert_allclose(model.relight(power).sum(axis=1), tristimulus(np.ones(81), power), rtol=1e-8, atol=1e-8)


@nonnegative_model
@given(low=reflectances, more=reflectances)
@few
def test_more_reflectance_never_lowers_a_coefficient(model, low, more):
    lower, higher = model.coefficients(low), model.coefficients(np.maximum(low, more))
    assert (higher >= lower - 1e-15).all()
    assert lower.min() >= 0 and higher.max() <= 1 + 1e-12


@nonnegative_model
@given(spectrum=reflectances, bounces=st.integers(1, 200))
@few
def test_no_number_of_bounces_makes_light(model, spectrum, bounces):
    coefficients = model.coefficients(0.99 * spectrum)
    powers_of = coefficients[None] ** np.arange(bounces + 1)[:, None]
    assert (np.diff(powers_of, axis=0) <= 0).all()
    assert (1 / (1 - coefficients) > 0).all()


@every_model
@given(light=sampled_spectra("illuminant"), surface=sampled_spectra())
@few
def test_any_measured_spectra_give_finite_colours_or_a_named_refusal(model, light, surface):
    try:
        xyz = model.relight(light) @ model.coefficients(surface)
    except SpectrumError as error:
        assert "drawn" in str(error) or "illuminant" in str(error)
        return
    assert np.isfinite(xyz).all()


@every_model
@given(power=st.one_of(powers, named_lights), scale=st.floats(1e-30, 1e30))
@few
def test_the_power_of_a_light_cancels(model, power, scale):
    assume(power @ library.observer()[:, 1] > 1e-6)
    # Lights of a single sample leave some directions to the ridge: compare what the matrix makes of real reflectances.
    seen = model.coefficients(library.reflectances("colorchecker"))
    np.testing.assert_allclose(
        seen @ model.relight(power * scale).T, seen @ model.relight(power).T, rtol=1e-5, atol=1e-6
    )


@given(bad=st.sampled_from([np.nan, np.inf, -np.inf]), where=st.integers(0, 80))
@few
def test_what_is_not_finite_is_refused(bad, where):
    spectrum = np.ones(81)
    spectrum[where] = bad
    model = MODELS["fitted 9"]
    for refused in (
        lambda: model.coefficients(spectrum),
        lambda: model.relight(spectrum),
        lambda: model.emission(spectrum, np.ones(81)),
        lambda: Spectrum(WAVELENGTHS, spectrum),
        lambda: model.reconstruct(spectrum[where] * np.ones(9)),
        lambda: FactorModel("own", WAVELENGTHS, spectrum[:, None] / 81),
    ):
        with pytest.raises((SpectrumError, ModelError), match="finite"):
            refused()


@given(spectrum=sampled_spectra(), order=st.randoms())
@few
def test_the_order_of_samples_is_irrelevant(spectrum, order):
    pairs = list(zip(spectrum.wavelengths, spectrum.values, strict=True))
    order.shuffle(pairs)
    again = Spectrum(*zip(*pairs, strict=True), "shuffled")
    np.testing.assert_array_equal(again.wavelengths, spectrum.wavelengths)
    np.testing.assert_array_equal(again.values, spectrum.values)


@given(fine=st.floats(0.05, 4.9), centre=st.floats(420, 740), width=st.floats(0.5, 30))
@few
def test_power_and_centroid_of_a_fine_light_are_kept(fine, centre, width):
    nm = np.arange(centre - 1.2 * width, centre + 1.2 * width, min(fine, width / 4))
    power = np.maximum(1 - np.abs(nm - centre) / width, 0)
    light = Spectrum(nm, power, kind="illuminant")
    seen = light.sampled()
    area = trapezoid(power, nm)
    inside = (nm > 385) & (nm < 775)
    assume(inside.all())
    np.testing.assert_allclose(seen.sum() * 5, area, rtol=1e-9)
    moment = trapezoid(power * (nm - centre), nm)
    np.testing.assert_allclose((seen * (WAVELENGTHS - centre)).sum() * 5, moment, atol=0.02 * area)


@given(rgb=arrays.arrays(np.float64, (3,), elements=st.floats(0, 1)), channels=st.sampled_from([9, 12, 15]))
@few
def test_every_srgb_colour_comes_back(rgb, channels):
    model = bases.fitted(channels)
    coefficients = upsample.rgb_matrix(model) @ rgb
    assert coefficients.min() >= -0.002 and coefficients.max() <= 1.002
    light = library.illuminant("D65")
    truth = upsample.rgb_to_xyz() @ rgb
    assert differences.delta_E_2000(model.relight(light) @ coefficients, truth, model.relight(light).sum(axis=1)) < 0.01
