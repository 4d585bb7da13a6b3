"""Media that absorb: the absorption of each channel that is right at a depth, in place of the mean.

Behind a channel light is the mean of exponentials, and a renderer has the exponential of one number. With the mean
absorption that number is right for thin layers only; here it is so where the medium has its colour.
"""

import numpy as np

from ..spectra.arrays import Array
from ..spectra.spectrum import Spectrum
from .factor_model import FactorModel

__all__ = ["DEPTH", "depth_for", "tint"]

DEPTH = 3.0  # optical depth where a medium is black at which its colour is right unless said otherwise
_STEPS = (1.0, 2.0, DEPTH, 5.0)  # beyond the last, what is thin in a picture loses more than what is thick gains


def tint(model: FactorModel, colour: Spectrum, depth: float = DEPTH) -> Array:
    """Coefficients (p,) of a medium that absorbs 1 less its `colour`: behind `depth` times that, each channel is right.

    >>> from relume.core import bases
    >>> tint(bases.fitted(6), Spectrum([400, 700], [0.5, 0.5])).round(6)
    array([0.5, 0.5, 0.5, 0.5, 0.5, 0.5])
    """
    through = np.exp(-depth * (1 - colour.sampled(model.wavelengths)))
    return 1 + np.log(np.maximum(through @ model.filters, 1e-30)) / depth


def depth_for(mean: float) -> float:
    """The depth at which the colour of a medium should be right that is `mean` deep on an average way through it.

    Half of it, in a few steps: what is deeper is darker, and no picture has one depth alone.

    >>> depth_for(0.1), depth_for(4.0), depth_for(50.0)
    (1.0, 2.0, 5.0)
    """
    return min(_STEPS, key=lambda step: abs(step - mean / 2))
