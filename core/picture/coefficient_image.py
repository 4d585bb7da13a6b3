"""The coefficient image: what a render's coefficient passes hold, with all that relighting them needs."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..model.factor_model import FactorModel
from ..spectra.library import OBSERVER
from ..spectra.spectrum import Spectrum
from .content import Content
from .mix import Light, Mix
from .recombination import recombination_matrices

__all__ = ["EVERYTHING_ELSE", "Block", "CoefficientImage", "gathered"]

# What no light group holds: the combined pass less all the groups.
EVERYTHING_ELSE = "Everything else"


@dataclass(frozen=True)
class CoefficientImage:
    """Coefficients of a rendered picture, with all that relighting it needs.

    groups: light group -> (height, width, p) float32. illuminants: light group -> what lit it. alpha: (height, width).
    view: how Blender would show it (`view_transform`, `look`, `exposure`, `gamma`), an empty mapping for plain sRGB.
    white, observer: as `mix.Mix` takes them. shows: the surfaces of the scene, by which errors are expected; None where
    nobody said. One that only describes has neither groups nor pixels.
    """

    model: FactorModel
    groups: Mapping[str, np.ndarray]
    illuminants: Mapping[str, Spectrum]
    alpha: np.ndarray
    space: str = "Linear Rec.709"
    white_balance: float = 0.0
    white_balance_method: str = "bradford"
    view: Mapping[str, object] = field(default_factory=dict)
    gains: Mapping[str, float] = field(default_factory=dict)
    white: tuple[float, float, float] | None = None
    observer: str | tuple[Spectrum, Spectrum, Spectrum] = OBSERVER
    shows: Content | None = None

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) in pixels."""
        return self.alpha.shape[1], self.alpha.shape[0]

    def mix(self, lights: Mapping[str, Light] | None = None, white_balance: float | None = None) -> Mix:
        """The mix that shows it: as it was lit, but for the lights and the white balance that are given."""
        if lights is None:
            lights = {group: Light(each, self.gains.get(group, 1.0)) for group, each in self.illuminants.items()}
        return Mix(
            {group: lights[group] for group in self.illuminants},
            white_balance=self.white_balance if white_balance is None else white_balance,
            method=self.white_balance_method,
            space=self.space,
            white=self.white,
            observer=self.observer,
        )

    def matrices(self) -> np.ndarray:
        """(groups, 3, p) matrices of the picture as it was lit. Raises as `recombination_matrices` does."""
        return recombination_matrices(self.model, self.mix())


class Block(NamedTuple):
    """A few rows of a coefficient image.

    rows: which. height: of the picture. groups: light group -> (rows, width, p) float32. alpha: (rows, width).
    """

    rows: slice
    height: int
    groups: dict[str, np.ndarray]
    alpha: np.ndarray


def gathered(blocks: Iterable[Block]) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Blocks as whole pictures: {group: (height, width, p)} and (height, width) alpha."""
    groups: dict[str, np.ndarray] = {}
    alpha = np.empty((0, 0), np.float32)
    for block in blocks:
        if not alpha.size:
            alpha = np.empty((block.height, *block.alpha.shape[1:]), np.float32)
            groups = {
                name: np.empty((block.height, *each.shape[1:]), np.float32) for name, each in block.groups.items()
            }
        alpha[block.rows] = block.alpha
        for name, each in block.groups.items():
            groups[name][block.rows] = each
    return groups, alpha
