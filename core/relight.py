"""Relight matrices: from the coefficients of a product of spectra to its XYZ under an illuminant.

A relight matrix R is (3, p). It may be any matrix, so the best one is fitted for each illuminant, on products of
reflectances, in the metric of CIEDE2000 at each true colour. It is exact for white by constraint: R @ 1 is the XYZ of
the illuminant, so a light seen directly keeps its colour.
"""

from functools import lru_cache

import numpy as np

from .measure import lab

__all__ = ["Training", "emitter", "fitted_matrix", "power_weights", "reconstructed_matrix", "training_products", "tristimulus"]

RIDGE = 1e-8  # relative to the mean diagonal; 1e-3 already raises the error two- to fivefold


class Training:
    """Products of reflectances that relight matrices are fitted on.

    products (N, n), coefficients (N, p) as a renderer would multiply them, weights (N,).
    """

    def __init__(self, products, coefficients, weights):
        self.products = products
        self.coefficients = coefficients
        self.weights = weights


def training_products(reflectances, filters, weights=(1.0, 0.5, 0.25, 0.1, 0.05), most=1200):
    """Products of 1 to len(weights) of the `reflectances` (m, n) and what a renderer makes of them -> Training.

    At most `most` products of each number of bounces are drawn, always the same ones; `weights` say how much each
    number of bounces counts.
    """
    random = np.random.default_rng(20031103)
    number = len(reflectances)
    spectra, coefficients, importance = [], [], []
    factors = reflectances @ filters
    for bounces, weight in enumerate(weights, start=1):
        if bounces == 1:
            chosen = np.arange(number)[:, None]
        elif number ** bounces <= most:
            chosen = np.stack(np.meshgrid(*[np.arange(number)] * bounces), axis=-1).reshape(-1, bounces)
        else:
            chosen = random.integers(number, size=(most, bounces))
        spectra.append(reflectances[chosen].prod(axis=1))
        coefficients.append(factors[chosen].prod(axis=1))
        importance.append(np.full(len(chosen), weight / len(chosen)))
    return Training(np.concatenate(spectra), np.concatenate(coefficients), np.concatenate(importance))


def power_weights(illuminant, cmfs):
    """Illuminant (n,) times matching functions (n, 3), scaled so that a perfect white has Y = 1 -> (n, 3).

    Raises ValueError for an illuminant with no visible power.
    """
    weights = np.asarray(illuminant)[:, None] * cmfs
    luminance = weights[:, 1].sum()
    if not luminance > 0:
        raise ValueError("the illuminant has no visible power between 380 and 780 nm")
    return weights / luminance


def tristimulus(spectra, illuminant, cmfs):
    """XYZ (..., 3) of reflectances (..., n) under an illuminant (n,), Y = 1 for a perfect white."""
    return spectra @ power_weights(illuminant, cmfs)


def local_metric(xyz, white):
    """J (N, 3, 3) such that |J dXYZ| is the CIEDE2000 difference of a small dXYZ at each of `xyz` (N, 3)."""
    white = np.maximum(white, 1e-6 * white[1])
    ratio = xyz / white
    slope = np.where(ratio > 216 / 24389, np.cbrt(np.maximum(ratio, 1e-4)) ** -2 / 3, 24389 / 27 / 116) / white
    opponent = np.array([[0.0, 116, 0], [500, -500, 0], [0, 200, -200]])  # CIELAB from f(XYZ)
    to_lab = opponent * slope[:, None, :]
    lightness, a, b = lab(xyz, white).T
    chroma7 = np.hypot(a, b) ** 7
    saturation = np.sqrt(chroma7 / (chroma7 + 25.0**7))
    stretch = 1 + 0.5 * (1 - saturation)
    chroma, hue = np.hypot(a * stretch, b), np.degrees(np.arctan2(b, a * stretch)) % 360
    t = (
        1
        - 0.17 * np.cos(np.radians(hue - 30))
        + 0.24 * np.cos(np.radians(2 * hue))
        + 0.32 * np.cos(np.radians(3 * hue + 6))
        - 0.20 * np.cos(np.radians(4 * hue - 63))
    )
    chroma7 = chroma**7
    rotation = -2 * np.sqrt(chroma7 / (chroma7 + 25.0**7)) * np.sin(
        np.radians(60 * np.exp(-(((hue - 275) / 25) ** 2)))
    )
    lightness_scale = 1 + 0.015 * (lightness - 50) ** 2 / np.sqrt(20 + (lightness - 50) ** 2)
    chroma_scale, hue_scale = 1 + 0.045 * chroma, 1 + 0.015 * chroma * t
    cos, sin = np.cos(np.radians(hue)), np.sin(np.radians(hue))
    # Rows: lightness, chroma and hue in units of tolerance. The rotation term couples the last two:
    # C^2 + H^2 + r C H is the squared length of (C + r/2 H, sqrt(1 - r^2/4) H).
    chroma_row = np.stack([cos * stretch, sin], axis=1) / chroma_scale[:, None]
    hue_row = np.stack([-sin * stretch, cos], axis=1) / hue_scale[:, None]
    metric = np.zeros((len(xyz), 3, 3))
    metric[:, 0, 0] = 1 / lightness_scale
    metric[:, 1, 1:] = chroma_row + rotation[:, None] / 2 * hue_row
    metric[:, 2, 1:] = np.sqrt(1 - rotation**2 / 4)[:, None] * hue_row
    return metric @ to_lab


def fitted_matrix(training, illuminant, cmfs):
    """The relight matrix (3, p) that fits the training products best under `illuminant` (n,), exact for white."""
    weights = power_weights(illuminant, cmfs)
    white = weights.sum(axis=0)
    truth = training.products @ weights
    metric = local_metric(truth, white)
    gram = np.einsum("nia,nib,n->abn", metric, metric, training.weights)

    channels = training.coefficients.shape[1]
    if channels == 1:
        return white[:, None]
    # R = white 1^T / p + Q N^T with N orthogonal to 1: every such R is exact for white.
    normal = _orthogonal_to_white(channels)
    features = training.coefficients @ normal
    residual = truth - training.coefficients.mean(axis=1)[:, None] * white
    size = channels - 1
    system = np.empty((3, size, 3, size))
    right = np.empty((3, size))
    for a in range(3):
        for b in range(a, 3):
            system[a, :, b, :] = (features * gram[a, b][:, None]).T @ features
            system[b, :, a, :] = system[a, :, b, :].T
        right[a] = (gram[a] * residual.T).sum(axis=0) @ features
    system = system.reshape(3 * size, 3 * size)
    # Scale the unknowns before adding the ridge: X, Y and Z of a single line may differ by orders of magnitude.
    scale = 1 / np.sqrt(np.maximum(np.diag(system), 1e-300))
    system = system * scale[:, None] * scale + RIDGE * np.eye(3 * size)
    solution = np.linalg.solve(system, right.ravel() * scale) * scale
    return np.outer(white, np.full(channels, 1 / channels)) + solution.reshape(3, size) @ normal.T


@lru_cache
def _orthogonal_to_white(channels):
    """Orthonormal basis (p, p - 1) of the vectors that sum to zero."""
    return np.linalg.svd(np.ones((1, channels)))[2][1:].T


def reconstructed_matrix(reconstruction, illuminant, cmfs):
    """CMF^T diag(E) B for spectra rebuilt as B c, B (n, p) -> (3, p), corrected to be exact for white."""
    weights = power_weights(illuminant, cmfs)
    matrix = weights.T @ reconstruction
    error = weights.sum(axis=0) - matrix.sum(axis=1)
    return matrix + error[:, None] / matrix.shape[1]


def emitter(training, matrix, illuminant, cmfs):
    """Non-negative coefficients (p,) of a light that is seen through another light's relight `matrix` (3, p).

    Fitted so that matrix @ (emission * c) is the product's colour under `illuminant`; the light itself keeps its XYZ
    wherever non-negative coefficients can reach it.
    """
    from scipy.optimize import nnls

    weights = power_weights(illuminant, cmfs)
    white = weights.sum(axis=0)
    truth = training.products @ weights
    metric = local_metric(truth, white) * np.sqrt(training.weights)[:, None, None]
    rows = (metric @ (matrix * training.coefficients[:, None, :])).reshape(-1, matrix.shape[1])
    right = np.einsum("nij,nj->ni", metric, truth).ravel()
    own = 1e4 * local_metric(white[None], white)[0]
    return nnls(np.concatenate([own @ matrix, rows]), np.concatenate([own @ white, right]))[0]
