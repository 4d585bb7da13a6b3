"""The rules by which a factor model makes its relight matrices: one small class for each, and one interface.

A rule owns the one array that its matrices need besides the filters.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..errors import ModelError
from ..spectra.arrays import Array, numbers, resampled
from ..spectra.spectrum import WAVELENGTHS
from . import relight, training

if TYPE_CHECKING:
    from .factor_model import FactorModel

__all__ = ["RULES", "Diagonal", "Direct", "Fitted", "Reconstructed", "Rule"]


class Rule(ABC):
    """kind: the rule's name in a file. array: the name of its array, here and in a file."""

    kind: ClassVar[str]
    array: ClassVar[str]

    def __post_init__(self) -> None:
        values = getattr(self, self.array)
        if values is not None:
            object.__setattr__(self, self.array, numbers(values, f"{self.array} of a factor model"))

    @abstractmethod
    def check(self, model: "FactorModel") -> None:
        """Raises ModelError where the rule does not work with these wavelengths and filters."""

    @abstractmethod
    def matrix(self, model: "FactorModel", weights: Array) -> Array:
        """(3, p) relight matrix for power weights (n, 3)."""

    def label(self, model: "FactorModel") -> str:
        """What people call the model."""
        return "no colours, one channel" if model.channels == 1 else f"{model.channels} channels"

    def reordered(self, order: list[int]) -> "Rule | None":
        """The rule for channels in another order; None where their order means something."""
        return self

    def training(self, wavelengths: Array) -> tuple[Array, training.Training]:
        """Reflectances (m, n) and their products, on these wavelengths."""
        if np.array_equal(wavelengths, WAVELENGTHS):
            return training.general()
        own = resampled(training.reflectances(), wavelengths)
        return own, training.products(own)

    def basis(self, filters: Array) -> Array:
        """B (n, p): spectra are rebuilt as B c, by default the smoothest that have the coefficients c."""
        # Least squared second differences subject to filters^T s = c; a flat spectrum has none, so it comes out flat.
        count, channels = filters.shape
        bend = np.diff(np.eye(count), n=2, axis=0)
        system = np.block([[bend.T @ bend, filters], [filters.T, np.zeros((channels, channels))]])
        right = np.concatenate([np.zeros((count, channels)), np.eye(channels)])
        return np.linalg.lstsq(system, right, rcond=None)[0][:count]


@dataclass(frozen=True, eq=False)
class Fitted(Rule):
    """Fits each matrix on products of the scene's own `reflectances` (m, 81), if any, and those of `training`."""

    kind = "fitted"
    array = "reflectances"
    bounces: ClassVar[tuple[float, ...]] = (1.0, 2.0, 3.0)  # how much products of 1, 2 and 3 of the scene's count
    reflectances: Array | None = None

    def check(self, model: "FactorModel") -> None:
        if not np.array_equal(model.wavelengths, WAVELENGTHS):
            raise ModelError("the fitted rule works on 380 to 780 nm at 5 nm")
        own = self.reflectances
        if own is not None and (own.ndim != 2 or own.shape[0] == 0 or own.shape[1] != WAVELENGTHS.size):
            raise ModelError(f"reflectances must be rows of {WAVELENGTHS.size} numbers, not {own.shape}")

    def matrix(self, model: "FactorModel", weights: Array) -> Array:
        exact = relight.exact_matrix(model.filters, weights)
        if exact is not None:
            return exact
        return relight.fitted_matrices(model.training_coefficients, *relight.targets(model.training, weights[None]))[0]

    def training(self, wavelengths: Array) -> tuple[Array, training.Training]:
        own = self.reflectances
        return training.general() if own is None else training.with_general(own, self.bounces)


@dataclass(frozen=True, eq=False)
class Direct(Fitted):
    """The same for a scene in which light is reflected once, and seldom more."""

    kind = "direct"
    bounces = (1.0, 0.3, 0.1)


@dataclass(frozen=True, eq=False)
class Reconstructed(Rule):
    """Rebuilds spectra with `reconstruction` (n, p), or as the smoothest, and integrates them."""

    kind = "reconstructed"
    array = "reconstruction"
    reconstruction: Array | None = None

    def check(self, model: "FactorModel") -> None:
        if self.reconstruction is not None and self.reconstruction.shape != model.filters.shape:
            raise ModelError(f"reconstruction must be {model.filters.shape}, not {self.reconstruction.shape}")

    def matrix(self, model: "FactorModel", weights: Array) -> Array:
        return relight.reconstructed_matrix(model.basis, weights)

    def label(self, model: "FactorModel") -> str:
        if model.channels == model.wavelengths.size:
            return f"exact, {model.channels} channels"
        return f"the reference, {model.channels} bands" if model.is_reference else super().label(model)

    def reordered(self, order: list[int]) -> Rule:
        return self if self.reconstruction is None else replace(self, reconstruction=self.reconstruction[:, order])

    def basis(self, filters: Array) -> Array:
        return super().basis(filters) if self.reconstruction is None else self.reconstruction


@dataclass(frozen=True, eq=False)
class Diagonal(Rule):
    """Scales three primaries, whose XYZ are the columns of `primaries` (3, 3)."""

    kind = "diagonal"
    array = "primaries"
    primaries: Array

    def check(self, model: "FactorModel") -> None:
        if self.primaries is None or model.channels != 3:
            raise ModelError("the diagonal rule needs three channels and their primaries")
        if self.primaries.shape != (3, 3) or not np.linalg.cond(self.primaries) < 1e12:
            raise ModelError("primaries must be the XYZ of three independent colours, (3, 3)")

    def matrix(self, model: "FactorModel", weights: Array) -> Array:
        return self.primaries * np.linalg.solve(self.primaries, weights.sum(axis=0))

    def label(self, model: "FactorModel") -> str:
        return f"one light, {model.name} RGB"

    def reordered(self, order: list[int]) -> None:
        return None


RULES: dict[str, type[Fitted] | type[Reconstructed] | type[Diagonal]] = {
    rule.kind: rule for rule in (Fitted, Direct, Reconstructed, Diagonal)
}
