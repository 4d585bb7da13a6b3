"""Integrals over wavelength: exact for what is measured more finely than the grid of WAVELENGTHS, as for lines.

On that grid a value stands for a triangle of 5 nm to either side. The weight of a light and of an observer there is the
integral of their product times the triangle, not the product of two values: so a line has its own colour, and a white
has the same under the grid as under spectra of 1 nm (`fine_weights`), which are the truth that models are held against.
"""

from collections.abc import Sequence
from functools import cache, lru_cache

import numpy as np

from ..errors import SpectrumError
from ..spectra import library
from ..spectra.arrays import Array, resampled
from ..spectra.spectrum import WAVELENGTHS, Spectrum

__all__ = ["FINE", "fine_weights", "is_finer", "light_weights", "sharing"]

FINE = np.arange(WAVELENGTHS[0], WAVELENGTHS[-1] + 0.5, 1.0)  # nm, (401,)
FINE.setflags(write=False)
_STEP = WAVELENGTHS[1] - WAVELENGTHS[0]

Observer = str | Sequence[Spectrum] | Array


@cache
def sharing() -> Array:
    """(401, 81): the part of each wavelength of FINE that each of its two neighbours on WAVELENGTHS has."""
    distance = np.abs(FINE[:, None] - WAVELENGTHS) / _STEP
    parts = np.maximum(1 - distance, 0)
    parts.setflags(write=False)
    return parts


def is_finer(spectrum: Spectrum) -> bool:
    """Whether a spectrum is measured in steps below 5 nm somewhere, or is the line of a lamp."""
    if spectrum.wavelengths.size == 1:
        return spectrum.kind == "illuminant"
    return bool(np.diff(spectrum.wavelengths).min() < _STEP * (1 - 1e-9))


def light_weights(light: Spectrum, observer: Observer = library.OBSERVER) -> Array:
    """A light times an observer's sensitivities on WAVELENGTHS -> (81, 3), in the light's own unit.

    observer: a name that `library.sensitivities` knows, or sensitivities, three Spectrum or (81, 3). Raises
    LibraryError, SpectrumError.
    """
    if not is_finer(light):
        return light.sampled()[:, None] * _on_grid(observer)
    return sharing().T @ _fine_product(light, observer) / _STEP


def fine_weights(light: Spectrum, observer: Observer = library.OBSERVER) -> Array:
    """The same at 1 nm, on FINE -> (401, 3): a perfect white has the same colour on both, rounding apart.

    Raises as `light_weights` does.
    """
    weights = _fine_product(light, observer) / _STEP
    if not is_finer(light):  # on the grid it is the sum of CIE 15: what that and the integral differ by is no error
        weights = weights * (light_weights(light, observer).sum(axis=0) / np.maximum(weights.sum(axis=0), 1e-300))
    return weights


def _fine_product(light: Spectrum, observer: Observer) -> Array:
    if light.wavelengths.size > 1:
        return light.sampled(FINE)[:, None] * _on_fine(observer)
    # A line's power is shared by two wavelengths of FINE, its sensitivities are its own
    own = np.stack([np.interp(light.wavelengths, FINE, column) for column in _on_fine(observer).T], axis=1)
    return light.sampled(FINE)[:, None] * own


def _on_grid(observer: Observer) -> Array:
    if isinstance(observer, str):
        return library.sensitivities(observer)
    if len(observer) == 3 and all(isinstance(one, Spectrum) for one in observer):
        return np.stack([one.sampled() for one in observer], axis=1)
    cmfs = np.asarray(observer, dtype=np.float64)
    if cmfs.shape != (WAVELENGTHS.size, 3) or not np.isfinite(cmfs).all():
        raise SpectrumError(f"an observer needs {WAVELENGTHS.size} x 3 finite sensitivities, got an array {cmfs.shape}")
    return cmfs


def _on_fine(observer: Observer) -> Array:
    if isinstance(observer, str):
        return _named_on_fine(observer)
    if len(observer) == 3 and all(isinstance(one, Spectrum) for one in observer):
        return np.stack([one.sampled(FINE) for one in observer], axis=1)
    return resampled(_on_grid(observer).T, FINE).T


@lru_cache(maxsize=16)
def _named_on_fine(name: str) -> Array:
    table = library.sensitivities(name, FINE)
    table.setflags(write=False)
    return table
