"""What one pixel of a coefficient image sends to the eye: its spectrum, its colour, and its difference to another."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..colour import differences
from ..model import relight
from ..model.factor_model import FactorModel
from ..spectra import library
from ..spectra.arrays import Array, ArrayLike
from ..spectra.spectrum import WAVELENGTHS, Spectrum
from .mix import Mix
from .recombination import color_of, mixed_white

__all__ = ["Pixel", "difference", "inspect", "range_of", "reflectance"]

_SAME = 0.01  # largest difference of coefficients of one surface


@dataclass(frozen=True)
class Pixel:
    """spectrum: (81,) power on `WAVELENGTHS`, its highest 1. xyz: (3,), in the unit of the picture."""

    spectrum: Array
    xyz: Array


def inspect(model: FactorModel, mix: Mix, coefficients: Sequence[ArrayLike]) -> Pixel:
    """The pixel of coefficients (groups, p) under the light of each group, before white balance.

    The spectrum is the smoothest that has these coefficients, times the illuminant; its colour is the relight
    matrices', as in the picture, and not that of the drawn curve.
    """
    luminous = library.observer()[:, 1]
    spectrum = np.zeros(WAVELENGTHS.size)
    for light, each in zip(mix.lights.values(), coefficients, strict=True):
        if light.gain > 0.0:
            power = light.illuminant.sampled()
            relight.power_weights(power, library.observer())  # raises SpectrumError where it cannot be seen
            reflected = np.interp(WAVELENGTHS, model.wavelengths, model.reconstruct(each))
            spectrum += light.gain * power / (power @ luminous) * np.maximum(reflected, 0.0)
    highest = spectrum.max()
    return Pixel(spectrum / highest if highest > 0.0 else spectrum, color_of(model, mix, coefficients))


def reflectance(model: FactorModel, coefficients: ArrayLike, known: Spectrum | None = None) -> Array:
    """(81,) what a surface reflects that an AOV carries the coefficients (p,) of, on `WAVELENGTHS`.

    That of its material, `known`, where it has these coefficients; otherwise the smoothest that has.
    """
    carried = np.asarray(coefficients, dtype=np.float64)
    if known is not None and np.abs(model.coefficients(known) - carried).max() < _SAME:
        return known.sampled()
    return np.interp(WAVELENGTHS, model.wavelengths, model.reconstruct(carried))


def range_of(spectrum: ArrayLike | None) -> str:
    """How much a surface reflects, in words."""
    if spectrum is None:
        return "no colour is carried"
    low, high = np.argmin(spectrum), np.argmax(spectrum)
    values = np.asarray(spectrum)
    if values[high] - values[low] < 0.005:
        return f"reflects {values[low]:.2f} of all light"
    least, most = f"{values[low]:.2f} at {WAVELENGTHS[low]:g} nm", f"{values[high]:.2f} at {WAVELENGTHS[high]:g} nm"
    return f"reflects {least} to {most}"


def difference(model: FactorModel, mix: Mix, one: Pixel, other: Pixel) -> float:
    """CIEDE2000 of two pixels in the mixed light, exposed so that the brighter of the two has half its luminance."""
    brighter = max(one.xyz[1], other.xyz[1])
    if not brighter > 0.0:
        return 0.0
    white = mixed_white(model, mix)
    return float(differences.delta_E_2000(0.5 * one.xyz / brighter, 0.5 * other.xyz / brighter, white))
