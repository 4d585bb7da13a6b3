"""Designing spectra: lights and materials that make the colours asked for, together.

`design` says what is wanted, `criteria` makes equations of it, `solve` finds the spectra, `report` says how near they
come, and `tables` reads and writes designs.

[BMD] S. Bergner, T. Moller, M. S. Drew, "A spectral engine for visualization", SFU-CMPT-TR2004-06.
"""

from ..errors import PaletteError
from .colours import normalised, scene_from_xyz, scene_linear, srgb_from_xyz, xyz_from_scene
from .design import Cell, Constancy, Criteria, Difference, Entry, FreeColour, Palette, scaled
from .limits import beyond
from .metamers import metamer, metameric_black, metamers
from .report import Report, matrix_colours, matrix_xyz, patches, report
from .solve import Solution, create
from .tables import from_dict, read, to_dict, upsampled
from .trial import HATCHED, Trial, Worn, coefficients_under, hatched, trial
from .tryon import TriedOn, try_on

__all__ = [
    "HATCHED",
    "Cell",
    "Constancy",
    "Criteria",
    "Difference",
    "Entry",
    "FreeColour",
    "Palette",
    "PaletteError",
    "Report",
    "Solution",
    "Trial",
    "TriedOn",
    "Worn",
    "beyond",
    "coefficients_under",
    "create",
    "from_dict",
    "hatched",
    "matrix_colours",
    "matrix_xyz",
    "metamer",
    "metameric_black",
    "metamers",
    "normalised",
    "patches",
    "read",
    "report",
    "scaled",
    "scene_from_xyz",
    "scene_linear",
    "srgb_from_xyz",
    "to_dict",
    "trial",
    "try_on",
    "upsampled",
    "xyz_from_scene",
]
