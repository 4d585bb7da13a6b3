"""Error against run time as a plot, drawn without a library: a small picture for panels, and SVG for reports.

Both axes are logarithmic. A point has a dot, its error with noise, and a dash, the error of the model alone.
"""

from collections.abc import Sequence
from typing import NamedTuple
from xml.sax.saxutils import escape

import numpy as np

from ..spectra.arrays import Array

__all__ = ["Point", "colours", "picture", "svg"]

_LEAST = 0.01  # a logarithmic axis has no zero
_JUST_SEEN = 1.0  # CIEDE2000
_MARKED = (0.93, 0.25, 0.2)
_HUES = (
    *((0.36, 0.62, 0.92), (0.95, 0.72, 0.2), (0.36, 0.78, 0.45)),
    *((0.75, 0.5, 0.9), (0.3, 0.8, 0.82), (0.95, 0.55, 0.7)),
    *((0.6, 0.42, 0.25), (0.78, 0.92, 0.42), (0.92, 0.92, 0.92)),
    *((0.2, 0.45, 0.62), (0.6, 0.6, 0.6), (0.75, 0.3, 0.6)),
)
_SVG = 'xmlns="http://www.w3.org/2000/svg" font-family="sans-serif" font-size="13"'
_HALO = 'paint-order="stroke" stroke="white" stroke-width="3"'
_DARK, _GRID = (0.11, 0.11, 0.11), (0.24, 0.24, 0.24)
_OVERSAMPLING = 2


class Point(NamedTuple):
    """A way to render: what it is called, what it took, and its errors, CIEDE2000."""

    name: str
    seconds: float
    total: float
    model: float


def colours(points: Sequence[Point], marked: str) -> list[tuple[float, float, float]]:
    """The sRGB colour 0..1 of each point: red for the one called `marked`."""
    return [_MARKED if point.name == marked else _HUES[k % len(_HUES)] for k, point in enumerate(points)]


def _range(values: Array) -> tuple[float, float]:
    """The logarithms between which an axis runs: around all values, a third of a decade at least."""
    low, high = np.log10(values.min()), np.log10(values.max())
    margin = max(0.08 * (high - low), 0.15)
    return float(low - margin), float(high + margin)


def _axes(points: Sequence[Point]) -> tuple[tuple[float, float], tuple[float, float]]:
    seconds = np.maximum([point.seconds for point in points], 1e-3)
    errors = np.maximum([[point.total, point.model, _JUST_SEEN] for point in points], _LEAST)
    return _range(seconds), _range(errors)


def _part(value: float, axis: tuple[float, float]) -> float:
    """Where a value stands on an axis, 0..1."""
    return float((np.log10(max(value, 1e-3)) - axis[0]) / (axis[1] - axis[0]))


def _ticks(axis: tuple[float, float]) -> list[float]:
    """1, 2 and 5 of each decade of an axis."""
    decades = range(int(np.floor(axis[0])), int(np.ceil(axis[1])) + 1)
    values = [times * 10.0**decade for decade in decades for times in (1, 2, 5)]
    return [value for value in values if axis[0] <= np.log10(value) <= axis[1]]


def picture(points: Sequence[Point], marked: str, size: int = 256) -> np.ndarray:
    """(size, size, 4) sRGB float32, lowest row first: the points in their `colours`, lines at 1, 2 and 5."""
    across, up = _axes(points)
    fine = size * _OVERSAMPLING
    places = (np.arange(fine) + 0.5) / fine
    drawn = np.ones((fine, fine, 4))
    drawn[..., :3] = _DARK
    for value in _ticks(across):
        drawn[:, np.abs(places - _part(value, across)) < 0.8 / fine, :3] = _GRID
    for value in _ticks(up):
        drawn[np.abs(places - _part(value, up)) < 0.8 / fine, :, :3] = _GRID
    drawn[np.abs(places - _part(_JUST_SEEN, up)) < 1.6 / fine, :, :3] = 0.5
    for point, colour in zip(points, colours(points, marked), strict=True):
        x, total, model = _part(point.seconds, across), *(_part(max(e, _LEAST), up) for e in point[2:])
        column = np.abs(places - x)
        between = (places > min(total, model)) & (places < max(total, model))
        drawn[np.ix_(between, column < 1.6 / fine)] = (*(0.6 * np.array(colour) + 0.4 * np.array(_DARK)), 1.0)
        drawn[np.ix_(np.abs(places - model) < 0.008, column < 0.03)] = (*colour, 1.0)
        drawn[np.hypot(column, (places - total)[:, None]) < 0.022] = (*colour, 1.0)
    parts = drawn.reshape(size, _OVERSAMPLING, size, _OVERSAMPLING, 4)
    return np.asarray(parts.mean(axis=(1, 3)), dtype=np.float32)


def svg(points: Sequence[Point], marked: str, title: str, across: str, up: str) -> str:
    """The plot as an SVG document with names and numbers. across, up: what the axes are."""
    width, height, left, top, right, bottom = 800, 550, 70, 40, 150, 60
    x_axis, y_axis = _axes(points)

    def x_of(value: float) -> float:
        return left + _part(value, x_axis) * (width - left - right)

    def y_of(value: float) -> float:
        return height - bottom - _part(max(value, _LEAST), y_axis) * (height - top - bottom)

    ends = (left, width - right, top, height - bottom)
    lines = [
        f'<svg {_SVG} viewBox="0 0 {width} {height}">',
        f'<rect width="{width}" height="{height}" fill="white"/>',
        _words(left, 24, title, size=15),
        _words((ends[0] + ends[1]) / 2, height - 16, across, anchor="middle"),
        f'<g transform="translate(20 {(ends[2] + ends[3]) / 2:.1f}) rotate(-90)">',
        _words(0, 0, up, anchor="middle") + "</g>",
    ]
    for value in _ticks(x_axis):
        lines += [_line(x_of(value), ends[2], x_of(value), ends[3], "#e3e3e3")]
        lines += [_words(x_of(value), ends[3] + 18, f"{value:g}", anchor="middle")]
    for value in _ticks(y_axis):
        lines += [_line(ends[0], y_of(value), ends[1], y_of(value), "#e3e3e3")]
        lines += [_words(ends[0] - 8, y_of(value) + 4, f"{value:g}", anchor="end")]
    lines.append(_line(ends[0], y_of(_JUST_SEEN), ends[1], y_of(_JUST_SEEN), "#808080", 'stroke-dasharray="3 3"'))
    taken: list[float] = []
    order = sorted(points, key=lambda point: -point.model)
    for point in order:
        colour = "#c62f26" if point.name == marked else "#2a6fb0"
        x, total, model = x_of(point.seconds), y_of(point.total), y_of(point.model)
        lines.append(_line(x, total, x, model, colour, 'stroke-opacity="0.5"'))
        lines.append(f'<circle cx="{x:.1f}" cy="{total:.1f}" r="5" fill="{colour}"/>')
        lines.append(_line(x - 7, model, x + 7, model, colour, 'stroke-width="2"'))
        written = model
        while any(abs(written - other) < 14 for other in taken):  # names stand below each other
            written += 2
        taken.append(written)
        lines.append(_words(x + 10, written + 4, point.name, colour))
    return "\n".join([*lines, "</svg>", ""])


def _words(x: float, y: float, words: str, colour: str = "#222222", anchor: str = "start", size: int = 13) -> str:
    place = f'x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-size="{size}"'
    return f'<text {place} fill="{colour}" {_HALO}>{escape(words)}</text>'


def _line(x: float, y: float, to_x: float, to_y: float, colour: str, more: str = "") -> str:
    return f'<line x1="{x:.1f}" y1="{y:.1f}" x2="{to_x:.1f}" y2="{to_y:.1f}" stroke="{colour}" {more}/>'
