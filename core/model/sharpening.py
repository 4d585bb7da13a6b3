"""Sharpening a basis: the combinations of its vectors that lie the most within one interval of wavelengths.

[DF] M. S. Drew, G. D. Finlayson, "Multispectral processing without spectra", JOSA A 20 (2003), eqs. 11 and 12.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..spectra.arrays import Array

__all__ = ["METHODS", "least_energy", "nonnegative", "principal_components", "sharpened"]

STEPS = 1000  # most of them, from each start
SETTLED = 1e-13  # gain of energy inside, of a total of 1, below which a start has converged

Inside = NDArray[np.bool_]  # (n,) which wavelengths the interval holds


def principal_components(signals: Array, count: int) -> Array:
    """The first `count` left singular vectors of signals (m, n), not centred -> (n, count). Raises ModelError."""
    components, strengths, _ = np.linalg.svd(signals.T, full_matrices=False)
    rank = int((strengths > 1e-3 * strengths[0]).sum())
    if count > rank:
        raise ModelError(f"these colour signals have {rank} independent components above 0.1 %, not {count}")
    return components[:, :count]


def least_energy(basis: Array, inside: Inside) -> Array:
    """Combination of an orthonormal basis (n, p) with least energy outside for unit L2 norm -> (n,) ([DF] eq. 11)."""
    outside = basis[~inside]
    return basis @ np.linalg.eigh(outside.T @ outside)[1][:, 0]


def nonnegative(basis: Array, inside: Inside) -> Array:
    """The same, nowhere negative -> (n,) of unit L2 norm over all wavelengths ([DF] eq. 12). Raises ModelError.

    The norm is an equality, so the problem is not convex: energy inside, as large as can be, is a convex function on
    the cone of non-negative combinations. Each step takes its gradient and goes to the nearest direction of the cone,
    which never makes it smaller; it starts from each wavelength of the interval, and the best end is taken.
    """
    within = basis[inside]
    best, most = None, -1.0
    for start in within:
        direction, energy = _nearest(basis, start), 0.0
        for _ in range(STEPS):
            length = np.linalg.norm(direction)
            if length < 1e-9:
                break
            direction = direction / length
            former, energy = energy, float(((within @ direction) ** 2).sum())
            if energy - former < SETTLED:
                break
            direction = _nearest(basis, within.T @ (within @ direction))
        if energy > most:
            best, most = direction, energy
    if best is None or most <= 0:
        raise ModelError("no non-negative filter in the span of these colour signals has any part in an interval")
    # Projections keep their constraints to some 1e-12 only.
    column = np.maximum(basis @ best, 0)
    return column / np.linalg.norm(column)


def _nearest(basis: Array, direction: Array) -> Array:
    """The t (p,) nearest to `direction` (p,) with basis t >= 0: what of it does not point out of the cone."""
    from scipy.optimize import nnls

    used = basis[basis.any(axis=1)]
    return direction + used.T @ nnls(used.T, -direction, maxiter=100 * len(used))[0]


METHODS: dict[str, Callable[[Array, Inside], Array]] = {"lagrange": least_energy, "nonnegative": nonnegative}


def sharpened(basis: Array, wavelengths: Array, intervals: list[tuple[float, float]], method: str) -> Array:
    """Filters (n, p) from an orthonormal basis (n, p), one for each (low, high) in nm; columns sum to 1 ([DF] 3.A).

    method: one of METHODS. Raises ModelError.
    """
    if method not in METHODS:
        raise ModelError(f"no sharpening method {method!r}: choose {' or '.join(METHODS)}")
    if len(intervals) != basis.shape[1]:
        raise ModelError(f"{basis.shape[1]} channels need {basis.shape[1]} intervals, not {len(intervals)}")
    columns = []
    for low, high in intervals:
        inside = (low <= wavelengths) & (high >= wavelengths)
        if not inside.any():
            step = wavelengths[1] - wavelengths[0]
            raise ModelError(f"the interval {low:g} to {high:g} nm holds none of the wavelengths, {step:g} nm apart")
        columns.append(METHODS[method](basis, inside))
    filters = np.stack(columns, axis=1)
    return filters / filters.sum(axis=0)
