"""Colour differences and their statistics."""

from collections.abc import Callable

import numpy as np

from ..errors import MeasureError
from ..spectra.arrays import Array, ArrayLike

__all__ = ["MeasureError", "delta_E_1976", "delta_E_1994", "delta_E_2000", "lab", "picture_delta_E", "statistics"]


def lab(xyz: ArrayLike, white: ArrayLike) -> Array:
    """CIELAB of XYZ (..., 3) relative to `white` (..., 3), both in the same unit (CIE 15).

    A single line may have X or Z of zero: such a white is floored at 1e-6 of its Y. Raises MeasureError for a white
    without luminance.
    """
    white = np.asarray(white, dtype=np.float64)
    if not (white[..., 1] > 0).all():
        raise MeasureError("the white that colours are compared under must have a positive luminance")
    ratio = np.asarray(xyz, dtype=np.float64) / np.maximum(white, 1e-6 * white[..., 1:2])
    linear = (24389 / 27 * ratio + 16) / 116
    f = np.where(ratio > 216 / 24389, np.cbrt(np.maximum(ratio, 0)), linear)
    x, y, z = np.moveaxis(f, -1, 0)
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)


def delta_E_1976(xyz_a: ArrayLike, xyz_b: ArrayLike, white: ArrayLike) -> Array:
    """Euclidean distance in CIELAB -> (...)."""
    return np.linalg.norm(lab(xyz_a, white) - lab(xyz_b, white), axis=-1)


def delta_E_1994(xyz_a: ArrayLike, xyz_b: ArrayLike, white: ArrayLike) -> Array:
    """CIE 1994 with the weights of graphic arts (kL = 1, K1 = 0.045, K2 = 0.015); `xyz_a` is the reference."""
    lab_a, lab_b = lab(xyz_a, white), lab(xyz_b, white)
    chroma_a, chroma_b = np.hypot(*_ab(lab_a)), np.hypot(*_ab(lab_b))
    lightness, chroma = lab_a[..., 0] - lab_b[..., 0], chroma_a - chroma_b
    hue_squared = np.maximum(((lab_a - lab_b)[..., 1:] ** 2).sum(axis=-1) - chroma**2, 0)
    return np.sqrt(lightness**2 + (chroma / (1 + 0.045 * chroma_a)) ** 2 + hue_squared / (1 + 0.015 * chroma_a) ** 2)


def delta_E_2000(xyz_a: ArrayLike, xyz_b: ArrayLike, white: ArrayLike) -> Array:
    """CIEDE2000 between XYZ arrays (..., 3) seen under `white` (3,) -> (...). (CIE 142; Sharma, Wu, Dalal 2005).

    >>> white = np.array([0.95, 1.0, 1.09])
    >>> round(float(delta_E_2000(0.50 * white, 0.51 * white, white)), 2)
    0.44
    """
    lab_a, lab_b = lab(xyz_a, white), lab(xyz_b, white)
    mean_chroma = (np.hypot(*_ab(lab_a)) + np.hypot(*_ab(lab_b))) / 2
    stretch = 1 + 0.5 * (1 - np.sqrt(mean_chroma**7 / (mean_chroma**7 + 25.0**7)))
    (a_a, b_a), (a_b, b_b) = _ab(lab_a), _ab(lab_b)
    a_a, a_b = a_a * stretch, a_b * stretch
    chroma_a, chroma_b = np.hypot(a_a, b_a), np.hypot(a_b, b_b)
    hue_a, hue_b = np.degrees(np.arctan2(b_a, a_a)) % 360, np.degrees(np.arctan2(b_b, a_b)) % 360

    grey = chroma_a * chroma_b == 0
    turn = (hue_b - hue_a + 180) % 360 - 180
    turn = np.where(grey, 0, turn)
    lightness, chroma = lab_b[..., 0] - lab_a[..., 0], chroma_b - chroma_a
    hue = 2 * np.sqrt(chroma_a * chroma_b) * np.sin(np.radians(turn / 2))

    mean_lightness, mean_chroma = (lab_a[..., 0] + lab_b[..., 0]) / 2, (chroma_a + chroma_b) / 2
    mean_hue = np.where(grey, hue_a + hue_b, (hue_a + turn / 2) % 360)
    lightness /= 1 + 0.015 * (mean_lightness - 50) ** 2 / np.sqrt(20 + (mean_lightness - 50) ** 2)
    chroma /= 1 + 0.045 * mean_chroma
    hue /= 1 + 0.015 * mean_chroma * hue_weight(mean_hue)
    coupling = rotation(mean_chroma, mean_hue)
    return np.sqrt(np.maximum(lightness**2 + chroma**2 + hue**2 + coupling * chroma * hue, 0))


def hue_weight(hue: Array) -> Array:
    """CIEDE2000's T at a hue in degrees."""
    return (
        1
        - 0.17 * np.cos(np.radians(hue - 30))
        + 0.24 * np.cos(np.radians(2 * hue))
        + 0.32 * np.cos(np.radians(3 * hue + 6))
        - 0.20 * np.cos(np.radians(4 * hue - 63))
    )


def rotation(chroma: Array, hue: Array) -> Array:
    """CIEDE2000's R_T, the coupling of chroma and hue differences in the blue; hue in degrees, 0..360."""
    angle = np.radians(60 * np.exp(-(((hue - 275) / 25) ** 2)))
    return -2 * np.sqrt(chroma**7 / (chroma**7 + 25.0**7)) * np.sin(angle)


def picture_delta_E(xyz: Array, truth: Array, white: Array, method: Callable[..., Array] | None = None) -> Array:
    """Colour difference of two pictures in XYZ (..., 3), the second the reference -> (...).

    white: XYZ of a perfect white under the light of the scene, of any luminance. Both pictures are exposed alike: the
    98th percentile of the reference's luminance is shown as white. method: `delta_E_2000` unless another is given.
    Raises MeasureError for a reference that is black.
    """
    exposure = np.percentile(truth[..., 1], 98)
    if not exposure > 0:
        raise MeasureError("the reference picture is black in more than 98 % of its pixels, or not a picture")
    white = np.asarray(white, dtype=np.float64) / white[1]
    return (method or delta_E_2000)(truth / exposure, xyz / exposure, white)


def _ab(lab_values: Array) -> tuple[Array, Array]:
    return lab_values[..., 1], lab_values[..., 2]


def statistics(values: ArrayLike) -> dict[str, float]:
    """Median, 90th, 98th and 99th percentile and maximum of an array -> dict of float."""
    values = np.asarray(values, dtype=np.float64).ravel()
    if values.size == 0:
        raise MeasureError("no values to take statistics of")
    median, p90, p98, p99 = np.percentile(values, [50, 90, 98, 99])
    return {"median": median, "p90": p90, "p98": p98, "p99": p99, "max": values.max()}
