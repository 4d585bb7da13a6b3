"""Small pictures of illuminants for menus and panels, as arrays: Blender's panels cannot draw curves themselves."""

from typing import Any

import numpy as np

from ..colour.spaces import rgb_to_xyz, srgb_encoded
from ..spectra import library
from ..spectra.arrays import Array
from ..spectra.spectrum import WAVELENGTHS, Spectrum

__all__ = ["circle", "curve", "dot", "icon", "lines", "paint", "patch", "plot", "ribbon", "swatch"]

_OVERSAMPLING = 2


def swatch(illuminant: Spectrum) -> Array:
    """(3,) colour of a white under an illuminant, sRGB 0..1, as bright as the display shows it without clipping."""
    xyz = illuminant.sampled() @ library.observer()
    rgb = np.maximum(np.linalg.solve(rgb_to_xyz(), xyz), 0.0)
    return srgb_encoded(rgb / rgb.max()) if rgb.max() > 0.0 else np.zeros(3)


def paint(reflectance: Spectrum) -> Array:
    """(3,) colour of a reflectance in D65, sRGB 0..1; what the display cannot show is clipped."""
    seen = library.illuminant("D65").sampled()[:, None] * library.observer()
    rgb = np.linalg.solve(rgb_to_xyz(), reflectance.sampled() @ seen / seen[:, 1].sum())
    return srgb_encoded(np.clip(rgb, 0.0, 1.0))


def curve(spectrum: Spectrum) -> Array:
    """(81,) values of a spectrum on `WAVELENGTHS`, its highest 1."""
    values = np.maximum(spectrum.sampled(), 0.0)
    return values / values.max() if values.max() > 0.0 else values


_DOTS = {"green": ((0.26, 0.72, 0.33), 0.24), "yellow": ((0.95, 0.76, 0.13), 0.32), "red": ((0.93, 0.25, 0.2), 0.4)}


def dot(level: str, size: int = 32) -> Array:
    """(size, size, 4) sRGB float32: a disc, green, yellow or red by `level`; the worse, the larger."""
    colour, radius = _DOTS[level]
    fine = size * _OVERSAMPLING
    places = (np.arange(fine) + 0.5) / fine - 0.5
    inside = np.hypot(places, places[:, None]) < radius
    picture = inside[..., None] * np.array([*colour, 1.0])  # alpha is multiplied in, as Blender's icons have it
    return _reduced(picture).astype(np.float32)


def _heights(values: Array, width: int) -> Array:
    """(width,) heights of a curve; the highest of what falls into a column, so that no line is lost."""
    fine = np.linspace(0, len(values) - 1, 8 * width)
    return np.interp(fine, np.arange(len(values)), values).reshape(width, 8).max(axis=1)


def _reduced(picture: Array) -> Array:
    """Mean over squares of `_OVERSAMPLING` pixels."""
    height, width, channels = picture.shape
    return picture.reshape(
        height // _OVERSAMPLING, _OVERSAMPLING, width // _OVERSAMPLING, _OVERSAMPLING, channels
    ).mean(axis=(1, 3))


def icon(values: Array, colour: Array, size: int = 32) -> Array:
    """(size, size, 4) sRGB float32, lowest row first: the swatch `colour` (3,), the curve `values` (81,) over it."""
    fine = size * _OVERSAMPLING
    heights = 0.06 + 0.80 * _heights(np.asarray(values, float), fine)
    rows = (np.arange(fine) + 0.5)[:, None] / fine
    luminance = np.asarray(colour, float) @ rgb_to_xyz()[1]
    ink = np.full(3, 0.05 if luminance > 0.4 else 0.95)
    picture = np.ones((fine, fine, 4))
    picture[..., :3] = np.where((rows < heights)[..., None], 0.25 * np.asarray(colour) + 0.75 * ink, colour)
    return _reduced(picture).astype(np.float32)


def plot(values: Array, width: int = 160, height: int = 160) -> Array:
    """(height, width, 4) sRGB float32, lowest row first: the area under a curve (81,) in the colours of its light."""
    fine = width * _OVERSAMPLING
    heights = _heights(np.asarray(values, float), fine)
    rows = (np.arange(height * _OVERSAMPLING) + 0.5)[:, None] / (height * _OVERSAMPLING)
    picture = np.ones((height * _OVERSAMPLING, fine, 4))
    colours = _rainbow(np.linspace(WAVELENGTHS[0], WAVELENGTHS[-1], fine))
    picture[..., :3] = np.where((rows < 0.96 * heights + 0.015)[..., None], colours, 0.08)
    return _reduced(picture).astype(np.float32)


def ribbon(values: Array) -> tuple[Array, Array]:
    """A strip of triangles that fills the area under a curve (n,): places (2n, 2) in 0..1 and colours (2n, 4)."""
    values = np.asarray(values, float)
    across = np.linspace(0.0, 1.0, len(values))
    places = np.stack([np.stack([across, np.zeros(len(values))], 1), np.stack([across, values], 1)], 1).reshape(-1, 2)
    colours = np.ones((len(values), 4))
    colours[:, :3] = _rainbow(WAVELENGTHS[0] + across * (WAVELENGTHS[-1] - WAVELENGTHS[0]))
    return places, np.repeat(colours, 2, axis=0)


def circle(count: int) -> Array:
    """(count, 2) points of the unit circle."""
    angles = 2 * np.pi * np.arange(count) / count
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)


def _rainbow(wavelengths: Array) -> Array:
    """(n, 3) sRGB that hints at the colour of each wavelength in nm; a drawing, not a measurement."""
    stops = [380, 420, 450, 485, 510, 550, 580, 610, 650, 780]
    red = [0.30, 0.38, 0.15, 0.05, 0.10, 0.55, 0.95, 0.98, 0.90, 0.40]
    green = [0.05, 0.10, 0.25, 0.70, 0.80, 0.85, 0.85, 0.50, 0.12, 0.02]
    blue = [0.40, 0.75, 0.95, 0.90, 0.40, 0.10, 0.10, 0.08, 0.08, 0.05]
    return np.stack([np.interp(wavelengths, stops, column) for column in (red, green, blue)], axis=1)


def patch(wanted: Array, full: Array, model: Array, size: int = 32) -> np.ndarray:
    """(size, size, 4) sRGB float32, lowest row first: `wanted` (3,) on the left, `full` over `model` on the right."""
    picture = np.ones((size, size, 4), dtype=np.float32)
    half = size // 2
    for area, color in (
        ((slice(None), slice(None, half)), wanted),
        ((slice(half, None), slice(half, None)), full),
        ((slice(None, half), slice(half, None)), model),
    ):
        picture[(*area, slice(3))] = np.clip(color, 0.0, 1.0)
    return picture


def lines(curves: list, width: int = 256, height: int = 256) -> np.ndarray:
    """(height, width, 4) sRGB float32, lowest row first: curves (81,) with their colours (3,), on a common scale.

    The scale holds 0 and all values; a line is drawn at 0, and at 1 where it is in sight.
    """
    fine_width, fine_height = width * _OVERSAMPLING, height * _OVERSAMPLING
    picture = np.full((fine_height, fine_width, 4), 0.11)
    picture[..., 3] = 1.0
    low = min([0.0, *(float(np.min(values)) for values, _ in curves)])
    high = max([1e-6, *(float(np.max(values)) for values, _ in curves)])
    rows = np.arange(fine_height)[:, None] + 0.5

    def row_of(value: float | Array) -> Any:
        return (0.04 + 0.92 * (value - low) / (high - low)) * fine_height

    for level in (0.0, 1.0):
        if low <= level <= high:
            picture[np.abs(rows[:, 0] - row_of(level)) < 1.5, :, :3] = 0.35
    for values, color in curves:
        fine = np.interp(np.linspace(0, len(values) - 1, fine_width), np.arange(len(values)), values)
        here, there = row_of(fine), row_of(np.append(fine[1:], fine[-1]))
        covered = (rows > np.minimum(here, there) - 3) & (rows < np.maximum(here, there) + 3)
        picture[covered, :3] = np.clip(color, 0.15, 1.0)
    return _reduced(picture).astype(np.float32)
