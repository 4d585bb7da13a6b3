"""Experiments on models without a renderer: random products, and metamers that come apart."""

from collections.abc import Sequence

import numpy as np

from ..core.colour import differences
from ..core.model.factor_model import FactorModel
from ..core.model.relight import power_weights
from ..core.spectra import library
from ..core.spectra.arrays import Array
from ..core.spectra.spectrum import Spectrum

__all__ = ["metamer_splits", "product_errors", "split_error"]


def product_errors(
    model: FactorModel, spectra: Array, lights: Sequence[Spectrum], count: int = 1, most: int = 400, seed: int = 7
) -> Array:
    """CIEDE2000 of products of `count` of the reflectances (m, 81), under each light (list of Spectrum) -> (e, N).

    All reflectances for one bounce, `most` random products for more.
    """
    chosen = np.arange(len(spectra))[:, None]
    if count > 1:
        chosen = np.random.default_rng(seed).integers(len(spectra), size=(most, count))
    products = spectra[chosen].prod(axis=1)
    coefficients = model.coefficients(spectra)[chosen].prod(axis=1)
    errors = []
    for light in lights:
        weights = power_weights(light.sampled(), library.observer())
        xyz = coefficients @ model.relight(light).T
        errors.append(differences.delta_E_2000(products @ weights, xyz, weights.sum(axis=0)))
    return np.stack(errors)


def metamer_splits(model: FactorModel, pairs: Array, light: Spectrum) -> tuple[Array, Array]:
    """CIEDE2000 between the two of each pair of reflectances (m, 2, 81) under a light: (m,) true, (m,) by the model."""
    weights = power_weights(light.sampled(), library.observer())
    both = pairs @ weights, model.coefficients(pairs) @ model.relight(light).T
    true, seen = (differences.delta_E_2000(xyz[:, 0], xyz[:, 1], weights.sum(axis=0)) for xyz in both)
    return true, seen


def split_error(true: Array, seen: Array) -> float:
    """Median relative error of the splits that can be seen, those above 1."""
    visible = true > 1
    return float(np.median(np.abs(seen - true)[visible] / true[visible]))
