"""Experiments on models without a renderer: light bounced off random surfaces, metamers, chosen products.

[DF] M. S. Drew, G. D. Finlayson, "Multispectral processing without spectra", JOSA A 20 (2003) 1181-1193.
"""

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from ..core.colour import differences
from ..core.model import bases
from ..core.model.factor_model import FactorModel
from ..core.model.relight import power_weights
from ..core.spectra import library
from ..core.spectra.arrays import Array
from ..core.spectra.spectrum import WAVELENGTHS, Spectrum

__all__ = ["PAPER_LIMITS", "bounces", "metamer_splits", "product_errors", "published", "split_error", "three_bounces"]

PAPER_LIMITS = (400, 700)  # nm
PUBLISHED = {
    "eq. 11": ("lagrange", "energy"),
    "eq. 12": ("nonnegative", "energy"),
    "eq. 12, least area": ("nonnegative", "area"),
}
THREE_SURFACES = ("light skin", "foliage", "blue sky")


def published(
    channels: int, lights: Sequence[Spectrum], reflectances: Sequence[Spectrum], limits: tuple[float, float]
) -> dict[str, FactorModel]:
    """The bases of [DF] -> {name: FactorModel}."""
    return {
        name: bases.sharpened(channels, method, lights, reflectances, limits=limits, outside=outside)
        for name, (method, outside) in PUBLISHED.items()
    }


def paper_observer() -> Array:
    """Colour matching functions that vanish outside PAPER_LIMITS -> (81, 3)."""
    inside = (PAPER_LIMITS[0] <= WAVELENGTHS) & (PAPER_LIMITS[1] >= WAVELENGTHS)
    return library.observer() * inside[:, None]


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


def accumulated(factors: Array, rule: str) -> Array:
    """Light after 1 to k bounces from k factors (k, ...) -> (k, ...), for spectra and coefficients alike.

    rule: "paper", a <- a (1 + S), or "physical", S1 + S1 S2 + S1 S2 S3 + ...
    """
    if rule == "paper":
        return np.cumprod(np.concatenate([factors[:1], 1 + factors[1:]]), axis=0)
    return np.cumsum(np.cumprod(factors, axis=0), axis=0)


def bounces(
    channels: int,
    reflectances: Sequence[Spectrum],
    lights: Sequence[Spectrum],
    rule: str = "paper",
    count: int = 5,
    trials: int = 1000,
    seed: int = 2003,
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Random series of bounces by every method of [DF] and ours, over PAPER_LIMITS.

    reflectances, lights: lists of Spectrum -> {method: CIE 1976 differences (trials, lights, count)}, and the same
    for the relative error of the spectra in percent, of those methods that rebuild spectra.
    """
    random = np.random.default_rng(seed)
    values = np.stack([spectrum.sampled() for spectrum in reflectances])
    series = values[random.integers(len(values), size=(count, trials))]
    true = accumulated(series, rule)
    cmfs = paper_observer()
    inside = cmfs.any(axis=1)
    equal = power_weights(np.ones(WAVELENGTHS.size), cmfs)

    theirs = published(channels, lights, reflectances, PAPER_LIMITS)
    linear = np.linalg.qr(theirs["eq. 11"].filters)[0]
    ours = {"block filters": bases.block(channels, PAPER_LIMITS), "fitted (ours)": bases.fitted(channels)}

    apart, spectral = defaultdict(list), defaultdict(list)
    for light in lights:
        power = light.sampled() / (light.sampled() @ cmfs[:, 1])  # Y = 1 for a perfect white
        white = power @ cmfs
        signal = true * power * inside
        rebuilt = {"best linear model": signal @ linear @ linear.T}
        for method, model in theirs.items():
            # In [DF] the light is one more factor: its coefficients multiply those of the surfaces.
            coefficients = model.coefficients(power) * accumulated(model.coefficients(series), rule)
            rebuilt[method] = model.reconstruct(coefficients)
        colours = {method: spectrum @ cmfs for method, spectrum in rebuilt.items()}
        for method, model in ours.items():
            coefficients = accumulated(model.coefficients(series), rule)
            colours[method] = coefficients @ model.relight(light, cmfs).T
        colours["multiply XYZ"] = accumulated(series @ equal / equal.sum(axis=0), rule) * white
        for method, xyz in colours.items():
            apart[method].append(differences.delta_E_1976(xyz, signal @ cmfs, white))
        for method, spectrum in rebuilt.items():
            error = np.linalg.norm(spectrum - signal, axis=-1) / np.linalg.norm(signal, axis=-1)
            spectral[method].append(100 * error)
    by_trial, rebuilt_by_trial = (
        {method: np.stack(v).transpose(2, 0, 1) for method, v in rows.items()} for rows in (apart, spectral)
    )
    return by_trial, rebuilt_by_trial


def three_surfaces() -> Array:
    """Light skin, foliage and blue sky of the ColorChecker -> (3, 81)."""
    return np.stack([library.reflectance(f"ColorChecker: {name}").sampled() for name in THREE_SURFACES])


def three_bounces(channels: int) -> dict[str, float]:
    """[DF] section 3.D: FL2 off light skin, foliage and blue sky; bases of the ColorChecker under FL2.

    -> {method: CIE 1976 difference}
    """
    light = library.illuminant("FL2")
    surfaces = three_surfaces()
    cmfs = paper_observer()
    weights = power_weights(light.sampled(), cmfs)
    white, truth = weights.sum(axis=0), surfaces.prod(axis=0) @ weights
    models = published(channels, [light], library.reflectances("colorchecker"), PAPER_LIMITS)
    models |= {"block filters": bases.block(channels, PAPER_LIMITS), "fitted (ours)": bases.fitted(channels)}
    colours = {
        method: model.coefficients(surfaces).prod(axis=0) @ model.relight(light, cmfs).T
        for method, model in models.items()
    }
    equal = power_weights(np.ones(WAVELENGTHS.size), cmfs)
    colours["multiply XYZ"] = (surfaces @ equal / equal.sum(axis=0)).prod(axis=0) * white
    return {method: float(differences.delta_E_1976(xyz, truth, white)) for method, xyz in colours.items()}


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
