"""A mix: all that decides what picture becomes of the coefficients of a render."""

from collections.abc import Mapping
from dataclasses import dataclass

from ..colour.spaces import REC709
from ..errors import UsageError
from ..spectra.library import OBSERVER
from ..spectra.spectrum import Spectrum

__all__ = ["GAINS", "Light", "Mix"]

GAINS = (0.0, 1e6)


@dataclass(frozen=True)
class Light:
    """What shines in one light group: an illuminant and a gain (1 keeps the luminance the artist lit with).

    Raises UsageError for a gain outside `GAINS`.
    """

    illuminant: Spectrum
    gain: float = 1.0

    def __post_init__(self) -> None:
        if not GAINS[0] <= self.gain <= GAINS[1]:  # nan is in no range
            raise UsageError(f"gain {self.gain:g} is not a number from {GAINS[0]:g} to {GAINS[1]:.0f}")


@dataclass(frozen=True)
class Mix:
    """A light for each light group, in the order of the groups, and how the sum of them is shown.

    white_balance: degree, 0 (none) to 1 (complete). method: one of `spaces.ADAPTATIONS`. space: working space of
    Blender. white: XYZ (3,), of any luminance, of what becomes white; that of the mix if None. observer: a name that
    `library.sensitivities` knows, or three Spectrum.
    """

    lights: Mapping[str, Light]
    white_balance: float = 0.0
    method: str = "bradford"
    space: str = REC709
    white: tuple[float, ...] | None = None
    observer: str | tuple[Spectrum, ...] = OBSERVER

    def __post_init__(self) -> None:
        object.__setattr__(self, "lights", dict(self.lights))
        if self.white is not None:
            object.__setattr__(self, "white", tuple(float(value) for value in self.white))
        if not isinstance(self.observer, str):
            object.__setattr__(self, "observer", tuple(self.observer))
