"""CGATS.17 tables: one spectrum in each line, in fields such as SPECTRAL_NM_400."""

import re

import numpy as np

from ..errors import SpectrumError
from .columns import number
from .measurement import MOST, Measurement

__all__ = ["measurements"]

_BAND = re.compile(r"(?:SPECTRAL_)?(NM|R|SPEC|PCT|DEC)_?([0-9]{3,4}(?:\.[0-9]+)?)", re.IGNORECASE)
_NEARLY_A_BAND = re.compile(r"(?:SPEC|NM).*|(?:R|PCT|DEC)[^A-Z].*|.*[0-9]{3}", re.IGNORECASE)
_WORD = re.compile(r'"([^"]*)"(?!\S)|(\S+)')
_LABELS = ("SAMPLE_NAME", "SAMPLE_ID", "SAMPLE_LOC")


def measurements(text: str, name: str) -> list[Measurement]:
    """The spectra in all tables of a text, one Measurement each. Raises SpectrumError, with the line."""
    found, fields, section, norm, rows = [], [], None, 1.0, 0
    said = {}  # NUMBER_OF_FIELDS, NUMBER_OF_SETS of this table
    for line, row in enumerate(text.replace("\r\n", "\n").replace("\r", "\n").split("\n"), start=1):
        words = [quoted or plain for quoted, plain in _WORD.findall(row)]
        if not words or row.lstrip().startswith("#"):
            continue
        if words[0] in ("BEGIN_DATA_FORMAT", "BEGIN_DATA"):
            if section:
                raise SpectrumError(f"line {line}: {words[0]} stands inside {section}, which does not end")
            section, rows = words[0], 0
            fields = [] if section == "BEGIN_DATA_FORMAT" else fields
        elif words[0] in ("END_DATA_FORMAT", "END_DATA"):
            if section != words[0].replace("END", "BEGIN"):
                raise SpectrumError(f"line {line}: {words[0]} without its beginning")
            have, key = (rows, "NUMBER_OF_SETS") if section == "BEGIN_DATA" else (len(fields), "NUMBER_OF_FIELDS")
            if said.pop(key, have) != have:
                raise SpectrumError(f"line {line}: holds {have}, not what {key} says")
            section = None
        elif section == "BEGIN_DATA_FORMAT":
            fields += words
        elif section == "BEGIN_DATA":
            if len(words) != len(fields):
                raise SpectrumError(f"line {line}: has {len(words)} cells for {len(fields)} fields")
            rows += 1
            spectrum = _measurement(fields, words, line, norm, f"{name} {len(found) + 1}")
            found += [spectrum] if spectrum else []
            if len(found) > MOST:
                raise SpectrumError(f"line {line}: a file may hold {MOST} spectra")
        elif words[0] in ("NUMBER_OF_SETS", "NUMBER_OF_FIELDS") and len(words) > 1:
            said[words[0]] = number(words[1])
        elif words[0] == "SPECTRAL_NORM" and len(words) > 1:  # Argyll: what stands for 1
            norm = number(words[1])
            if norm not in (1.0, 100.0):
                raise SpectrumError(f"line {line}: SPECTRAL_NORM is {words[1][:40]!r}, neither 1 nor 100")
    if section:
        raise SpectrumError(f"is cut off: {section} does not end")
    if not found:
        raise SpectrumError("has no table with spectral fields such as SPECTRAL_NM_400")
    return found


def _measurement(fields, cells, line, norm, name):
    """One line of a table; None where its fields are not spectral."""
    bands = {place: match for place, field in enumerate(fields) if (match := _BAND.fullmatch(field))}
    if not bands:
        return None
    for place, field in enumerate(fields):
        if place not in bands and _NEARLY_A_BAND.fullmatch(field):
            raise SpectrumError(f"the field {field[:40]!r} does not end in a wavelength in nm")
    values = {place: number(cells[place]) for place in bands}
    for place, value in values.items():
        if value is None:
            raise SpectrumError(f"line {line}: {cells[place][:40]!r} in {fields[place]} is not a number")
    label = next((cells[fields.index(field)] for field in _LABELS if field in fields), name)
    per_cent = norm == 100.0 or all(match[1].upper() == "PCT" for match in bands.values())
    return Measurement(
        np.full(len(bands), line),
        np.array([float(match[2]) for match in bands.values()]),
        np.array(list(values.values()))[:, None],
        [label],
        per_cent=(per_cent,),
    )
