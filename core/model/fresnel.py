"""Conductors: the n and k of each channel, from the complex index over wavelength."""

import numpy as np

from ..spectra.arrays import Array, ArrayLike
from ..spectra.spectrum import WAVELENGTHS, Spectrum
from .factor_model import FactorModel

__all__ = ["conductor_channels", "filtered_conductor", "normal_reflectance", "reflectance"]

# Cosines of the angles that the fit looks at: light that arrives from everywhere comes with equal weight per cosine.
COSINES = (np.arange(24) + 0.5) / 24


def reflectance(n: ArrayLike, k: ArrayLike, cosine: ArrayLike) -> Array:
    """Unpolarised Fresnel reflectance of a conductor in air; arrays broadcast, cosine in 0..1 -> 0..1.

    >>> round(float(reflectance(0.27, 2.95, 1.0)), 2)  # gold in red light, head on
    0.9
    """
    n, k, cosine = np.broadcast_arrays(*(np.asarray(x, dtype=np.float64) for x in (n, k, cosine)))
    squared = cosine**2
    sine = 1 - squared
    difference = n**2 - k**2 - sine
    root = np.sqrt(difference**2 + 4 * n**2 * k**2)
    a = np.sqrt(np.maximum((root + difference) / 2, 0))
    s = (root + squared - 2 * a * cosine) / (root + squared + 2 * a * cosine + 1e-300)
    p = (
        s
        * (squared * root + sine**2 - 2 * a * cosine * sine)
        / (squared * root + sine**2 + 2 * a * cosine * sine + 1e-300)
    )
    return (s + p) / 2


def normal_reflectance(n: Spectrum, k: Spectrum) -> Spectrum:
    """Reflectance at normal incidence of a metal of index `n` and extinction `k` (Spectrum) -> Spectrum."""
    return Spectrum(WAVELENGTHS, reflectance(n.sampled(), k.sampled(), 1.0), n.name)


def conductor_channels(model: FactorModel, n: Spectrum, k: Spectrum) -> tuple[Array, Array]:
    """n (p,) and k (p,) per channel of `model` for a metal's index `n` and extinction `k` (Spectrum)."""
    return filtered_conductor(model.filters, n.sampled(model.wavelengths), k.sampled(model.wavelengths))


def filtered_conductor(filters: Array, n: Array, k: Array) -> tuple[Array, Array]:
    """n (q,), k (q,), both positive, whose reflectance over angle best matches that seen through `filters` (m, q).

    n, k: (m,) over wavelength. The filters may be signed, as those of a preview; reflectances outside 0..1 are then met
    as nearly as a conductor can. Gauss-Newton on log n and log k, damped, from several starting points.
    """
    target = reflectance(n[:, None], k[:, None], COSINES).T @ filters  # (angles, q)
    target = np.clip(target, 1e-3, 1.0)
    weights = np.abs(filters) / np.abs(filters).sum(axis=0)
    start_n, start_k = n @ weights, k @ weights
    starts = [(start_n, start_k), (np.maximum(start_n, 1), start_k), (0.2 * start_n, 1.5 * start_k + 0.5)]
    best, best_error = _descend(np.log(np.maximum(starts[0], 1e-3)), target)
    for guess in starts[1:]:
        log_index, error = _descend(np.log(np.maximum(guess, 1e-3)), target)
        better = error < best_error * (1 - 1e-6)
        best, best_error = np.where(better, log_index, best), np.where(better, error, best_error)
    n, k = np.exp(best)
    return n, k


def _descend(log_index: Array, target: Array, steps: int = 60) -> tuple[Array, Array]:
    """Levenberg-Marquardt for every channel at once: log (n, k) (2, q) -> (2, q), squared error (q,)."""

    def reflected(values: Array) -> Array:
        return reflectance(np.exp(values[0]), np.exp(values[1]), COSINES[:, None])

    damping = np.full(target.shape[1], 1e-2)
    current = reflected(log_index)
    error = ((current - target) ** 2).sum(axis=0)
    for _ in range(steps):
        step = 1e-5
        slopes = np.stack(
            [(reflected(log_index + step * unit[:, None]) - current) / step for unit in np.eye(2)]
        )  # (2, angles, q)
        normal = np.einsum("iaq,jaq->qij", slopes, slopes)
        gradient = np.einsum("iaq,aq->qi", slopes, target - current)
        ridge = damping * np.trace(normal, axis1=1, axis2=2) + 1e-15
        damped = normal + ridge[:, None, None] * np.eye(2)
        move = np.clip(np.linalg.solve(damped, gradient[:, :, None])[:, :, 0].T, -1, 1)
        trial = np.clip(log_index + move, np.log(1e-3), np.log(50))
        reflected_trial = reflected(trial)
        trial_error = ((reflected_trial - target) ** 2).sum(axis=0)
        accept = trial_error < error
        log_index = np.where(accept, trial, log_index)
        current = np.where(accept, reflected_trial, current)
        error = np.where(accept, trial_error, error)
        damping = np.clip(np.where(accept, damping / 5, damping * 5), 1e-9, 1e6)
    return log_index, error
