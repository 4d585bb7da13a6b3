"""What shines in a row of the mixer, of what the row says, as a Spectrum."""

import json
from functools import lru_cache

from ...core.picture import mixing
from ...core.spectra import library
from ...core.spectra.spectrum import Spectrum, SpectrumError

__all__ = ["part_spectrum", "spectrum_of", "stored_spectrum"]


@lru_cache(maxsize=256)
def stored_spectrum(text: str) -> Spectrum:
    """The Spectrum that a property holds as JSON. Raises SpectrumError."""
    if not text:
        raise SpectrumError("no file has been read yet: choose one")
    return Spectrum.from_dict(json.loads(text))


def part_spectrum(name: str, measured: str = "") -> Spectrum:
    """The spectrum of a part of a blend: its own where it has one, as JSON, or that of a name."""
    return stored_spectrum(measured) if measured else library.illuminant(name)


def spectrum_of(said: dict) -> Spectrum:
    """The Spectrum that a row, as `choice` gives it, stands for. Raises LibraryError, SpectrumError."""
    return mixing.tinted(_lamp_of(said), tuple(said["tint"]))


def _lamp_of(said: dict) -> Spectrum:
    """What shines behind the gel."""
    if said["source"] == "FILE":
        return stored_spectrum(said["measured"])
    if said["source"] == "BLEND":
        parts = said["blend"]
        return mixing.blend(tuple((part_spectrum(name, *measured), weight) for name, weight, *measured in parts))
    named = {"PLANCKIAN": f"Planckian {said['temperature']:.0f} K", "DAYLIGHT": f"D {said['cct']:.0f} K"}
    return library.illuminant(named.get(said["source"], said["illuminant"]))
