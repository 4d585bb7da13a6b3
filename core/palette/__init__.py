"""Designing spectra: lights and materials that make the colours asked for, together.

`design` says what is wanted, `criteria` makes equations of it, `solve` finds the spectra, `report` says how near they
come, and `tables` reads and writes designs.

[BMD] S. Bergner, T. Moller, M. S. Drew, "A spectral engine for visualization", SFU-CMPT-TR2004-06.
"""

from ..errors import PaletteError
from ..metamers import metamer, metameric_black, metamers
from .command import main
from .design import Cell, Constancy, Criteria, Difference, Entry, FreeColour, Palette
from .report import Report, report
from .solve import Solution, create
from .tables import from_dict, read, to_dict

__all__ = [
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
    "create",
    "from_dict",
    "main",
    "metamer",
    "metameric_black",
    "metamers",
    "read",
    "report",
    "to_dict",
]
