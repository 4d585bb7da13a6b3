"""What a scene shows and how it is lit, as far as errors of its colours depend on it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..colour.spaces import REC709
from ..errors import UsageError
from ..spectra import library
from ..spectra.arrays import Array, ArrayLike
from ..spectra.spectrum import Spectrum

__all__ = ["Content", "general", "kept"]

MOST = 60  # surfaces that a file keeps
_BRIGHTEST = 1e6


@dataclass(frozen=True, eq=False)
class Content:
    """What a scene shows and how it is lit.

    reflectances: the measured spectra. colours: (m, 3) RGB colours of `space`. shares: part of the picture of each
    reflectance, then of each colour; need not sum to 1. textures: part of the picture whose colours are not known.
    again: part of the light that each of them, textures last, reflects more than once, as `finish` has it. depths:
    optical depth of each that is a medium which absorbs, where it is black; 0 for what reflects. right_at: the depth at
    which channels of a medium are right, as `absorption` makes them; 0 where they are means. All none by default.
    filtered: what shines through a spectrum in the light group of others: its name, that group, the spectrum.
    lights: what shines in each light group. choices: illuminants that the artist wants to switch to later. bounces: how
    often light is reflected between surfaces at most. disperses: whether a glass makes a spectrum.
    """

    reflectances: Sequence[Spectrum] = ()
    colours: ArrayLike = ()
    shares: ArrayLike | None = None
    textures: float = 0.0
    lights: Sequence[Spectrum] = ()
    choices: Sequence[Spectrum] = ()
    bounces: int = 4
    space: str = REC709
    disperses: bool = False
    again: ArrayLike | None = None
    depths: ArrayLike | None = None
    right_at: ArrayLike | None = None
    filtered: Sequence[tuple[str, str, Spectrum]] = ()

    def __post_init__(self) -> None:
        colours = np.asarray(self.colours, dtype=np.float64).reshape(-1, 3)
        count = len(self.reflectances) + len(colours)
        shares = np.ones(count) if self.shares is None else np.asarray(self.shares, dtype=np.float64)
        if shares.shape != (count,) or (shares < 0).any():
            raise UsageError(f"a scene of {count} surfaces needs as many shares of 0 or more, got {shares.shape}")
        again = np.zeros(count + 1) if self.again is None else np.asarray(self.again, dtype=np.float64)
        if again.shape != (count + 1,) or not ((again >= 0) & (again < 1)).all():
            raise UsageError(f"{count} surfaces and their textures reflect a part of 0 to 1 again, got {again.shape}")
        for field in ("depths", "right_at"):
            given = getattr(self, field)
            values = np.zeros(count) if given is None else np.asarray(given, dtype=np.float64)
            if values.shape != (count,) or not (values >= 0).all():
                raise UsageError(f"a scene of {count} surfaces needs as many depths of 0 or more, got {values.shape}")
            object.__setattr__(self, field, values)
        if not self.lights:
            raise UsageError("a scene needs at least one light")
        object.__setattr__(self, "colours", colours)
        object.__setattr__(self, "shares", shares)
        object.__setattr__(self, "again", again)

    @property
    def rgb(self) -> Array:
        """(m, 3) the colours, as an array."""
        return np.asarray(self.colours)

    @property
    def parts(self) -> Array:
        """(surfaces,) the shares, as an array."""
        return np.asarray(self.shares)

    @property
    def parts_again(self) -> Array:
        """(surfaces + 1,) `again`, as an array."""
        return np.asarray(self.again)

    @property
    def optical_depths(self) -> Array:
        """(surfaces,) the depths, as an array."""
        return np.asarray(self.depths)

    @property
    def rights(self) -> Array:
        """(surfaces,) the depths at which channels are right, as an array."""
        return np.asarray(self.right_at)

    @property
    def switches(self) -> bool:
        """Whether the light may become another than the one rendered for."""
        lit = self.lights[0].sampled()
        return any(not np.allclose(_unit(other.sampled()), _unit(lit)) for other in [*self.lights[1:], *self.choices])


def general(lights: Sequence[Spectrum]) -> Content:
    """What stands for a scene of which nothing is known but its lights: measured surfaces, the CES."""
    return Content(library.reflectances("ces"), lights=lights, bounces=2)


def kept(content: Content) -> Content:
    """What a file keeps of it: the surfaces that are seen most, `MOST` of them, and what shines now.

    Colours that are no finite numbers, or beyond any surface's, are left out.
    """
    measured = len(content.reflectances)
    usable = np.append(np.ones(measured, bool), (np.abs(content.rgb) <= _BRIGHTEST).all(axis=1))  # nan is not
    order = [n for n in np.argsort(-content.parts, kind="stable") if usable[n]]
    chosen = np.sort(np.array(order[:MOST], dtype=int))
    return replace(
        content,
        reflectances=[content.reflectances[n] for n in chosen if n < measured],
        colours=content.rgb[[n - measured for n in chosen if n >= measured]],
        shares=content.parts[chosen],
        again=content.parts_again[[*chosen, -1]],
        depths=content.optical_depths[chosen],
        right_at=content.rights[chosen],
        choices=(),
    )


def _unit(power: Array) -> Array:
    return power / power.max()
