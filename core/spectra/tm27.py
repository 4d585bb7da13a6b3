"""ANSI/IES TM-27: an XML file of one spectrum.

colour-science reads these too, but repeats, gaps and nested entities leave it with errors of Python's and without the
line; and to import it takes seconds.
"""

from xml.parsers import expat

import numpy as np

from ..errors import SpectrumError
from .columns import number
from .measurement import Measurement

__all__ = ["measurement"]

_LONGEST = 100_000  # characters in one element
# What a file may say that it measured -> the kinds of Spectrum that it can be read as
_QUANTITIES = {
    "flux": ("illuminant",),
    "intensity": ("illuminant",),
    "irradiance": ("illuminant",),
    "radiance": ("illuminant",),
    "exitance": ("illuminant",),
    "reflectance": ("reflectance",),
    "transmittance": ("reflectance",),
    "r-values": ("reflectance",),
    "t-values": ("reflectance",),
}


def measurement(data: bytes, name: str, kind: str) -> Measurement:
    """The spectrum in a file's bytes. It is called by its description, else `name`.

    Raises SpectrumError, with the line; also for a quantity that is not of `kind`.
    """
    path, lines, samples, words = [], [], [], {}

    def start(tag, attributes):
        path.append(tag.rpartition(":")[2])
        words[path[-1]] = ""
        if len(path) == 1 and not path[0].upper().startswith("IESTM27"):
            raise SpectrumError(f"is not a TM-27 spectrum: it begins with <{path[0][:40]}>")
        if path[-1] == "SpectralData":
            lines.append(parser.CurrentLineNumber)
            samples.append([attributes.get("wavelength", "")])

    def text(characters):
        words[path[-1]] += characters
        if len(words[path[-1]]) > _LONGEST:
            raise SpectrumError(f"line {parser.CurrentLineNumber}: <{path[-1][:40]}> holds more than a spectrum's text")

    def end(_):
        if path[-1] == "SpectralData":
            samples[-1].append(words["SpectralData"])
        path.pop()

    def document_type(*_):
        raise SpectrumError(f"line {parser.CurrentLineNumber}: has a document type, which TM-27 has not")

    parser = expat.ParserCreate()
    parser.buffer_text = True
    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler = text
    parser.StartDoctypeDeclHandler = document_type  # no entities either: they can be made to fill the memory
    try:
        parser.Parse(data, True)
    except SpectrumError:
        raise
    except (expat.ExpatError, ValueError, LookupError) as error:
        line = getattr(error, "lineno", parser.CurrentLineNumber)
        raise SpectrumError(f"line {line}: not well-formed XML: {error}") from None
    if not samples:
        raise SpectrumError("is not a TM-27 spectrum: it has no SpectralData")
    quantity = words.get("SpectralQuantity", "").strip()
    if kind not in _QUANTITIES.get(quantity.lower(), (kind,)):
        raise SpectrumError(f"holds {quantity}, where {kind} was expected")
    values = np.empty((len(samples), 2))
    for row, (line, pair) in enumerate(zip(lines, samples, strict=True)):
        for column, (cell, what) in enumerate(zip(pair, ("wavelength", "value"), strict=True)):
            found = number(cell.strip())
            if found is None:
                raise SpectrumError(f"line {line}: the {what} {cell.strip()[:40]!r} is not a number")
            values[row, column] = found
    description = words.get("Description", "").strip()
    return Measurement(np.array(lines), values[:, 0], values[:, 1:], [description or name])
