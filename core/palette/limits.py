"""What becomes of spectra that nothing real has: below 0, or reflectances above 1."""

import numpy as np

__all__ = ["beyond"]


def beyond(spectrum):
    """What happens to a reflectance or a light outside its range, in one sentence; "" for one inside."""
    is_light = spectrum.kind == "illuminant"
    low, high = float(spectrum.values.min()), float(spectrum.values.max())
    name = spectrum.name or ("the light" if is_light else "the reflectance")
    if low < 0.0:
        words = f"{name!r} is {low:.2g} at {spectrum.wavelengths[np.argmin(spectrum.values)]:g} nm"
        if is_light:
            return f"{words}, and no lamp shines with less than nothing: design it within bounds"
        return f"{words}, and no surface reflects less than nothing: coefficients below 0 render as 0"
    if high > 1.0 and not is_light:
        words = f"{name!r} is {high:.2f} at {spectrum.wavelengths[np.argmax(spectrum.values)]:g} nm"
        return f"{words}, more than falls on it: where light bounces often it grows with every bounce"
    return ""
