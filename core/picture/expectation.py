"""How far the colours of a picture are expected to be from full spectra, for the mix that is chosen now.

Pixels are drawn from what the scene shows (`pixels`) and held against their spectra under the very lights of the mix.
They are kept from one mix to the next: a change costs a relight matrix and the comparison of some hundred colours.
"""

from collections.abc import Generator
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from ..errors import MeasureError
from ..model import bases
from ..model.factor_model import FactorModel
from ..model.integration import FINE
from ..model.rules import Fitted
from ..spectra import library
from ..spectra.arrays import Array
from ..spectra.library import OBSERVER
from ..spectra.spectrum import Spectrum
from .content import Content, general
from .mix import Light, Mix
from .pixels import Pixels, difference, true_weights
from .plan import CHANNELS

__all__ = ["GREEN", "LEVELS", "YELLOW", "Expectation", "advising", "expected", "expected_of", "level", "words"]

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


def advising(model: FactorModel, content: Content | None, mix: Mix) -> Generator[None, None, str]:
    """What would help a mix whose level is not green, in words; works piece by piece, for who draws meanwhile.

    A light group of its own for what shines through a spectrum in that of others; else the fewest channels that are
    yellow or green, and their error. Empty where nothing needs help, or nothing helps.
    """
    yield from _prepared(model, content, mix)
    now = expected(model, content, mix)
    if now.level == "green" or model.is_reference:
        return ""
    aim = GREEN if now.level == "yellow" else YELLOW
    for name, group, spectrum in _surfaces(content).filtered:
        light = mix.lights.get(group)
        if light is not None and light.gain > 0:
            inside, own = _filtered(model, _lit(_surfaces(content)), light, spectrum, mix.observer)
            if inside >= aim and own < 0.7 * inside:
                return f"give {name} a light group of its own, of what it sends out: {own:.1f} in place of {inside:.1f}"
            yield
    best = None
    for channels in (each for each in CHANNELS if each > model.channels):
        finer = bases.fitted(channels)
        yield from _prepared(finer, content, mix)
        error = expected(finer, content, mix).p98
        if best is None or error < best[1]:
            best = channels, error
        if error < min(aim, 0.7 * now.p98):
            break
        yield
    if best is None or best[1] > 0.8 * now.p98:
        yield from _prepared(bases.bands(81), content, mix)
        exact = expected(bases.bands(81), content, mix).p98
        return f"Exact, 27 passes: {exact:.1f}" if exact < 0.8 * now.p98 else ""
    return f"{best[0]} channels: {best[1]:.1f}"


def _filtered(
    model: FactorModel, content: Content, light: Light, spectrum: Spectrum, observer: str | tuple[Spectrum, ...]
) -> tuple[float, float]:
    """98th percentiles in light that goes through a spectrum: as products of coefficients, and as a light by itself."""
    through = light.illuminant.sampled(FINE) * spectrum.sampled(FINE)
    if not through.max() > 0:
        return 0.0, 0.0
    sent = Spectrum(FINE, through, spectrum.name, "illuminant")
    matrix = model.relight(light.illuminant, observer)
    true = _drawn(content).true_xyz(sent, observer)
    white = true_weights(sent, observer).sum(axis=0)
    found = (_coefficients(model, content) * model.coefficients(spectrum)) @ matrix.T
    luminance = float(spectrum.sampled(FINE) @ true_weights(light.illuminant, observer)[:, 1])
    inside = _summary(found / max(luminance, 1e-12), true, white)
    return inside.p98, expected_of(model, content, Light(sent), observer).p98


def _prepared(model: FactorModel, content: Content | None, mix: Mix) -> Generator[None, None, None]:
    """Work out and keep what `expected` takes, light by light."""
    surfaces = _surfaces(content)
    _drawn(surfaces)
    yield
    for light in mix.lights.values():
        if light.gain > 0:
            _drawn(surfaces).true_xyz(light.illuminant, mix.observer)
            yield
            _ = model.training_coefficients if isinstance(model.rule, Fitted) else None
            yield
            _coefficients(model, surfaces)
            yield
            _seen(model, surfaces, light.illuminant, mix.observer)
            yield


@lru_cache(maxsize=1)
def _anything() -> Content:
    return general([library.illuminant("D65")])


def _surfaces(content: Content | None) -> Content:
    return _anything() if content is None else content


@lru_cache(maxsize=8)
def _lit(content: Content) -> Content:
    """What a scene shows, without the spectra that light goes through, which stand among its surfaces."""
    filters = {spectrum.name for _, _, spectrum in content.filtered}
    stays = [n for n, spectrum in enumerate(content.reflectances) if spectrum.name not in filters]
    kept = np.array([*stays, *range(len(content.reflectances), len(content.parts))], dtype=int)
    return replace(
        content,
        reflectances=[content.reflectances[n] for n in stays],
        shares=content.parts[kept],
        again=content.parts_again[[*kept, -1]],
        depths=content.optical_depths[kept],
        right_at=content.rights[kept],
    )


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
