"""Spectra at the edges of what a scene may hold, by formula: gels, saturated paints, LEDs, lamps with gels.

They widen what filters are fitted on, where the measurements of colour-science hold none: dyes have absorption bands
that are Gaussian in wavenumber, and obey Beer's law with depth; edges of glasses and of interference filters are
logistic; paints of other strength obey Kubelka & Munk (1931); an LED is a peak of 12 to 42 nm, or a blue one with a
phosphor. Always the same draws of them.
"""

from functools import cache

import numpy as np

from ..spectra import library
from ..spectra.arrays import Array
from ..spectra.spectrum import WAVELENGTHS

__all__ = ["gels", "lights", "paints"]

SEED = 20160824
GELS = 60  # of each kind
LAMPS = ("A", "D65", "FL2", "FL11", "LED-B3", "LED-V1", "HP1")


@cache
def gels() -> Array:
    """Transmittances of dyed films, glasses with an edge, and interference filters -> (3 GELS, 81)."""
    random = np.random.default_rng(SEED)
    return np.concatenate([kind(random, GELS) for kind in (_dyed, _edged, _banded)])


def _dyed(random: np.random.Generator, count: int) -> Array:
    """One to three dyes in a clear film, at a depth of its own."""
    wavenumber = 1e7 / WAVELENGTHS
    rows = []
    for _ in range(count):
        dyes = random.integers(1, 4)
        density = np.zeros_like(WAVELENGTHS)
        for _ in range(dyes):
            centre, width = 1e7 / random.uniform(370, 720), random.uniform(700, 2500)
            density += random.uniform(0.2, 1) * np.exp(-0.5 * ((wavenumber - centre) / width) ** 2)
        rows.append(random.uniform(0.8, 0.95) * np.exp(-random.uniform(0.7, 6) * density / density.max()))
    return np.stack(rows)


def _step(centre: float, width: float) -> Array:
    return 1 / (1 + np.exp(-np.clip((WAVELENGTHS - centre) / width, -300, 300)))


def _edged(random: np.random.Generator, count: int) -> Array:
    """Long- and short-pass, the steepest of 3 nm, with what they leak."""
    rows = []
    for _ in range(count):
        step = _step(random.uniform(420, 680), random.uniform(2, 14))
        step = step if random.random() < 0.65 else 1 - step
        leak = random.choice([0.002, 0.02, 0.08])
        rows.append(leak + (random.uniform(0.75, 0.95) - leak) * step)
    return np.stack(rows)


def _banded(random: np.random.Generator, count: int) -> Array:
    """Band-pass and, one in three, band-stop, of 25 to 130 nm."""
    rows = []
    for _ in range(count):
        middle, half, slope = random.uniform(420, 670), random.uniform(12, 65), random.uniform(2, 10)
        band = _step(middle - half, slope) - _step(middle + half, slope)
        band = 1 - band if random.random() < 0.35 else band
        if random.random() < 0.5:
            band = np.maximum(band, _step(random.uniform(690, 760), 10))  # dyes pass the far red
        leak = random.choice([0.002, 0.02])
        rows.append(leak + (random.uniform(0.6, 0.93) - leak) * np.clip(band, 0, 1))
    return np.stack(rows)


@cache
def paints() -> Array:
    """The more colourful of the CES and the ColorChecker as paints three times as strong -> (m, 81)."""
    measured = np.stack([s.sampled() for name in ("ces", "colorchecker") for s in library.reflectances(name)])
    measured = np.clip(measured, 0.005, 0.98)
    colourful = measured[np.ptp(measured, axis=1) / measured.max(axis=1) > 0.7]
    strength = 3 * (1 - colourful) ** 2 / (2 * colourful)
    return 1 + strength - np.sqrt(strength**2 + 2 * strength)


@cache
def lights() -> tuple[Array, Array, Array]:
    """Relative power of coloured LEDs (l, 81), of mixtures and white LEDs (m, 81), of lamps with gels (g, 81)."""
    random = np.random.default_rng(SEED + 1)
    single = np.stack([_peak(centre, random.uniform(14, 38)) for centre in np.arange(410, 681, 9.0)])
    mixed = []
    for count in (3, 3, 4, 5) * 6:
        ends = np.linspace(445, 645, count) + random.uniform(-18, 18, count)
        peaks = np.stack([_peak(centre, random.uniform(12, 42)) for centre in ends])
        mixed.append(random.uniform(0.35, 1, count) @ peaks)
    for _ in range(10):
        phosphor = _peak(random.uniform(535, 605), random.uniform(90, 140))
        mixed.append(_peak(random.uniform(440, 465), random.uniform(18, 30)) * random.uniform(0.3, 1.2) + phosphor)
    lamps = [library.illuminant(name).sampled() for name in LAMPS]
    films = gels()
    through = [lamps[n % len(lamps)] * films[random.integers(len(films))] for n in range(30)]
    return single, np.stack(mixed), np.stack(through)


def _peak(centre: float, width: float) -> Array:
    """A Gaussian of full width `width` at half its height, in nm."""
    return np.exp(-4 * np.log(2) * ((WAVELENGTHS - centre) / width) ** 2)
