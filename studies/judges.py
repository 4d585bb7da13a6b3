"""Spectra at the edges that nothing was fitted to, to judge models by: made otherwise than `core.model.extremes`.

Where `luxpy` is installed its files of IES TM-30 judge as well: 4,880 measured reflectances less the CES, and 64 lamps
of mixed LEDs. Nothing of luxpy is imported, shipped or trained on.
"""

import csv
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from ..core.model.integration import FINE
from ..core.spectra import library
from ..core.spectra.arrays import Array
from ..core.spectra.spectrum import Spectrum

__all__ = [
    "boxes",
    "coloured_leds",
    "films",
    "led_mixtures",
    "measured",
    "saturated",
    "tm30_lamps",
    "tm30_reflectances",
]

SEED = 1931
FILMS = 172


def _spectra(rows: Array, name: str, kind: str = "reflectance") -> list[Spectrum]:
    return [Spectrum(FINE, row, f"{name} {number}", kind) for number, row in enumerate(rows, 1)]


@cache
def films() -> list[Spectrum]:
    """Gels, coloured glasses and interference filters on 1 nm: measured reflectances at depth (Beer's law), edges by
    the normal distribution, Butterworth band-passes and band-stops."""
    from scipy.special import erf

    random = np.random.default_rng(SEED)
    dyes = np.stack([spectrum.sampled(FINE) for spectrum in measured()])
    dyes = np.clip(dyes, 0.003, 1)
    dyes = dyes[np.ptp(dyes, axis=1) / dyes.max(axis=1) > 0.6]
    rows = []
    for _ in range(FILMS // 2):
        dye = dyes[random.integers(len(dyes))]
        rows.append(0.9 * (dye / dye.max()) ** random.uniform(1, 4))
    for number in range(FILMS - FILMS // 2):
        middle, width = random.uniform(420, 660), random.uniform(12, 60)
        edge = 0.5 * (1 + erf((FINE - middle) / random.uniform(4, 25)))
        band = 1 / (1 + np.abs((FINE - middle) / width) ** random.choice([6, 8]))
        rows.append(0.003 + 0.88 * (edge, 1 - edge, band, 1 - band)[number % 4])
    return _spectra(np.stack(rows), "film")


def measured() -> list[Spectrum]:
    """TM-30's reflectances, or the CES where luxpy is not installed."""
    return tm30_reflectances() or library.reflectances("ces")


@cache
def saturated() -> list[Spectrum]:
    """The 60 most saturated of `measured`, by how far they reach down and up."""
    values = np.stack([spectrum.sampled() for spectrum in measured()])
    purity = np.ptp(values, axis=1) / (values.max(axis=1) + 0.02) * values.max(axis=1)
    return [measured()[number] for number in np.argsort(-purity, kind="stable")[:60]]


def boxes(width: float) -> list[Spectrum]:
    """Reflectances of 0.9 over `width` nm, of 0.05 elsewhere, on 1 nm."""
    middles = np.arange(415.0, 700.0, 10.0)
    rows = 0.05 + 0.85 * (np.abs(FINE - middles[:, None]) <= width / 2)
    return _spectra(rows, f"box of {width:g} nm")


def _led(peak: float, width: float) -> Array:
    """An LED's power on FINE (Y. Ohno, Optical Engineering 44, 2005, eq. 1)."""
    bell = np.exp(-(((FINE - peak) / width) ** 2))
    return (bell + 2 * bell**5) / 3


@cache
def coloured_leds() -> list[Spectrum]:
    """55 LEDs with peaks from 420 to 670 nm, on 1 nm."""
    random = np.random.default_rng(SEED)
    rows = [_led(peak, random.uniform(10, 28)) for peak in np.linspace(420, 670, 55)]
    return _spectra(np.stack(rows), "LED", "illuminant")


@cache
def led_mixtures() -> list[Spectrum]:
    """53 white lights of three and of four LEDs, on 1 nm."""
    random = np.random.default_rng(SEED)
    rows = []
    for number in range(53):
        peaks = [(455, 530, 625), (450, 520, 590, 635)][number % 2]
        rows.append(sum(random.uniform(0.5, 1) * _led(p + random.normal(0, 8), random.uniform(10, 26)) for p in peaks))
    return _spectra(np.stack(rows), "LED mixture", "illuminant")


def _luxpy() -> Path | None:
    found = find_spec("luxpy")
    return Path(found.submodule_search_locations[0]) / "data" if found and found.submodule_search_locations else None


@cache
def tm30_reflectances(count: int = 400) -> list[Spectrum]:
    """`count` of TM-30's 4,880 reflectances, drawn, without those that are CES; [] without luxpy."""
    folder = _luxpy()
    if folder is None:
        return []
    table = np.load(folder / "rfls/IESTM30_15_R4880.npz")["_IESTM30_R4880"]
    nm, values = table[0], np.clip(table[1:], 0, 1)
    chosen = np.random.default_rng(SEED).permutation(len(values))
    ces = np.stack([spectrum.sampled() for spectrum in library.reflectances("ces")])
    own = [n for n in chosen if np.abs(ces - values[n, ::5]).max(axis=1).min() > 1e-3][:count]
    return [Spectrum(nm[::5], values[n, ::5], f"TM-30 {n + 1}") for n in own]


@cache
def tm30_lamps() -> list[Spectrum]:
    """TM-30's lamps of mixed LEDs; [] without luxpy."""
    folder = _luxpy()
    if folder is None:
        return []
    table = np.loadtxt(folder / "spds/IESTM30_15_Sspds.dat", delimiter=",")
    with open(folder / "spds/IESTM30_15_Sinfo.txt", newline="", encoding="utf-8") as file:
        info = list(csv.reader(file))[1:]
    mixed = [n for n, row in enumerate(info) if any(cell.strip() == "LED Mixed" for cell in row)]
    return [Spectrum(table[:, 0], table[:, 1 + n], f"TM-30 lamp {n + 1}", "illuminant") for n in mixed]
