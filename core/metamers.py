"""Designing metamers: reflectances that match under one light and come apart under another.

[BMD] S. Bergner, T. Moller, M. S. Drew, "A spectral engine for visualization", SFU-CMPT-TR2004-06.
"""

import numpy as np

from . import library, relight
from .spectrum import WAVELENGTHS, Spectrum, SpectrumError

__all__ = ["metamer", "metameric_black", "metamers"]


def metameric_black(spectrum, illuminants, observer="CIE 1931 2°"):
    """The part of a spectrum (..., 81) that is invisible under every one of the `illuminants` (list of Spectrum).

    It is what remains after projection on the span of the weighted matching functions; it may be negative.
    """
    cmfs = library.observer(observer)
    seen = np.concatenate([relight.power_weights(light.sampled(), cmfs) for light in illuminants], axis=1)
    visible, strengths, _ = np.linalg.svd(seen, full_matrices=False)
    visible = visible[:, strengths > 1e-10 * strengths[0]]
    return spectrum - spectrum @ visible @ visible.T


def metamer(reflectance, direction, illuminants, amount=1.0):
    """A reflectance that matches `reflectance` under all `illuminants` -> Spectrum.

    direction: Spectrum whose metameric black is added, as much of it as keeps the result in 0..1, times `amount`.
    Raises SpectrumError where nothing of it can be added.
    """
    base = reflectance.sampled()
    black = metameric_black(direction.sampled(), illuminants)
    if np.abs(black).max() < 1e-9:
        raise SpectrumError(
            f"{direction.name or 'the direction'} has no part that is invisible under these illuminants"
        )
    with np.errstate(divide="ignore"):
        room = np.where(black > 0, (1 - base) / black, np.where(black < 0, -base / black, np.inf)).min()
    if room <= 0:
        raise SpectrumError(
            f"{reflectance.name or 'the reflectance'} already reaches 0 or 1: nothing can be added to it"
        )
    return Spectrum(WAVELENGTHS, base + amount * room * black, f"metamer of {reflectance.name}")


def metamers(illuminant, count, seed=20040601):
    """Pairs of reflectances (count, 2, 81) that match under `illuminant`, made of random CES, always the same."""
    random = np.random.default_rng(seed)
    samples = library.reflectances("ces")
    values = np.stack([sample.sampled() for sample in samples])
    pairs = []
    while len(pairs) < count:
        first, second, up, down = random.integers(len(values), size=4)
        if up == down:
            continue
        base = Spectrum(WAVELENGTHS, 0.1 + 0.4 * (values[first] + values[second]))
        direction = Spectrum(WAVELENGTHS, values[up] - values[down])
        other = metamer(base, direction, [illuminant], amount=0.95)
        pairs.append([base.values, other.values])
    return np.array(pairs)
