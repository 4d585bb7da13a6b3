"""The ways to make a factor model.

[DF] M. S. Drew, G. D. Finlayson, "Multispectral processing without spectra", JOSA A 20 (2003).
[WE] G. Ward, E. Eydelberg-Vileshin, "Picture perfect RGB rendering using spectral prefiltering and sharp color
     primaries", Eurographics Workshop on Rendering (2002).
"""

from functools import cache

import numpy as np

from . import library, relight
from .factor_model import FactorModel, ModelError
from .spectrum import WAVELENGTHS

__all__ = ["bands", "block", "fitted", "named", "prefiltered", "rgb", "scene"]

# Columns: XYZ of the primaries.
SRGB = np.array([[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]])
# [WE] section 2.2: XYZ to Sharp RGB.
SHARP = np.linalg.inv([[1.2694, -0.0988, -0.1706], [-0.8364, 1.8006, 0.0357], [0.0297, -0.0315, 1.0018]])
SPACES = {"sharp": SHARP, "srgb": SRGB, "xyz": np.eye(3)}

# nm; optimised for products of the CES under the CIE illuminants
EDGES = {
    6: (454, 493, 522, 565, 610),
    9: (452, 486, 512, 535, 556, 580, 610, 638),
    12: (423, 449, 478, 506, 526, 540, 555, 580, 602, 621, 646),
}


def rgb():
    """What Blender does: the sRGB colours of spectra under D65, multiplied."""
    return prefiltered(library.illuminant("D65"), space="srgb", name="rgb")


def prefiltered(illuminant, space="sharp", name=None):
    """Colours under a dominant `illuminant`, exact for it after one bounce, diagonal for others [WE].

    space: "sharp", "srgb" or "xyz". Filters may be negative. Raises ModelError.
    """
    if space not in SPACES:
        raise ModelError(f"no space {space!r} for prefiltering: choose {', '.join(SPACES)}")
    weights = relight.power_weights(illuminant.sampled(), library.observer())
    filters = weights @ np.linalg.inv(SPACES[space]).T
    sums = filters.sum(axis=0)
    if (sums <= 1e-3 * sums.max()).any():
        raise ModelError(f"{illuminant.name or 'the illuminant'} is outside the {space} primaries: prefilter for another")
    return FactorModel(
        name or f"prefiltered {space}", WAVELENGTHS, filters / sums, rule="diagonal", primaries=SPACES[space]
    )


def block(channels):
    """Equal bands that tile 380 to 780 nm, spectra rebuilt by the pseudo-inverse ([DF] section 3.C)."""
    _check_channels(channels)
    edges = np.linspace(WAVELENGTHS[0] - 2.5, WAVELENGTHS[-1] + 2.5, channels + 1)
    filters = _boxes(edges)
    filters /= filters.sum(axis=0)
    return FactorModel(
        "block", WAVELENGTHS, filters, rule="reconstructed", reconstruction=np.linalg.pinv(filters.T)
    )


@cache
def bands(channels=36):
    """The reference: `channels` samples of the spectrum, interpolated for integration.

    Products are exact at the samples for any number of bounces; only interpolation between samples errs. Samples are
    10 nm apart from 390 nm at 36 channels. Raises ModelError below 33 channels.
    """
    if not 33 <= channels <= WAVELENGTHS.size:
        raise ModelError(f"the reference needs 33 to {WAVELENGTHS.size} channels, not {channels}")
    if channels == WAVELENGTHS.size:
        samples = WAVELENGTHS
    else:
        samples = np.linspace(390.0, 740.0, channels)
    filters = np.stack([np.interp(samples, WAVELENGTHS, row) for row in np.eye(WAVELENGTHS.size)])
    return FactorModel(
        "bands", WAVELENGTHS, filters, rule="reconstructed", reconstruction=_cubic(samples)
    )


@cache
def fitted(channels=9):
    """Non-negative filters optimised for products of one to three bounces; the default model."""
    _check_channels(channels)
    return FactorModel("fitted", WAVELENGTHS, _weighted_bands(EDGES.get(channels) or _quantile_edges(channels)))


def scene(channels, reflectances, illuminants):
    """`fitted`, specialised to the `reflectances` (list of Spectrum) and `illuminants` of one scene."""
    if not reflectances:
        raise ModelError("a scene model needs at least one reflectance")
    general = fitted(channels)
    own = np.stack([spectrum.sampled() for spectrum in reflectances])
    return FactorModel("scene", WAVELENGTHS, general.filters, reflectances=own)


@cache
def named(name, channels):
    """The model that a saved scene names: "rgb", "fitted", "bands" or "block". Raises ModelError."""
    makers = {"rgb": lambda channels: rgb(), "fitted": fitted, "bands": bands, "block": block}
    if name not in makers:
        raise ModelError(f"no model named {name!r}: choose {', '.join(makers)}")
    return makers[name](channels)


def _check_channels(channels):
    if not (isinstance(channels, (int, np.integer)) and 1 <= channels <= WAVELENGTHS.size):
        raise ModelError(f"channels must be a whole number from 1 to {WAVELENGTHS.size}, not {channels!r}")


def _boxes(edges):
    """Indicators (81, p) of the bands between p + 1 `edges`, in nm; a sample 5 nm wide may belong to two bands in part."""
    low, high = WAVELENGTHS[:, None] - 2.5, WAVELENGTHS[:, None] + 2.5
    return np.clip(np.minimum(high, edges[1:]) - np.maximum(low, edges[:-1]), 0, None) / 5


def _weighted_bands(inner_edges):
    """Adjoining bands weighted by the sum of the colour matching functions -> filters (81, p)."""
    filters = _boxes(np.array([377.5, *inner_edges, 782.5])) * library.observer().sum(axis=1)[:, None]
    return filters / filters.sum(axis=0)


def _quantile_edges(channels):
    """Edges that share the matching functions' sum equally, softened towards equal width at the ends."""
    share = np.cumsum(np.cbrt(library.observer().sum(axis=1)))
    return np.interp(np.arange(1, channels) / channels, share / share[-1], WAVELENGTHS + 2.5)


def _cubic(samples):
    """Interpolation matrix (81, p): natural cubic through equidistant samples, constant outside them."""
    from scipy.interpolate import CubicSpline

    inside = np.clip(WAVELENGTHS, samples[0], samples[-1])
    return CubicSpline(samples, np.eye(samples.size), bc_type="natural")(inside)
