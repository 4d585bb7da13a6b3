"""The ways to make a factor model.

[DF] M. S. Drew, G. D. Finlayson, "Multispectral processing without spectra", JOSA A 20 (2003).

[WE] G. Ward, E. Eydelberg-Vileshin, "Picture perfect RGB rendering using spectral prefiltering and sharp color
primaries", Eurographics Workshop on Rendering (2002).
"""

from collections.abc import Callable, Sequence
from functools import cache

import numpy as np

from ..colour import spaces
from ..spectra import library
from ..spectra.arrays import Array
from ..spectra.spectrum import WAVELENGTHS, Spectrum
from . import filters as filter_files
from . import relight, sharpening
from .factor_model import REFERENCE_CHANNELS, FactorModel, ModelError
from .rules import Diagonal, Fitted, Reconstructed

__all__ = ["bands", "block", "fitted", "named", "prefiltered", "rgb", "scene", "sharpened"]

Limits = tuple[float, float]  # nm

# Columns: XYZ of the primaries that colours are prefiltered for; Sharp RGB is [WE] section 2.2.
SPACES = {"sharp": np.linalg.inv(spaces.ADAPTATIONS["sharp"]), "srgb": spaces.rgb_to_xyz(), "xyz": np.eye(3)}


def rgb() -> FactorModel:
    """What Blender does: the sRGB colours of spectra under D65, multiplied."""
    return prefiltered(library.illuminant("D65"), space="srgb", name="rgb")


def prefiltered(illuminant: Spectrum, space: str = "sharp", name: str | None = None) -> FactorModel:
    """Colours under a dominant `illuminant`, exact for it after one bounce, diagonal for others [WE].

    space: "sharp", "srgb" or "xyz". Filters may be negative. Raises ModelError.

    >>> prefiltered(library.illuminant("A")).label
    'one light, prefiltered sharp RGB'
    """
    if space not in SPACES:
        raise ModelError(f"no space {space!r} for prefiltering: choose {', '.join(SPACES)}")
    weights = relight.power_weights(illuminant.sampled(), library.observer())
    filters = weights @ np.linalg.inv(SPACES[space]).T
    sums = filters.sum(axis=0)
    if (sums <= 1e-3 * sums.max()).any():
        raise ModelError(f"{illuminant.name or 'the illuminant'} is outside the {space} primaries")
    return FactorModel(name or f"prefiltered {space}", WAVELENGTHS, filters / sums, rule=Diagonal(SPACES[space]))


def block(channels: int, limits: Limits = (380, 780)) -> FactorModel:
    """Equal bands that tile `limits`, in nm, spectra rebuilt by the pseudo-inverse ([DF] section 3.C)."""
    _check_channels(channels)
    edges = np.linspace(limits[0] - 2.5, limits[1] + 2.5, channels + 1)
    filters = _boxes(edges)
    filters /= filters.sum(axis=0)
    return FactorModel("block", WAVELENGTHS, filters, rule=Reconstructed(np.linalg.pinv(filters.T)))


@cache
def bands(channels: int = 36) -> FactorModel:
    """The reference: `channels` samples of the spectrum, interpolated for integration.

    Products are exact at the samples for any number of bounces; only interpolation between samples errs. At 36 channels
    the samples are `filters.REFERENCE`, at other numbers equally spaced. Raises ModelError below 33 channels.
    """
    _check_channels(channels)
    if not REFERENCE_CHANNELS <= channels <= WAVELENGTHS.size:
        raise ModelError(f"the reference needs {REFERENCE_CHANNELS} to {WAVELENGTHS.size} channels, not {channels}")
    samples = np.linspace(390.0, 740.0, channels)
    if channels == len(filter_files.REFERENCE):
        samples = np.array(filter_files.REFERENCE, dtype=np.float64)
    if channels == WAVELENGTHS.size:
        samples = WAVELENGTHS
    filters = np.stack([np.interp(samples, WAVELENGTHS, row) for row in np.eye(WAVELENGTHS.size)])
    return FactorModel("bands", WAVELENGTHS, filters, rule=Reconstructed(_cubic(samples)))


@cache
def fitted(channels: int = 9) -> FactorModel:
    """Non-negative filters optimised for products of one to three bounces; the default model.

    Optimised filters ship for 3, 5, 6, 7, 9, 12, 15, 18, 21 and 24 channels, those from 18 on for gels, LEDs and
    saturated paints as well; other numbers get adjoining bands weighted by the colour matching functions.

    >>> model = fitted(9)
    >>> model.passes, model.filters.shape
    (3, (81, 9))
    """
    _check_channels(channels)
    shipped = filter_files.read_filters()
    filters = shipped[channels] if channels in shipped else filter_files.start_filters(channels)
    return FactorModel("fitted", WAVELENGTHS, filters)


def sharpened(
    channels: int,
    method: str = "nonnegative",
    lights: Sequence[Spectrum] | None = None,
    reflectances: Sequence[Spectrum] | None = None,
    intervals: Sequence[Limits] | None = None,
    limits: Limits = (380, 780),
) -> FactorModel:
    """Sharpened principal components of colour signals, spectra rebuilt by the pseudo-inverse [DF].

    method: "lagrange", least energy outside each interval for unit L2 norm ([DF] eq. 11), or "nonnegative", the same
    with filters that are nowhere negative ([DF] eq. 12). lights, reflectances: lists of Spectrum, by default CIE
    daylights and A, and the CES. intervals: (low, high) in nm for each channel, by default equal parts of `limits`,
    also in nm, outside which filters vanish. The paper's own 31 samples are in `studies/multispectral.py`.
    Raises ModelError, also where the colour signals have fewer than `channels` independent components.
    """
    _check_channels(channels)
    lights = lights or [library.illuminant(name) for name in ("A", "D50", "D55", "D65", "D75")]
    signals = _colour_signals(lights, reflectances or library.reflectances("ces"))
    within = (limits[0] <= WAVELENGTHS) & (limits[1] >= WAVELENGTHS)
    basis = sharpening.principal_components(signals * within, channels) * within[:, None]
    if intervals is None:
        edges = np.linspace(*limits, channels + 1)
        intervals = list(zip(edges[:-1], edges[1:], strict=True))
    filters = sharpening.sharpened(basis, WAVELENGTHS, list(intervals), method)
    name = f"sharpened {method}"
    return FactorModel(name, WAVELENGTHS, filters, rule=Reconstructed(np.linalg.pinv(filters.T)))


def _colour_signals(lights: Sequence[Spectrum], reflectances: Sequence[Spectrum]) -> Array:
    """All lights, each with a peak of 1, times all reflectances -> (m, 81). Raises ModelError."""
    power = np.stack([light.sampled() for light in lights])
    if not (power.max(axis=1) > 0).all():
        raise ModelError(f"{lights[int(np.argmin(power.max(axis=1)))].name or 'a light'} has no power in 380 to 780 nm")
    power /= power.max(axis=1, keepdims=True)
    return (power[:, None, :] * np.stack([s.sampled() for s in reflectances])).reshape(-1, WAVELENGTHS.size)


def scene(
    channels: int,
    reflectances: Sequence[Spectrum],
    illuminants: Sequence[Spectrum],
    exact: bool | None = None,
    lobes: bool = False,
    rule: type[Fitted] = Fitted,
    bounces: Sequence[float] | None = None,
) -> FactorModel:
    """`fitted`, specialised to the reflectances and illuminants (lists of Spectrum) of one scene.

    exact: whether the first bounce under each of the illuminants is to be exact for every reflectance, by default where
    there are at least 6 channels for each. Exactness costs accuracy of further bounces, and most of all where filters
    are to stay non-negative. lobes: let exact filters be negative in places, mostly where the eye sees little, for
    further bounces several times nearer to the truth; the scene's own coefficients stay positive even so, but those of
    other reflectances may leave 0..1. `benchmarks/core_accuracy.py` gives both in figures. rule: `Direct` where light
    is reflected once. bounces: how much products of 1, 2 and 3 reflectances count for the filters; by default as much
    as for the matrices of the rule. Raises ModelError.
    """
    _check_channels(channels)
    if not reflectances or not illuminants:
        raise ModelError("a scene model needs at least one reflectance and one illuminant")
    if exact is None:
        exact = channels >= 6 * len(illuminants)
    if exact and channels < 3 * len(illuminants):
        raise ModelError(
            f"{channels} channels are exact for at most {channels // 3} illuminants, not {len(illuminants)}"
        )
    from . import optimise, training

    own = np.stack([spectrum.sampled() for spectrum in reflectances])
    power = np.stack([illuminant.sampled() for illuminant in illuminants])
    with optimise.one_thread():
        task = optimise.Task.of(*training.with_general(own, bounces or rule.bounces, part=8), power)
        weights = np.concatenate([relight.power_weights(e, library.observer()) for e in power], axis=1)
        filters = optimise.scene_filters(fitted(channels).filters, task, weights)
        found: Array | None = filters
        if exact and lobes:
            model = FactorModel("scene", WAVELENGTHS, filters, Fitted(own))
            matrices = np.concatenate([model.relight(illuminant) for illuminant in illuminants])
            found = relight.with_exact_lights(filters, matrices, weights)
            found /= found.sum(axis=0)
        elif exact:
            found = optimise.exact_filters(filters, task, weights)
    if found is None or (own @ found).min() < 0:
        raise ModelError(
            "no filters found that are exact for these illuminants and keep the scene's coefficients positive; "
            "try exact=False"
        )
    return FactorModel("scene", WAVELENGTHS, found, rule(own))


@cache
def named(name: str, channels: int) -> FactorModel:
    """The model that a saved scene names: "rgb", "fitted", "bands" or "block". Raises ModelError."""
    makers: dict[str, Callable[[int], FactorModel]] = {
        "rgb": lambda channels: rgb(),
        "fitted": fitted,
        "bands": bands,
        "block": block,
    }
    if name not in makers:
        raise ModelError(f"no model named {name!r}: choose {', '.join(makers)}")
    return makers[name](channels)


def _check_channels(channels: int) -> None:
    if not (isinstance(channels, (int, np.integer)) and 1 <= channels <= WAVELENGTHS.size):
        raise ModelError(f"channels must be a whole number from 1 to {WAVELENGTHS.size}, not {channels!r}")


def _boxes(edges: Array) -> Array:
    """Indicators (81, p) of the bands between p + 1 `edges`, in nm; a sample may belong to two in part."""
    low, high = WAVELENGTHS[:, None] - 2.5, WAVELENGTHS[:, None] + 2.5
    return np.clip(np.minimum(high, edges[1:]) - np.maximum(low, edges[:-1]), 0, None) / 5


def _cubic(samples: Array) -> Array:
    """Interpolation matrix (81, p): natural cubic spline through `samples`, constant outside them."""
    from scipy.interpolate import CubicSpline

    inside = np.clip(WAVELENGTHS, samples[0], samples[-1])
    return CubicSpline(samples, np.eye(samples.size), bc_type="natural")(inside)
