"""Relight matrices: from the coefficients of a product of spectra to its XYZ under an illuminant.

A relight matrix R is (3, p). It may be any matrix, so the best one is fitted for each illuminant, on products of
reflectances, in the metric of CIEDE2000 at each true colour. It is exact for white by constraint: R @ 1 is the XYZ of
the illuminant, so a light seen directly keeps its colour.

Arrays that hold one symmetric 3 x 3 matrix per product keep its six entries in the order of PAIRS.
"""

from functools import lru_cache

import numpy as np

from ..colour.differences import hue_weight, lab, rotation
from ..spectra.arrays import Array, ArrayLike
from ..spectra.spectrum import SpectrumError
from .training import Training

__all__ = [
    "emitter",
    "exact_matrix",
    "fitted_matrices",
    "power_weights",
    "reconstructed_matrix",
    "scaled",
    "targets",
    "with_exact_lights",
]

RIDGE = 1e-8  # relative to each unknown's own scale; 1e-3 already raises the error two- to fivefold
PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
SYMMETRIC = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])  # the place of entry (a, b) in PAIRS


def power_weights(illuminant: ArrayLike, cmfs: Array) -> Array:
    """Illuminant (n,) times matching functions (n, 3), scaled so that a perfect white has Y = 1 -> (n, 3).

    Raises SpectrumError for an illuminant with no visible power.

    >>> power_weights(np.ones(3), np.eye(3)).sum(axis=0)
    array([1., 1., 1.])
    """
    illuminant = np.asarray(illuminant, dtype=np.float64)
    peak = np.abs(illuminant).max(initial=0)
    if not peak > 0:
        raise SpectrumError("the illuminant has no power between 380 and 780 nm")
    return scaled((illuminant / peak)[:, None] * cmfs)


def scaled(weights: Array) -> Array:
    """Weights (n, 3), a light times matching functions, scaled so that a perfect white has Y = 1 -> (n, 3).

    Raises SpectrumError for a light that cannot be seen.
    """
    luminance = weights[:, 1].sum()
    # Light that is negative in parts may be invisible but for rounding, as a metameric black is.
    if not luminance > 1e-9 * np.abs(weights).sum():
        raise SpectrumError("the illuminant has no visible power between 380 and 780 nm")
    return weights / luminance


def targets(training: Training, weights: Array) -> tuple[Array, Array, Array]:
    """What matrices are fitted to, for power weights (e, n, 3) -> truth (e, 3, N), metric (e, 6, N), white (e, 3).

    metric: `JᵀJ` times the importance of each product, where `|J dXYZ|` is a small difference in CIEDE2000.
    """
    lights, count = len(weights), weights.shape[1]
    truth = _product(weights.transpose(0, 2, 1).reshape(3 * lights, count), training.products.T)
    truth = truth.reshape(lights, 3, len(training.products))
    white = weights.sum(axis=1)
    metric = np.empty((len(weights), 6, len(training.products)))
    for one in range(len(weights)):
        jacobian = local_metric(truth[one].T, white[one])
        for entry, (a, b) in enumerate(PAIRS):
            metric[one, entry] = training.weights * (jacobian[:, :, a] * jacobian[:, :, b]).sum(axis=1)
    return truth, metric, white


def local_metric(xyz: Array, white: Array) -> Array:
    """J (N, 3, 3) such that |J dXYZ| is the CIEDE2000 difference of a small dXYZ at each of `xyz` (N, 3)."""
    white = np.maximum(white, 1e-6 * white[1])
    ratio = xyz / white
    slope = np.where(ratio > 216 / 24389, np.cbrt(np.maximum(ratio, 1e-4)) ** -2 / 3, 24389 / 27 / 116) / white
    opponent = np.array([[0.0, 116, 0], [500, -500, 0], [0, 200, -200]])  # CIELAB from f(XYZ)
    to_lab = opponent * slope[:, None, :]
    lightness, a, b = lab(xyz, white).T
    chroma7 = np.hypot(a, b) ** 7
    stretch = 1 + 0.5 * (1 - np.sqrt(chroma7 / (chroma7 + 25.0**7)))
    chroma, hue = np.hypot(a * stretch, b), np.arctan2(b, a * stretch)
    coupling = rotation(chroma, np.degrees(hue) % 360)
    # Rows: lightness, chroma and hue in units of tolerance. The rotation term couples the last two:
    # C^2 + H^2 + r C H is the squared length of (C + r/2 H, sqrt(1 - r^2/4) H).
    chroma_row = np.stack([np.cos(hue) * stretch, np.sin(hue)], axis=1) / (1 + 0.045 * chroma)[:, None]
    hue_row = np.stack([-np.sin(hue) * stretch, np.cos(hue)], axis=1)
    hue_row /= (1 + 0.015 * chroma * hue_weight(np.degrees(hue)))[:, None]
    rows = np.zeros((len(xyz), 3, 3))
    rows[:, 0, 0] = 1 / (1 + 0.015 * (lightness - 50) ** 2 / np.sqrt(20 + (lightness - 50) ** 2))
    rows[:, 1, 1:] = chroma_row + coupling[:, None] / 2 * hue_row
    rows[:, 2, 1:] = np.sqrt(1 - coupling**2 / 4)[:, None] * hue_row
    return rows @ to_lab


def fitted_matrices(coefficients: Array, truth: Array, metric: Array, white: Array) -> Array:
    """Relight matrices (e, 3, p): least squares over products with coefficients (N, p), exact for white.

    truth (e, 3, N), metric (e, 6, N) and white (e, 3) are those of `targets`.
    """
    count, channels = coefficients.shape
    lights = len(white)
    even = np.repeat(white[:, :, None] / channels, channels, axis=2)
    if channels == 1:
        return even
    # R = white 1^T / p + Q N^T with N orthogonal to 1: every such R is exact for white, and Q (3, p - 1) is free.
    normal = _orthogonal_to_white(channels)
    features = _product(coefficients, normal)
    size = channels - 1
    rows, columns = np.triu_indices(size)
    moments = _product(metric.reshape(-1, count), features[:, rows] * features[:, columns])
    blocks = np.empty((lights, 6, size, size))
    blocks[:, :, rows, columns] = blocks[:, :, columns, rows] = moments.reshape(lights, 6, -1)
    system = blocks[:, SYMMETRIC].transpose(0, 1, 3, 2, 4).reshape(lights, 3 * size, 3 * size)
    residual = truth - coefficients.mean(axis=1) * white[:, :, None]
    right = (weighted(metric, residual).reshape(-1, count) @ features).reshape(lights, 3 * size)
    # Scale the unknowns before adding the ridge: X, Y and Z of a single line may differ by orders of magnitude.
    scale = 1 / np.sqrt(np.maximum(np.einsum("eii->ei", system), 1e-300))
    system = system * scale[:, :, None] * scale[:, None, :] + RIDGE * np.eye(3 * size)
    free = np.linalg.solve(system, (right * scale)[:, :, None])[:, :, 0] * scale
    return even + free.reshape(lights, 3, size) @ normal.T


def _product(left: Array, right: Array) -> Array:
    """left (a, n) @ right (n, b), in parts small enough that BLAS does not start its threads.

    They wait for one another by spinning: on a busy machine a relight matrix took 100 ms with them, 2 ms without. Only
    where the parts would be tiny, as with many lights at once, threads are worth it.
    """
    (rows, inner), columns = left.shape, right.shape[1]
    longest = max(rows, inner, columns)
    step = 200_000 * longest // (rows * inner * columns)
    if step < 100:
        return left @ right
    parts = [slice(first, first + step) for first in range(0, longest, step)]
    if longest == rows:
        return np.concatenate([left[part] @ right for part in parts])
    if longest == inner:
        return np.sum([left[:, part] @ right[part] for part in parts], axis=0)
    return np.concatenate([left @ right[:, part] for part in parts], axis=1)


def exact_matrix(filters: Array, weights: Array) -> Array | None:
    """The (3, p) exact for every spectrum, where power weights (n, 3) are combinations of `filters`; else None."""
    matrix = np.linalg.lstsq(filters, weights, rcond=1e-13)[0]
    error = np.abs(filters @ matrix - weights).max()
    return matrix.T if error < 1e-11 * np.abs(weights).max() else None


def with_exact_lights(filters: Array, matrix: Array, weights: Array) -> Array:
    """The smallest change of `filters` (n, p) that makes `weights` (n, 3 e) combinations of them, by `matrix` (3 e, p).

    Columns still sum to 1 where matrix @ 1 is the column sums of the weights; small lobes may become negative.
    """
    return filters + (weights - filters @ matrix.T) @ np.linalg.pinv(matrix).T


def weighted(metric: Array, difference: Array) -> Array:
    """The symmetric matrices `metric` (e, 6, N) times vectors `difference` (e, 3, N) -> (e, 3, N)."""
    return np.stack([sum(metric[:, SYMMETRIC[a, b]] * difference[:, b] for b in range(3)) for a in range(3)], axis=1)


@lru_cache
def _orthogonal_to_white(channels: int) -> Array:
    """Orthonormal basis (p, p - 1) of the vectors that sum to zero."""
    return np.linalg.svd(np.ones((1, channels)))[2][1:].T


def reconstructed_matrix(reconstruction: Array, weights: Array) -> Array:
    """Integrate spectra rebuilt as B c, B (n, p), with power weights (n, 3) -> (3, p), made exact for white."""
    matrix = weights.T @ reconstruction
    error = weights.sum(axis=0) - matrix.sum(axis=1)
    return matrix + error[:, None] / matrix.shape[1]


def emitter(training: Training, coefficients: Array, matrix: Array, weights: Array) -> Array:
    """Non-negative coefficients (p,) of a light that is seen through another light's relight `matrix` (3, p).

    Fitted so that matrix @ (emission * c) is the colour of each product, with coefficients (N, p), under the light of
    power weights (n, 3). The light itself keeps its XYZ wherever non-negative coefficients can reach it.
    """
    from scipy.optimize import nnls

    white = weights.sum(axis=0)
    truth = training.products @ weights
    metric = local_metric(truth, white) * np.sqrt(training.weights)[:, None, None]
    rows = (metric @ (matrix * coefficients[:, None, :])).reshape(-1, matrix.shape[1])
    right = np.einsum("nij,nj->ni", metric, truth).ravel()
    # Products are summarised by their triangular factor: nnls then takes p + 1 rows instead of thousands.
    triangle = np.linalg.qr(np.column_stack([rows, right]), mode="r")
    own = 1e4 * local_metric(white[None], white)[0]
    system = np.concatenate([own @ matrix, triangle[:, :-1]])
    return nnls(system, np.concatenate([own @ white, triangle[:, -1]]))[0]
