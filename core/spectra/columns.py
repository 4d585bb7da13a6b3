"""Text in columns, wavelengths in the first: which separator, which decimal mark, a heading or none."""

import csv
import re

import numpy as np

from ..errors import SpectrumError
from .measurement import MOST, Measurement, is_per_cent, without_per_cent

__all__ = ["measurement", "number"]

_EMPTY = " \t\v\f\xa0;,"  # a line of nothing else is an empty row of a spreadsheet
_PART = 10_000  # lines that are read at once
_LONGEST = 500  # characters of a heading that are looked at
_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_STARTS_AS_NUMBER = re.compile(r"""[\s"']*[+-]?[.,]?[0-9]""")
_NOT_A_NAME = {"nan", "inf", "+inf", "-inf", "infinity", "-infinity", "n/a", "na", "null", "none", "-", "--"}
_OF_WAVELENGTHS = re.compile(r"wave|well|λ|lambda|nm\b|[µμu]m\b|nanom|wl\b|longueur|longitud|lunghezza", re.IGNORECASE)
# A comma that cannot stand between thousands: 0,5 · 0,500 · 12,5 · 1234,567 · 1,2345 · 1,234e5, and 380,000 in front
_DECIMAL_COMMA = re.compile(
    r"(?<![0-9,])(?:0[0-9]*|[0-9]{4,}),[0-9]|,[0-9]{1,2}(?![0-9])|,[0-9]{4,}|,[0-9]+[eE]|(?<![0-9]),[0-9]"
    r"|^\s*[1-9][0-9][0-9],[0-9]{3}(?![0-9,])",
    re.MULTILINE,
)


def number(cell: str):
    """The finite decimal number in a cell, None if it is none: `nan`, `1e400`, `0x1p-3` and `1_0` are not."""
    value = float(cell) if _NUMBER.fullmatch(cell) else None
    return value if value is None or abs(value) < float("inf") else None


def measurement(text: str, name: str) -> Measurement:
    """The table in a text. Its spectra are called as the heading calls them, else `name`.

    Raises SpectrumError, with the line.
    """
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    numbers = [line for line, row in enumerate(lines, start=1) if (kept := row.strip(_EMPTY)) and kept[0] != "#"]
    rows = lines if len(numbers) == len(lines) else [lines[line - 1] for line in numbers]
    if not rows:
        raise SpectrumError("holds no numbers")
    first = next((row for row in (0, 1) if row < len(rows) and _STARTS_AS_NUMBER.match(rows[row])), None)
    if first is None:
        start = rows[min(1, len(rows) - 1)].strip()[:40]
        raise SpectrumError(f"line {numbers[min(1, len(rows) - 1)]}: {start!r} does not begin with a wavelength")
    separator = _separator(rows[first])
    if '"' in text:
        rows = [_unquoted(row, separator, line) for row, line in zip(rows, numbers, strict=True)]
        separator = "\t"
    head = []
    if first == 1:
        head = [cell[:_LONGEST] for cell in _stripped(_cells(rows[0], separator))]
        line, rows, numbers = numbers[0], rows[1:], numbers[1:]
    count = _count(rows[0], separator, head)
    if head:
        _check_heading(head, line, count)
    if count - 1 > MOST:
        raise SpectrumError(f"line {numbers[0]}: has {count} columns; a file may hold {MOST} spectra")
    _check_commas(rows, numbers, separator, head, count)
    with_sign = "%" in rows[0]
    if separator != ",":
        rows = _with_points(rows, numbers)
    values = _table(rows, numbers, separator, count, with_sign)
    names = [name] if count == 2 else [f"{name} {column}" for column in range(1, count)]
    per_cent = [with_sign] * (count - 1)
    title = " ".join(head[:50])[:_LONGEST]  # where it is no heading, or one that blanks have torn
    if len(head) == count:
        per_cent = [with_sign or is_per_cent(heading) for heading in head[1:]]
        names = [without_per_cent(heading) or other for heading, other in zip(head[1:], names, strict=True)]
    elif is_per_cent(title):
        per_cent = [True] * (count - 1)
    unit = head[0] if len(head) == count else re.sub(r"(?<![\w-])[0-9][0-9.,]*\s*\w+", "", title)  # less its amounts
    return Measurement(np.array(numbers), values[:, 0], values[:, 1:], names, unit, tuple(per_cent))


def _separator(row):
    """What separates the cells of a line of numbers: tab, semicolon, comma, or None for blanks."""
    for mark in ("\t", ";"):
        if mark in row.strip():
            return mark
    words = row.split()
    if "," in row and not (len(words) > 1 and not any(word[0] == "," or word[-1] == "," for word in words)):
        return ","
    return None  # with decimal commas, or none


def _cells(row, separator):
    return row.split() if separator is None else [cell.strip() for cell in row.split(separator)]


def _stripped(cells):
    """The cells without empty ones at the end, which trailing separators make."""
    while cells and not cells[-1]:
        cells = cells[:-1]
    return cells


def _unquoted(row, separator, line):
    """A line with quoted cells as one with tabs between the cells."""
    if '"' not in row:
        return "\t".join(_cells(row, separator))
    try:
        cells = next(csv.reader([row.strip(" ")], delimiter=separator or " ", skipinitialspace=True, strict=True))
    except csv.Error as error:
        raise SpectrumError(f"line {line}: cannot be split into cells: {error}") from None
    return "\t".join(cell.replace("\t", " ").strip() for cell in cells)


def _check_heading(head, line, count):
    """Raises SpectrumError where the first line is a damaged line of numbers, not a heading."""
    if len(head) == count and _OF_WAVELENGTHS.search(head[0]):
        return  # spectra may be numbered
    for cell in head[1:]:
        if _STARTS_AS_NUMBER.match(cell) or cell.lower() in _NOT_A_NAME:
            raise SpectrumError(f"line {line}: {head[0][:40]!r} is not a number, and {cell[:40]!r} is no heading")


def _count(row, separator, head):
    """How many columns there are: as many as in the first line, or as in the heading where its last cells are empty."""
    cells = _cells(row, separator)
    filled = len(_stripped(cells))
    return len(head) if filled < len(head) <= len(cells) else filled


def _check_commas(rows, numbers, separator, head, count):
    """Raises SpectrumError for a file that can be read in two ways."""
    if separator == "," and count > 2 and not any("." in row for row in rows):
        # A heading with a comma in it may have as many parts: "wavelength, nm, R", or "R, old" above 0,5
        cells = [_cells(row, separator)[:count] for row in rows] if len(head) == count else []
        apart = cells and re.fullmatch(r"\W*(in )?(nm|[µμu]m)\W*", head[1], re.IGNORECASE)
        flat = [set(column) <= {"0", "1"} for column in zip(*cells, strict=False)][1:]
        if len(head) != count or apart or any(flat[:-1]) and not flat[-1]:
            raise SpectrumError(
                f"line {numbers[0]}: {rows[0].strip()[:40]!r} may be {count - 1} spectra, or numbers with decimal "
                "commas: write decimal points, separate with semicolons, or give every column a heading"
            )
    if separator is None and "," in rows[0] and all(re.fullmatch(r"\S+(\s+[0-9]{3})+\s*", row) for row in rows):
        raise SpectrumError(
            f"line {numbers[0]}: {rows[0].strip()[:40]!r} may have a blank between thousands or between columns: "
            "write numbers without blanks"
        )


def _with_points(rows, numbers):
    """Lines with decimal points in place of decimal commas. Raises SpectrumError where the commas may be others."""
    body = "\n".join(rows)
    if "," not in body:
        return rows
    comma = next(row for row, line in enumerate(rows) if "," in line)
    if "." in body:
        point = next(row for row, line in enumerate(rows) if "." in line)
        raise SpectrumError(
            f"line {numbers[comma]}: has a comma in a number, line {numbers[point]} a decimal point: use one of them"
        )
    if not _DECIMAL_COMMA.search(body):
        cell = re.search(r"[^\s;]*,[^\s;]*", rows[comma])[0]
        raise SpectrumError(
            f"line {numbers[comma]}: the comma in {cell[:40]!r} may be a decimal mark or stand between thousands: "
            "write decimal points"
        )
    return body.replace(",", ".").split("\n")


def _table(rows, numbers, separator, count, with_sign):
    """(n, count) numbers of lines; a part that is out of the ordinary is read cell by cell, to name line and cell."""
    parts = []
    for first in range(0, len(rows), _PART):
        some = rows[first : first + _PART]
        values = None if with_sign or count < 2 else _plain_table(some, separator)
        if values is None or values.shape != (len(some), count) or not np.isfinite(values).all():
            lines = zip(some, numbers[first : first + _PART], strict=True)
            values = np.array([_numbers(row, line, separator, count, with_sign) for row, line in lines])
        parts.append(values)
    return np.concatenate(parts)


def _numbers(row, line, separator, count, with_sign):
    """The numbers in a line."""
    cells = _cells(row, separator)
    while len(cells) > count and not cells[-1]:
        cells.pop()
    if with_sign:
        cells = [cells[0], *(_without_sign(cell, line) for cell in cells[1:])]
    found = [number(cell) for cell in cells]
    if None in found:
        raise SpectrumError(f"line {line}: {cells[found.index(None)][:40]!r} is not a number")
    if len(found) < 2:
        raise SpectrumError(f"line {line}: needs a wavelength and at least one value")
    if len(found) != count:
        raise SpectrumError(f"line {line}: has {len(found)} columns, the lines before {count}")
    return found


def _plain_table(rows, separator):
    """(n, columns) numbers where lines hold nothing but digits, marks and separators, by NumPy's fast reader; or None.

    That reader takes `nan` and numbers that fill up a float for numbers, and cannot name the line of the file.
    """
    plain = b"0123456789+-.eE \n" + (separator or "").encode()
    try:
        if "\n".join(rows).encode("ascii").translate(None, plain):
            return None
        return np.loadtxt(rows, delimiter=separator, comments=None, ndmin=2)
    except (UnicodeEncodeError, ValueError):
        return None


def _without_sign(cell, line):
    if not cell.endswith("%"):
        raise SpectrumError(f"line {line}: {cell[:40]!r} has no % sign; other values have one")
    return cell[:-1].rstrip()
