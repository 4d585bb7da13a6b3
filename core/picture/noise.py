"""What the passes of a render tell of one another's noise.

Each pass holds the same scene in three channels, with noise of its own, most of it in brightness. What is left between
passes shows as noise of hue, which no RGB render has.
"""

import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ..colour.spaces import xyz_to_rgb
from ..model.factor_model import FactorModel
from ..spectra import library
from ..spectra.arrays import Array
from .recombination import relight_matrix

__all__ = [
    "AGREED",
    "BLUR",
    "EROSION",
    "LEAST_ALBEDO",
    "MOST",
    "SHARE",
    "SURE",
    "TO_NOISE",
    "denoised",
    "estimated",
    "mirrored",
    "to_picture",
]

BLUR = 12  # pixels, three standard deviations of the Gaussian: Blender's compositor calls that its size
EROSION = 6  # pixels around, in which noise is smallest
LEAST_ALBEDO = 0.001  # brightness is divided by the albedo and this
SURE = 4.0  # times the length of its normal, the part of a pixel that is taken to be no light itself
AGREED = 3.0  # times the noise, the most by which a pass is changed in relation to the mean of all
MOST = 4.0  # times, the most by which a pixel of a pass is made brighter
SHARE = 0.5  # of the picture denoised as one
_SPACE = "Linear Rec.2020"  # of the picture that all passes are denoised in: nothing natural is negative in it
_ROWS = 128  # worked on at a time
_HALO = BLUR + EROSION + 1  # rows around that count as well
# |second difference along both axes of noise| to the noise itself: it sees no straight edge and no slope
TO_NOISE = float(np.sqrt(np.pi / 2) / (2 / 3))


def estimated(groups: Mapping[str, Array], guides: Sequence[Mapping[str, Array]]) -> dict[str, Array]:
    """Light groups (height, width, p) with what the brightness of passes differs in by chance taken out of them.

    A ratio estimator: each pass is scaled to the mean brightness of all, times what its own is of that in the
    neighbourhood; brightness is divided by the albedo first, so that textures stay. The mean stays as it is, and no
    pass is changed by much more than the noise around, measured where the picture is smooth: the more samples, the
    less. What shines itself has no noise and stays: it has no normal.
    guides: "Albedo" and "Normal" of each pass, (height, width, 3), as the denoiser is guided; of normals the first
    pass's will do.
    """
    if len(guides) < 2:
        return dict(groups)
    import scipy.ndimage  # noqa: F401  # here, for two threads that import SciPy at once end in a deadlock

    height, channels = len(guides[0]["Albedo"]), next(iter(groups.values())).shape[-1]
    found = {name: np.empty_like(values) for name, values in groups.items()}

    def work(top: int) -> None:
        around = slice(max(top - _HALO, 0), min(top + _ROWS + _HALO, height))
        inner = slice(top - around.start, min(top + _ROWS, height) - around.start)
        rows = slice(top, top + inner.stop - inner.start)
        normal = guides[0]["Normal"][around]
        surface = np.sqrt(np.einsum("ijk,ijk->ij", normal, normal))
        albedo = _brightness([guide["Albedo"][around] for guide in guides], channels) + np.float32(LEAST_ALBEDO)
        for name, values in groups.items():
            factors = _factors(values[around], albedo, surface)[:, inner]
            for k, factor in enumerate(factors):
                own = slice(3 * k, 3 * k + 3)
                np.multiply(values[rows, :, own], factor[..., None], out=found[name][rows, :, own])

    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        for _ in pool.map(work, range(0, height, _ROWS)):
            pass
    return found


def _factors(values: Array, albedo: Array, surface: Array) -> Array:
    """(passes, height, width) by which passes are scaled; albedo: of each pass; surface: length of the mean normal."""
    from scipy import ndimage

    def blurred(planes: Array) -> Array:
        across = ndimage.gaussian_filter1d(planes, BLUR / 3, axis=2, mode="nearest", truncate=3.0)
        return ndimage.gaussian_filter1d(across, BLUR / 3, axis=1, mode="nearest", truncate=3.0)

    parts = [values[..., 3 * k : 3 * k + 3] for k in range(len(albedo))]
    brightness = np.maximum(_brightness(parts, values.shape[-1]) / albedo, 0.0)
    part, wanted = _over_mean(brightness), _over_mean(blurred(brightness))
    difference = part
    for axis in (1, 2):
        difference = difference - ndimage.uniform_filter1d(difference, 3, axis=axis, mode="nearest")
    size = (1, 2 * EROSION + 1, 2 * EROSION + 1)
    noise = ndimage.minimum_filter(blurred(np.abs(difference)), size, mode="nearest")
    limit = noise * (np.float32(AGREED * TO_NOISE) * np.minimum(surface * np.float32(SURE), 1.0))
    agreed = _over_mean(part + np.clip(wanted - part, -limit, limit))
    return np.where(part > 0.0, np.minimum(_ratio(agreed, part), MOST), np.float32(1.0))


def _brightness(passes: Sequence[Array], channels: int) -> Array:
    """(passes, height, width), means over the channels that the model has in each pass."""
    planes = []
    for k, values in enumerate(passes):
        count = min(channels - 3 * k, 3)
        planes.append(sum(values[..., channel] for channel in range(count)) / np.float32(count))
    return np.stack(planes)


def _over_mean(planes: Array) -> Array:
    """(passes, height, width) over the mean of all."""
    return _ratio(planes, planes.mean(axis=0))


def _ratio(above: Array, below: Array) -> Array:
    """Quotients, 0 where there is no light: as Blender's nodes divide."""
    return np.divide(above, below, out=np.zeros(above.shape, np.float32), where=below != 0)


def denoised(
    model: FactorModel, groups: Mapping[str, Array], guides: Sequence[Mapping[str, Array]], denoiser: Callable
) -> dict[str, Array]:
    """Light groups (height, width, p) without their noise: every pass by itself, then held to the picture of them all.

    What a denoiser leaves of the noise of passes is partly the same, for it goes by what it sees: so each sees another
    mirror image. A pass has a part of the samples, and where these are too few all are denoised alike badly: so half
    of what the picture in daylight, denoised as one, differs by goes back to the passes, by the least change that
    gives it.
    denoiser(picture, guides) -> picture, (height, width, 3) without negative numbers. guides: of each pass, {} or some
    of "Albedo" and "Normal", (height, width, 3).
    """
    if len(guides) < 2:
        return {name: _clean(values, guides[0], denoiser) for name, values in groups.items()}
    together, to_passes = to_picture(model)
    joint = _joint(guides, together)
    found = {}
    for name, values in groups.items():
        passes = [
            _clean(values[..., 3 * k : 3 * k + 3], guide, denoiser, mirrored(k)) for k, guide in enumerate(guides)
        ]
        apart = np.concatenate(passes, axis=-1)
        picture = _clean(values @ together.T, joint, denoiser)
        found[name] = apart + np.float32(SHARE) * ((picture - apart @ together.T) @ to_passes.T)
    return found


def mirrored(index: int) -> tuple[bool, bool]:
    """Whether a pass is denoised left for right, and upside down."""
    return index % 4 != 1, index % 4 in (1, 2)


def to_picture(model: FactorModel) -> tuple[Array, Array]:
    """(3, p) coefficients to a picture in daylight, and (p, 3), by which the least coefficients give a picture."""
    matrix = xyz_to_rgb(_SPACE) @ relight_matrix(model, library.illuminant("D65"))
    return matrix.astype(np.float32), np.linalg.pinv(matrix).astype(np.float32)


def _joint(guides: Sequence[Mapping[str, Array]], together: Array) -> dict[str, Array]:
    """What guides the denoiser of the picture of all passes."""
    found = {}
    if "Albedo" in guides[0]:
        every = np.concatenate([guide["Albedo"] for guide in guides], axis=-1)[..., : together.shape[1]]
        found["Albedo"] = np.clip(every @ together.T, 0.0, 1.0)
    if "Normal" in guides[0]:
        found["Normal"] = np.mean([guide["Normal"] for guide in guides], axis=0)
    return found


def _clean(
    values: Array, guides: Mapping[str, Array], denoiser: Callable, mirror: tuple[bool, bool] = (False, False)
) -> Array:
    """(height, width, 1 to 3) without noise; negative numbers, which the denoiser does not know, stay."""
    count = values.shape[-1]
    filled = values[..., np.minimum(range(3), count - 1)]
    seen = {name: _turned(guide, mirror) for name, guide in guides.items()}
    clean = _turned(denoiser(_turned(np.maximum(filled, 0.0), mirror), seen), mirror)
    return (clean + np.minimum(filled, 0.0))[..., :count]


def _turned(picture: Array, mirror: tuple[bool, bool]) -> Array:
    return np.ascontiguousarray(picture[:: -1 if mirror[1] else 1, :: -1 if mirror[0] else 1])
