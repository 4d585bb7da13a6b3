"""The factor model: filters that make coefficients, and matrices that make colours of them.

A renderer multiplies coefficients channel by channel and adds them; that is exact for scaling and adding spectra, and
approximate for their product. Every published method is one choice of filters and of a rule for the matrices.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..errors import ModelError
from ..spectra import library
from ..spectra.arrays import Array, ArrayLike, numbers, resampled
from ..spectra.spectrum import WAVELENGTHS, Spectrum, SpectrumError
from . import integration, relight
from .rules import RULES, Fitted, Rule
from .training import Training

__all__ = ["FactorModel", "ModelError", "Observer", "Spectra"]

REFERENCE_CHANNELS = 33  # the fewest that make a reference
MOST_WAVELENGTHS = 5000  # of a model in a file: the largest array made of it has so many squared

Spectra = Spectrum | Sequence[Spectrum] | ArrayLike
Observer = str | Sequence[Spectrum] | Array


@dataclass(frozen=True, eq=False)
class FactorModel:
    """Filters (n, p) on wavelengths (n,) nm, and the rule by which `relight` makes its matrices.

    filters: columns sum to 1, so that a flat spectrum of 1 has coefficients 1. rule: see `rules`.
    Raises ModelError.
    """

    name: str
    wavelengths: Array
    filters: Array
    rule: Rule = Fitted()

    def __post_init__(self) -> None:
        if not isinstance(self.name, str):
            raise ModelError("the name of a factor model must be text")
        try:
            for field in ("wavelengths", "filters"):
                object.__setattr__(self, field, numbers(getattr(self, field), field))
            with np.errstate(all="ignore"):
                self._check()
                self.rule.check(self)
        except ModelError as error:
            raise ModelError(f"model {self.name[:60]!r}: {error}") from None

    def _check(self) -> None:
        count = self.wavelengths.size
        if self.wavelengths.ndim != 1 or not 0 < count <= MOST_WAVELENGTHS:
            raise ModelError(f"wavelengths must be a list of 1 to {MOST_WAVELENGTHS}")
        steps = np.diff(self.wavelengths)
        if not (steps > 0).all() or not np.allclose(steps, steps[:1], rtol=1e-6):
            raise ModelError("wavelengths must increase in equal steps")
        if self.filters.ndim != 2 or len(self.filters) != count or not 0 < self.channels <= MOST_WAVELENGTHS:
            raise ModelError(f"filters {self.filters.shape} do not fit {count} wavelengths")
        if not np.allclose(self.filters.sum(axis=0), 1, rtol=0, atol=1e-9):
            raise ModelError("every filter must sum to 1")

    @property
    def channels(self) -> int:
        """Number of coefficients p."""
        return self.filters.shape[1]

    @property
    def passes(self) -> int:
        """Number of RGB passes that carry them."""
        return -(-self.channels // 3)

    @property
    def label(self) -> str:
        """What people call the model: "9 channels", "the reference, 36 bands"."""
        return self.rule.label(self)

    @property
    def is_reference(self) -> bool:
        """Whether every channel is a sample of the spectrum, so that products are exact for any number of bounces."""
        return self.channels >= REFERENCE_CHANNELS and np.count_nonzero(self.filters, axis=0).max() <= 2

    def reordered(self, order: list[int]) -> "FactorModel":
        """The same model with its channels in another order; itself where their order means something."""
        rule = self.rule.reordered(order)
        return self if rule is None else replace(self, filters=self.filters[:, order], rule=rule)

    def coefficients(self, spectra: Spectra) -> Array:
        """Coefficients of a Spectrum (p,), of a list of them (m, p), or of an array (..., n) on `wavelengths` (..., p).

        Raises SpectrumError.

        >>> from relume.core import bases
        >>> bases.fitted(6).coefficients(np.full(81, 0.5))
        array([0.5, 0.5, 0.5, 0.5, 0.5, 0.5])
        """
        return self._sampled(spectra) @ self.filters

    def shares(self, spectrum: Spectrum, steps: int = 36, most: int = 6) -> Array:
        """Means of a Spectrum over equal shares of each filter's weight, from blue to red -> (shares, p).

        There are as many shares as give all filters together that many `steps`, `most` for each at most. They average
        to the coefficients. What treats every wavelength apart, as refraction does, can treat each share apart.
        Raises SpectrumError.
        """
        values, parts = self._sampled(spectrum), min(-(-steps // self.channels), most)
        weights = np.maximum(self.filters, 0)
        ends = np.cumsum(weights / weights.sum(axis=0), axis=0)[:, None] * parts  # (n, 1, p)
        starts = np.concatenate([np.zeros_like(ends[:1]), ends[:-1]])
        share = np.arange(parts)[:, None]
        overlap = np.clip(np.minimum(ends, share + 1) - np.maximum(starts, share), 0, None)  # (n, parts, p)
        means = np.einsum("n,nkp->kp", values, overlap)
        return means + self.coefficients(spectrum) - means.mean(axis=0)

    def relight(self, illuminant: Spectra, observer: Observer = library.OBSERVER) -> Array:
        """XYZ of a product of coefficients under `illuminant`, with Y = 1 for a perfect white -> (3, p).

        observer: the name of an observer or camera that `library.sensitivities` knows, or sensitivities, (n, 3) or
        three Spectrum, the second of which takes Y's place. Raises SpectrumError, library.LibraryError.

        >>> from relume.core import bases
        >>> white = bases.fitted(9).relight(library.illuminant("A")) @ np.ones(9)
        >>> white.round(2)
        array([1.1 , 1.  , 0.36])
        """
        return self.rule.matrix(self, self._weights(illuminant, observer))

    def emission(self, illuminant: Spectra, reference: Spectra, observer: Observer = library.OBSERVER) -> Array:
        """Coefficients (p,) of a light of this `illuminant` whose light group is relit by `reference`.

        A perfect white has Y = 1 under it. All ones where the two are the same. Raises as `relight` does.
        """
        weights, other = (self._weights(light, observer) for light in (illuminant, reference))
        if np.allclose(weights, other, rtol=0, atol=1e-12):
            return np.ones(self.channels)
        return relight.emitter(self.training, self.training_coefficients, self.rule.matrix(self, other), weights)

    def reconstruct(self, coefficients: ArrayLike) -> Array:
        """The smoothest spectra (..., n) that have these coefficients (..., p); flat for equal coefficients.

        Raises ModelError.
        """
        coefficients = np.asarray(coefficients, dtype=np.float64)
        if coefficients.ndim == 0 or coefficients.shape[-1] != self.channels:
            raise ModelError(f"expected {self.channels} coefficients per spectrum, got an array {coefficients.shape}")
        if not np.isfinite(coefficients).all():
            raise ModelError("coefficients must be finite numbers")
        return coefficients @ self.basis.T

    def to_dict(self) -> dict[str, Any]:
        """A JSON-able description from which `from_dict` makes the same model."""
        arrays = {name: getattr(self, name) for name in ("wavelengths", "filters")}
        arrays[self.rule.array] = getattr(self.rule, self.rule.array)
        lists = {name: array.tolist() for name, array in arrays.items() if array is not None}
        return {"name": self.name, "rule": self.rule.kind, **lists}

    @classmethod
    def from_dict(cls, description: object) -> "FactorModel":
        """The inverse of `to_dict`. Raises ModelError, whatever the description."""
        if not isinstance(description, Mapping):
            raise ModelError("not the description of a factor model: expected names and values")
        given = {"rule": Fitted.kind} | {name: value for name, value in description.items() if value is not None}
        kind = given.pop("rule")
        if not isinstance(kind, str) or kind not in RULES:
            raise ModelError(f"not the description of a factor model: its rule is none of {', '.join(RULES)}")
        rule = RULES[kind]
        values = given.pop(rule.array, None)
        needed = {"name", "wavelengths", "filters"}
        if given.keys() != needed:
            odd = sorted(given.keys() ^ needed, key=str)[0]
            why = f"{odd!r} is missing" if odd in needed else f"{str(odd)[:60]!r} is not one of its fields"
            raise ModelError(f"not the description of a factor model of the rule {kind}: {why}")
        return cls(**given, rule=rule(values))

    def _sampled(self, spectra: Spectra) -> Array:
        if isinstance(spectra, Spectrum):
            return spectra.sampled(self.wavelengths)
        if isinstance(spectra, (list, tuple)) and spectra and all(isinstance(s, Spectrum) for s in spectra):
            return np.stack([spectrum.sampled(self.wavelengths) for spectrum in spectra])
        values = np.asarray(spectra, dtype=np.float64)
        if values.ndim == 0 or values.shape[-1] != self.wavelengths.size:
            raise SpectrumError(
                f"expected a Spectrum or {self.wavelengths.size} values per spectrum, got an array {values.shape}"
            )
        if not np.isfinite(values).all():
            raise SpectrumError("spectra must be finite numbers")
        return values

    def _weights(self, illuminant: Spectra, observer: Observer) -> Array:
        """(n, 3) power weights of a light: integrated where it is measured more finely than the grid."""
        on_grid = np.array_equal(self.wavelengths, WAVELENGTHS)
        if on_grid and isinstance(illuminant, Spectrum) and integration.is_finer(illuminant):
            power = illuminant.sampled()
            relight.power_weights(power, library.observer())  # raises SpectrumError where it cannot be seen
            return relight.scaled(integration.light_weights(illuminant, observer) / np.abs(power).max())
        return relight.power_weights(self._sampled(illuminant), self._observer(observer))

    def _observer(self, observer: Observer) -> Array:
        if isinstance(observer, str):
            return resampled(library.sensitivities(observer).T, self.wavelengths).T
        if len(observer) == 3 and all(isinstance(one, Spectrum) for one in observer):
            return np.stack([one.sampled(self.wavelengths) for one in observer], axis=1)
        cmfs = np.asarray(observer, dtype=np.float64)
        if cmfs.shape != (self.wavelengths.size, 3) or not np.isfinite(cmfs).all():
            raise SpectrumError(
                f"an observer needs {self.wavelengths.size} x 3 finite sensitivities, got an array {cmfs.shape}"
            )
        return cmfs

    @property
    def training(self) -> Training:
        """Products that matrices and emissions are fitted on."""
        return self._training_set[1]

    @cached_property
    def training_coefficients(self) -> Array:
        """(N, p): what a renderer makes of those products."""
        reflectances, drawn = self._training_set
        return drawn.coefficients(reflectances @ self.filters)

    @cached_property
    def _training_set(self) -> tuple[Array, Training]:
        return self.rule.training(self.wavelengths)

    @cached_property
    def basis(self) -> Array:
        """B (n, p): spectra are rebuilt from coefficients c as B c."""
        return self.rule.basis(self.filters)
