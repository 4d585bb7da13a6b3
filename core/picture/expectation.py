"""How far the colours of a picture are expected to be from full spectra, for the mix that is chosen now.

Pixels are drawn from what the scene shows (`pixels`) and held against their spectra under the very lights of the mix.
They are kept from one mix to the next: a change costs a relight matrix and the comparison of some hundred colours.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..errors import MeasureError
from ..model import bases
from ..model.factor_model import FactorModel
from ..spectra import library
from ..spectra.arrays import Array
from ..spectra.library import OBSERVER
from ..spectra.spectrum import Spectrum
from .content import Content, general
from .mix import Light, Mix
from .pixels import Pixels, difference
from .plan import CHANNELS

__all__ = ["GREEN", "LEVELS", "YELLOW", "Expectation", "advice", "expected", "expected_of", "level", "words"]

DRAWN = 700
GREEN, YELLOW = 0.5, 2.0  # CIEDE2000 at the 98th percentile below which a level is left
LEVELS = ("green", "yellow", "red")


@dataclass(frozen=True)
class Expectation:
    """CIEDE2000 to full spectra, median and 98th percentile over a picture."""

    median: float
    p98: float

    @property
    def level(self) -> str:
        """One of LEVELS."""
        return level(self.p98)


def level(p98: float) -> str:
    """ "green" where nobody sees a difference, "yellow" where they stand side by side, "red" where anybody does.

    >>> level(0.3), level(1.0), level(5.0)
    ('green', 'yellow', 'red')
    """
    return LEVELS[int(p98 >= GREEN) + int(p98 >= YELLOW)]


def expected(model: FactorModel, content: Content | None, mix: Mix) -> Expectation:
    """What is expected of a whole mix. content: what the scene shows; None where that is not known.

    Groups that are off do not count; where all are, nothing is expected to differ. Raises SpectrumError, LibraryError,
    MeasureError.
    """
    lights = [light for light in mix.lights.values() if light.gain > 0]
    if not lights:
        return Expectation(0.0, 0.0)
    found, true, white = np.zeros((DRAWN, 3)), np.zeros((DRAWN, 3)), np.zeros(3)
    shares = _drawn(_surfaces(content)).mixture(len(lights))
    for number, light in enumerate(lights):
        share = light.gain * shares[:, number, None]
        own, full, light_white = _seen(model, _surfaces(content), light.illuminant, mix.observer)
        found, true, white = found + share * own, true + share * full, white + light.gain * light_white
    return _summary(found, true, white)


def expected_of(
    model: FactorModel, content: Content | None, light: Light, observer: str | tuple[Spectrum, ...] = OBSERVER
) -> Expectation:
    """The same for one light alone, whatever its gain."""
    return _summary(*_seen(model, _surfaces(content), light.illuminant, observer))


def words(expectation: Expectation, content: Content | None) -> str:
    """An expectation as a line of text.

    >>> words(Expectation(0.1234, 1.234), None)
    'ΔE 0.12 expected, 1.23 at the 98th percentile (of surfaces in general: the file does not say what it shows)'
    """
    known = "" if content is not None else " (of surfaces in general: the file does not say what it shows)"
    return f"ΔE {expectation.median:.2f} expected, {expectation.p98:.2f} at the 98th percentile{known}"


def advice(model: FactorModel, content: Content | None, mix: Mix) -> str:
    """What would help a mix whose level is not green: the fewest channels that are yellow or green, and their error.

    Empty where nothing needs help, or nothing helps. Takes up to a second: it is for who asks.
    """
    now = expected(model, content, mix)
    if now.level == "green" or model.is_reference:
        return ""
    aim = GREEN if now.level == "yellow" else YELLOW
    best = None
    for channels in (each for each in CHANNELS if each > model.channels):
        error = expected(bases.fitted(channels), content, mix).p98
        if best is None or error < best[1]:
            best = channels, error
        if error < min(aim, 0.7 * now.p98):
            break
    if best is None or best[1] > 0.8 * now.p98:
        exact = expected(bases.bands(81), content, mix).p98
        return f"Exact, 27 passes: {exact:.1f}" if exact < 0.8 * now.p98 else ""
    return f"{best[0]} channels: {best[1]:.1f}"


@lru_cache(maxsize=1)
def _anything() -> Content:
    return general([library.illuminant("D65")])


def _surfaces(content: Content | None) -> Content:
    return _anything() if content is None else content


@lru_cache(maxsize=8)
def _drawn(content: Content) -> Pixels:
    return Pixels(content, DRAWN)


@lru_cache(maxsize=32)
def _coefficients(model: FactorModel, content: Content) -> Array:
    return _drawn(content).coefficients(model)


@lru_cache(maxsize=512)
def _seen(
    model: FactorModel, content: Content, light: Spectrum, observer: str | tuple[Spectrum, ...]
) -> tuple[Array, Array, Array]:
    """XYZ (DRAWN, 3) by the model and in truth under a light of gain 1, and that of a perfect white (3,)."""
    matrix = model.relight(light, observer)
    true = _drawn(content).true_xyz(light, observer)
    return _coefficients(model, content) @ matrix.T, true, matrix.sum(axis=1)


def _summary(found: Array, true: Array, white: Array) -> Expectation:
    """Raises MeasureError where there is nothing to be seen, or more than numbers can say."""
    with np.errstate(all="ignore"):
        median, p98 = np.percentile(difference(found, true, white), (50, 98))
    if not np.isfinite(p98):
        raise MeasureError("what the picture is expected to be is no finite number")
    return Expectation(float(median), float(p98))
