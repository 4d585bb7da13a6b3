"""What becomes of spectra that nothing real has: below 0, or reflectances above 1."""

import numpy as np

from ..spectra.spectrum import Spectrum

__all__ = ["beyond"]


def beyond(spectrum: Spectrum, shines: bool = False) -> str:
    """What happens to a reflectance or a light outside its range, in one sentence; "" for one inside.

    shines: whether it is what a surface or a volume emits. What shines is added up, never multiplied by itself, and is
    carried with its sign; what reflects is not.
    """
    low, high = float(spectrum.values.min()), float(spectrum.values.max())
    is_light = spectrum.kind == "illuminant"
    name = spectrum.name or ("the light" if is_light else "the reflectance")
    if low < 0.0:
        words = f"{name!r} is {low:.2g} at {spectrum.wavelengths[np.argmin(spectrum.values)]:g} nm"
        if is_light:
            return f"{words}, as no lamp is: the picture is right, the viewport shows at least 0"
        if shines:
            return f"{words}, as nothing is that shines: the picture takes that part of the light away"
        return f"{words}, and no surface reflects less than nothing: coefficients below 0 render as 0"
    if high > 1.0 and not (is_light or shines):
        words = f"{name!r} is {high:.2f} at {spectrum.wavelengths[np.argmax(spectrum.values)]:g} nm"
        return f"{words}, more than falls on it: where light bounces often it grows with every bounce"
    return ""
