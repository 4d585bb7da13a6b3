"""From coefficients to a picture: the matrices that a scene carries.

Everything a Blender scene needs to show a factor model is a handful of small matrices, and they are all made here:

- `recombination_matrices`: one 3×p matrix per light group, coefficients to working-space RGB;
- `coefficient_pass`: what the view layer of one coefficient pass holds;
- `preview`: what the artist's own view layer holds, so that the viewport shows the chosen illuminant.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..colour.spaces import REC709, adaptation, rgb_to_xyz, xyz_to_rgb
from ..errors import ModelError
from ..model.factor_model import FactorModel
from ..model.upsample import rgb_matrix
from ..spectra import library
from ..spectra.arrays import Array, ArrayLike
from ..spectra.library import OBSERVER
from ..spectra.spectrum import Spectrum
from .mix import Mix

__all__ = [
    "ViewLayerNumbers",
    "coefficient_pass",
    "color_of",
    "for_passes",
    "mixed_white",
    "observer_to_xyz",
    "preview",
    "recombination_matrices",
    "relight_matrix",
]

# Below this part of the largest channel a light is taken to have none of that primary: under a sodium lamp the blue of
# a display is negative, and a preview colour divided by it would mean nothing.
_NO_PRIMARY = 0.02


@dataclass(frozen=True)
class ViewLayerNumbers:
    """What a view layer holds for the shaders: the colour of coefficients c is `spectrum @ c`, that of an RGB input
    is `rgb @ colour`, and a lamp of light group g is coloured `lights[g]`.

    spectrum: (3, p), rgb: (3, 3), lights: (groups, 3).
    """

    spectrum: Array
    rgb: Array
    lights: Array


@lru_cache(maxsize=16)
def observer_to_xyz(observer: str | tuple[Spectrum, ...] = OBSERVER) -> Array:
    """(3, 3) from what an observer or camera sees to the XYZ that a display is made for.

    observer: a name that `library.sensitivities` knows, or three Spectrum. The matrix of least squares over the CES
    reflectances in daylight (as a camera's input transform), exact for white. Raises LibraryError.
    """
    if observer == OBSERVER:
        return np.eye(3)
    seen = library.sensitivities(observer) if isinstance(observer, str) else _sampled_sensitivities(observer)
    daylight = library.illuminant("D65").sampled()
    samples = np.stack([spectrum.sampled() for spectrum in library.reflectances("ces")])
    sources, targets = (samples @ _normalised(daylight[:, None] * cmfs) for cmfs in (seen, library.observer()))
    white, wanted = (_normalised(daylight[:, None] * cmfs).sum(axis=0) for cmfs in (seen, library.observer()))
    # Every matrix that is exact for white is one of them plus rows at right angles to it
    exact = np.outer(wanted, white) / (white @ white)
    free = np.linalg.svd(white[None])[2][1:].T
    return exact + np.linalg.lstsq(sources @ free, targets - sources @ exact.T, rcond=None)[0].T @ free.T


def _sampled_sensitivities(observer: Sequence[Spectrum]) -> Array:
    return np.stack([one.sampled() for one in observer], axis=1)


def _normalised(weights: Array) -> Array:
    return weights / weights[:, 1].sum()


@lru_cache(maxsize=4096)
def relight_matrix(model: FactorModel, illuminant: Spectrum, observer: str | tuple[Spectrum, ...] = OBSERVER) -> Array:
    """(3, p), read-only: coefficients to the XYZ of a display, as `observer` sees them under `illuminant`.

    The last ones are kept: a mixer asks for the same lights again and again. Raises as `FactorModel.relight` does.
    """
    matrix = observer_to_xyz(observer) @ model.relight(illuminant, observer)
    matrix.setflags(write=False)
    return matrix


def mixed_white(model: FactorModel, mix: Mix) -> Array:
    """(3,) XYZ, Y = 1, of a perfect white lit by all the lights; D65 where every light is off."""
    white = np.zeros(3)
    for light in mix.lights.values():
        if light.gain > 0.0:
            white += light.gain * relight_matrix(model, light.illuminant, mix.observer).sum(axis=1)
    return white / white[1] if white[1] > 0.0 else rgb_to_xyz().sum(axis=1)


def color_of(model: FactorModel, mix: Mix, coefficients: Sequence[ArrayLike]) -> Array:
    """(..., 3) XYZ of coefficients (groups, ..., p) under the lights of their groups, before white balance."""
    lights = mix.lights.values()
    matrices = [light.gain * relight_matrix(model, light.illuminant, mix.observer) for light in lights]
    return np.sum([np.asarray(each) @ matrix.T for each, matrix in zip(coefficients, matrices, strict=True)], axis=0)


def _balanced(model: FactorModel, mix: Mix) -> Array:
    """(3, 3) XYZ to the working space, with the mix's white balanced to D65."""
    to_rgb = xyz_to_rgb(mix.space)
    display_white = np.linalg.inv(to_rgb).sum(axis=1)
    if mix.white_balance == 0.0:
        return to_rgb
    white = mixed_white(model, mix) if mix.white is None else np.asarray(mix.white)
    if not white[1] > 0.0:
        raise ModelError("white balance: what is to be white is dark; pick another pixel or group")
    return to_rgb @ adaptation(white, display_white, mix.white_balance, mix.method)


def recombination_matrices(model: FactorModel, mix: Mix) -> Array:
    """(groups, 3, p) matrices: the picture is the sum over light groups of `matrix @ coefficients`.

    Gain, relight matrix, white balance and working space are folded together; nothing is clamped.

    >>> from relume.core import bases
    >>> from relume.core.picture.mix import Light
    >>> warm = Mix({"key": Light(library.illuminant("A"), gain=2.0)}, white_balance=1.0)
    >>> recombination_matrices(bases.fitted(9), warm).sum(axis=(0, 2)).round(6)  # of a white surface
    array([2., 2., 2.])
    """
    to_rgb = _balanced(model, mix)
    lights = mix.lights.values()
    return np.array([light.gain * (to_rgb @ relight_matrix(model, light.illuminant, mix.observer)) for light in lights])


def for_passes(matrices: Array) -> Array:
    """Matrices for the images a renderer gives, where the last light group is everything that no other group holds.

    The renderer's last image is then all light, the others included: each of the others' matrices has to make up for
    what the last one adds. (groups, 3, p) in and out.
    """
    return np.concatenate([matrices[:-1] - matrices[-1], matrices[-1:]])


def coefficient_pass(model: FactorModel, index: int, groups: int, space: str = REC709) -> ViewLayerNumbers:
    """What the view layer of coefficient pass `index` holds: channels 3·index to 3·index + 2 and white lamps.

    Where the model ends before the pass does, its last channel fills it: a renderer samples by all three.
    """
    channels = np.minimum(3 * index + np.arange(3), model.channels - 1)
    return ViewLayerNumbers(
        spectrum=np.eye(model.channels)[channels],
        rgb=rgb_matrix(model, space)[channels],
        lights=np.ones((groups, 3)),
    )


def preview(model: FactorModel, mix: Mix) -> ViewLayerNumbers:
    """What the artist's own view layer holds: colours prefiltered for the strongest light [WE section 2].

    A first bounce of the strongest light is exact to the model; other lights act as RGB colours.
    """
    matrices = recombination_matrices(model, mix)
    whites = matrices.sum(axis=2)  # (groups, 3): a perfect white under each light
    key = int(np.argmax([light.gain for light in mix.lights.values()]))
    lit = whites[key]
    shown = lit > _NO_PRIMARY * lit.max()
    spectrum = np.full((3, model.channels), 1.0 / model.channels)
    if lit.max() > 0.0:
        spectrum[shown] = matrices[key][shown] / lit[shown, None]
    rgb = spectrum @ rgb_matrix(model, mix.space)
    return ViewLayerNumbers(spectrum=spectrum, rgb=rgb, lights=np.maximum(whites, 0.0))
