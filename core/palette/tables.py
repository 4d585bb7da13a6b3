"""Designs as tables: TOML that people write, and the same as dictionaries that a .blend keeps.

docs/palette.md says what they hold. Raises PaletteError with the file, the table and what was expected.
"""

import tomllib
from collections.abc import Callable, Iterator
from dataclasses import fields
from functools import cache
from math import inf
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from ..colour.spaces import REC709
from ..errors import LibraryError, PaletteError, RelumeError
from ..model import bases, upsample
from ..model.factor_model import FactorModel
from ..spectra import files, library
from ..spectra.arrays import ArrayLike
from ..spectra.spectrum import WAVELENGTHS, Spectrum
from . import colours
from .design import Bounds, Cell, Constancy, Criteria, Difference, Entry, FreeColour, Palette, Three

__all__ = ["VERSION", "from_dict", "read", "to_dict", "upsampled"]

VERSION = 1
_ENTRY = {
    *("name", "spectrum", "file", "planckian", "colour", "designed", "luminance"),
    *("bounds", "near", "near_weight", "span", "span_weight"),
}
_TABLES = {
    "lights": _ENTRY,
    "reflectances": _ENTRY,
    "cells": {"light", "reflectance", "colour", "rgb", "xyz", "weight", "free"},
    "free_colours": {"name", "lower", "upper"},
    "differences": {"light", "between", "least", "most", "weight"},
    "constancies": {"reflectance", "lights", "adapted", "weight"},
}
_CRITERIA = {"channels", *(field.name for field in fields(Criteria))}
Table = dict[str, Any]
Made = TypeVar("Made")


def read(path: str | Path) -> Palette:
    """The Palette in a TOML file; files that it names are looked for beside it. Raises PaletteError."""
    path = Path(path)
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except FileNotFoundError:
        raise PaletteError(f"{path}: no such file") from None
    except (OSError, UnicodeDecodeError) as error:
        raise PaletteError(f"{path}: cannot be read as text: {error}") from None
    except tomllib.TOMLDecodeError as error:
        raise PaletteError(f"{path}: not TOML: {error}") from None
    try:
        return from_dict(table, path.parent)
    except RelumeError as error:
        raise PaletteError(f"{path}: {error}") from None


def from_dict(table: Table, folder: Path = Path()) -> Palette:
    """The Palette that a table describes. Raises PaletteError."""
    if not isinstance(table, dict):
        raise PaletteError("a design is a table")
    if table.get("version", VERSION) != VERSION:
        raise PaletteError(
            f"a design of version {table['version']}, which this Relume does not know: it reads {VERSION}"
        )
    _only(table, {"version", "title", "criteria", *_TABLES}, "the design")
    for name in _TABLES:
        if not isinstance(table.get(name, []), list) or not all(isinstance(one, dict) for one in table.get(name, [])):
            raise PaletteError(f"{name} is a list of tables: begin each with [[{name}]]")
    lights = tuple(_entries(table, "lights", "light", folder))
    reflectances = tuple(_entries(table, "reflectances", "reflectance", folder))
    columns = {entry.name: index for index, entry in enumerate(lights)}
    rows = {entry.name: index for index, entry in enumerate(reflectances)}
    try:
        return Palette(
            lights,
            reflectances,
            tuple(_each(table, "cells", lambda one: _cell(one, rows, columns))),
            tuple(_each(table, "free_colours", _free)),
            tuple(_each(table, "differences", lambda one: _difference(one, rows, columns))),
            tuple(_each(table, "constancies", lambda one: _constancy(one, rows, columns))),
            _criteria(table.get("criteria", {})),
            str(table.get("title", "")),
        )
    except (TypeError, ValueError) as error:
        raise error if isinstance(error, RelumeError) else PaletteError(str(error)) from None


def _each(table: Table, name: str, make: Callable[[Table], Made]) -> Iterator[Made]:
    for number, one in enumerate(table.get(name, []), start=1):
        where = f"{name} {number}"
        _only(one, _TABLES[name], where)
        try:
            yield make(one)
        except KeyError as error:
            if isinstance(error, LibraryError):
                raise PaletteError(f"{where}: {error}") from None
            raise PaletteError(f"{where}: {error.args[0]!r} is missing") from None
        except (TypeError, ValueError) as error:
            raise PaletteError(f"{where}: {error}") from None


def _only(table: Table, known: set[str], where: str) -> None:
    for name in table:
        if name not in known:
            raise PaletteError(f"{where}: no {name!r} is known; there are {', '.join(sorted(known))}")


def _entries(table: Table, name: str, kind: str, folder: Path) -> Iterator[Entry]:
    def make(one: Table) -> Entry:
        spectrum = _spectrum(one, kind, folder)
        return Entry(
            str(one.get("name", spectrum.name if spectrum else "")),
            spectrum,
            bool(one.get("designed", False)),
            _number(one, "luminance", 1.0),
            _pair(one["bounds"]) if "bounds" in one else None,
            _named(one["near"], kind) if "near" in one else None,
            _number(one, "near_weight", 0.1 if "near" in one else 0.0),
            str(one.get("span", "")),
            _number(one, "span_weight", 0.1 if "span" in one else 0.0),
        )

    return _each(table, name, make)


def _spectrum(one: Table, kind: str, folder: Path) -> Spectrum | None:
    given = [name for name in ("spectrum", "file", "planckian", "colour") if name in one]
    if len(given) > 1:
        raise PaletteError(f"{' and '.join(given)} are both given: one says what it is")
    if "spectrum" in one:
        return _named(one["spectrum"], kind)
    if "planckian" in one:
        return library.illuminant(f"Planckian {_number(one, 'planckian', 0.0):g} K")
    if "colour" in one:
        return _upsampled(one["colour"], kind)
    if "file" not in one:
        return None
    path = folder / str(one["file"])
    if kind == "light":
        return files.illuminant(path)
    found = files.read(path)
    if len(found) > 1:
        raise PaletteError(f"{path}: holds {len(found)} spectra; a row is one reflectance")
    return found[0]


def _named(what: Any, kind: str) -> Spectrum:
    if isinstance(what, dict):
        return Spectrum.from_dict(what)
    return library.illuminant(what) if kind == "light" else library.reflectance(what)


def upsampled(rgb: ArrayLike, space: str = REC709, name: str = "") -> Spectrum:
    """The smooth reflectance that has a colour, linear RGB (3,) of a space, under D65 -> Spectrum in 0..1."""
    reference = bases.bands()
    values = reference.reconstruct(upsample.rgb_matrix(reference, space) @ np.asarray(rgb, dtype=np.float64))
    return Spectrum(WAVELENGTHS, np.clip(values, 0.0, 1.0), name)


def _upsampled(text: str, kind: str) -> Spectrum:
    """The spectrum of a colour such as #3366cc: of a reflectance under D65, of a light as it is."""
    reflectance = upsampled(colours.display_from_xyz() @ colours.xyz_from_hex(text), name=str(text))
    if kind == "light":
        values = reflectance.values * library.illuminant("D65").sampled()
        return Spectrum(WAVELENGTHS, values, str(text), "illuminant")
    return reflectance


def _cell(one: Table, rows: dict[str, int], columns: dict[str, int]) -> Cell:
    return Cell(
        _index(one["reflectance"], rows, "reflectance"),
        _index(one["light"], columns, "light"),
        _colour(one),
        _number(one, "weight", 1.0),
        str(one.get("free", "")),
    )


def _colour(one: Table) -> Three | None:
    given = [name for name in ("colour", "rgb", "xyz") if name in one]
    if len(given) > 1:
        raise PaletteError(f"{' and '.join(given)} are both given: one is enough")
    if not given:
        return None
    if "colour" in one:
        return _three(colours.xyz_from_hex(one["colour"]).tolist())
    values = _three(one[given[0]])
    return _three(colours.xyz_from_rgb(values).tolist()) if given[0] == "rgb" else values


def _free(one: Table) -> FreeColour:
    lower, upper = _three(one.get("lower", [-inf] * 3)), _three(one.get("upper", [inf] * 3))
    return FreeColour(str(one["name"]), lower, upper)


def _difference(one: Table, rows: dict[str, int], columns: dict[str, int]) -> Difference:
    between = one["between"]
    if not isinstance(between, list) or len(between) != 2:
        raise PaletteError("'between' names two reflectances")
    first, second = (_index(name, rows, "reflectance") for name in between)
    least, most = (_number(one, name, 0.0) if name in one else None for name in ("least", "most"))
    return Difference(_index(one["light"], columns, "light"), first, second, least, most, _number(one, "weight", 1.0))


def _constancy(one: Table, rows: dict[str, int], columns: dict[str, int]) -> Constancy:
    lights = tuple(_index(name, columns, "light") for name in one["lights"])
    row = _index(one["reflectance"], rows, "reflectance")
    return Constancy(row, lights, bool(one.get("adapted", False)), _number(one, "weight", 1.0))


def _criteria(table: Table) -> Criteria:
    _only(table, _CRITERIA, "criteria")
    numbers = {name: _number(table, name, 0.0) for name in ("model_error", "smoothness") if name in table}
    known: Table = numbers | {name: take(table[name]) for name, take in _TAKEN.items() if name in table}
    if table.get("channels"):
        known["model"] = _model(str(table.get("model", "fitted")), table["channels"])
    return Criteria(**known)


@cache
def _model(name: str, channels: int) -> FactorModel:
    if name not in ("fitted", "block", "sharpened"):
        raise PaletteError(f"criteria: no model {name!r}: choose fitted, block, sharpened")
    return getattr(bases, name)(channels)


def _index(name: str, names: dict[str, int], what: str) -> int:
    if name not in names:
        raise PaletteError(f"no {what} is named {name!r}; there are {', '.join(names) or 'none'}")
    return names[name]


def _number(one: Table, name: str, default: float) -> float:
    value = one.get(name, default)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise PaletteError(f"{name!r} is a number, not {value!r}")
    return float(value)


def _three(values: Any) -> Three:
    if not isinstance(values, (list, tuple)) or len(values) != 3:
        raise PaletteError(f"a colour has three numbers, not {values!r}")
    x, y, z = values
    return float(x), float(y), float(z)


def _pair(values: Any) -> Bounds:
    if not isinstance(values, (list, tuple)) or len(values) != 2:
        raise PaletteError(f"bounds are two numbers, the lowest and the highest, not {values!r}")
    return float(values[0]), float(values[1])


# What becomes of the values of a table of criteria
_TAKEN: Table = {"space": str, "use_model": bool, "bounded": bool, "reflectance_bounds": _pair, "light_bounds": _pair}


def to_dict(palette: Palette) -> Table:
    """A table that JSON can keep, and from which `from_dict` makes the same design."""
    criteria = palette.criteria
    table = {
        "version": VERSION,
        "title": palette.title,
        "criteria": {
            "space": criteria.space,
            "model": "fitted" if criteria.model is None else criteria.model.name.split()[0],
            "channels": 0 if criteria.model is None else criteria.model.channels,
            "use_model": criteria.use_model,
            "model_error": criteria.model_error,
            "smoothness": criteria.smoothness,
            "bounded": criteria.bounded,
            "reflectance_bounds": list(criteria.reflectance_bounds),
            "light_bounds": list(criteria.light_bounds),
        },
        "lights": [_entry_dict(entry) for entry in palette.lights],
        "reflectances": [_entry_dict(entry) for entry in palette.reflectances],
    }
    rows = [entry.name for entry in palette.reflectances]
    columns = [entry.name for entry in palette.lights]
    table["cells"] = [
        {"light": columns[c.light], "reflectance": rows[c.reflectance], "weight": c.weight}
        | ({"free": c.free} if c.free else {"xyz": list(c.target or ())})
        for c in palette.cells
    ]
    table["free_colours"] = [
        {"name": one.name, "lower": list(one.lower), "upper": list(one.upper)} for one in palette.free_colours
    ]
    table["differences"] = [
        {"light": columns[one.light], "between": [rows[one.first], rows[one.second]], "weight": one.weight}
        | {name: getattr(one, name) for name in ("least", "most") if getattr(one, name) is not None}
        for one in palette.differences
    ]
    table["constancies"] = [
        {
            "reflectance": rows[one.reflectance],
            "lights": [columns[light] for light in one.lights],
            "adapted": one.adapted,
            "weight": one.weight,
        }
        for one in palette.constancies
    ]
    return table


def _entry_dict(entry: Entry) -> Table:
    table = {"name": entry.name, "designed": entry.designed, "luminance": entry.luminance}
    if entry.spectrum is not None:
        table["spectrum"] = entry.spectrum.to_dict()
    if entry.bounds is not None:
        table["bounds"] = list(entry.bounds)
    if entry.near is not None:
        table |= {"near": entry.near.to_dict(), "near_weight": entry.near_weight}
    if entry.span:
        table |= {"span": entry.span, "span_weight": entry.span_weight}
    return table
