"""The mixer's arithmetic: gains, blends of illuminants, and the light dial.

[BMD] S. Bergner, T. Moller, M. S. Drew, "A spectral engine for visualization", SFU-CMPT-TR2004-06: illuminants stand as
points on a disc, and the position of a handle weighs them.
"""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from ..colour.spaces import srgb_decoded
from ..errors import UsageError
from ..model import relight, upsample
from ..spectra import library
from ..spectra.arrays import Array
from ..spectra.spectrum import WAVELENGTHS, Spectrum, SpectrumError

__all__ = ["anchors", "blend", "gain", "gains", "handle", "stops", "tinted", "weights"]


def gain(stops: float) -> float:
    """The multiple of brightness that a number of stops stands for.

    >>> gain(-1)
    0.5
    """
    return 2.0**stops


def stops(gain: float) -> float:
    """The inverse of `gain`. Raises UsageError for a gain of zero or less."""
    if not gain > 0.0:
        raise UsageError(f"a gain of {gain:g} has no number of stops: expected more than 0")
    return float(np.log2(gain))


def gains(stops: Sequence[float], solo: Sequence[bool], mute: Sequence[bool]) -> Array:
    """(groups,) gains: where any group is solo only those sound; a mute one never does.

    >>> gains([1, 0, 0], solo=[True, True, False], mute=[False, True, False])
    array([2., 0., 0.])
    """
    alone, heard = np.asarray(solo, bool), ~np.asarray(mute, bool)
    if alone.any():
        heard = heard & alone
    return np.where(heard, np.exp2(np.asarray(stops, float)), 0.0)


@lru_cache(maxsize=4096)
def blend(parts: tuple[tuple[Spectrum, float], ...]) -> Spectrum:
    """The illuminant of several lamps, each with its part of the luminance of a white that they light.

    parts: (illuminant, weight), weights of any sum. Raises SpectrumError for weights that are negative or all zero.
    """
    if any(weight < 0.0 for _, weight in parts) or not sum(weight for _, weight in parts) > 0.0:
        raise SpectrumError("a blend needs weights of 0 or more, and one of them more than 0")
    luminous = library.observer()
    total = sum(weight for _, weight in parts)
    power = np.zeros(WAVELENGTHS.size)
    for illuminant, weight in parts:
        if weight > 0.0:
            values = illuminant.sampled()
            relight.power_weights(values, luminous)  # raises SpectrumError where it cannot be seen
            values = values / np.abs(values).max()  # the faintest and the strongest alike
            power += weight / total * values / (values @ luminous[:, 1])
    shares = [f"{weight / total:.0%} {illuminant.name}" for illuminant, weight in parts if weight > 0.0]
    return Spectrum(WAVELENGTHS, power, " + ".join(shares), "illuminant", "blend")


@lru_cache(maxsize=1024)
def tinted(illuminant: Spectrum, colour: tuple[float, float, float]) -> Spectrum:
    """An illuminant behind a gel of a colour, sRGB 0..1: its transmittance is what the colour is as a spectrum.

    White leaves the illuminant as it is. Raises SpectrumError for black.

    >>> red = tinted(library.illuminant("A"), (1.0, 0.2, 0.1))
    >>> red.name
    'A, gel #ff331a'
    """
    if min(colour) >= 1.0:
        return illuminant
    passed = upsample.rgb_spectra() @ srgb_decoded(np.clip(np.asarray(colour, float), 0.0, 1.0))
    if not passed.max() > 0.0:
        raise SpectrumError("a black gel lets no light through: choose a lighter colour")
    values = illuminant.values * np.interp(illuminant.wavelengths, WAVELENGTHS, passed / passed.max())
    words = "".join(f"{round(255 * float(np.clip(part, 0.0, 1.0))):02x}" for part in colour)
    return Spectrum(illuminant.wavelengths, values, f"{illuminant.name}, gel #{words}", "illuminant", illuminant.source)


def anchors(count: int) -> Array:
    """(count, 2) places of the illuminants on the unit circle of the light dial, the first at the top, clockwise."""
    angles = np.pi / 2 - 2 * np.pi * np.arange(count) / count
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)


def handle(weights: Sequence[float]) -> Array:
    """(2,) where the handle of the dial stands for these weights: the mean of the anchors."""
    parts = np.asarray(weights, float)
    total = parts.sum()
    return parts @ anchors(len(parts)) / total if total > 0.0 else np.zeros(2)


def weights(position: Sequence[float], count: int) -> Array:
    """(count,) weights, of sum 1, of the illuminants for a handle at `position` (2,); `handle` is the inverse.

    Wachspress coordinates of the polygon of the anchors: at an anchor its illuminant alone, on a side only those of its
    two ends. A handle outside the polygon is taken to its border. (E. L. Wachspress, "A rational finite element basis",
    1975; for a regular polygon.)

    >>> weights((0, 1), 4)
    array([1., 0., 0., 0.])
    """
    if count < 1:
        raise UsageError("the light dial needs at least one illuminant")
    x, y = (float(value) for value in position)
    if count == 1:
        return np.ones(1)
    if count == 2:
        up = np.clip((y + 1.0) / 2.0, 0.0, 1.0)
        return np.array([up, 1.0 - up])
    corners = anchors(count)
    middles = (corners + np.roll(corners, -1, axis=0)) / 2.0
    inside = np.cos(np.pi / count)  # from the centre to each side
    normals = middles / inside
    reach = (normals @ (x, y)).max() / inside
    point = np.array([x, y]) / max(reach, 1.0)
    distances = np.maximum(inside - normals @ point, 0.0)
    distances[distances < 1e-12] = 0.0
    # The corner i lies on the sides i - 1 and i
    products = np.array([np.delete(distances, [i - 1 if i else count - 1, i]).prod() for i in range(count)])
    return products / products.sum()
