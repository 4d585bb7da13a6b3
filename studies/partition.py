"""Filters of which every pass's three share out one common weighting: the noise of hue they save, and what it costs.

    python -m relume.studies.partition [--reflectances FILE] [--iterations N] [--noise WEIGHT ...] [--passes N]

Then a pass's three channels, each times its share of the weighting, sum to the same number in every pass, whatever the
spectrum: what of the passes' noise is one of brightness can be divided out exactly, without blurring anything.

The noise is that of a pixel whose samples are, each with a brightness of its own (relative variance 1), half the colour
of a surface and half that of its product with another; the passes share the samples. *Hue* is the
variance across the direction of brightness, in the metric of CIEDE2000, over that of an RGB render with as many
samples: to first order, for many samples. "Divided" is without the passes' brightness: exact for filters that share a
weighting, while for others the ratio of two passes' brightness has to be taken from a blurred picture.
"""

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..core.colour import differences
from ..core.model import bases, channel_order, optimise, relight, training
from ..core.spectra import files, library
from ..core.spectra.arrays import Array
from ..core.spectra.spectrum import WAVELENGTHS
from .levers import cie_lights
from .reports import Section, publish

PASSES = 3
SURFACES, SECONDS = 40, 12  # of the pixels whose noise counts
SPREAD = 1.0  # variance of a sample's brightness, relative
EVERY = 4  # every nth illuminant is optimised for; all of them judge


@dataclass(frozen=True, eq=False)
class Pixels:
    """Samples of pixels: spectra (m, s, n), of mean (m, n) by their weights (s,)."""

    samples: Array
    weights: Array

    @classmethod
    def drawn(cls, spectra: Array, seed: int) -> "Pixels":
        random = np.random.default_rng(seed)
        first = spectra[random.integers(len(spectra), size=SURFACES)]
        second = spectra[random.integers(len(spectra), size=(SURFACES, SECONDS))]
        samples = np.concatenate([first[:, None], first[:, None] * second], axis=1)
        return cls(samples, np.array([0.5, *[0.5 / SECONDS] * SECONDS]))

    @property
    def mean(self) -> Array:
        return np.einsum("s,msn->mn", self.weights, self.samples)

    def metric(self, power: Array) -> tuple[Array, Array]:
        """(e, m, 3, 3) of power weights (e, n, 3): a small difference in CIEDE2000, and what is not of brightness."""
        metrics, across = [], []
        for one, white in zip(power, power.sum(axis=1), strict=True):
            xyz = self.mean @ one
            metric = relight.local_metric(xyz, white)
            along = np.einsum("mij,mj->mi", metric, xyz)
            along /= np.linalg.norm(along, axis=1, keepdims=True)
            metrics.append(metric)
            across.append(metric - along[:, :, None] * np.einsum("mi,mij->mj", along, metric)[:, None])
        return np.stack(metrics), np.stack(across)

    def rgb_variance(self, power: Array) -> Array:
        """(2,) of one sample of an RGB render, of hue and in all: the mean over pixels and illuminants."""
        seen = np.einsum("enj,msn->emsj", power, self.samples, optimize=True)
        return self._variance(seen, power)

    def variance(self, filters: Array, matrices: Array, power: Array, brightness: Array | None) -> Array:
        """The same with filters (n, 3 k) and matrices (e, 3, 3 k), for one sample in all passes together.

        brightness: (3 k,) how the channels of a pass sum to what is divided out; None where nothing is.
        """
        passes = filters.shape[1] // 3
        seen = [self.samples @ filters[:, 3 * k : 3 * k + 3] for k in range(passes)]
        parts = [matrices[..., 3 * k : 3 * k + 3] for k in range(passes)]
        means = [np.einsum("s,msj->mj", self.weights, each) for each in seen]
        whole = sum(np.einsum("eij,mj->emi", part, mean) for part, mean in zip(parts, means, strict=True))
        found = np.zeros(2)
        for k in range(passes):
            made = passes * seen[k]
            if brightness is not None:
                bright = seen[k] @ brightness[3 * k : 3 * k + 3]
                bright /= (bright @ self.weights)[:, None]
                made = made - passes * means[k][:, None] * bright[..., None]
            colour = np.einsum("eij,msj->emsi", parts[k], made, optimize=True)
            if brightness is not None:
                colour += whole[:, :, None] * bright[..., None]
            found += self._variance(colour, power) / passes
        return found

    def _variance(self, colours: Array, power: Array) -> Array:
        """(2,) of the XYZ (e, m, s, 3) of samples, each times a brightness of its own: of hue, and in all."""
        found = []
        for metric in reversed(self.metric(power)):
            seen = np.einsum("emij,emsj->emsi", metric, colours, optimize=True)
            mean = np.einsum("emsi,s->emi", seen, self.weights)
            square = (1 + SPREAD) * np.einsum("emsi,s->em", seen**2, self.weights) - np.square(mean).sum(axis=-1)
            found.append(square.mean())
        return np.array(found)


@dataclass(frozen=True, eq=False)
class Shared:
    """Filters that share a weighting, from unknowns: the logarithm of the weighting (n,), of the shares (n, k, 3)."""

    weighting: Array
    shares: Array

    @classmethod
    def of(cls, unknowns: Array) -> "Shared":
        parts = unknowns.reshape(WAVELENGTHS.size, -1)
        weighting = np.exp(parts[:, 0] - parts[:, 0].max())
        logarithms = parts[:, 1:].reshape(WAVELENGTHS.size, -1, 3)
        shares = np.exp(logarithms - logarithms.max(axis=2, keepdims=True))
        return cls(weighting / weighting.sum(), shares / shares.sum(axis=2, keepdims=True))

    @property
    def unscaled(self) -> Array:
        return (self.weighting[:, None, None] * self.shares).reshape(WAVELENGTHS.size, -1)

    @property
    def brightness(self) -> Array:
        """(3 k,) of each channel in its pass: its share of the weighting."""
        return self.unscaled.sum(axis=0)

    @property
    def filters(self) -> Array:
        return self.unscaled / self.brightness

    def back(self, by_filters: Array, by_weighting: Array) -> Array:
        """A gradient by the unknowns."""
        by_unscaled = (by_filters - (by_filters * self.filters).sum(axis=0)) / self.brightness
        by_unscaled = by_unscaled.reshape(self.shares.shape)
        by_weighting = by_weighting + (by_unscaled * self.shares).sum(axis=(1, 2))
        by_weighting = self.weighting * (by_weighting - by_weighting @ self.weighting)
        by_shares = by_unscaled * self.weighting[:, None, None]
        by_shares = self.shares * (by_shares - (by_shares * self.shares).sum(axis=2, keepdims=True))
        return np.concatenate([by_weighting[:, None], by_shares.reshape(len(by_weighting), -1)], axis=1).ravel()


class Aim:
    """Accuracy of products, and noise of hue, weighed against each other: what filters and matrices are fitted to."""

    def __init__(self, power: Array, noise: float, passes: int = PASSES, seed: int = 1):
        spectra = training.reflectances()
        self.spectra, self.drawn = spectra, training.products(spectra, optimise.BOUNCES, most=200)
        self.pixels, self.white = Pixels.drawn(spectra, seed), power.sum(axis=1)
        truth, metric, _ = relight.targets(self.drawn, power)
        self.passes, count = passes, SURFACES * (1 + SECONDS)
        _, across = self.pixels.metric(power)
        across = np.einsum("emai,emaj->emij", across, across)
        entries = np.stack([across[..., a, b] for a, b in relight.PAIRS], axis=1)  # (e, 6, m)
        weights = noise * passes * (1 + SPREAD) / self.pixels.rgb_variance(power)[0] / SURFACES * self.pixels.weights
        entries = (entries[..., None] * weights).reshape(len(power), 6, count)
        self.truth = np.concatenate([truth, np.zeros((len(power), 3, passes * count))], axis=2)
        self.metric = np.concatenate([metric, *[entries] * passes], axis=2) / len(power)

    def coefficients(self, filters: Array, brightness: Array) -> Array:
        """(N, 3 k): those of the products, and what is left of each pixel's samples in each pass."""
        rows = [self.drawn.coefficients(self.spectra @ filters)]
        for k in range(self.passes):
            own = slice(3 * k, 3 * k + 3)
            each = self.pixels.samples @ filters[:, own]
            bright = each @ brightness[own]
            mean = np.einsum("s,msj->mj", self.pixels.weights, each)
            left = each - mean[:, None] * (bright / (bright @ self.pixels.weights)[:, None])[..., None]
            padded = np.zeros((left.shape[0] * left.shape[1], filters.shape[1]))
            padded[:, own] = left.reshape(-1, 3)
            rows.append(padded)
        return np.concatenate(rows)

    def matrices(self, filters: Array, brightness: Array) -> Array:
        return relight.fitted_matrices(self.coefficients(filters, brightness), self.truth, self.metric, self.white)

    def __call__(self, unknowns: Array) -> tuple[float, Array]:
        """Error, by the best matrices, and its gradient."""
        shared = Shared.of(unknowns)
        filters = shared.filters
        coefficients = self.coefficients(filters, shared.brightness)
        matrices = relight.fitted_matrices(coefficients, self.truth, self.metric, self.white)
        residual = matrices @ coefficients.T - self.truth
        pull = relight.weighted(self.metric, residual)
        by_row = 2 * np.einsum("exN,exp->Np", pull, matrices, optimize=True)
        by_filters, by_weighting = self._back(shared, filters, by_row)
        return float((pull * residual).sum()), shared.back(by_filters, by_weighting)

    def _back(self, shared: Shared, filters: Array, by_row: Array) -> tuple[Array, Array]:
        """The gradients by filters (n, 3 k) and by the weighting (n,) of one by the rows of `coefficients`."""
        factors, done = self.spectra @ filters, 0
        by_factor = np.zeros_like(factors)
        for chosen in self.drawn.factors:
            part = by_row[done : done + len(chosen)]
            done += len(chosen)
            for place in range(chosen.shape[1]):
                others = np.delete(chosen, place, axis=1)
                np.add.at(by_factor, chosen[:, place], part * factors[others].prod(axis=1))
        by_filters, by_weighting = self.spectra.T @ by_factor, np.zeros(len(filters))
        samples, mean = self.pixels.samples, self.pixels.mean
        bright = samples @ shared.weighting
        ratio = bright / (mean @ shared.weighting)[:, None]
        for k, part in enumerate(np.split(by_row[done:], self.passes)):
            own = slice(3 * k, 3 * k + 3)
            pull = part[:, own].reshape(*samples.shape[:2], 3)
            pulled = np.einsum("ms,msj->mj", ratio, pull)
            by_filters[:, own] += np.einsum("msn,msj->nj", samples, pull, optimize=True) - mean.T @ pulled
            by_ratio = -np.einsum("msj,mj->ms", pull, mean @ filters[:, own])
            inverse = 1 / (mean @ shared.weighting)
            by_weighting += np.einsum("ms,m,msn->n", by_ratio, inverse, samples, optimize=True)
            by_weighting -= (by_ratio * ratio).sum(axis=1) * inverse @ mean
        return by_filters, by_weighting


def interleaved(passes: int = PASSES) -> Array:
    """Unknowns of a start: two edges in every pass, interleaved, at equal parts of the observer's weight."""
    weighting = library.observer().sum(axis=1)
    weighting = weighting / weighting.sum() + 1e-3 / WAVELENGTHS.size
    place = np.cumsum(weighting) / weighting.sum()
    edges = (np.arange(2 * passes) + 1) / (2 * passes + 1)
    columns = [np.log(weighting)]
    for k in range(passes):
        low, high = edges[k], edges[k + passes]
        middles = np.array([low / 2, (low + high) / 2, (1 + high) / 2])
        reach = np.array([low / 2, (high - low) / 2, (1 - high) / 2])
        columns += list((-(((place[:, None] - middles) / reach) ** 2)).T * 4)
    return np.stack(columns, axis=1).ravel()


def optimised(start: Array, aim: Aim, iterations: int) -> Array:
    from scipy.optimize import minimize

    found = minimize(aim, start, jac=True, method="L-BFGS-B", options={"maxiter": iterations, "maxcor": 30})
    return np.asarray(found.x)


def _judged(filters: Array, matrices: Array, spectra: Array, power: Array, count: int) -> str:
    """CIEDE2000 of products of `count` of the spectra: median / 90th / 99th percentile."""
    chosen = np.arange(len(spectra))[:, None]
    if count > 1:
        chosen = np.random.default_rng(7).integers(len(spectra), size=(400, count))
    products, coefficients = spectra[chosen].prod(axis=1), (spectra @ filters)[chosen].prod(axis=1)
    pairs = zip(power, matrices, strict=True)
    found = [differences.delta_E_2000(products @ w, coefficients @ m.T, w.sum(axis=0)) for w, m in pairs]
    return " / ".join(f"{value:.2f}" for value in np.percentile(found, (50, 90, 99)))


def section(spectra: Array, iterations: int, noises: Sequence[float], passes: int = PASSES) -> Section:
    """Accuracy and noise of today's filters, and of those that share a weighting."""
    power = np.stack([relight.power_weights(light.sampled(), library.observer()) for light in cie_lights()])
    pixels, rows = Pixels.drawn(spectra, seed=5), []
    plain = pixels.rgb_variance(power)

    def judge(name: str, filters: Array, brightness: Array, known: float, divided: bool) -> None:
        matrices = Aim(power, known, passes).matrices(filters, brightness)
        hue, whole = pixels.variance(filters, matrices, power, brightness if divided else None) / plain
        errors = [_judged(filters, matrices, spectra, power, count) for count in (1, 2)]
        rows.append([name, known or "–", *errors, f"{hue:.2f}", f"{whole:.2f}"])

    model = channel_order.balanced(bases.fitted(3 * passes))
    bright = model.relight(library.illuminant("D65"))[1]
    judge("today's", model.filters, bright, 0.0, False)
    judge("today's, divided", model.filters, bright, 0.0, True)
    for known in noises:
        judge("today's, divided", model.filters, bright, known, True)
    start = interleaved(passes)
    shared = Shared.of(start)
    for known in (0.0, *noises):
        judge("shared, bands interleaved", shared.filters, shared.brightness, known, True)
    for known in (0.0, *noises):
        start = optimised(start, Aim(power[::EVERY], known, passes), iterations)
        shared = Shared.of(start)
        judge("shared, optimised", shared.filters, shared.brightness, known, True)
    words = (
        f"{passes} passes of three channels. CIEDE2000 of {len(spectra)} reflectances and of products of two under "
        f"{len(power)} CIE illuminants, median / 90th / 99th percentile; variance of hue, and of hue and brightness, "
        "over an RGB render's. The weight says how much that of hue counted beside the squared errors when the "
        "matrices, and filters that were optimised, were made."
    )
    return Section("Filters that share a weighting", words, ("filters", "weight", "ΔE", "of two", "hue", "all"), rows)


def main(argv: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m relume.studies.partition", description=__doc__)
    parser.add_argument("--reflectances", type=Path, metavar="FILE", help="to judge by (the CES of colour-science)")
    parser.add_argument("--iterations", type=int, default=300, metavar="N", help="for each weight (300)")
    parser.add_argument("--noise", type=float, nargs="+", default=[0.01, 0.03, 0.1], metavar="WEIGHT")
    parser.add_argument("--passes", type=int, default=PASSES, metavar="N", help="of three channels each (3)")
    options = parser.parse_args(argv)
    judges = files.read(options.reflectances, "reflectance") if options.reflectances else library.reflectances("ces")
    with optimise.one_thread():
        values = np.stack([spectrum.sampled() for spectrum in judges])
        publish("partition", [section(values, options.iterations, options.noise, options.passes)])
    return 0


if __name__ == "__main__":
    sys.exit(main())
