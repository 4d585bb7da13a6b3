import numpy as np
import pytest

from relume.core.model import bases, fresnel
from relume.core.spectra import library


def complex_fresnel(n, k, cosine):
    """Unpolarised reflectance from Fresnel's amplitudes with a complex index."""
    index = n + 1j * k
    inside = np.sqrt(1 - (1 - cosine**2) / index**2)
    s = (cosine - index * inside) / (cosine + index * inside)
    p = (index * cosine - inside) / (index * cosine + inside)
    return (np.abs(s) ** 2 + np.abs(p) ** 2) / 2


def test_reflectance_agrees_with_complex_amplitudes():
    random = np.random.default_rng(0)
    n, k, cosine = random.uniform(0.05, 5, 500), random.uniform(0, 8, 500), random.uniform(0.001, 1, 500)
    np.testing.assert_allclose(fresnel.reflectance(n, k, cosine), complex_fresnel(n, k, cosine), atol=1e-10)


@pytest.mark.parametrize("metal", library.conductors())
@pytest.mark.parametrize("channels", [3, 9])
def test_channels_reflect_what_their_filters_see(metal, channels):
    model = bases.fitted(channels)
    n, k = library.conductor(metal)
    n_channel, k_channel = fresnel.conductor_channels(model, n, k)
    assert n_channel.shape == k_channel.shape == (channels,) and (n_channel > 0).all() and (k_channel > 0).all()
    for cosine in (0.05, 0.3, 0.6, 1.0):
        seen = complex_fresnel(n.sampled(), k.sampled(), cosine) @ model.filters
        np.testing.assert_allclose(complex_fresnel(n_channel, k_channel, cosine), seen, atol=0.012)


def test_reference_keeps_the_metal_itself():
    n, k = library.conductor("gold")
    model = bases.bands(36)
    n_channel, k_channel = fresnel.conductor_channels(model, n, k)
    samples = model.wavelengths @ model.filters
    np.testing.assert_allclose(n_channel, n.sampled(samples), atol=1e-6)
    np.testing.assert_allclose(k_channel, k.sampled(samples), atol=1e-6)


def test_signed_filters_give_positive_indices():
    n, k = library.conductor("gold")
    n_channel, k_channel = fresnel.filtered_conductor(bases.rgb().filters, n.sampled(), k.sampled())
    assert (n_channel > 0).all() and (k_channel > 0).all()
    assert np.isfinite(n_channel).all() and np.isfinite(k_channel).all()
