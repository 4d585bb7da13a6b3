"""Narrow spectra are integrated on their own wavelengths, in colour and in coefficients."""

import numpy as np
import pytest

from relume.core.model import bases, integration
from relume.core.spectra import library
from relume.core.spectra.spectrum import WAVELENGTHS, Spectrum

NM = integration.FINE


@pytest.mark.parametrize("wavelength", [450, 532.4, 589.3, 647])
def test_a_line_has_its_own_colour(wavelength):
    seen = bases.fitted(9).relight(library.line(wavelength)).sum(axis=1)
    true = np.array([np.interp(wavelength, NM, column) for column in library.sensitivities("CIE 1931 2", NM).T])
    assert np.allclose(seen, true / true[1], rtol=1e-6)


def test_an_led_of_2_nm_steps_has_the_colour_of_its_integral():
    fine = np.arange(380, 781, 2.0)
    led = Spectrum(fine, np.exp(-0.5 * ((fine - 521) / 4) ** 2), "LED", "illuminant")
    every = np.arange(380, 780.01, 0.1)
    power = np.interp(every, fine, led.values)
    cmfs = [np.interp(every, NM, column) for column in library.sensitivities("CIE 1931 2", NM).T]
    true = np.array([(power * column).sum() for column in cmfs])
    assert np.allclose(bases.fitted(9).relight(led).sum(axis=1), true / true[1], rtol=2e-3)


@pytest.mark.parametrize("name", ["A", "FL11", "HP1", "Kinoton 75P", "532 nm"])
@pytest.mark.parametrize("observer", ["CIE 1931 2°", "Nikon 5100 (NPL)"])
def test_white_is_the_same_at_1_and_at_5_nm(name, observer):
    light = library.illuminant(name)
    fine, coarse = (each(light, observer).sum(axis=0) for each in (integration.fine_weights, integration.light_weights))
    assert np.allclose(fine, coarse, rtol=1e-9)


def test_coefficients_are_integrals_of_a_narrow_gel():
    """Filters are linear between their wavelengths: coefficients are then integrals to the last digits."""
    model = bases.fitted(12)
    gel = Spectrum(NM, 0.05 + 0.9 * (abs(NM - 533) < 3), "gel")
    every = np.arange(380, 780.005, 0.01)
    values = np.interp(every, NM, gel.values)
    filters = np.stack([np.interp(every, WAVELENGTHS, column) for column in model.filters.T], axis=1)
    assert np.allclose(model.coefficients(gel), values @ filters / filters.sum(axis=0), atol=2e-4)
    assert np.allclose(model.coefficients(Spectrum(NM, np.full(401, 0.3))), 0.3, rtol=1e-12)


def test_coarse_spectra_stay_as_they_are_measured():
    patch = library.reflectance("ColorChecker: red")
    assert np.array_equal(patch.sampled(), np.interp(WAVELENGTHS, patch.wavelengths, patch.values))
