"""What a page knows of lamps: their names and curves, and matrices of each from coefficients to XYZ."""

from collections.abc import Mapping, Sequence

import numpy as np

from ..errors import LibraryError
from ..model.factor_model import FactorModel
from ..picture import drawing
from ..picture.recombination import relight_matrix
from ..spectra import library
from ..spectra.library import OBSERVER
from ..spectra.spectrum import WAVELENGTHS, Spectrum

__all__ = ["KINDS", "RENDERED", "catalogue", "chosen", "matrices", "observers", "temperature_spectra", "temperatures"]

RENDERED = "As rendered"  # the family of illuminants that a file brings with it
CAMERAS = ("Nikon 5100 (NPL)", "Sigma SDMerill (NPL)")
KINDS = {"planckian": ("Planckian", 1000.0, 20000.0, 48), "daylight": ("D", 4000.0, 20000.0, 24)}


def chosen(names: Sequence[str]) -> dict[str, str]:
    """{name: family} of the lamps that a page offers: all that the library has for ("all",). Raises LibraryError."""
    every = {name: family for family, members in library.illuminants().items() for name in members}
    if list(names) == ["all"]:
        return every
    if not names:
        raise LibraryError("no lamps: give names of illuminants, or all")
    return {found: every.get(found, "Lamps") for found in (library.illuminant(name).name for name in names)}


def observers(own: str | tuple[Spectrum, ...] = OBSERVER) -> list[str | tuple[Spectrum, ...]]:
    """The observers that a page offers: the standard ones, cameras, and a file's `own`, first."""
    known = [*library.observers(), *CAMERAS]
    return [own, *(name for name in known if name != own)]


def catalogue(spectra: Mapping[str, Spectrum], families: Mapping[str, str]) -> list[dict]:
    """Name, family and colour of each lamp, as a menu shows it. Its curve is in `power`."""
    return [
        {"name": name, "family": families[name], "colour": np.round(drawing.swatch(spectrum), 3).tolist()}
        for name, spectrum in spectra.items()
    ]


def power(spectra: Sequence[Spectrum]) -> np.ndarray:
    """(lamps, 81) float32 spectral power on `WAVELENGTHS`, scaled so that a perfect white has Y = 1."""
    luminous = library.observer()[:, 1]
    values = np.stack([spectrum.sampled(WAVELENGTHS) for spectrum in spectra])
    return (values / (values @ luminous)[:, None]).astype(np.float32)


def matrices(
    model: FactorModel, spectra: Sequence[Spectrum], seen_by: Sequence[str | tuple[Spectrum, ...]]
) -> np.ndarray:
    """(observers, lamps, 3, p) float32: coefficients to the XYZ of a display, under each lamp, for each observer."""
    return np.array(
        [[relight_matrix(model, spectrum, observer) for spectrum in spectra] for observer in seen_by], np.float32
    )


def temperatures(kind: str) -> np.ndarray:
    """The temperatures in kelvin at which a page knows a kind of `KINDS`, evenly spaced in mired, hottest first."""
    _, coldest, hottest, count = KINDS[kind]
    return 1e6 / np.linspace(1e6 / hottest, 1e6 / coldest, count)


def temperature_spectra(kind: str) -> list[Spectrum]:
    """The illuminants of a kind of `KINDS` at its `temperatures`; between them a page interpolates matrices."""
    word = KINDS[kind][0]
    return [library.illuminant(f"{word} {np.clip(kelvin, *KINDS[kind][1:3]):.6f} K") for kelvin in temperatures(kind)]
