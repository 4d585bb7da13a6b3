"""The factor model: filters that make coefficients, and matrices that make colours of them.

A renderer multiplies coefficients channel by channel and adds them; that is exact for scaling and adding spectra, and
approximate for their product. Every published method is one choice of filters and of a rule for the matrices.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from . import library, relight, training
from .errors import ModelError
from .spectrum import WAVELENGTHS, Spectrum, SpectrumError

__all__ = ["FactorModel", "ModelError"]

RULES = ("fitted", "reconstructed", "diagonal")
ARRAYS = ("wavelengths", "filters", "reconstruction", "primaries", "reflectances")


@dataclass(frozen=True, eq=False)
class FactorModel:
    """Filters (n, p) on wavelengths (n,) nm, and the rule by which `relight` makes its matrices.

    filters: columns sum to 1, so that a flat spectrum of 1 has coefficients 1.
    rule: "fitted" fits each matrix on products of the scene's `reflectances` (m, n) and those of `training`;
        "reconstructed" rebuilds spectra with `reconstruction` (n, p) and integrates them; "diagonal" scales three
        primaries, whose XYZ are the columns of `primaries` (3, 3).
    Raises ModelError.
    """

    name: str
    wavelengths: np.ndarray
    filters: np.ndarray
    rule: str = "fitted"
    reconstruction: np.ndarray | None = None
    primaries: np.ndarray | None = None
    reflectances: np.ndarray | None = None

    def __post_init__(self):
        for field in ARRAYS:
            if getattr(self, field) is not None:
                try:
                    array = np.array(getattr(self, field), dtype=np.float64, order="C")
                except (TypeError, ValueError):
                    raise ModelError(f"model {self.name!r}: {field} must be numbers") from None
                if not np.isfinite(array).all():
                    raise ModelError(f"model {self.name!r}: {field} must be finite numbers")
                array.setflags(write=False)
                object.__setattr__(self, field, array)
        if self.rule not in RULES:
            raise ModelError(f"model {self.name!r}: rule {self.rule!r} is none of {', '.join(RULES)}")
        self._check_shapes()
        if self.rule == "fitted" and not np.array_equal(self.wavelengths, WAVELENGTHS):
            raise ModelError(f"model {self.name!r}: the fitted rule works on 380 to 780 nm at 5 nm")
        if not np.allclose(self.filters.sum(axis=0), 1, rtol=0, atol=1e-9):
            raise ModelError(f"model {self.name!r}: every filter must sum to 1")
        if self.rule == "diagonal" and (self.primaries is None or self.channels != 3):
            raise ModelError(f"model {self.name!r}: the diagonal rule needs three channels and their primaries")

    def _check_shapes(self):
        if self.wavelengths.ndim != 1 or not np.allclose(steps := np.diff(self.wavelengths), abs(steps[:1]), rtol=1e-6):
            raise ModelError(f"model {self.name!r}: wavelengths must increase in equal steps")
        count = self.wavelengths.size
        if self.filters.ndim != 2 or len(self.filters) != count or self.filters.shape[1] == 0:
            raise ModelError(f"model {self.name!r}: filters {self.filters.shape} do not fit {count} wavelengths")
        expected = {"reconstruction": self.filters.shape, "primaries": (3, 3)}
        if self.reflectances is not None:
            expected["reflectances"] = (len(np.atleast_1d(self.reflectances)), count)
        for field, shape in expected.items():
            array = getattr(self, field)
            if array is not None and array.shape != shape:
                raise ModelError(f"model {self.name!r}: {field} must be {shape}, not {array.shape}")

    @property
    def channels(self):
        """Number of coefficients p."""
        return self.filters.shape[1]

    @property
    def passes(self):
        """Number of RGB passes that carry them."""
        return -(-self.channels // 3)

    def coefficients(self, spectra):
        """Coefficients of a Spectrum (p,), of a list of them (m, p), or of an array (..., n) on `wavelengths` (..., p).

        Raises SpectrumError.
        """
        return self._sampled(spectra) @ self.filters

    def shares(self, spectrum, steps=36, most=6):
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

    def relight(self, illuminant, observer="CIE 1931 2°"):
        """XYZ of a product of coefficients under `illuminant`, with Y = 1 for a perfect white -> (3, p).

        observer: the name of an observer or camera that `library.sensitivities` knows, or sensitivities, (n, 3) or
        three Spectrum, the second of which takes Y's place. Raises SpectrumError, library.LibraryError.
        """
        return self._matrix(self._sampled(illuminant), self._observer(observer))

    def emission(self, illuminant, reference, observer="CIE 1931 2°"):
        """Coefficients (p,) of a light of this `illuminant` whose light group is relit by `reference`.

        A perfect white has Y = 1 under it. All ones where the two are the same. Raises as `relight` does.
        """
        power, cmfs = self._sampled(illuminant), self._observer(observer)
        other = self._sampled(reference)
        if np.allclose(relight.power_weights(power, cmfs), relight.power_weights(other, cmfs), rtol=0, atol=1e-12):
            return np.ones(self.channels)
        weights = relight.power_weights(power, cmfs)
        return relight.emitter(self._training, self._training_coefficients, self._matrix(other, cmfs), weights)

    def reconstruct(self, coefficients):
        """The smoothest spectra (..., n) that have these coefficients (..., p); flat for equal coefficients.

        Raises ModelError.
        """
        coefficients = np.asarray(coefficients, dtype=np.float64)
        if coefficients.ndim == 0 or coefficients.shape[-1] != self.channels:
            raise ModelError(f"expected {self.channels} coefficients per spectrum, got an array {coefficients.shape}")
        if not np.isfinite(coefficients).all():
            raise ModelError("coefficients must be finite numbers")
        return coefficients @ self._reconstruction.T

    def to_dict(self):
        """A JSON-able description from which `from_dict` makes the same model."""
        arrays = {field: getattr(self, field) for field in ARRAYS if getattr(self, field) is not None}
        return {"name": self.name, "rule": self.rule, **{field: array.tolist() for field, array in arrays.items()}}

    @classmethod
    def from_dict(cls, description):
        """The inverse of `to_dict`. Raises ModelError."""
        try:
            return cls(**description)
        except TypeError as error:
            raise ModelError(f"not the description of a factor model: {error}") from None

    def _matrix(self, illuminant, cmfs):
        weights = relight.power_weights(illuminant, cmfs)
        if self.rule == "fitted":
            exact = relight.exact_matrix(self.filters, weights)
            if exact is not None:
                return exact
            return relight.fitted_matrices(
                self._training_coefficients, *relight.targets(self._training, weights[None])
            )[0]
        if self.rule == "reconstructed":
            return relight.reconstructed_matrix(self._reconstruction, weights)
        return self.primaries * np.linalg.solve(self.primaries, weights.sum(axis=0))

    def _sampled(self, spectra):
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

    def _observer(self, observer):
        if isinstance(observer, str):
            return self._on_own_wavelengths(library.sensitivities(observer).T).T
        if len(observer) == 3 and all(isinstance(one, Spectrum) for one in observer):
            return np.stack([one.sampled(self.wavelengths) for one in observer], axis=1)
        cmfs = np.asarray(observer, dtype=np.float64)
        if cmfs.shape != (self.wavelengths.size, 3) or not np.isfinite(cmfs).all():
            raise SpectrumError(
                f"an observer needs {self.wavelengths.size} x 3 finite sensitivities, got an array {cmfs.shape}"
            )
        return cmfs

    def _on_own_wavelengths(self, rows):
        """Rows (m, 81) on WAVELENGTHS -> (m, n)."""
        if np.array_equal(self.wavelengths, WAVELENGTHS):
            return rows
        return np.stack([np.interp(self.wavelengths, WAVELENGTHS, row) for row in rows])

    @property
    def _training(self):
        return self._training_set[1]

    @cached_property
    def _training_coefficients(self):
        reflectances, drawn = self._training_set
        return drawn.coefficients(reflectances @ self.filters)

    @cached_property
    def _training_set(self):
        """Reflectances (m, n) and their products, on this model's wavelengths."""
        if self.rule != "fitted" and not np.array_equal(self.wavelengths, WAVELENGTHS):
            own = self._on_own_wavelengths(training.reflectances())
            return own, training.products(own)
        if self.reflectances is not None:
            return training.with_general(self.reflectances)
        return training.general()

    @cached_property
    def _reconstruction(self):
        if self.reconstruction is not None:
            return self.reconstruction
        # Least squared second differences subject to filters^T s = c; a flat spectrum has none, so it comes out flat.
        count, channels = self.filters.shape
        bend = np.diff(np.eye(count), n=2, axis=0)
        system = np.block([[bend.T @ bend, self.filters], [self.filters.T, np.zeros((channels, channels))]])
        right = np.concatenate([np.zeros((count, channels)), np.eye(channels)])
        return np.linalg.lstsq(system, right, rcond=None)[0][:count]
