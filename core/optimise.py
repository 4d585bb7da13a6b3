"""Making the filters: non-negative, and as right as p channels can be for products of one to three reflectances.

    python -m relume.core.optimise [--channels P ...] [--out FILE]

writes the filters that ship, the same bits each time on the same machine and libraries, on any number of cores. The
error that is minimised is that of the best relight matrices for the filters (variable projection): at those matrices
its derivative with respect to them is zero, so the gradient needs the filters' part only.
"""

import argparse
import os
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from . import filters as filter_files
from . import library, relight, training
from .spectrum import WAVELENGTHS

__all__ = ["Task", "main", "optimised", "scene_filters"]

CHANNELS = (3, 5, 6, 7, 9, 12, 15, 18)
BOUNCES = (1.0, 0.2, 0.15)  # how much products of 1, 2 and 3 reflectances count
BOUNCES_OF_FEW = (1.0, 0.4, 0.4)  # the same for up to 6 channels, whose products stray more
STARTS = 24
THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


@dataclass(frozen=True, eq=False)
class Task:
    """Reflectances (m, n), their products, and what the products look like under e illuminants."""

    reflectances: np.ndarray
    training: training.Training
    truth: np.ndarray
    metric: np.ndarray
    white: np.ndarray

    @classmethod
    def of(cls, reflectances, drawn, illuminants):
        """Products `drawn` (Training) from reflectances (m, n), under illuminants (e, n) in equal shares."""
        cmfs = library.observer()
        weights = np.stack([relight.power_weights(illuminant, cmfs) for illuminant in illuminants])
        truth, metric, white = relight.targets(drawn, weights)
        return cls(reflectances, drawn, truth, metric / len(illuminants), white)

    def error(self, filters):
        """Mean squared difference of the products in units of CIEDE2000, and its gradient (n, p)."""
        factors = self.reflectances @ filters
        coefficients = self.training.coefficients(factors)
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
        return float((pull * residual).sum()), self.reflectances.T @ by_factor


def optimised(filters, task, iterations):
    """Better filters (n, p) for `task`, from `filters`: non-negative, columns sum to 1 -> filters, error."""
    from scipy.optimize import minimize

    shape = filters.shape
    scale = shape[0] / shape[1]  # makes the unknowns of order one

    def error(unscaled):
        unscaled = unscaled.reshape(shape)
        sums = unscaled.sum(axis=0)
        value, gradient = task.error(unscaled / sums)
        gradient = (gradient - (gradient * unscaled / sums).sum(axis=0)) / sums
        return value, gradient.ravel()

    result = minimize(
        error,
        (filters * scale).ravel(),
        jac=True,
        method="L-BFGS-B",
        bounds=[(0, None)] * filters.size,
        options={"maxiter": iterations, "maxfun": 2 * iterations, "maxcor": 30, "ftol": 1e-10, "gtol": 1e-12},
    )
    best = result.x.reshape(shape)
    return best / best.sum(axis=0), float(result.fun)


def general_task(channels):
    """What the shipped filters are made for: the general training set under the CIE illuminants."""
    bounces = BOUNCES if channels > 6 else BOUNCES_OF_FEW
    names = [name for family in library.cie_illuminants().values() for name in family]
    spectra = training.reflectances()
    illuminants = np.stack([library.illuminant(name).sampled() for name in names])
    return Task.of(spectra, training.products(spectra, bounces, most=500), illuminants)


def make_filters(channels, task, starts=STARTS, tell=lambda line: None):
    """The best filters (81, p) found for `task` from several starts, in the order of their mean wavelength."""
    random = np.random.default_rng(channels)
    tries = []
    for number in range(starts):
        start = filter_files.start_filters(channels, random if number else None)
        tries.append(optimised(start, task, 250))
    tries.sort(key=lambda attempt: attempt[1])
    finished = [optimised(filters, task, 2500) for filters, _ in tries[:5]]
    filters, error = min(finished, key=lambda attempt: attempt[1])
    tell(f"p = {channels}: mean squared error {error:.6f}, from {starts} starts")
    return filters[:, np.argsort(WAVELENGTHS @ filters)]


def scene_filters(start, own, illuminants):
    """Filters (81, p) for products of a scene's own reflectances (m, 81) under its illuminants (e, 81).

    start: filters (81, p) for the general case; two rougher starts compete with them.
    """
    task = Task.of(*training.with_general(own), illuminants)
    random = np.random.default_rng(len(own))
    starts = [np.maximum(start, 1e-7), *(filter_files.start_filters(start.shape[1], random) for _ in range(2))]
    tries = [optimised(filters, task, 80) for filters in starts]
    filters, _ = optimised(min(tries, key=lambda attempt: attempt[1])[0], task, 500)
    return filters[:, np.argsort(WAVELENGTHS @ filters)]


def main(argv=None):
    """The command: make the shipped filters again."""
    if any(os.environ.get(name) != "1" for name in THREADS):
        # The last bits of a matrix product depend on the number of threads, which is fixed once numpy is loaded.
        command = [sys.executable, "-m", "relume.core.optimise", *(sys.argv[1:] if argv is None else argv)]
        return subprocess.run(command, env=os.environ | dict.fromkeys(THREADS, "1")).returncode
    parser = argparse.ArgumentParser(prog="python -m relume.core.optimise", description="Make the filters that ship.")
    parser.add_argument("--channels", type=int, nargs="+", default=CHANNELS, metavar="P")
    parser.add_argument("--out", type=Path, default=filter_files.SHIPPED)
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), metavar="N", help="processes at a time")
    options = parser.parse_args(argv)
    with ProcessPoolExecutor(options.jobs) as pool:
        filters = dict(zip(options.channels, pool.map(_made, options.channels), strict=True))
    filter_files.write_filters(options.out, filters)
    return 0


def _made(channels):
    return make_filters(channels, general_task(channels), tell=lambda line: print(line, flush=True))


if __name__ == "__main__":
    sys.exit(main())
