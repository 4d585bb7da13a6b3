"""Making the filters: non-negative, and as right as p channels can be for products of one to three reflectances.

`python -m relume.core.model.optimise [--channels P ...] [--out FILE]` writes the filters that ship, the same bits each
time on the same machine and libraries, on any number of cores. The error that is minimised is that of the best relight
matrices for the filters (variable projection): at those matrices its derivative with respect to them is zero, so the
gradient needs the filters' part only.
"""

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from ..spectra import library
from ..spectra.arrays import Array
from ..spectra.spectrum import WAVELENGTHS
from . import extremes, relight, training
from . import filters as filter_files
from .training import Training

__all__ = ["Task", "exact_filters", "main", "one_thread", "optimised", "scene_filters"]

CHANNELS = (3, 5, 6, 7, 9, 12, 15, 18, 21, 24)
BOUNCES = (1.0, 0.2, 0.15)  # how much products of 1, 2 and 3 reflectances count
BOUNCES_OF_FEW = (1.0, 0.4, 0.4)  # the same for up to 6 channels, whose products stray more
# From 18 channels on ordinary surfaces and lights leave nothing to gain: gels, saturated paints and LEDs count as well
FOR_EXTREMES = 18
EXTREMES = 0.3
# Starts, how many of them are finished, iterations of each and of a finish; the more channels, the less they differ
EFFORT = (24, 5, 250, 2500)
EFFORTS = {18: (8, 2, 250, 2500), 21: (8, 2, 83, 833), 24: (8, 2, 83, 833)}
SCENE_WORK = 40_000_000  # iterations times products times lights times channels: one to two seconds
SCENE_ITERATIONS = 4000
EXACT_ITERATIONS = 2000
PENALTIES = (1e1, 1e4, 1e8)
WIDENINGS = (0, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 1)


@dataclass(frozen=True, eq=False)
class Task:
    """Reflectances (m, n), their products, and what the products look like under e illuminants."""

    reflectances: Array
    training: Training
    truth: Array
    metric: Array
    white: Array

    @classmethod
    def of(cls, reflectances: Array, drawn: Training, illuminants: Array, shares: Array | None = None) -> "Task":
        """Products `drawn` (Training) from reflectances (m, n), under illuminants (e, n).

        shares: (e,) how much each illuminant counts, of sum 1; by default all the same.
        """
        cmfs = library.observer()
        weights = np.stack([relight.power_weights(illuminant, cmfs) for illuminant in illuminants])
        truth, metric, white = relight.targets(drawn, weights)
        shares = np.full(len(illuminants), 1 / len(illuminants)) if shares is None else shares
        return cls(reflectances, drawn, truth, metric * shares[:, None, None], white)

    def error(self, filters: Array, matrices: Array | None = None) -> tuple[float, Array, Array]:
        """Mean squared difference of the products in units of CIEDE2000, by the best matrices or those given (e, 3, p).

        -> error, its gradient by the filters (n, p), and by the matrices (e, 3, p), which vanishes at the best.
        """
        factors = self.reflectances @ filters
        coefficients = self.training.coefficients(factors)
        if matrices is None:
            matrices = relight.fitted_matrices(coefficients, self.truth, self.metric, self.white)
        residual = matrices @ coefficients.T - self.truth
        pull = relight.weighted(self.metric, residual)
        by_coefficient = 2 * np.einsum("exN,exp->Np", pull, matrices, optimize=True)
        by_factor = np.zeros_like(factors)
        done = 0
        for chosen in self.training.factors:
            part = by_coefficient[done : done + len(chosen)]
            done += len(chosen)
            for own in range(chosen.shape[1]):
                others = np.delete(chosen, own, axis=1)
                np.add.at(by_factor, chosen[:, own], part * factors[others].prod(axis=1))
        return float((pull * residual).sum()), self.reflectances.T @ by_factor, 2 * (pull @ coefficients)


def one_thread() -> AbstractContextManager:
    """Context in which matrix products use one thread: on these small ones more are slower, and change the last bits.

    An optimum far along depends on those bits.
    """
    import scipy.optimize  # noqa: F401  (only loaded libraries can be limited)
    from threadpoolctl import threadpool_limits

    return threadpool_limits(1, "blas")


def optimised(filters: Array, task: Task, iterations: int) -> tuple[Array, float]:
    """Better filters (n, p) for `task`, from `filters`: non-negative, columns sum to 1 -> filters, error."""

    def error(scaled: Array) -> tuple[float, Array]:
        filters, back = _normalised(scaled)
        value, gradient, _ = task.error(filters)
        return value, back(gradient)

    (best,), value = _minimised(error, [filters], iterations)
    return _normalised(best)[0], value


def exact_filters(filters: Array, task: Task, weights: Array) -> Array | None:
    """Non-negative filters (n, p) of which the power weights (n, 3 e) are combinations, or None where none are found.

    They start from `filters` and do what they can for `task`, whose lights are those of the weights. Filters and
    relight matrices are optimised together under a rising penalty; then every row of the filters is the non-negative
    one nearest to it that is exact, for matrices widened by as little as makes that possible.
    """
    from scipy.optimize import nnls

    largest, white = np.abs(weights).max(axis=0), weights.sum(axis=0)
    matrices = np.linalg.lstsq(filters, weights, rcond=1e-12)[0].T
    iterations = _affordable(task, filters, EXACT_ITERATIONS)

    def error(penalty: float, scaled: Array, matrices: Array) -> tuple[float, Array, Array]:
        filters, back = _normalised(scaled)
        value, gradient, by_matrix = task.error(filters, matrices.reshape(-1, 3, filters.shape[1]))
        residual = (filters @ matrices.T - weights) / largest
        pull = 2 * penalty * residual / largest
        gradients = back(gradient + pull @ matrices), by_matrix.reshape(matrices.shape) + pull.T @ filters
        return value + penalty * (residual**2).sum(), *gradients

    for penalty in PENALTIES:
        (filters, matrices), _ = _minimised(partial(error, penalty), [np.maximum(filters, 1e-7), matrices], iterations)
        filters, _ = _normalised(filters)
    for wider in WIDENINGS:
        tried = matrices + wider * (matrices - white[:, None] / len(matrices[0]))
        system = np.concatenate([1e5 * tried / largest[:, None], np.eye(len(tried[0]))])
        peak = filters.max()
        right = np.concatenate([1e5 * weights / largest / peak, filters / peak], axis=1)
        rows = peak * np.stack([nnls(system, row)[0] for row in right])
        found = rows / rows.sum(axis=0)
        if relight.exact_matrix(found, weights) is not None:
            return found
    return None


def _affordable(task: Task, filters: Array, most: int) -> int:
    """How many iterations SCENE_WORK pays for, `most` at most."""
    return min(SCENE_WORK // (task.truth[:, 0].size * filters.shape[1]), most)


def _normalised(scaled: Array) -> tuple[Array, Callable[[Array], Array]]:
    """Filters (n, p) whose columns sum to 1, and the function that takes a gradient by them back to `scaled`."""
    sums = np.maximum(scaled.sum(axis=0), 1e-6)  # a line search may come by a filter of zero
    return scaled / sums, lambda gradient: (gradient - (gradient * scaled / sums).sum(axis=0)) / sums


def _minimised(error: Callable[..., tuple], start: list[Array], iterations: int) -> tuple[list[Array], float]:
    """Arrays that minimise error(*arrays) -> value, *gradients; the first of them, filters, stays non-negative."""
    from scipy.optimize import minimize

    # A scale that makes the unknowns of order one.
    start = [start[0] * (start[0].shape[0] / start[0].shape[1]), *start[1:]]
    ends = np.cumsum([array.size for array in start])[:-1]

    def split(unknowns: Array) -> list[Array]:
        return [part.reshape(array.shape) for part, array in zip(np.split(unknowns, ends), start, strict=True)]

    def flat(unknowns: Array) -> tuple[float, Array]:
        value, *gradients = error(*split(unknowns))
        return value, np.concatenate([gradient.ravel() for gradient in gradients])

    result = minimize(
        flat,
        np.concatenate([array.ravel() for array in start]),
        jac=True,
        method="L-BFGS-B",
        bounds=[(0, None)] * start[0].size + [(None, None)] * sum(array.size for array in start[1:]),
        options={"maxiter": iterations, "maxfun": 2 * iterations, "maxcor": 30, "ftol": 1e-10, "gtol": 1e-12},
    )
    return split(result.x), float(result.fun)


def general_task(channels: int, weight: float | None = None) -> Task:
    """What the shipped filters are made for: the general training set under the CIE illuminants, and where there are
    channels enough gels, saturated paints and LEDs.

    weight: how much these count, of surfaces and of lights, where all others count 1.
    """
    weight = (EXTREMES if channels >= FOR_EXTREMES else 0.0) if weight is None else weight
    bounces = BOUNCES if channels > 6 else BOUNCES_OF_FEW
    names = [name for family in library.cie_illuminants().values() for name in family]
    spectra = training.reflectances()
    illuminants = np.stack([library.illuminant(name).sampled() for name in names])
    if weight == 0.0:
        return Task.of(spectra, training.products(spectra, bounces, most=500), illuminants)
    kinds = extremes.lights()
    shares = [np.full(len(illuminants), 1 / len(illuminants))]
    shares += [np.full(len(kind), weight / len(kinds) / len(kind)) for kind in kinds]
    counted = np.concatenate(shares) / (1 + weight)
    return Task.of(*training.with_extremes(bounces, weight), np.concatenate([illuminants, *kinds]), counted)


def make_filters(channels: int, task: Task) -> tuple[Array, float]:
    """The best filters (81, p) found for `task` from several starts, by their mean wavelength, and their error."""
    starts, kept, first, last = EFFORTS.get(channels, EFFORT)
    random = np.random.default_rng(channels)
    tries = []
    for number in range(starts):
        start = filter_files.start_filters(channels, random if number else None)
        tries.append(optimised(start, task, first))
    tries.sort(key=lambda attempt: attempt[1])
    finished = [optimised(filters, task, last) for filters, _ in tries[:kept]]
    filters, error = min(finished, key=lambda attempt: attempt[1])
    return filters[:, np.argsort(WAVELENGTHS @ filters)], error


def scene_filters(start: Array, task: Task, weights: Array) -> Array:
    """Filters (81, p) for the `task` of a scene lit by power weights (81, 3 e).

    `start`, filters for the general case, competes with bands that share out the power of the scene's own lights: where
    those have lines, the best filters are far from any general ones.
    """
    channels, power = start.shape[1], np.abs(weights).sum(axis=1)
    random = np.random.default_rng(len(task.reflectances))
    iterations = _affordable(task, start, SCENE_ITERATIONS)
    tries = [np.maximum(start, 1e-7), *(filter_files.start_filters(channels, random, power) for _ in range(8))]
    # Half of the starts may lead nowhere; a sixteenth of the iterations shows which.
    for kept, share in ((9, 16), (3, 16), (1, 4)):
        done = [optimised(filters, task, iterations // share) for filters in tries[:kept]]
        tries = [filters for filters, _ in sorted(done, key=lambda one: one[1])]
    return tries[0][:, np.argsort(WAVELENGTHS @ tries[0])]


def main(argv: Sequence[str] | None = None) -> int:
    """The command: make the shipped filters again."""
    parser = argparse.ArgumentParser(
        prog="python -m relume.core.model.optimise", description="Make the filters that ship."
    )
    parser.add_argument("--channels", type=int, nargs="+", default=CHANNELS, metavar="P")
    parser.add_argument("--out", type=Path, default=filter_files.SHIPPED)
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), metavar="N", help="processes at a time")
    words = "how much gels, paints and LEDs count; default: 0, and 0.3 from 18 channels on"
    parser.add_argument("--extremes", type=float, metavar="WEIGHT", help=words)
    options = parser.parse_args(argv)
    filters = {}
    with ProcessPoolExecutor(options.jobs) as pool:
        made_one = partial(_made, weight=options.extremes)
        for channels, made in zip(options.channels, pool.map(made_one, options.channels), strict=True):
            filters[channels] = made
            filter_files.write_filters(options.out, dict(sorted(filters.items())))
    return 0


def _made(channels: int, weight: float | None = None) -> Array:
    with one_thread():
        filters, error = make_filters(channels, general_task(channels, weight))
    print(f"p = {channels}: mean squared error {error:.6f}", flush=True)
    return filters


if __name__ == "__main__":
    sys.exit(main())
