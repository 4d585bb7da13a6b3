"""From RGB colours to coefficients, so that every colour comes back exactly under D65."""

from functools import cache, lru_cache

import numpy as np

from ..colour import differences
from ..colour.spaces import D65_WHITE, REC709, RGB_SPACES, rgb_to_xyz
from ..spectra import library
from ..spectra.arrays import Array, ArrayLike
from ..spectra.spectrum import WAVELENGTHS
from .factor_model import FactorModel, ModelError

__all__ = ["RGB_SPACES", "filter_difference", "is_outside_rec709", "rgb_matrix", "rgb_spectra", "rgb_to_xyz"]


@cache
def rgb_matrix(model: FactorModel, space: str = REC709) -> Array:
    """RGB to coefficients, (p, 3): rows sum to 1, and relight(D65) @ A is the colour itself.

    A mixture of the smooth basis of Mallett & Yuksel (2019), projected on the filters and corrected by the smallest
    change that makes the round trip exact with coefficients in 0..1 for colours inside Rec.709. Colours outside
    Rec.709, whichever space they come in, may get coefficients outside 0..1. Below 4 channels exactness decides; below
    3 only luminance comes back.

    >>> from relume.core import bases
    >>> model = bases.fitted(9)
    >>> shown = model.relight(library.illuminant("D65")) @ rgb_matrix(model) @ [0.8, 0.1, 0.1]
    >>> np.allclose(shown, rgb_to_xyz() @ [0.8, 0.1, 0.1])
    True
    """
    basic = _rec709_matrix(model)
    if space == REC709:
        return basic
    matrix = basic @ np.linalg.solve(rgb_to_xyz(), rgb_to_xyz(space))
    matrix.setflags(write=False)
    return matrix


@cache
def rgb_spectra(space: str = REC709) -> Array:
    """(81, 3), read-only: the spectra that RGB colours truly have, whatever the model, are mixtures of these columns.

    Those that the reference gives them: they come back exactly under D65, and rows sum to 1.
    """
    from . import bases

    reference = bases.bands()
    spectra = reference.reconstruct(rgb_matrix(reference, space).T).T
    spectra.setflags(write=False)
    return spectra


@cache
def _rec709_matrix(model: FactorModel) -> Array:
    target = rgb_to_xyz()
    if model.channels < 3:
        return np.tile(target[1], (model.channels, 1))
    if not np.array_equal(model.wavelengths, WAVELENGTHS):  # white is that of daylight on the model's own wavelengths
        target = target * (_under_daylight(model).sum(axis=1) / target.sum(axis=1))[:, None]
    matrix = _nearest(model.coefficients(_primaries(model).T).T, _under_daylight(model), target)
    matrix.setflags(write=False)
    return matrix


def is_outside_rec709(rgb: ArrayLike, space: str = REC709) -> bool:
    """Whether a colour is purer than any of Rec.709, by 1 % of its brightest channel. Channels below 0 count as 0."""
    if space == REC709:
        return False
    own = np.linalg.solve(rgb_to_xyz(REC709), rgb_to_xyz(space) @ np.maximum(rgb, 0.0))
    return bool(own.min() < -0.01 * own.max())


def filter_difference(model: FactorModel, rgb: ArrayLike, space: str = REC709) -> float:
    """How far surfaces in coloured light differ from the product of two RGB colours: CIEDE2000, the worst of six.

    They are red, green, blue and the mixtures of two, of 5 and 80 %, lit by D65 through a filter of that colour; the
    light is as bright as white in a picture.
    """
    return _filter_difference(model, tuple(np.asarray(rgb, dtype=np.float64).tolist()), space)


@lru_cache(maxsize=4096)  # a scene has many lights of few colours, and is looked at again and again
def _filter_difference(model: FactorModel, rgb: tuple[float, ...], space: str) -> float:
    light = np.maximum(rgb, 0.0)
    luminance = float(rgb_to_xyz(space)[1] @ light)
    if luminance <= 0.0:
        return 0.0
    light /= luminance
    surfaces = 0.05 + 0.75 * np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [1, 0, 1], [0, 1, 1]])
    matrix = rgb_matrix(model, space)
    spectral = (matrix @ light * (surfaces @ matrix.T)) @ _under_daylight(model).T
    plain = (light * surfaces) @ rgb_to_xyz(space).T
    return float(differences.delta_E_2000(plain, spectral, D65_WHITE).max())


@cache
def _under_daylight(model: FactorModel) -> Array:
    """The relight matrix of D65, (3, p)."""
    matrix = model.relight(library.illuminant("D65"))
    matrix.setflags(write=False)
    return matrix


def _primaries(model: FactorModel) -> Array:
    """Reflectances (n, 3) of red, green and blue that the model is to come near to.

    Those that the reference gives its colours, so that models differ by their products alone.
    """
    from . import bases

    smooth = library.colour_science().recovery.MSDS_BASIS_FUNCTIONS_sRGB_MALLETT2019
    reference = bases.bands()
    if model is not reference and np.array_equal(model.wavelengths, reference.wavelengths):
        return rgb_spectra()
    values = np.stack([np.interp(model.wavelengths, smooth.wavelengths, column) for column in smooth.values.T], axis=1)
    return values / values.sum(axis=1, keepdims=True)


def _nearest(start: Array, relight: Array, target: Array) -> Array:
    """The A (p, 3) nearest to `start` with relight @ A = target, rows summing to 1 and, if possible, A >= 0."""
    channels = len(start)
    # Unknowns in row-major order; one equation per entry of the target, one per row sum.
    round_trip = np.einsum("ij,kl->ikjl", relight, np.eye(3)).reshape(9, 3 * channels)
    rows = np.repeat(np.eye(channels), 3, axis=1)
    equations = np.concatenate([round_trip, rows])
    right = np.concatenate([target.ravel(), np.ones(channels)])
    pinned = np.zeros(3 * channels, dtype=bool)
    best = None
    for _ in range(2 * channels):
        free = ~pinned
        known = start.ravel()[free]
        shortfall = right - equations[:, free] @ known
        change = np.linalg.lstsq(equations[:, free], shortfall, rcond=1e-10)[0]
        if np.abs(equations[:, free] @ change - shortfall).max() > 1e-9:
            break  # no non-negative matrix is exact: keep the one with fewest pins
        values = np.zeros(3 * channels)
        values[free] = known + change
        best = values
        if values.min() >= -1e-12:
            break
        pinned |= values < -1e-12
    if best is None:
        raise ModelError("these filters cannot carry RGB colours: their relight matrix under D65 is singular")
    return best.reshape(channels, 3)
