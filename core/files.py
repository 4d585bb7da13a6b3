"""Reading and writing spectra: CSV, .spd and text in columns, ANSI/IES TM-27 (.spdx), and CGATS.

Raises SpectrumError with the file and, where there is one, the line.
"""

import csv
import re
from pathlib import Path

import numpy as np

from . import results
from .spectrum import Spectrum, SpectrumError

__all__ = ["illuminant", "observer", "read", "write"]

LIMITS = (100.0, 5000.0)  # nm; a first column outside is not wavelengths in nanometres


def read(path, kind="reflectance"):
    """The spectra in a file -> list of Spectrum, named by its heading or by the file.

    .csv: wavelengths in nm in the first column, one spectrum in each further one, a heading line if the first line is
    not numbers; separators comma, semicolon or tab. .spd, .txt, .dat: the same, separated by blanks too. .spdx: TM-27.
    .it8, .cgats, .cie: CGATS tables with fields such as SPECTRAL_NM_400. Lines that start with # are skipped.
    Raises SpectrumError.
    """
    path = Path(path)
    readers = {".spdx": _read_tm27, ".xml": _read_tm27, ".cgats": _read_cgats, ".it8": _read_cgats, ".cie": _read_cgats}
    try:
        text = path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise SpectrumError(f"{path}: no such file") from None
    except (OSError, UnicodeDecodeError) as error:
        raise SpectrumError(f"{path}: cannot be read as text: {error}") from None
    spectra = readers.get(path.suffix.lower(), _read_columns)(path, text, kind)
    if not spectra:
        raise SpectrumError(f"{path}: holds no spectra")
    return spectra


def illuminant(path):
    """The one illuminant in a file -> Spectrum of kind "illuminant". Raises SpectrumError, also for negative power."""
    found = read(path, kind="illuminant")
    if len(found) > 1:
        raise SpectrumError(f"{path}: holds {len(found)} spectra; an illuminant's file holds one")
    (lamp,) = found
    if (lamp.values < 0).any():
        first = lamp.wavelengths[np.argmax(lamp.values < 0)]
        raise SpectrumError(f"{path}: the power at {first:g} nm is negative; an illuminant's is 0 or more")
    if not (lamp.sampled() > 0).any():
        raise SpectrumError(f"{path}: no power between 380 and 780 nm")
    return lamp


def observer(path):
    """Three sensitivities in a file, red, green, blue or x, y, z -> tuple of Spectrum. Raises SpectrumError."""
    found = read(path, kind="sensitivity")
    if len(found) != 3:
        raise SpectrumError(f"{path}: holds {len(found)} spectra; an observer or camera has three sensitivities")
    return tuple(found)


def write(path, spectra):
    """Write spectra as CSV, on the union of their wavelengths -> path. Raises SpectrumError, ResultError.

    Every spectrum must be measured over the whole of that range; between its samples it is interpolated.
    """
    spectra = [spectra] if isinstance(spectra, Spectrum) else list(spectra)
    if not spectra:
        raise SpectrumError(f"{path}: no spectra to write")
    wavelengths = np.unique(np.concatenate([spectrum.wavelengths for spectrum in spectra]))
    for spectrum in spectra:
        if spectrum.wavelengths[0] > wavelengths[0] or spectrum.wavelengths[-1] < wavelengths[-1]:
            raise SpectrumError(
                f"{path}: {spectrum.name!r} covers {spectrum.wavelengths[0]:g} to {spectrum.wavelengths[-1]:g} nm, "
                f"the others {wavelengths[0]:g} to {wavelengths[-1]:g} nm"
            )
    columns = [np.interp(wavelengths, spectrum.wavelengths, spectrum.values) for spectrum in spectra]
    path = Path(path)
    with results.replacing(path) as partial, open(partial, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["wavelength_nm", *(spectrum.name for spectrum in spectra)])
        writer.writerows([repr(float(value)) for value in row] for row in zip(wavelengths, *columns, strict=True))
    return path


def _read_columns(path, text, kind):
    """Wavelengths in the first column, spectra in the others."""
    blanks = path.suffix.lower() != ".csv"
    head, rows = None, []
    for number, line in enumerate(text.splitlines(), start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        cells = _cells(line, blanks)
        values = [_number(cell) for cell in cells]
        if head is None and not rows and None in values:
            head = cells
            continue
        if None in values:
            raise SpectrumError(f"{path}, line {number}: {cells[values.index(None)]!r} is not a number")
        if len(values) < 2:
            raise SpectrumError(f"{path}, line {number}: needs a wavelength and at least one value")
        if rows and len(values) != len(rows[0]):
            raise SpectrumError(f"{path}, line {number}: has {len(values)} columns, the lines before {len(rows[0])}")
        if not LIMITS[0] <= values[0] <= LIMITS[1]:
            raise SpectrumError(f"{path}, line {number}: {values[0]:g} is not a wavelength in nm")
        rows.append(values)
    if not rows:
        raise SpectrumError(f"{path}: holds no numbers")
    table = np.array(rows)
    names = [path.stem] if table.shape[1] == 2 else [f"{path.stem} {j}" for j in range(1, table.shape[1])]
    if head is not None and len(head) == table.shape[1]:
        names = [name.strip() or other for name, other in zip(head[1:], names, strict=True)]
    return [
        _spectrum(path, table[:, 0], column, name, kind) for name, column in zip(names, table[:, 1:].T, strict=True)
    ]


def _cells(line, blanks):
    """The cells of a line, separated by tab, semicolon, comma or, if `blanks`, blanks; decimal commas are read."""
    for separator in ("\t", ";"):
        if separator in line:
            return [cell.strip().replace(",", ".") for cell in line.strip().split(separator)]
    if "," in line:
        return [cell.strip() for cell in next(csv.reader([line]))]
    return line.split() if blanks else [line.strip()]


def _number(cell):
    try:
        return float(cell)
    except ValueError:
        return None


def _read_tm27(path, text, kind):
    """ANSI/IES TM-27: an XML file of one spectrum, read by colour-science."""
    from xml.etree.ElementTree import ParseError

    from colour import SpectralDistribution_IESTM2714

    try:
        distribution = SpectralDistribution_IESTM2714(str(path)).read()
        wavelengths, values = distribution.wavelengths, distribution.values
    except ParseError as error:
        raise SpectrumError(f"{path}, line {error.position[0]}: not well-formed XML: {error}") from None
    except (ValueError, TypeError, AttributeError, KeyError):
        raise SpectrumError(f"{path}: not a TM-27 spectrum") from None
    kind = "illuminant" if kind == "reflectance" and distribution.spectral_quantity in (None, "flux") else kind
    return [_spectrum(path, wavelengths, values, distribution.header.description or path.stem, kind)]


def _read_cgats(path, text, kind):
    """CGATS.17: fields between BEGIN_DATA_FORMAT and END_DATA_FORMAT, rows between BEGIN_DATA and END_DATA."""
    fields, rows, section = [], [], None
    for number, line in enumerate(text.splitlines(), start=1):
        word = line.strip()
        if word in ("BEGIN_DATA_FORMAT", "BEGIN_DATA"):
            section = word
        elif word.startswith("END_DATA"):
            section = None
        elif section == "BEGIN_DATA_FORMAT":
            fields += word.split()
        elif section == "BEGIN_DATA" and word:
            cells = [quoted or plain for quoted, plain in re.findall(r'"([^"]*)"|(\S+)', word)]
            if len(cells) != len(fields):
                raise SpectrumError(f"{path}, line {number}: has {len(cells)} cells for {len(fields)} fields")
            rows.append((number, cells))
    bands = {
        j: re.fullmatch(r"(?:SPECTRAL_)?(?:NM|nm|R|SPEC)_?(\d{3,4}(?:\.\d+)?)", field) for j, field in enumerate(fields)
    }
    bands = {j: float(match[1]) for j, match in bands.items() if match}
    if not bands:
        raise SpectrumError(f"{path}: has no spectral fields such as SPECTRAL_NM_400")
    labels = [j for j, field in enumerate(fields) if field in ("SAMPLE_NAME", "SAMPLE_ID", "SAMPLE_LOC")]
    spectra = []
    for number, cells in rows:
        values = [_number(cells[j]) for j in bands]
        if None in values:
            raise SpectrumError(f"{path}, line {number}: a spectral value is not a number")
        name = cells[labels[0]] if labels else f"{path.stem} {len(spectra) + 1}"
        spectra.append(_spectrum(path, list(bands.values()), values, name, kind))
    return spectra


def _spectrum(path, wavelengths, values, name, kind):
    try:
        return Spectrum(wavelengths, values, name, kind, path.name)
    except SpectrumError as error:
        raise SpectrumError(f"{path}: {error}") from None
