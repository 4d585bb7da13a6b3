"""Colours of lights on reflectances: XYZ in which a white under a light of luminance 1 has Y = 1."""

from functools import cache

import numpy as np

from ..colour.spaces import D65_WHITE, adaptation, rgb_to_xyz, srgb_decoded, srgb_encoded, xyz_to_rgb
from ..errors import PaletteError
from ..model.relight import local_metric
from ..spectra import library
from ..spectra.arrays import Array, ArrayLike

__all__ = [
    "adapted",
    "colour",
    "display_from_xyz",
    "encoded",
    "luminance_one",
    "metric",
    "normalised",
    "scene_from_xyz",
    "scene_linear",
    "srgb_from_xyz",
    "xyz_from_hex",
    "xyz_from_rgb",
    "xyz_from_scene",
    "xyz_weights",
]


@cache
def xyz_weights() -> Array:
    """(3, 81), read-only: XYZ of a spectrum of power, for which a flat 1 has Y = 1 ([BMD] eq. 16)."""
    weights = library.observer().T / library.observer()[:, 1].sum()
    weights.setflags(write=False)
    return weights


def colour(lights: Array, reflectances: Array) -> Array:
    """XYZ (r, l, 3) of reflectances (r, 81) under lights (l, 81)."""
    return np.einsum("kn,ln,rn->rlk", xyz_weights(), lights, reflectances, optimize=True)


def luminance_one(values: Array) -> Array | None:
    """A light (81,) scaled so that a white has Y = 1 under it; None where the eye sees nothing of it."""
    luminance = xyz_weights()[1] @ values
    # Parts below zero may make it invisible but for rounding
    return values / luminance if luminance > 1e-9 * np.abs(values).max(initial=1e-300) else None


def metric(xyz: ArrayLike, white: ArrayLike) -> Array:
    """(3, 3): the length of its product with a small change of the colour `xyz` is CIEDE2000, under `white`."""
    white = np.asarray(white, dtype=np.float64)
    # CIELAB is steep near black, and what is below black has no colour
    return local_metric(np.maximum(xyz, 1e-3 * white)[None] / white[1], white / white[1])[0] / white[1]


def adapted(white: Array) -> Array:
    """(3, 3) from XYZ under `white` to XYZ under D65 of the same luminance, by Bradford."""
    return adaptation(white, D65_WHITE)


def display_from_xyz() -> Array:
    """(3, 3) from XYZ to the RGB of the display, linear ([BMD] eq. 16)."""
    return xyz_to_rgb()


def xyz_from_rgb(rgb: ArrayLike) -> Array:
    """XYZ (..., 3) of linear RGB (..., 3) of the display."""
    return np.asarray(rgb, dtype=np.float64) @ rgb_to_xyz().T


def xyz_from_hex(text: str) -> Array:
    """XYZ (3,) of "#rrggbb" in sRGB. Raises ValueError."""
    digits = str(text).removeprefix("#")
    if len(digits) != 6:
        raise ValueError(f"{text!r} is not a colour such as #3366cc")
    return xyz_from_rgb(srgb_decoded(np.array([int(digits[k : k + 2], 16) / 255 for k in (0, 2, 4)])))


def srgb_from_xyz(xyz: ArrayLike) -> Array:
    """sRGB 0..1 (..., 3) of XYZ (..., 3), clipped to the display."""
    return srgb_encoded(np.asarray(xyz) @ display_from_xyz().T)


def encoded(xyz: ArrayLike) -> str:
    """The "#rrggbb" of XYZ (3,)."""
    return "#" + "".join(f"{round(255 * value):02x}" for value in srgb_from_xyz(xyz))


def normalised(values: Array, way: str) -> Array:
    """A spectrum (81,) scaled: "LUMINANCE", so that its luminance is 1; "L2", so that its values' squares sum to 1.

    Raises PaletteError for one that has none.
    """
    scale = xyz_weights()[1] @ values if way == "LUMINANCE" else np.linalg.norm(values)
    if not scale > 1e-9 * np.abs(values).max(initial=1e-300):
        raise PaletteError(
            "a spectrum without luminance cannot be normalised by it" if way == "LUMINANCE" else "it is 0"
        )
    return values / scale


def xyz_from_scene(rgb: ArrayLike, space: str) -> list[float]:
    """XYZ, three floats, of a colour in a working space of Blender."""
    return (rgb_to_xyz(space) @ np.asarray(rgb, dtype=np.float64)).tolist()


def scene_from_xyz(xyz: ArrayLike, space: str) -> list[float]:
    """A colour of a working space of Blender, three floats, 0 or more, of XYZ (3,)."""
    return np.maximum(np.linalg.solve(rgb_to_xyz(space), np.asarray(xyz, dtype=np.float64)), 0.0).tolist()


def scene_linear(xyz: ArrayLike, space: str) -> Array:
    """Colours (..., 3) of a working space of Blender, with its own sign, of XYZ (..., 3)."""
    return np.asarray(xyz, dtype=np.float64) @ np.linalg.inv(rgb_to_xyz(space)).T
