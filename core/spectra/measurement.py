"""What a file says, before it is believed: units, per cent, ranges -> Spectrum. Every format goes through here."""

import re
from typing import NamedTuple

import numpy as np

from .spectrum import NOISE, RANGES, WAVELENGTHS, Spectrum, SpectrumError

__all__ = ["MOST", "Measurement", "is_per_cent", "plain_name", "spectra", "without_per_cent"]

# Of what was measured: a fluorescent paint gives back, at some wavelengths, up to twice the light that falls there, and
# one in per cent that stays below 2 would be blacker than soot.
REFLECTANCE = (-NOISE, 2.0)

LIMITS = (100.0, 5000.0)  # nm; whatever lies outside is no wavelength in nanometres
MOST = 100_000  # spectra in a file
_LONGEST = 200  # characters of a name
_FLUORESCENT = 1.0 + NOISE  # a greater reflectance is remarked upon

_PER_CENT = r"[(\[]?\s*(?:%|(?<![a-z])(?:in[\s_])?per[\s_]?cent(?:age)?(?![a-z])|(?<![a-z])pct(?![a-z]))\s*[)\]]?"
_AMOUNT = re.compile(r"(?<![\w.])\d[\d.,]*\s*(?:%|per[\s_]?cent)", re.IGNORECASE)

# How a heading calls the unit of its wavelengths, what it is called here, and the nanometres that it stands for
_UNITS = (
    (r"nm|nanomet\w*", "nm", lambda x: x),
    (r"[µμu]m|microns?|[µμ]|micromet\w*", "µm", lambda x: x * 1000.0),
    (r"å|[aå]ngstr\w*|(?<=[(\[])a(?=[)\]])", "Å", lambda x: x / 10.0),
    (r"cm\^?[-−–]1|cm⁻¹|1/cm|wavenumbers?", "cm⁻¹", lambda x: 1e7 / x),
    (r"ev", "eV", lambda x: 1239.841984 / x),
)
# What wavelengths look like whose unit is not said, in a range that holds visible light
_LOOKS = ((0.2, 20.0, "µm or eV"), (2000.0, 12000.0, "Å"), (8000.0, 50000.0, "cm⁻¹"))


class Measurement(NamedTuple):
    """Wavelengths (n,) and values (n, m) as they stand in a file, in the order of its `lines` (n,).

    names: of the m spectra. unit: what the heading says of the wavelengths. per_cent: (m,) whether the file says so.
    """

    lines: np.ndarray
    wavelengths: np.ndarray
    values: np.ndarray
    names: list[str]
    unit: str = "nm"
    per_cent: tuple[bool, ...] = (False,)


def is_per_cent(heading: str) -> bool:
    """Whether a heading such as "R (%)" gives the unit; "50 % grey" does not, which is an amount in a name."""
    return re.search(_PER_CENT, re.sub(_AMOUNT, "", heading), re.IGNORECASE) is not None


def without_per_cent(heading: str) -> str:
    """A heading without its unit, if that is per cent: what is called so is a fraction from now on."""
    return re.sub(_PER_CENT, " ", heading, flags=re.IGNORECASE).strip(" ,;:_/") if is_per_cent(heading) else heading


def plain_name(name: str) -> str:
    """A name on one line, and not too long for a heading or a data-block."""
    return re.sub(r"[\x00-\x1f\x7f\s]+", " ", name).strip()[:_LONGEST]


def spectra(found: Measurement, kind: str, source: str) -> list[Spectrum]:
    """The spectra of a measurement, in nm and as fractions of 1, checked -> list of Spectrum.

    What was read otherwise than it stands there is said in their `source`. Raises SpectrumError, without the file.
    """
    remarks: list[str] = []
    wavelengths = _nanometres(found, kind, remarks)
    values = _fractions(found, remarks) if kind == "reflectance" else found.values
    values = _within(found, wavelengths, values, kind, remarks)
    _check_samples(found, wavelengths, kind)
    source = ", ".join([source, *dict.fromkeys(remarks)])
    names = [plain_name(name) for name in found.names]
    return [Spectrum(wavelengths, column, name, kind, source) for name, column in zip(names, values.T, strict=True)]


def _nanometres(found: Measurement, kind: str, remarks: list[str]) -> np.ndarray:
    """(n,) nm, by the unit that the heading gives."""
    heading = found.unit.lower()
    unit, convert = "nm", _UNITS[0][2]
    for words, name, conversion in _UNITS:
        if re.search(rf"(?<![a-zµμåα-ω])(?:{words})(?![a-zµμå])", heading.replace("_", " ")):
            unit, convert = name, conversion
            break
    else:
        if heading.strip() == "wl" and found.wavelengths.max() < 100:
            unit, convert = "µm", _UNITS[1][2]  # the files of refractiveindex.info
    if unit in ("cm⁻¹", "eV") and kind == "illuminant":
        raise SpectrumError(f"its power is per {unit}; an illuminant's is per nm: convert both columns")
    with np.errstate(all="ignore"):
        nanometres = convert(found.wavelengths)
    outside = ~((nanometres >= LIMITS[0]) & (nanometres <= LIMITS[1]))
    if outside.any():
        row = np.argmax(outside)
        low, high = found.wavelengths.min(), found.wavelengths.max()
        hint = next((name for least, most, name in _LOOKS if unit == "nm" and least <= low <= high <= most), "")
        hint = f"; it looks like {hint}: say so in the heading of the first column, or give nm" if hint else ""
        raise SpectrumError(f"line {found.lines[row]}: {found.wavelengths[row]:g} is not a wavelength in {unit}{hint}")
    low, high = nanometres.min(), nanometres.max()
    if kind not in ("illuminant", "sensitivity") and (high < WAVELENGTHS[0] or low > WAVELENGTHS[-1]):
        raise SpectrumError(f"covers {low:g} to {high:g} nm, nothing of the visible 380 to 780 nm")
    if unit != "nm":
        remarks.append(f"wavelengths read as {unit}")
    return nanometres


def _fractions(found: Measurement, remarks: list[str]) -> np.ndarray:
    """(n, m) reflectances; those in per cent divided by 100."""
    if not any(found.per_cent):
        return found.values
    remarks.append("read as per cent")
    return found.values / np.where(found.per_cent, 100.0, 1.0)


def _within(
    found: Measurement, wavelengths: np.ndarray, values: np.ndarray, kind: str, remarks: list[str]
) -> np.ndarray:
    """(n, m) values inside the range of their kind; a meter's noise below 0 is 0. Raises SpectrumError."""
    least, high = REFLECTANCE if kind == "reflectance" else RANGES[kind]
    low = -NOISE * np.abs(values).max(axis=0) if kind == "illuminant" else np.full(values.shape[1], least)
    outside = (values < low) | (values > high)
    if outside.any():
        row, column = np.argwhere(outside)[0]
        where = f"line {found.lines[row]}: " + (f"{found.names[column]!r:.60}: " if len(found.names) > 1 else "")
        value = f"{found.values[row, column]:g}{' %' if kind == 'reflectance' and found.per_cent[column] else ''}"
        if kind == "illuminant" and values[row, column] < 0:
            raise SpectrumError(
                f"{where}the power at {wavelengths[row]:g} nm is negative, {value}; an illuminant's is 0 or more"
            )
        words = f"{where}{value} is outside the range of {kind}, {least:g} to {high:g}"
        if kind == "reflectance" and not any(found.per_cent) and high < values.max() <= 100 * high:
            words += "; it looks like per cent: write % in the column's heading, or divide by 100"
        raise SpectrumError(words)
    if kind in ("illuminant", "reflectance") and (values < 0).any():
        remarks.append("noise below 0 read as 0")
        values = np.maximum(values, 0.0)
    if kind == "reflectance" and values.max() > _FLUORESCENT:
        remarks.append("above 1 in places, as if it fluoresced")
    return values


def _check_samples(found: Measurement, wavelengths: np.ndarray, kind: str) -> None:
    """Raises SpectrumError for wavelengths that are repeated, or for one alone where one says nothing of the others."""
    order = np.argsort(wavelengths, kind="stable")
    again = np.flatnonzero(np.diff(wavelengths[order]) <= 0)
    if again.size:
        first, second = found.lines[order[again[0]]], found.lines[order[again[0] + 1]]
        raise SpectrumError(
            f"line {second}: {wavelengths[order[again[0]]]:g} nm occurs more than once, first in line {first}"
        )
    if wavelengths.size < 2 and kind in ("reflectance", "sensitivity"):
        raise SpectrumError(f"holds one wavelength only; a {kind} needs two or more")
