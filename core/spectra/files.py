"""Reading and writing spectra: text in columns, ANSI/IES TM-27 and CGATS.

Raises SpectrumError, one sentence with the file and, where there is one, the line. Text in columns is read here and not
by colour-science or NumPy alone: they make a number of `nan`, know no decimal comma, no unit and no per cent, and do
not say which line is wrong.
"""

import codecs
import csv
import os
import stat
from pathlib import Path

import numpy as np

from .. import results
from . import cgats, columns, measurement, tm27
from .spectrum import Spectrum, SpectrumError

__all__ = ["LARGEST", "illuminant", "observer", "read", "write"]

LARGEST = 64 * 2**20  # bytes; a file of a million wavelengths has about 20 MB
_CGATS, _TM27 = (".cgats", ".it8", ".cie", ".ti3"), (".spdx", ".xml")
# The longer mark first: that of UTF-16 begins that of UTF-32
_MARKS = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF32_LE, "utf-32-le"),
    (codecs.BOM_UTF32_BE, "utf-32-be"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)


def read(path, kind="reflectance"):
    """The spectra in a file -> list of Spectrum of that `kind`, named by its heading or by the file.

    Text in columns: wavelengths in the first, in nm unless its heading says µm, Å, cm⁻¹ or eV, one spectrum in each
    further one; separated by tabs, semicolons, commas or blanks; decimal points, or commas where nothing else is
    possible. One line of headings; lines that start with # are skipped. TM-27 (.spdx, XML), CGATS: as their fields say.
    Reflectances are per cent where the heading says so. What was read otherwise than it stands there is said in the
    spectrum's `source`. Raises SpectrumError, also for what can be read in two ways.
    """
    path = Path(path)
    try:
        return [spectrum for found in _found(path, kind) for spectrum in measurement.spectra(found, kind, path.name)]
    except SpectrumError as error:
        raise SpectrumError(f"{path}{', ' if str(error).startswith('line ') else ': '}{error}") from None


def _found(path, kind):
    data = _bytes(path)
    suffix = path.suffix.lower()
    if suffix in _TM27 or data.removeprefix(codecs.BOM_UTF8)[:1] == b"<":
        return [tm27.measurement(data, path.stem, kind)]
    text = _text(data)
    if suffix in _CGATS or "BEGIN_DATA_FORMAT" in text:
        return cgats.measurements(text, path.stem)
    return [columns.measurement(text, path.stem)]


def _bytes(path):
    """What a regular file holds. Raises SpectrumError for any other, which may never end."""
    try:
        status = path.stat()
        if stat.S_ISDIR(status.st_mode):
            raise SpectrumError("is a folder, not a file")
        if not stat.S_ISREG(status.st_mode):
            raise SpectrumError("is not a regular file")
        with open(path, "rb", opener=lambda name, flags: os.open(name, flags | getattr(os, "O_NONBLOCK", 0))) as file:
            data = file.read(LARGEST + 1)
    except FileNotFoundError:
        raise SpectrumError("no such file") from None
    except OSError as error:
        raise SpectrumError(f"cannot be read: {error.strerror or error}") from None
    except ValueError as error:  # a NUL in the name
        if isinstance(error, SpectrumError):
            raise
        raise SpectrumError(f"cannot be read: {error}") from None
    if len(data) > LARGEST:
        raise SpectrumError(f"is larger than {LARGEST >> 20} MB: no file of spectra")
    return data


def _text(data):
    """Text by its byte order mark, else UTF-8, else as Windows and older instruments write. Raises SpectrumError."""
    mark, encoding = next(((mark, name) for mark, name in _MARKS if data.startswith(mark)), (b"", "utf-8"))
    try:
        text = data[len(mark) :].decode(encoding)
    except UnicodeDecodeError as error:
        if mark:
            raise SpectrumError(f"cannot be read as text in {encoding.upper()}: {error.reason}") from None
        text = data.decode("latin-1")
    if "\0" in text:
        line = text[: text.index("\0")].count("\n") + 1
        raise SpectrumError(f"line {line}: has a NUL character: not text, or text without a byte order mark")
    return text


def illuminant(path):
    """The one illuminant in a file -> Spectrum of kind "illuminant". Raises SpectrumError, also for one in the dark."""
    found = read(path, kind="illuminant")
    if len(found) > 1:
        raise SpectrumError(f"{path}: holds {len(found)} spectra; an illuminant's file holds one")
    (lamp,) = found
    if not (lamp.sampled() > 0).any():
        raise SpectrumError(f"{path}: no power between 380 and 780 nm")
    return lamp


def observer(path):
    """Three sensitivities in a file, red, green, blue or x, y, z -> tuple of Spectrum. Raises SpectrumError."""
    found = read(path, kind="sensitivity")
    if len(found) != 3:
        raise SpectrumError(f"{path}: holds {len(found)} spectra; an observer or camera has three sensitivities")
    for spectrum in found:
        if not spectrum.sampled().any():
            raise SpectrumError(f"{path}: {spectrum.name!r} responds to nothing between 380 and 780 nm")
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
    names = [measurement.plain_name(measurement.without_per_cent(spectrum.name)) for spectrum in spectra]
    values = [np.interp(wavelengths, spectrum.wavelengths, spectrum.values) for spectrum in spectra]
    path = Path(path)
    with results.replacing(path) as partial, open(partial, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["wavelength_nm", *names])
        writer.writerows([repr(float(value)) for value in row] for row in zip(wavelengths, *values, strict=True))
    return path
