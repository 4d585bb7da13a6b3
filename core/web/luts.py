"""View transforms as tables: what a page needs to show a picture as Blender does where that is not plain sRGB."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ..colour.differences import delta_E_2000
from ..colour.spaces import REC709, rgb_to_xyz, srgb_decoded, xyz_to_rgb
from ..spectra import library
from ..spectra.arrays import Array

__all__ = ["Lut", "bake", "difference", "is_plain", "sampled"]

SIZE = 49
STOPS = (-12.0, 8.0)  # of linear values that a table reaches; below, the steps are equal
# Primaries, as xy of red, green, blue, between which a table may be made; the best of them is taken. FilmLight E-Gamut
# is what AgX works in.
_E_GAMUT = ((0.8, 0.3177), (0.18, 0.9), (0.065, -0.0805))

# Linear RGB in a working space (height, width, 3) -> what the display shows, 0..1 as encoded for sRGB
Show = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Lut:
    """values: (n, n, n, 3) of the display, blue slowest, over log2(rgb + 2**low) from `STOPS`; rgb = matrix @ XYZ."""

    matrix: Array
    values: np.ndarray


def is_plain(view: Mapping[str, object]) -> bool:
    """Whether a picture with this view is shown as plain sRGB, but for exposure and gamma."""
    transform, look = view.get("view_transform", "Standard"), view.get("look", "None")
    return transform == "Standard" and look in ("None", "", None) and view.get("display_device", "sRGB") == "sRGB"


def _matrices() -> list[Array]:
    """(3, 3) XYZ to RGB of each set of primaries."""
    white = rgb_to_xyz().sum(axis=1)
    corners = np.array([(x / y, 1.0, (1 - x - y) / y) for x, y in _E_GAMUT]).T
    return [
        np.linalg.inv(corners * np.linalg.solve(corners, white)),
        xyz_to_rgb("Linear Rec.2020"),
        xyz_to_rgb(),
    ]


def bake(show: Show, space: str = REC709) -> Lut:
    """The table nearest to what `show` makes of linear RGB in `space`: of those between several primaries the best."""
    probe = _probe(space)
    wanted = show(probe[None])[0]
    found = [_baked(show, space, matrix) for matrix in _matrices()]
    errors = [np.percentile(difference(sampled(lut, probe @ rgb_to_xyz(space).T), wanted), 98) for lut in found]
    return found[int(np.argmin(errors))]


def _baked(show: Show, space: str, matrix: Array) -> Lut:
    low, high = STOPS
    axis = np.exp2(np.linspace(low, high, SIZE)) - 2.0**low
    blue, green, red = np.meshgrid(axis, axis, axis, indexing="ij")
    rgb = np.stack([red, green, blue], axis=-1).reshape(SIZE, -1, 3)
    there = rgb @ (xyz_to_rgb(space) @ np.linalg.inv(matrix)).T
    shown = show(there.astype(np.float32)).reshape(SIZE, SIZE, SIZE, 3)
    return Lut(matrix, (np.round(255 * shown) / 255).astype(np.float32))  # a byte's 256 values pack well


def _probe(space: str) -> np.ndarray:
    """(n, 3) colours of pictures, of every brightness: between white and the pure colours of the spectrum."""
    rng = np.random.default_rng(0)
    pure = library.observer()[8:60][rng.integers(0, 52, 4096)]  # 420 to 675 nm
    pure = pure / pure.sum(axis=1, keepdims=True)
    white = rgb_to_xyz().sum(axis=1) / rgb_to_xyz().sum()
    part = rng.uniform(0, 1, (4096, 1)) ** 3
    xyz = np.exp2(rng.uniform(-6, 4, (4096, 1))) * (part * pure + (1 - part) * white)
    return (xyz @ xyz_to_rgb(space).T).astype(np.float32)


def sampled(lut: Lut, xyz: np.ndarray) -> np.ndarray:
    """(n, 3) of the display: a table read at XYZ (n, 3), as a page reads it."""
    low, high = STOPS
    size = len(lut.values)
    stops = np.log2(np.maximum(xyz @ lut.matrix.T, 0.0) + 2.0**low)
    place = np.clip((stops - low) / (high - low), 0.0, 1.0) * (size - 1)
    first = np.minimum(place.astype(int), size - 2)
    part = place - first
    found = np.zeros_like(place)
    for corner in range(8):
        step = np.array([corner & 1, corner >> 1 & 1, corner >> 2])
        weight = np.where(step, part, 1.0 - part).prod(axis=1)
        red, green, blue = (first + step).T
        found += weight[:, None] * lut.values[blue, green, red]
    return found


def difference(shown: np.ndarray, wanted: np.ndarray) -> Array:
    """(n,) CIEDE2000 of colours (n, 3) as encoded for an sRGB display."""
    to_xyz = rgb_to_xyz()
    xyz, truth = (srgb_decoded(np.clip(each, 0.0, 1.0).astype(np.float64)) @ to_xyz.T for each in (shown, wanted))
    return delta_E_2000(xyz, truth, to_xyz.sum(axis=1))
