"""The coefficient image: what a render's coefficient passes hold, with all that relighting them needs."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from .factor_model import FactorModel
from .spectrum import Spectrum
from .view import OBSERVER, Light, recombination_matrices

__all__ = ["EVERYTHING_ELSE", "CoefficientImage"]

# What no light group holds: the combined pass less all the groups.
EVERYTHING_ELSE = "Everything else"


@dataclass(frozen=True)
class CoefficientImage:
    """Coefficients of a rendered picture, with all that relighting it needs.

    groups: light group -> (height, width, p) float32. illuminants: light group -> what lit it. alpha: (height, width).
    view: how Blender would show it (`view_transform`, `look`, `exposure`, `gamma`), an empty mapping for plain sRGB.
    white, observer: as `view.recombination_matrices` takes them. One that only describes has neither groups nor pixels.
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

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) in pixels."""
        return self.alpha.shape[1], self.alpha.shape[0]

    def matrices(self) -> np.ndarray:
        """(groups, 3, p) matrices of the picture as it was lit. Raises as `view.recombination_matrices` does."""
        lights = [Light(illuminant, self.gains.get(group, 1.0)) for group, illuminant in self.illuminants.items()]
        return recombination_matrices(
            self.model,
            lights,
            white_balance=self.white_balance,
            method=self.white_balance_method,
            space=self.space,
            white=self.white,
            observer=self.observer,
        )
