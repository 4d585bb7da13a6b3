"""The products of reflectances that filters and relight matrices are fitted on.

The reflectances are those that colour-science ships: CES, ColorChecker, and the test colours of two quality indices.
Two things that measured surfaces have and these samples lack are added: the absorption below 410 nm and the blue peak
of brightened white cloth and paper, and fine structure of two scales. Its amount was chosen by fitting on CES alone and
testing on the other charts, which between 8 and 20 nm do not tell one scale from another.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ..spectra import library
from ..spectra.arrays import Array
from ..spectra.spectrum import WAVELENGTHS
from . import extremes

__all__ = ["Training", "general", "products", "reflectances", "with_extremes", "with_general"]

SETS = ("ces", "colorchecker", "tcs", "cqs")
SEED = 20031103
STRUCTURE = (8.0, 20.0)  # nm, correlation lengths
BOUNCES = (1.0, 0.25, 0.15, 0.05)  # how much products of 1, 2, 3 and 4 reflectances count


@dataclass(frozen=True, eq=False)
class Training:
    """Products of reflectances (N, n), and how they come about.

    factors: for each number of bounces k, the indices (N_k, k) of the reflectances multiplied; sum of N_k = N.
    weights: (N,) importance, summing to 1.
    """

    products: Array
    factors: tuple[NDArray[np.int64], ...]
    weights: Array

    def coefficients(self, factors: Array) -> Array:
        """What a renderer makes of the products, (N, p), from the coefficients (m, p) of their `factors`."""
        return np.concatenate([factors[chosen].prod(axis=1) for chosen in self.factors])


def products(spectra: Array, bounces: Sequence[float] = BOUNCES, most: int = 1000) -> Training:
    """Products of the reflectances (m, n), at most `most` for each number of bounces, always the same -> Training."""
    random = np.random.default_rng(SEED)
    count = len(spectra)
    factors, weights = [], []
    for number, weight in enumerate(bounces, start=1):
        if number == 1 or count**number <= most:
            chosen = np.stack(np.meshgrid(*[np.arange(count)] * number, indexing="ij"), axis=-1).reshape(-1, number)
        else:
            chosen = random.integers(count, size=(most, number))
        factors.append(chosen)
        weights.append(np.full(len(chosen), weight / len(chosen) / sum(bounces)))
    spectra = np.concatenate([spectra[chosen].prod(axis=1) for chosen in factors])
    return Training(spectra, tuple(factors), np.concatenate(weights))


def with_general(
    own: Array, bounces: Sequence[float] = (1.0, 2.0, 3.0), share: float = 0.99, most: int = 500, part: int = 1
) -> tuple[Array, Training]:
    """Products of a scene's `own` reflectances (m, 81), which have `share` of the weight, and of the general ones.

    part: every nth of the general reflectances takes part, n = `part`. -> all the reflectances (m + ..., 81), Training.
    """
    general = reflectances()[::part]
    mine, others = products(own, bounces, most), products(general, BOUNCES[:3], most // part)
    return np.concatenate([own, general]), Training(
        np.concatenate([mine.products, others.products]),
        mine.factors + tuple(chosen + len(own) for chosen in others.factors),
        np.concatenate([share * mine.weights, (1 - share) * others.weights]),
    )


def with_extremes(bounces: Sequence[float], share: float, most: int = 500) -> tuple[Array, Training]:
    """The general products and, with `share` of their weight besides, those of gels and saturated paints.

    Of these come films and paints alone, surfaces under films, and three paints one after the other, of them or of the
    general ones. -> all the reflectances (m + ..., 81), Training.
    """
    random = np.random.default_rng(SEED)
    own, gels, paints = reflectances(), extremes.gels(), extremes.paints()
    base = products(own, bounces, most)
    films = len(own) + np.arange(len(gels))
    strong = films[-1] + 1 + np.arange(len(paints))
    every, under = np.concatenate([np.arange(len(own)), strong]), most // 2
    parts = {
        0.4: films[:, None],
        0.1: strong[:, None],
        0.3: np.stack([random.choice(films, under), random.choice(every, under)], axis=1),
        0.2: np.stack([random.choice(each, under) for each in (strong, every, strong)], axis=1),
    }
    spectra = np.concatenate([own, gels, paints])
    more = [spectra[chosen].prod(axis=1) for chosen in parts.values()]
    weights = [np.full(len(chosen), share * part / len(chosen)) for part, chosen in parts.items()]
    total = np.concatenate([base.weights, *weights])
    return spectra, Training(
        np.concatenate([base.products, *more]), base.factors + tuple(parts.values()), total / total.sum()
    )


@cache
def general() -> tuple[Array, Training]:
    """The general training set: its reflectances (m, 81) and their products -> (array, Training)."""
    return reflectances(), products(reflectances())


@cache
def reflectances() -> Array:
    """The general training set on WAVELENGTHS -> (m, 81)."""
    measured = np.stack([spectrum.sampled() for name in SETS for spectrum in library.reflectances(name)])
    structured = [_with_fine_structure(measured, width, SEED + n) for n, width in enumerate(STRUCTURE)]
    return np.concatenate([measured, _brightened_whites(), *structured])


def _brightened_whites() -> Array:
    """White and grey with the ultraviolet edge and the emission peak of optical brighteners -> (16, 81)."""
    levels = [0.8 * np.ones_like(WAVELENGTHS), 0.45 * np.linspace(0.85, 1, WAVELENGTHS.size)]
    edges = [0.25 + 0.75 / (1 + np.exp((edge - WAVELENGTHS) / 6)) for edge in (400, 410)]
    peaks = [np.exp(-0.5 * ((WAVELENGTHS - 438) / width) ** 2) for width in (14, 22)]
    return np.stack(
        [
            level * edge * (1 + amount * peak)
            for level in levels
            for edge in edges
            for amount in (0.06, 0.22)
            for peak in peaks
        ]
    )


def _with_fine_structure(spectra: Array, width: float, seed: int, amount: float = 0.03) -> Array:
    """Spectra times 1 + noise, the noise of standard deviation `amount` and correlation length `width` nm."""
    random = np.random.default_rng(seed)
    distance = np.subtract.outer(WAVELENGTHS, WAVELENGTHS) / width
    shape = np.linalg.cholesky(np.exp(-0.5 * distance**2) + 1e-6 * np.eye(WAVELENGTHS.size))
    noise = random.standard_normal(spectra.shape) @ shape.T
    return np.clip(spectra * (1 + amount * noise), 0, 1)
