"""From XYZ to a picture: working space, white balance, and the matrices a scene carries.

Everything a Blender scene needs to show a factor model is a handful of small matrices, and they are all made here:

- `recombination_matrices`: one 3×p matrix per light group, coefficients to working-space RGB;
- `coefficient_pass`: what the view layer of one coefficient pass holds;
- `preview`: what the artist's own view layer holds, so that the viewport shows the chosen illuminant.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from . import library
from .errors import ModelError, UsageError
from .factor_model import FactorModel
from .spectrum import WAVELENGTHS, Spectrum
from .upsample import rgb_matrix, rgb_to_xyz

__all__ = [
    "ADAPTATIONS",
    "GAINS",
    "OBSERVER",
    "Light",
    "ViewLayerNumbers",
    "adaptation",
    "coefficient_pass",
    "color_of",
    "daylight_rgb",
    "display_primaries",
    "for_passes",
    "mixed_white",
    "observer_to_xyz",
    "preview",
    "recombination_matrices",
    "relight_matrix",
    "sharp_rgb",
    "srgb_encoded",
    "xyz_to_rgb",
]

ADAPTATIONS = {
    # XYZ to the cone-like space in which white balance is a diagonal
    "bradford": np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]]),
    # Sharp: [WE] section 2.1, after Finlayson & Süsstrunk, "Performance of a chromatic adaptation transform based on
    # spectral sharpening", CIC 8 (2000)
    "sharp": np.array([[1.2694, -0.0988, -0.1706], [-0.8364, 1.8006, 0.0357], [0.0297, -0.0315, 1.0018]]),
}

OBSERVER = "CIE 1931 2°"  # whose XYZ a display is made for

GAINS = (0.0, 1e6)

# Below this part of the largest channel a light is taken to have none of that primary: under a sodium lamp the blue of
# a display is negative, and a preview colour divided by it would mean nothing.
_NO_PRIMARY = 0.02


@dataclass(frozen=True)
class Light:
    """What shines in one light group: an illuminant and a gain (1 keeps the luminance the artist lit with).

    Raises UsageError for a gain outside `GAINS`.
    """

    illuminant: Spectrum
    gain: float = 1.0

    def __post_init__(self):
        if not GAINS[0] <= self.gain <= GAINS[1]:  # nan is in no range
            raise UsageError(f"gain {self.gain:g} is not a number from {GAINS[0]:g} to {GAINS[1]:.0f}")


@dataclass(frozen=True)
class ViewLayerNumbers:
    """What a view layer holds for the shaders: the colour of coefficients c is `spectrum @ c`, that of an RGB input
    is `rgb @ colour`, and a lamp of light group g is coloured `lights[g]`.

    spectrum: (3, p), rgb: (3, 3), lights: (groups, 3).
    """

    spectrum: np.ndarray
    rgb: np.ndarray
    lights: np.ndarray


def xyz_to_rgb(space: str = "Linear Rec.709") -> np.ndarray:
    """(3, 3) matrix from XYZ (D65 white of Y = 1 gives 1, 1, 1) to a working space of Blender."""
    return np.linalg.inv(rgb_to_xyz(space))


def sharp_rgb() -> np.ndarray:
    """(3, 3) matrix from XYZ to Sharp RGB, scaled so that the equal-energy white gives 1, 1, 1 [WE]."""
    matrix = ADAPTATIONS["sharp"]
    return matrix / matrix.sum(axis=1, keepdims=True)


def adaptation(source, target, degree: float = 1.0, method: str = "bradford") -> np.ndarray:
    """(3, 3) chromatic adaptation in XYZ from the white `source` (3,) to `target` (3,), both of any luminance.

    `degree` is 0 for none, 1 for complete; between the two the white is moved in proportion (CIECAM02's D).
    Luminance of the white is kept. Raises ModelError for a white that the method cannot balance (a cone response of
    zero or less), for a degree outside 0..1 and for an unknown method.
    """
    if method not in ADAPTATIONS:
        raise ModelError(f"unknown white balance method {method!r}: expected one of {', '.join(ADAPTATIONS)}")
    if not 0.0 <= degree <= 1.0:
        raise ModelError(f"degree of white balance is {degree}: expected 0 (none) to 1 (complete)")
    if degree == 0.0:
        return np.eye(3)
    cone = ADAPTATIONS[method]
    source, target = np.asarray(source, float), np.asarray(target, float)
    from_white, to_white = cone @ (source / source[1]), cone @ (target / target[1])
    if np.any(from_white <= 0.0):
        raise ModelError("white balance: this light has no response in one of the eye's channels; use less than full")
    gains = degree * to_white / from_white + (1.0 - degree)
    matrix = np.linalg.inv(cone) @ np.diag(gains) @ cone
    return matrix / (matrix @ source)[1] * source[1]


@lru_cache(maxsize=16)
def observer_to_xyz(observer=OBSERVER) -> np.ndarray:
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


def _sampled_sensitivities(observer) -> np.ndarray:
    return np.stack([one.sampled() for one in observer], axis=1)


def _normalised(weights: np.ndarray) -> np.ndarray:
    return weights / weights[:, 1].sum()


@lru_cache(maxsize=4096)
def relight_matrix(model: FactorModel, illuminant: Spectrum, observer=OBSERVER) -> np.ndarray:
    """(3, p), read-only: coefficients to the XYZ of a display, as `observer` sees them under `illuminant`.

    The last ones are kept: a mixer asks for the same lights again and again. Raises as `FactorModel.relight` does.
    """
    matrix = observer_to_xyz(observer) @ model.relight(illuminant, observer)
    matrix.setflags(write=False)
    return matrix


def mixed_white(lights: Sequence[Light], model: FactorModel, observer=OBSERVER) -> np.ndarray:
    """(3,) XYZ, Y = 1, of a perfect white lit by all the lights; D65 where every light is off."""
    white = np.zeros(3)
    for light in lights:
        if light.gain > 0.0:
            white += light.gain * relight_matrix(model, light.illuminant, observer).sum(axis=1)
    return white / white[1] if white[1] > 0.0 else rgb_to_xyz("Linear Rec.709").sum(axis=1)


def color_of(coefficients, model: FactorModel, lights: Sequence[Light], observer=OBSERVER) -> np.ndarray:
    """(..., 3) XYZ of coefficients (groups, ..., p) under the lights of their groups, before white balance."""
    matrices = [light.gain * relight_matrix(model, light.illuminant, observer) for light in lights]
    return sum(np.asarray(each) @ matrix.T for each, matrix in zip(coefficients, matrices, strict=True))


def _balanced(lights: Sequence[Light], model, degree: float, method: str, space: str, white, observer) -> np.ndarray:
    """(3, 3) XYZ to the working space, with `white`, or else the white of the mix, balanced to D65."""
    to_rgb = xyz_to_rgb(space)
    display_white = np.linalg.inv(to_rgb).sum(axis=1)
    if degree == 0.0:
        return to_rgb
    if white is None:
        white = mixed_white(lights, model, observer)
    if not np.asarray(white)[1] > 0.0:
        raise ModelError("white balance: what is to be white is dark; pick another pixel or group")
    return to_rgb @ adaptation(white, display_white, degree, method)


def recombination_matrices(
    model: FactorModel,
    lights: Sequence[Light],
    *,
    white_balance: float = 0.0,
    method: str = "bradford",
    space: str = "Linear Rec.709",
    white=None,
    observer=OBSERVER,
) -> np.ndarray:
    """(groups, 3, p) matrices: the picture is the sum over light groups of `matrix @ coefficients`.

    Gain, relight matrix, white balance and working space are folded together; nothing is clamped. white: XYZ (3,), of
    any luminance, of what becomes white; that of the mix if none is given. observer: see `FactorModel.relight`.
    """
    to_rgb = _balanced(lights, model, white_balance, method, space, white, observer)
    return np.array([light.gain * (to_rgb @ relight_matrix(model, light.illuminant, observer)) for light in lights])


def for_passes(matrices: np.ndarray) -> np.ndarray:
    """Matrices for the images a renderer gives, where the last light group is everything that no other group holds.

    The renderer's last image is then all light, the others included: each of the others' matrices has to make up for
    what the last one adds. (groups, 3, p) in and out.
    """
    return np.concatenate([matrices[:-1] - matrices[-1], matrices[-1:]])


def coefficient_pass(model: FactorModel, index: int, groups: int, space: str = "Linear Rec.709") -> ViewLayerNumbers:
    """What the view layer of coefficient pass `index` holds: channels 3·index to 3·index + 2 and white lamps.

    Where the model ends before the pass does, its last channel fills it: a renderer samples by all three.
    """
    channels = np.minimum(3 * index + np.arange(3), model.channels - 1)
    return ViewLayerNumbers(
        spectrum=np.eye(model.channels)[channels],
        rgb=rgb_matrix(model, space)[channels],
        lights=np.ones((groups, 3)),
    )


def preview(
    model: FactorModel,
    lights: Sequence[Light],
    *,
    white_balance: float = 0.0,
    method: str = "bradford",
    space: str = "Linear Rec.709",
    white=None,
    observer=OBSERVER,
) -> ViewLayerNumbers:
    """What the artist's own view layer holds: colours prefiltered for the strongest light [WE section 2].

    A first bounce of the strongest light is exact to the model; other lights act as RGB colours. Takes what
    `recombination_matrices` takes.
    """
    matrices = recombination_matrices(
        model, lights, white_balance=white_balance, method=method, space=space, white=white, observer=observer
    )
    whites = matrices.sum(axis=2)  # (groups, 3): a perfect white under each light
    key = int(np.argmax([light.gain for light in lights]))
    lit = whites[key]
    shown = lit > _NO_PRIMARY * lit.max()
    spectrum = np.full((3, model.channels), 1.0 / model.channels)
    if lit.max() > 0.0:
        spectrum[shown] = matrices[key][shown] / lit[shown, None]
    return ViewLayerNumbers(spectrum=spectrum, rgb=spectrum @ rgb_matrix(model, space), lights=np.maximum(whites, 0.0))


def daylight_rgb(reflectance: Spectrum, space: str = "Linear Rec.709") -> np.ndarray:
    """(3,) colour 0..1 of a reflectance in D65, for a scene that knows no spectra; clipped to the gamut of `space`."""
    cmfs, daylight = library.observer(), library.illuminant("D65").sampled(WAVELENGTHS)
    xyz = (reflectance.sampled(WAVELENGTHS) * daylight) @ cmfs / (daylight @ cmfs[:, 1])
    return np.clip(xyz_to_rgb(space) @ xyz, 0.0, 1.0)


def display_primaries(spectrum: Spectrum) -> np.ndarray:
    """(3,) values of a spectrum at 630, 532 and 467 nm, the primaries of Rec.2020: n and k for an RGB renderer."""
    return spectrum.sampled(np.array([467.0, 532.0, 630.0]))[::-1]


def srgb_encoded(rgb: np.ndarray) -> np.ndarray:
    """Linear Rec.709 of any shape to sRGB 0..1 (IEC 61966-2-1), clipped to the display's gamut."""
    rgb = np.clip(rgb, 0.0, 1.0)
    return np.where(rgb <= 0.0031308, 12.92 * rgb, 1.055 * np.power(rgb, 1 / 2.4) - 0.055)
