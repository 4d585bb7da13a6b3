"""A design: lights in columns, reflectances in rows, the colours wanted where they meet, and what else is to hold.

Colours are XYZ in which a white under a light of luminance 1 has Y = 1. Spectra are on `WAVELENGTHS`; a light of flat 1
has luminance 1.
"""

from dataclasses import dataclass, field, replace
from math import inf
from typing import Any

import numpy as np

from ..errors import PaletteError
from ..model.factor_model import FactorModel
from ..spectra import library
from ..spectra.arrays import Array
from ..spectra.spectrum import WAVELENGTHS, Spectrum
from . import colours

__all__ = ["Cell", "Constancy", "Criteria", "Difference", "Entry", "FreeColour", "Key", "Palette", "scaled"]

Key = tuple[str, Any]  # what is to be found: ("light", index), ("reflectance", index), ("free", name)
Bounds = tuple[float, float]
Three = tuple[float, float, float]

SPACES = ("rgb", "xyz", "perceptual")
LEAST_SAMPLES = 4  # fewer within the visible range say nothing of a spectrum
MOST = 1e6  # of weights, luminances and colours: beyond it their squares leave what is computed with
NO_BOUNDS: Bounds = (-inf, inf)


@dataclass(frozen=True, eq=False)
class Entry:
    """One light or one reflectance.

    spectrum: what it is, or, where it is `designed`, what it was made last; None for what is still to be made.
    luminance: of a light, Y of a white under it, whatever the scale of its spectrum.
    bounds: lowest and highest value of what is designed; those of `Criteria` unless given.
    near: a Spectrum that it is to stay near to, with `near_weight`; span: a set of reflectances of the library whose
    principal components it is to be made of, with `span_weight`.
    """

    name: str
    spectrum: Spectrum | None = None
    designed: bool = False
    luminance: float = 1.0
    bounds: Bounds | None = None
    near: Spectrum | None = None
    near_weight: float = 0.0
    span: str = ""
    span_weight: float = 0.0


@dataclass(frozen=True)
class Cell:
    """What a reflectance is to look like under a light: a target colour, XYZ, or a free colour by name.

    Free colours are found by the design; cells with one name have one colour.
    """

    reflectance: int
    light: int
    target: Three | None = None
    weight: float = 1.0
    free: str = ""


@dataclass(frozen=True)
class FreeColour:
    """Bounds (3,) of a free colour in linear RGB of the display."""

    name: str
    lower: Three = (-inf, -inf, -inf)
    upper: Three = (inf, inf, inf)


@dataclass(frozen=True)
class Difference:
    """Two reflectances under a light, at least or at most so far apart in CIEDE2000."""

    light: int
    first: int
    second: int
    least: float | None = None
    most: float | None = None
    weight: float = 1.0


@dataclass(frozen=True)
class Constancy:
    """A reflectance that has one colour under several lights; `adapted`: as an eye that adapts to each sees it."""

    reflectance: int
    lights: tuple[int, ...]
    adapted: bool = False
    weight: float = 1.0


@dataclass(frozen=True, eq=False)
class Criteria:
    """What holds for the whole design, with the weights that [BMD] begins with.

    space: in what colours are compared: "rgb" as in the paper, "xyz", or "perceptual", where 0.01 is 1 CIEDE2000.
    use_model: targets are for the colours of `model` and not of full spectra ([BMD] eq. 19, "use V7").
    model_error: weight of the difference of both (eq. 20). smoothness: eq. 21. bounded: whether reflectances stay in
    `reflectance_bounds` and lights in `light_bounds`.
    """

    space: str = "perceptual"
    model: FactorModel | None = None
    use_model: bool = False
    model_error: float = 0.1
    smoothness: float = 0.001
    bounded: bool = True
    reflectance_bounds: Bounds = (0.0, 1.0)
    light_bounds: Bounds = (0.0, inf)


@dataclass(frozen=True, eq=False)
class Palette:
    """A design. Raises PaletteError for one that cannot mean anything."""

    lights: tuple[Entry, ...]
    reflectances: tuple[Entry, ...]
    cells: tuple[Cell, ...] = ()
    free_colours: tuple[FreeColour, ...] = ()
    differences: tuple[Difference, ...] = ()
    constancies: tuple[Constancy, ...] = ()
    criteria: Criteria = field(default_factory=Criteria)
    title: str = ""

    def __post_init__(self) -> None:
        _check_criteria(self.criteria)
        for kind, entries in (("light", self.lights), ("reflectance", self.reflectances)):
            names = [entry.name for entry in entries]
            for entry in entries:
                if names.count(entry.name) > 1:
                    raise PaletteError(f"two {kind}s are named {entry.name!r}")
                _check_entry(kind, entry, self.bounds(kind, entry))
        self._check_cells()
        for one in self.free_colours:
            if not all(low <= high for low, high in zip(one.lower, one.upper, strict=True)):
                raise PaletteError(
                    f"free colour {one.name!r}: its lower bounds {one.lower} exceed its upper {one.upper}"
                )
        for pair in self.differences:
            where = f"the difference of {self.where_both(pair)}"
            if pair.first == pair.second:
                raise PaletteError(f"{where}: a reflectance does not differ from itself")
            if pair.least is None and pair.most is None:
                raise PaletteError(f"{where}: say how far apart they are to be at least or at most")
            if pair.least is not None and pair.most is not None and pair.least > pair.most:
                raise PaletteError(f"{where}: at least {pair.least:g} and at most {pair.most:g} exclude each other")
            _check_number(f"{where}: the weight", pair.weight)
            for amount in (pair.least, pair.most):
                _check_number(f"{where}: a difference", 0.0 if amount is None else amount)
        for constancy in self.constancies:
            name = self.reflectances[constancy.reflectance].name
            _check_number(f"{name!r}: the weight of its constancy", constancy.weight)
            if len(set(constancy.lights)) < 2:
                raise PaletteError(f"{name!r} stays the same under two lights or more")

    def _check_cells(self) -> None:
        seen: set[tuple[int, int]] = set()
        for cell in self.cells:
            if not (0 <= cell.reflectance < len(self.reflectances) and 0 <= cell.light < len(self.lights)):
                raise PaletteError(f"a cell names row {cell.reflectance} and column {cell.light}, which are not there")
            where = self.where(cell)
            if (cell.reflectance, cell.light) in seen:
                raise PaletteError(f"{where} is given twice")
            seen.add((cell.reflectance, cell.light))
            if (cell.target is None) == (not cell.free):
                raise PaletteError(f"{where}: give a target colour or a free colour, and not both")
            if cell.target is not None and not np.isfinite(cell.target).all():
                raise PaletteError(f"{where}: the target colour is not three finite numbers")
            if cell.target is not None and np.abs(cell.target).max() > MOST:
                raise PaletteError(f"{where}: the target colour is more than {MOST:g} times as bright as white")
            _check_number(f"{where}: the weight", cell.weight)

    def where(self, cell: Cell) -> str:
        """The words for a cell."""
        return self.where_at(cell.reflectance, cell.light)

    def where_at(self, reflectance: int, light: int) -> str:
        """The words for where a reflectance and a light meet, by their indices."""
        return f"{self.reflectances[reflectance].name!r} under {self.lights[light].name!r}"

    def where_both(self, one: Difference) -> str:
        """The words for where two reflectances meet a light."""
        return f"{self.reflectances[one.first].name!r} and {self.where_at(one.second, one.light)}"

    def bounds(self, kind: str, entry: Entry) -> Bounds:
        """Lowest and highest value of what is designed."""
        if entry.bounds is not None:
            return entry.bounds
        if not self.criteria.bounded:
            return NO_BOUNDS
        return self.criteria.light_bounds if kind == "light" else self.criteria.reflectance_bounds

    def designed(self) -> list[Key]:
        """The ("light" or "reflectance", index) of all that is to be made."""
        rows = [("reflectance", i) for i, entry in enumerate(self.reflectances) if entry.designed]
        return [("light", j) for j, entry in enumerate(self.lights) if entry.designed] + rows

    def entry(self, kind: str, index: int) -> Entry:
        """The light or reflectance of that index."""
        return (self.lights if kind == "light" else self.reflectances)[index]

    def meetings(self) -> list[tuple[int, int]]:
        """The (reflectance, light) of all that cells, differences and constancies speak of, in order."""
        found = [(cell.reflectance, cell.light) for cell in self.cells if cell.weight > 0]
        for pair in self.differences:
            found += [(pair.first, pair.light), (pair.second, pair.light)]
        for constancy in self.constancies:
            found += [(constancy.reflectance, light) for light in constancy.lights]
        return sorted(set(found))

    def sampled(self, kind: str) -> Array:
        """Spectra (n, 81) of all lights or reflectances; what is still to be made is flat."""
        entries = self.lights if kind == "light" else self.reflectances
        return np.array([_sampled(kind, entry) for entry in entries]).reshape(len(entries), WAVELENGTHS.size)


def _check_number(what: str, value: float) -> None:
    if not 0 <= value <= MOST:
        raise PaletteError(f"{what} must be from 0 to {MOST:g}, not {value:g}")


def scaled(palette: Palette, kind: str, index: int, way: str, factor: float = 1.0) -> Entry:
    """The Entry of a light or reflectance, normalised by "LUMINANCE" or "L2" norm, and times `factor`.

    Raises PaletteError for one without a spectrum, or with nothing to normalise by.
    """
    entry = palette.entry(kind, index)
    if entry.spectrum is None:
        raise PaletteError(f"{kind} {entry.name!r} has no spectrum yet: create spectra")
    values = factor * colours.normalised(palette.sampled(kind)[index], way)
    spectrum = replace(entry.spectrum, wavelengths=WAVELENGTHS, values=values)
    luminance = max(float(colours.xyz_weights()[1] @ values), 0.0) if kind == "light" else entry.luminance
    return replace(entry, spectrum=spectrum, luminance=luminance)


def _sampled(kind: str, entry: Entry) -> Array:
    if entry.spectrum is None:
        return np.full(WAVELENGTHS.size, 1.0 if kind == "light" else 0.5)
    values = entry.spectrum.sampled()
    unit = colours.luminance_one(values) if kind == "light" else None
    return values if unit is None else entry.luminance * unit


def _check_criteria(criteria: Criteria) -> None:
    if criteria.space not in SPACES:
        raise PaletteError(f"colours are compared in {', '.join(SPACES)}, not in {criteria.space!r}")
    if criteria.use_model and criteria.model is None:
        raise PaletteError("a design for the colours of a model needs that model")
    for name in ("model_error", "smoothness"):
        _check_number(f"the weight of {name.replace('_', ' ')}", getattr(criteria, name))


def _check_entry(kind: str, entry: Entry, bounds: Bounds) -> None:
    where = f"{kind} {entry.name!r}"
    if not entry.designed and entry.spectrum is None:
        raise PaletteError(f"{where} is neither given nor designed")
    if len(bounds) != 2 or not bounds[0] < bounds[1]:
        raise PaletteError(f"{where}: no value is at least {bounds[0]:g} and at most {bounds[-1]:g}")
    for spectrum in filter(None, (entry.spectrum, entry.near)):
        inside = (spectrum.wavelengths >= WAVELENGTHS[0]) & (spectrum.wavelengths <= WAVELENGTHS[-1])
        # A single line is a light, and two samples may be a slope of which nothing more is known: not here
        if spectrum.kind != "illuminant" and inside.sum() < LEAST_SAMPLES:
            raise PaletteError(
                f"{where}: {spectrum.name!r} has {inside.sum()} samples between 380 and 780 nm; "
                f"a design needs {LEAST_SAMPLES} or more"
            )
        spectrum.sampled()
    if entry.span and entry.span not in library.REFLECTANCE_SETS:
        raise PaletteError(
            f"{where}: no set of reflectances {entry.span!r}: choose {', '.join(library.REFLECTANCE_SETS)}"
        )
    for name in ("near_weight", "span_weight", "luminance"):
        _check_number(f"{where}: its {name.replace('_', ' ')}", getattr(entry, name))
    given = None if entry.designed else entry.spectrum
    if kind == "light" and given and colours.luminance_one(given.sampled()) is None:
        raise PaletteError(f"{where} has no power where the eye sees")
