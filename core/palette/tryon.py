"""Another reflectance tried on in a render that is there: what is directly seen of a surface, in its new spectrum.

An AOV carries the coefficients of what each pixel sees first. Where that is the surface, its light is multiplied by new
over old, channel by channel, which is exact for one diffuse reflection. Light that met the surface before or after, and
mirror reflections, are as they were.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import PaletteError
from ..spectra.arrays import ArrayLike

__all__ = ["TriedOn", "try_on"]

MOST = 20.0  # times that a channel may be brighter: below 1 / MOST of the new, too little of the old light is known
ALIKE = 0.01  # largest difference of a coefficient at which a pixel sees the surface alone


@dataclass(frozen=True, eq=False)
class TriedOn:
    """coefficients: (height, width, p) of the picture as it would be. seen: (height, width), where the surface is seen.

    doubtful: (height, width), where it is seen and the picture is only approximate: in part, at its edges, or where
    the old surface reflected too little in a channel to say what fell on it.
    """

    coefficients: NDArray[np.floating]
    seen: NDArray[np.bool_]
    doubtful: NDArray[np.bool_]


def try_on(
    coefficients: ArrayLike, surface: ArrayLike, old: ArrayLike, new: ArrayLike, diffuse: ArrayLike | None = None
) -> TriedOn:
    """A picture (height, width, p) with `new` coefficients (p,) in place of `old` (p,) -> TriedOn.

    surface: (height, width, p) of the AOV. diffuse: the part (height, width, p) of the picture that is reflected
    diffusely, for surfaces that also mirror; all of it unless given. Raises PaletteError where the surface is nowhere.
    """
    coefficients, surface = np.asarray(coefficients), np.asarray(surface)
    old, new = np.asarray(old, dtype=np.float64), np.asarray(new, dtype=np.float64)
    seen = np.abs(surface - old).max(axis=-1) < ALIKE * max(1.0, np.abs(old).max())
    if not seen.any():
        raise PaletteError("this surface is not seen in the picture: render again with surfaces, or choose another")
    # Pixels between the surface and another are mixtures: their neighbours see it
    beside = np.zeros_like(seen)
    for axis in (0, 1):
        for step in (-1, 1):
            beside |= np.roll(seen, step, axis)
    ratio = np.where(old * MOST > np.abs(new), new / np.where(old > 0, old, 1.0), 1.0)
    lost = bool((old * MOST <= np.abs(new)).any())
    reflected = coefficients if diffuse is None else np.asarray(diffuse)
    changed = coefficients + reflected * (ratio - 1.0).astype(coefficients.dtype)
    tried = np.where(seen[..., None], changed, coefficients)
    return TriedOn(tried, seen, (beside & ~seen) | (seen & lost))
