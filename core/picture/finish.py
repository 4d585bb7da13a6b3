"""What becomes of light at a surface or in a medium of a colour, where that is no multiple of the colour.

Cycles adds the light that a rough surface reflects more than once, and what a medium lets through is an exponential.
"""

import math
from collections.abc import Sequence

import numpy as np

from ..spectra.arrays import Array, ArrayLike

__all__ = ["VOLUME", "let_through", "reflected", "rough_diffuse", "rough_glossy", "way_through"]

VOLUME = 0.5  # part of the light that a scattering volume scatters again


def rough_diffuse(roughness: float) -> float:
    """Part of the light that meets a diffuse surface of Cycles (Oren-Nayar, by Fujii and Portsmouth) more than once.

    >>> round(rough_diffuse(1.0), 3), round(rough_diffuse(0.0), 3)
    (0.167, 0.0)
    """
    roughness = min(max(roughness, 0.0), 1.0)
    scale = 1 / (math.pi + roughness * (math.pi / 2 - 2 / 3))
    return 1 - scale * (math.pi + roughness * (2 * math.pi - 5.6) / 3)


def rough_glossy(roughness: float) -> float:
    """The same of a microfacet surface (GGX), as `reflected` takes it.

    The part is within 0.03 of 1 less the mean albedo of the distribution (Kulla & Conty 2017). Half of it: such light
    has met the colour once more, that of a diffuse surface twice.
    """
    return 0.5 * (1 - 1 / (1 + 1.45 * min(max(roughness, 0.0), 1.0) ** 3.2))


def reflected(colour: Array, again: ArrayLike) -> Array:
    """What a surface of a colour (..., n) reflects, a part `again` (..., 1) of it more than once -> (..., n).

    Cycles' law of a diffuse surface, to the seventh digit of what it renders. Colours up to 1.
    """
    again = np.asarray(again)
    return colour * (1 - again) * (1 + again * colour**2 / (1 - again * colour))


def let_through(colour: Array, depth: ArrayLike) -> Array:
    """What a medium lets through that absorbs 1 less its colour (..., n), of a depth (..., 1) where it is black."""
    return np.exp(-np.asarray(depth) * (1 - colour))


def way_through(size: Sequence[float]) -> float:
    """The mean way through a box of that size, four times its volume by its surface.

    >>> way_through((2.0, 2.0, 2.0))
    1.3333333333333333
    """
    a, b, c = (max(abs(side), 1e-9) for side in size)
    return 2 * a * b * c / (a * b + b * c + c * a)
