"""Whose the data of the asset library are, and under which terms; docs/assets.md says where that was looked up.

colour-science is BSD-3-Clause as a package. Where no terms of those who measured were found, that is said in place of a
licence.
"""

from ..core.spectra import library

__all__ = ["CES", "CHART", "DATABASE", "DESIGNED", "GROUND", "MADE", "of_lamp"]

_SHIPPED = "shipped by colour-science (BSD-3-Clause); terms of {} were not found"

DATABASE = "CC0-1.0 (refractiveindex.info database)"
CES = _SHIPPED.format("the CIE, whose report 224:2017 they are of,")
CHART = "Copyright 2004-2012 Danny Pascale, BabelColor; in colour-science (BSD-3-Clause) by permission"
GROUND = "shipped by earthlib 1.1.0 (MIT); terms of those who measured were not found"
DESIGNED = "GPL-3.0-or-later (designed by Relume)"
MADE = "GPL-3.0-or-later (made by Relume)"
_FORMULA = "Planck's law", "CIE daylight", "line"


def of_lamp(illuminant: str) -> tuple[str, str]:
    """(source, terms) of an illuminant of the library."""
    spectrum = library.illuminant(illuminant)
    if spectrum.source in _FORMULA:
        return f"{illuminant}, {spectrum.source}", MADE
    if any(spectrum.name in names for names in library.cie_illuminants().values()):
        return f"{illuminant}, CIE 15:2018", _SHIPPED.format("the CIE")
    if spectrum.name == "Kinoton 75P":
        return f"{illuminant}, from T. Borer", "shipped by colour-science (BSD-3-Clause), after a private communication"
    return f"{illuminant}, NIST CQS simulation 7.4", _SHIPPED.format("NIST")
