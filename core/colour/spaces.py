"""Colour spaces and white balance: every matrix and constant of them, once.

colour-science ships most of these, but takes a second to import: a test holds the numbers here against its own.
"""

from functools import cache

import numpy as np

from ..errors import ModelError
from ..spectra import library
from ..spectra.arrays import Array, ArrayLike
from ..spectra.spectrum import Spectrum

__all__ = [
    "ADAPTATIONS",
    "D65_WHITE",
    "REC709",
    "RGB_SPACES",
    "adaptation",
    "daylight_rgb",
    "display_primaries",
    "rgb_to_xyz",
    "srgb_decoded",
    "srgb_encoded",
    "xyz_to_rgb",
]

REC709 = "Linear Rec.709"  # the primaries of sRGB

# XYZ of D65 on the working grid. The spaces' own rounded xy, (0.3127, 0.3290), would leave white itself 0.02 CIEDE2000
# away from the light that it is seen under.
D65_WHITE = np.array([0.95042967, 1.0, 1.08880055])

# xy of red, green, blue, white. ACEScg is adapted from its own white to D65, as Blender's colour management does.
D65 = (0.3127, 0.3290)
RGB_SPACES = {
    REC709: ((0.64, 0.33), (0.30, 0.60), (0.15, 0.06), D65),
    "Linear Rec.2020": ((0.708, 0.292), (0.170, 0.797), (0.131, 0.046), D65),
    "ACEScg": ((0.713, 0.293), (0.165, 0.830), (0.128, 0.044), (0.32168, 0.33767)),
}
REC2020_WAVELENGTHS = (630.0, 532.0, 467.0)  # nm, of its primaries

ADAPTATIONS = {
    # XYZ to the cone-like space in which white balance is a diagonal
    "bradford": np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]]),
    # Sharp: [WE] section 2.1, after Finlayson & Süsstrunk, "Performance of a chromatic adaptation transform based on
    # spectral sharpening", CIC 8 (2000)
    "sharp": np.array([[1.2694, -0.0988, -0.1706], [-0.8364, 1.8006, 0.0357], [0.0297, -0.0315, 1.0018]]),
}


def _xyz(xy: tuple[float, float]) -> Array:
    x, y = xy
    return np.array([x / y, 1.0, (1 - x - y) / y])


@cache
def rgb_to_xyz(space: str = REC709) -> Array:
    """XYZ of the primaries, (3, 3), columns; RGB (1, 1, 1) is the XYZ of D65, Y = 1. Raises ModelError.

    >>> rgb_to_xyz().sum(axis=1).round(3)
    array([0.95 , 1.   , 1.089])
    """
    if space not in RGB_SPACES:
        raise ModelError(f"no RGB space {space!r}: choose {', '.join(RGB_SPACES)}")
    *primaries, white = RGB_SPACES[space]
    columns = np.stack([_xyz(xy) for xy in primaries], axis=1)
    if white != D65:
        cone = ADAPTATIONS["bradford"]
        matrix = columns * np.linalg.solve(columns, _xyz(white))
        gain = (cone @ D65_WHITE) / (cone @ _xyz(white))
        matrix = np.linalg.solve(cone, gain[:, None] * (cone @ matrix))
    else:
        matrix = columns * np.linalg.solve(columns, D65_WHITE)
    matrix.setflags(write=False)
    return matrix


def xyz_to_rgb(space: str = REC709) -> Array:
    """(3, 3) matrix from XYZ (D65 white of Y = 1 gives 1, 1, 1) to a working space of Blender. Raises ModelError."""
    return np.linalg.inv(rgb_to_xyz(space))


def adaptation(source: ArrayLike, target: ArrayLike, degree: float = 1.0, method: str = "bradford") -> Array:
    """(3, 3) chromatic adaptation in XYZ from the white `source` (3,) to `target` (3,), both of any luminance.

    `degree` is 0 for none, 1 for complete; between the two the white is moved in proportion (CIECAM02's D).
    Luminance of the white is kept. Raises ModelError for a white that the method cannot balance (a cone response of
    zero or less), for a degree outside 0..1 and for an unknown method.

    >>> warm = np.array([1.1, 1.0, 0.36])
    >>> np.allclose(adaptation(warm, D65_WHITE) @ warm, D65_WHITE)
    True
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
        raise ModelError(
            "white balance: this light lacks a colour altogether, as sodium lacks blue, and nothing makes it white; "
            "set white balance to 0, or take another white"
        )
    gains = degree * to_white / from_white + (1.0 - degree)
    matrix = np.linalg.inv(cone) @ np.diag(gains) @ cone
    return matrix / (matrix @ source)[1] * source[1]


def daylight_rgb(reflectance: Spectrum, space: str = REC709) -> Array:
    """(3,) colour 0..1 of a reflectance in D65, for a scene that knows no spectra; clipped to the gamut of `space`."""
    cmfs, daylight = library.observer(), library.illuminant("D65").sampled()
    xyz = (reflectance.sampled() * daylight) @ cmfs / (daylight @ cmfs[:, 1])
    return np.clip(xyz_to_rgb(space) @ xyz, 0.0, 1.0)


def display_primaries(spectrum: Spectrum) -> Array:
    """(3,) values of a spectrum at the primaries of Rec.2020, from red to blue: n and k for an RGB renderer."""
    return spectrum.sampled(np.array(REC2020_WAVELENGTHS[::-1]))[::-1]


def srgb_encoded(rgb: ArrayLike) -> Array:
    """Linear Rec.709 of any shape to sRGB 0..1 (IEC 61966-2-1), clipped to the display's gamut.

    >>> srgb_encoded([0.0, 0.18, 2.0]).round(3)
    array([0.   , 0.461, 1.   ])
    """
    rgb = np.clip(rgb, 0.0, 1.0)
    return np.where(rgb <= 0.0031308, 12.92 * rgb, 1.055 * np.power(rgb, 1 / 2.4) - 0.055)


def srgb_decoded(encoded: Array) -> Array:
    """The inverse of `srgb_encoded`, for 0..1."""
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
