"""The criteria of a design as equations: rows of one stacked linear system in all that is to be found ([BMD] eq. 22).

What is not linear is written as it is near the spectra at hand, to be solved again from there: the metric of CIEDE2000
at their colours, whites and relight matrices of lights that are designed, and colours that are to be far apart.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np

from ..colour.differences import delta_E_2000
from ..colour.spaces import D65_WHITE
from ..errors import SpectrumError
from ..model.factor_model import FactorModel
from ..spectra import library
from ..spectra.arrays import Array, ArrayLike
from ..spectra.spectrum import WAVELENGTHS, Spectrum
from . import colours
from .design import Cell, Constancy, Difference, Key, Palette

__all__ = ["Block", "State", "System", "model_colour", "smoothness_rows", "system"]

Parts = tuple[tuple[Key, Array], ...]

COUNT = WAVELENGTHS.size
PERCEPTUAL = 0.01  # one CIEDE2000 weighs as much as 0.01 of RGB, which it is near middle grey
MARGIN = 0.02  # CIEDE2000 by which a difference is to keep its demand: what is soft ends a little beside it
COMPONENTS = 8  # of a set of measured reflectances, that a spectrum in their span is made of


@dataclass(frozen=True, eq=False)
class State:
    """Spectra at hand: lights (l, 81), reflectances (r, 81), and by name the XYZ of free colours."""

    lights: Array
    reflectances: Array
    free: dict[Key, Array]

    def colours(self) -> Array:
        """XYZ (r, l, 3)."""
        return colours.colour(self.lights, self.reflectances)

    def whites(self) -> Array:
        """XYZ (l, 3) of the white that colours are compared under, in the chromaticity of each light.

        Its Y is 1 whatever the luminance: a light that is designed would else grow until all errors look small. That
        of equal energy where the eye sees nothing of a light.
        """
        whites = self.lights @ colours.xyz_weights().T
        dark = whites[:, 1] <= 1e-9 * np.abs(whites).max(axis=1, initial=1e-300)
        whites[dark | (whites.min(axis=1) <= 0)] = 1.0
        return whites / whites[:, 1:2]


@dataclass(frozen=True, eq=False)
class Block:
    """Equations sum(matrix @ x[key]) = right, parts: ((key, matrix (m, n)), ...), right: (m,).

    hard: they hold as far as any spectra can make them, before everything else.
    """

    criterion: str
    words: str
    parts: Parts
    right: Array
    hard: bool = False

    @property
    def own(self) -> Key | None:
        """The key of the one spectrum that all of whose values these equations are about; None for others."""
        (key, matrix), *others = self.parts
        return key if not others and not self.hard and len(matrix) >= matrix.shape[1] else None

    def residual(self, x: dict[Key, Array]) -> Array:
        """(m,) for values by key."""
        return sum((matrix @ x[key] for key, matrix in self.parts), -self.right)


@dataclass(frozen=True, eq=False)
class System:
    """Blocks in unknowns of `sizes` {key: n}, with bounds {key: (lower (n,), upper (n,))}."""

    blocks: tuple[Block, ...]
    sizes: dict[Key, int]
    bounds: dict[Key, tuple[Array, Array]]


def system(palette: Palette, state: State, designed: Sequence[Key], push: Array | None = None) -> System:
    """The equations of a Palette near a State -> System.

    designed: those of `palette.designed()` that are unknown now, no light and reflectance that meet. push: direction
    (3,), lightness, chroma and hue, in which colours that are to differ are taken apart where they are still equal.
    """
    unknown = set(designed)
    maker = _Maker(palette, state, unknown)
    blocks = [maker.cell(cell) for cell in palette.cells if cell.weight > 0]
    if palette.criteria.model is not None and palette.criteria.model_error > 0:
        blocks += [maker.model_error(*place) for place in palette.meetings()]
    for number, one in enumerate(palette.constancies):
        blocks += maker.constancy(number, one)
    blocks += [maker.difference(one, push) for one in palette.differences]
    for kind, index in designed:
        blocks += _alone(palette, kind, index)
    asked = tuple(block for block in blocks if block.parts)
    sizes = {key: matrix.shape[1] for block in asked for key, matrix in block.parts}
    sizes |= dict.fromkeys(designed, COUNT)
    return System(asked, sizes, {key: _bounds(palette, key, size) for key, size in sizes.items()})


def _bounds(palette: Palette, key: Key, size: int) -> tuple[Array, Array]:
    kind, index = key
    if kind in ("light", "reflectance"):
        low, high = palette.bounds(kind, palette.entry(kind, index))
        return np.full(size, float(low)), np.full(size, float(high))
    for one in palette.free_colours if kind == "free" else ():
        if one.name == index:
            return np.array(one.lower, float), np.array(one.upper, float)
    return np.full(size, -np.inf), np.full(size, np.inf)


class _Maker:
    """Makes the blocks of what happens where lights and reflectances meet."""

    def __init__(self, palette: Palette, state: State, unknown: set[Key]) -> None:
        self.palette, self.state, self.unknown = palette, state, unknown
        self.xyz, self.whites = state.colours(), state.whites()

    def metric(self, xyz: Array, white: Array) -> Array:
        """(3, 3) from XYZ to the space in which colours are compared."""
        space = self.palette.criteria.space
        if space == "perceptual":
            return PERCEPTUAL * colours.metric(xyz, white)
        return colours.display_from_xyz() if space == "rgb" else np.eye(3)

    def full(self, reflectance: int, light: int) -> tuple[Parts, Array]:
        """Colour as linear in what is unknown ([BMD] eq. 18): parts, constant (3,)."""
        weights = colours.xyz_weights()
        if ("reflectance", reflectance) in self.unknown:
            return ((("reflectance", reflectance), weights * self.state.lights[light]),), np.zeros(3)
        if ("light", light) in self.unknown:
            return ((("light", light), weights * self.state.reflectances[reflectance]),), np.zeros(3)
        return (), self.xyz[reflectance, light]

    def model(self, reflectance: int, light: int) -> tuple[Parts, Array]:
        """The same for the colour that the factor model makes ([BMD] eq. 19)."""
        model, lit, row = self.palette.criteria.model, self.state.lights[light], self.state.reflectances[reflectance]
        assert model is not None, "a design for the colours of a model has one"
        if ("reflectance", reflectance) in self.unknown:
            return ((("reflectance", reflectance), _relight(model, lit) @ model.filters.T),), np.zeros(3)
        now = model_colour(model, lit, row)
        if ("light", light) not in self.unknown:
            return (), now
        # A relight matrix is fitted to its light, which is no linear function of it: what spectra rebuilt from the
        # coefficients give is one, and is right to the little that is added here.
        matrix = colours.xyz_weights() * model.reconstruct(row @ model.filters)
        return ((("light", light), matrix),), now - matrix @ lit

    def seen(self, reflectance: int, light: int) -> tuple[Parts, Array, Array]:
        """That of both which is designed for, and the XYZ (3,) of now."""
        model = self.palette.criteria.model
        if model is None or not self.palette.criteria.use_model:
            return *self.full(reflectance, light), self.xyz[reflectance, light]
        now = model_colour(model, self.state.lights[light], self.state.reflectances[reflectance])
        return *self.model(reflectance, light), now

    def cell(self, cell: Cell) -> Block:
        """The block of one cell: a target ([BMD] eq. 18, 19) or a free colour (eq. 23, 24)."""
        where = self.palette.where(cell)
        parts, constant, _ = self.seen(cell.reflectance, cell.light)
        if cell.free:
            rgb = colours.display_from_xyz()
            joined = (*_scaled(rgb, parts), (("free", cell.free), -np.eye(3)))
            return Block("free colour", f"free colour {cell.free}: {where}", joined, -rgb @ constant, hard=True)
        goal = np.array(cell.target, float)
        rows = cell.weight / np.sqrt(3) * self.metric(goal, self.whites[cell.light])
        return Block("target", where, _scaled(rows, parts), rows @ (goal - constant))

    def model_error(self, reflectance: int, light: int) -> Block:
        """What the model's colour differs by from that of full spectra, wherever a demand is made ([BMD] eq. 20)."""
        metric = self.metric(self.xyz[reflectance, light], self.whites[light])
        for cell in self.palette.cells:
            if (cell.reflectance, cell.light) == (reflectance, light) and cell.target is not None:
                metric = self.metric(np.array(cell.target, float), self.whites[light])
        rows = self.palette.criteria.model_error / np.sqrt(3) * metric
        (full, at), (reduced, there) = self.full(reflectance, light), self.model(reflectance, light)
        pairs = zip(full, reduced, strict=True)
        parts = tuple((key, rows @ (one - other)) for (key, one), (_, other) in pairs)
        return Block("model error", self.palette.where_at(reflectance, light), parts, rows @ (there - at))

    def constancy(self, number: int, one: Constancy) -> Iterator[Block]:
        """One colour under several lights: a free colour of its own, in XYZ."""
        key = ("constancy", number)
        for light in one.lights:
            parts, constant, xyz = self.seen(one.reflectance, light)
            white = self.whites[light]
            if one.adapted:
                to_common = colours.adapted(white)
                parts, constant = _scaled(to_common, parts), to_common @ constant
                xyz, white = to_common @ xyz, D65_WHITE * white[1]
            rows = one.weight / np.sqrt(3) * self.metric(xyz, white)
            joined = (*_scaled(rows, parts), (key, -rows))
            where = self.palette.where_at(one.reflectance, light)
            yield Block("constancy", where, joined, -rows @ constant)

    def difference(self, one: Difference, push: Array | None) -> Block:
        """Two reflectances near to or far from each other: their difference is to be the nearest one allowed."""
        parts, at, first = self.seen(one.first, one.light)
        others, there, second = self.seen(one.second, one.light)
        white = self.whites[one.light]
        metric = colours.metric((first + second) / 2, white)
        now = metric @ (first - second)
        length = np.linalg.norm(now)
        # The metric is that of small differences: what it makes of this one is put right
        stretch = delta_E_2000(first, second, white) / length if length > 1e-3 else 1.0
        wanted = length * stretch
        if one.least is not None and wanted < one.least + MARGIN:
            direction = now / length if length > 1e-3 else np.array([1.0, 0.0, 0.0] if push is None else push)
            now = direction * (one.least + MARGIN) / stretch
        elif one.most is not None and wanted > one.most - MARGIN:
            now = now * (max(one.most - MARGIN, 0.0) / max(wanted, 1e-9))
        scale = PERCEPTUAL * one.weight / np.sqrt(3)
        rows = scale * metric
        joined = (*_scaled(rows, parts), *_scaled(-rows, others))
        merged: dict[Key, Array] = {}
        for key, matrix in joined:
            merged[key] = merged.get(key, 0.0) + matrix
        right = scale * now + rows @ (there - at)
        return Block("difference", self.palette.where_both(one), tuple(merged.items()), right)


def _scaled(rows: Array, parts: Parts) -> Parts:
    return tuple((key, rows @ matrix) for key, matrix in parts)


def _alone(palette: Palette, kind: str, index: int) -> Iterator[Block]:
    """The blocks of one spectrum by itself: smoothness (eq. 21), and nearness to real ones."""
    entry, key = palette.entry(kind, index), (kind, index)
    if palette.criteria.smoothness > 0:
        rows = palette.criteria.smoothness * smoothness_rows()
        yield Block("smoothness", entry.name, ((key, rows),), np.zeros(COUNT))
    if entry.near is not None and entry.near_weight > 0:
        scale = entry.near_weight / np.sqrt(COUNT)
        yield Block("nearness", entry.name, ((key, scale * np.eye(COUNT)),), scale * entry.near.sampled())
    if entry.span and entry.span_weight > 0:
        outside = np.eye(COUNT) - _components(entry.span) @ _components(entry.span).T
        yield Block("span", entry.name, ((key, entry.span_weight / np.sqrt(COUNT) * outside),), np.zeros(COUNT))


@cache
def smoothness_rows() -> Array:
    """(81, 81), read-only: second differences, normalised as printed ([BMD] eq. 21)."""
    rows = 2 * np.eye(COUNT) - np.eye(COUNT, k=1) - np.eye(COUNT, k=-1)
    rows /= np.sqrt(COUNT) * np.linalg.norm([-1, 2, -1])
    rows.setflags(write=False)
    return rows


@cache
def _components(name: str) -> Array:
    """The first principal components (81, 8) of a set of reflectances."""
    values = np.stack([spectrum.sampled() for spectrum in library.reflectances(name)])
    return np.linalg.svd(values, full_matrices=False)[2][:COMPONENTS].T


def model_colour(model: FactorModel, light: Array, reflectance: ArrayLike) -> Array:
    """XYZ (..., 3) that a factor model makes of reflectances (..., 81) under a light (81,)."""
    return np.asarray(reflectance) @ model.filters @ _relight(model, light).T


def _relight(model: FactorModel, light: Array) -> Array:
    """(3, p): coefficients to XYZ, in the luminance of the light (81,); zero where the eye sees nothing of it."""
    return _relight_of(model, np.ascontiguousarray(light).tobytes())


@lru_cache(maxsize=256)
def _relight_of(model: FactorModel, light: bytes) -> Array:
    values = np.frombuffer(light)
    try:
        matrix = model.relight(Spectrum(WAVELENGTHS, values, kind="illuminant"))
    except SpectrumError:
        return np.zeros((3, model.channels))
    return (colours.xyz_weights()[1] @ values) * matrix
