"""What the filters give and what the matrix gives: each way of making colours, with each set of filters."""

from collections.abc import Callable, Sequence

import numpy as np

from ..core.colour import differences
from ..core.model import bases
from ..core.model.factor_model import FactorModel
from ..core.model.relight import power_weights, reconstructed_matrix
from ..core.model.rules import Fitted
from ..core.spectra import library
from ..core.spectra.arrays import Array
from ..core.spectra.spectrum import WAVELENGTHS, Spectrum
from .reports import Section

__all__ = ["WAYS", "cie_lights", "section", "summary", "way_errors"]

CHANNELS = (6, 9)
LIMITS = (400, 700)  # nm, of the paper; of 380 to 780 both boxes and eq. 12 make less
NARROW = (420, 680)  # where boxes with a fitted matrix do best, of limits ten apart
PERCENTILES = (50, 90, 99)

Colours = Callable[[FactorModel, Spectrum], Array]  # -> (3, p), of products of the coefficients of surfaces


def cie_lights() -> list[Spectrum]:
    """The 52 CIE illuminants that reach 780 nm."""
    return [library.illuminant(name) for family in library.cie_illuminants().values() for name in family]


def light_as_factor(model: FactorModel, light: Spectrum) -> Array:
    """The light is one more factor, and spectra are rebuilt by the pseudo-inverse: [DF] eqs. 23 to 27."""
    observer = library.observer()
    power = light.sampled() / (light.sampled() @ observer[:, 1])
    return observer.T @ np.linalg.pinv(model.filters.T) * model.coefficients(power)


def pseudo_inverse(model: FactorModel, light: Spectrum) -> Array:
    """The light at full resolution on what the pseudo-inverse rebuilds, and white made exact."""
    weights = power_weights(light.sampled(), library.observer())
    return reconstructed_matrix(np.linalg.pinv(model.filters.T), weights)


def fitted_matrix(model: FactorModel, light: Spectrum) -> Array:
    """The matrix fitted to products under the light, as `fitted` models have it."""
    return FactorModel(model.name, WAVELENGTHS, model.filters, Fitted()).relight(light)


WAYS: dict[str, Colours] = {
    "light as a factor": light_as_factor,
    "pseudo-inverse": pseudo_inverse,
    "fitted matrix": fitted_matrix,
}


def way_errors(
    model: FactorModel, way: Colours, spectra: Array, lights: Sequence[Spectrum], count: int = 1, seed: int = 7
) -> Array:
    """CIEDE2000 of products of `count` of the reflectances (m, 81) under each light -> (e, N).

    All reflectances for one bounce, 400 random products for more.
    """
    chosen = np.arange(len(spectra))[:, None]
    if count > 1:
        chosen = np.random.default_rng(seed).integers(len(spectra), size=(400, count))
    products, coefficients = spectra[chosen].prod(axis=1), model.coefficients(spectra)[chosen].prod(axis=1)
    errors = []
    for light in lights:
        weights = power_weights(light.sampled(), library.observer())
        xyz = coefficients @ way(model, light).T
        errors.append(differences.delta_E_2000(products @ weights, xyz, weights.sum(axis=0)))
    return np.stack(errors)


def summary(errors: Array) -> str:
    """Median / 90th / 99th percentile in words."""
    return " / ".join(f"{value:.2f}" for value in np.percentile(errors, PERCENTILES))


def section(reflectances: Sequence[Spectrum]) -> Section:
    """Filters × matrix, for 6 and 9 channels under the CIE illuminants."""
    values, lights, rows = np.stack([spectrum.sampled() for spectrum in reflectances]), cie_lights(), []
    for p in CHANNELS:
        made = {
            "boxes": bases.block(p, LIMITS),
            "boxes, 420 to 680 nm": bases.block(p, NARROW),
            "eq. 12": bases.sharpened(p, limits=LIMITS),
            "eq. 11": bases.sharpened(p, "lagrange", limits=LIMITS),
            "ours": bases.fitted(p),
        }
        for name, model in made.items():
            rows.append([p, name, *(summary(way_errors(model, way, values, lights)) for way in WAYS.values())])
    words = (
        f"CIEDE2000 of {len(values)} reflectances under {len(lights)} CIE illuminants, median / 90th / 99th "
        "percentile. Down a column the matrix is made alike and the filters differ; along a row the filters are the "
        "same. Boxes adjoin; they and the intervals of eqs. 11 and 12 tile 400 to 700 nm, the basis is of the CES "
        "in daylights and A."
    )
    return Section("Filters and matrices", words, ("p", "filters", *WAYS), rows)
