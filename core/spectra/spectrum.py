"""A measured spectrum, and the wavelengths that everything is computed on."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from ..errors import SpectrumError

__all__ = ["KINDS", "NOISE", "RANGES", "WAVELENGTHS", "Spectrum", "SpectrumError"]

WAVELENGTHS = np.arange(380.0, 785.0, 5.0)  # nm, (81,)
WAVELENGTHS.setflags(write=False)

NOISE = 0.02  # how far below 0 a measurement may fall, of a perfect white or of a lamp's peak: a meter's dark noise
_GREATEST = 1e30  # of a relative power; its sums and products with others stay far from what a float can hold
# What a value of each kind may be. A designed reflectance may leave 0..1 ([BMD] section 4: metameric blacks); n and k
# of metals reach 10 and 60 in the infrared; matching functions may be negative.
RANGES = {
    "reflectance": (-1e3, 1e3),
    "illuminant": (-_GREATEST, _GREATEST),
    "refractive index": (0.0, 100.0),
    "extinction": (0.0, 100.0),
    "sensitivity": (-_GREATEST, _GREATEST),
}
KINDS = tuple(RANGES)
_WIDEST = 5.0 + 1e-6  # nm: steps of a grid whose values are means of a reflectance; on coarser ones they are samples
_ZERO_OUTSIDE = ("illuminant", "sensitivity")


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Samples of one quantity over wavelength.

    wavelengths: (n,) nm, in any order on the way in, increasing afterwards.
    values: (n,) reflectance 0..1, relative power per nm, n, k or sensitivity, by `kind`; within its `RANGES`.
    Raises SpectrumError.
    """

    wavelengths: np.ndarray
    values: np.ndarray
    name: str = ""
    kind: str = "reflectance"
    source: str = ""

    def __post_init__(self) -> None:
        where = f"spectrum {self.name!r}" if self.name else "spectrum"
        try:
            wavelengths = np.array(self.wavelengths, dtype=np.float64)
            values = np.array(self.values, dtype=np.float64)
        except (TypeError, ValueError):
            raise SpectrumError(f"{where}: wavelengths and values must be numbers") from None
        if self.kind not in KINDS:
            raise SpectrumError(f"{where}: kind {self.kind!r} is none of {', '.join(KINDS)}")
        if wavelengths.ndim != 1 or wavelengths.shape != values.shape:
            raise SpectrumError(
                f"{where}: needs one value per wavelength, has shapes {wavelengths.shape} and {values.shape}"
            )
        if wavelengths.size == 0:
            raise SpectrumError(f"{where}: has no samples")
        if not np.isfinite(wavelengths).all() or (wavelengths <= 0).any():
            raise SpectrumError(f"{where}: wavelengths must be positive numbers of nanometres")
        if not np.isfinite(values).all():
            first = wavelengths[np.argmin(np.isfinite(values))]
            raise SpectrumError(f"{where}: the value at {first:g} nm is not a finite number")
        low, high = RANGES[self.kind]
        outside = (values < low) | (values > high)
        if outside.any():
            first = np.argmax(outside)
            raise SpectrumError(
                f"{where}: the value at {wavelengths[first]:g} nm is {values[first]:g}; "
                f"{self.kind} is a number from {low:g} to {high:g}"
            )
        order = np.argsort(wavelengths, kind="stable")
        wavelengths, values = wavelengths[order], values[order]
        repeated = np.flatnonzero(np.diff(wavelengths) <= 0)
        if repeated.size:
            raise SpectrumError(f"{where}: {wavelengths[repeated[0]]:g} nm occurs more than once")
        for array in (wavelengths, values):
            array.setflags(write=False)
        object.__setattr__(self, "wavelengths", wavelengths)
        object.__setattr__(self, "values", values)

    def sampled(self, wavelengths: ArrayLike = WAVELENGTHS) -> np.ndarray:
        """Values on `wavelengths` (m,) nm -> (m,), linear between samples.

        Reflectances and indices keep their end values outside the measured range, which must not lie wholly outside
        380 to 780 nm; illuminants and sensitivities are zero there. An illuminant measured more finely than
        `wavelengths`, and a reflectance where these are 5 nm apart or less, is averaged with triangular weights
        instead, so that nothing narrow falls between two samples: of an illuminant power and centroid are kept, and
        filters that are linear between `wavelengths` have the integral of a reflectance. An illuminant of one sample is
        a line. Raises SpectrumError.
        """
        wavelengths = np.asarray(wavelengths, dtype=np.float64)
        if self.kind not in _ZERO_OUTSIDE:
            first, last = self.wavelengths[0], self.wavelengths[-1]
            if last < WAVELENGTHS[0] or first > WAVELENGTHS[-1]:
                raise SpectrumError(
                    f"spectrum {self.name!r}: covers {first:g} to {last:g} nm, nothing of the visible 380 to 780 nm"
                )
            narrow = wavelengths.size > 1 and np.diff(wavelengths).max() <= _WIDEST
            if narrow and self.kind == "reflectance" and self._is_finer(wavelengths):
                return self._averaged(wavelengths)
            return np.interp(wavelengths, self.wavelengths, self.values)
        if self.kind == "illuminant" and wavelengths.size > 1:
            if self.wavelengths.size == 1:
                step = np.gradient(wavelengths)
                return _shared_out(self.values, self.wavelengths, wavelengths) / step
            if self._is_finer(wavelengths):
                return self._averaged(wavelengths)
        return np.interp(wavelengths, self.wavelengths, self.values, left=0.0, right=0.0)

    def _is_finer(self, wavelengths: np.ndarray) -> bool:
        """Whether it has steps below those of `wavelengths`, which increase."""
        if self.wavelengths.size == 1 or wavelengths.size == 1:
            return False
        return bool(np.diff(self.wavelengths).min() < np.diff(wavelengths).min() * (1 - 1e-9))

    def _averaged(self, wavelengths: np.ndarray) -> np.ndarray:
        """Triangle-weighted averages of the piecewise linear spectrum; exact: Simpson's rule between all knots."""
        knots = np.union1d(self.wavelengths, wavelengths)
        left, right = knots[:-1], knots[1:]
        points = np.concatenate([left, (left + right) / 2, right])
        weights = np.concatenate([right - left, 4 * (right - left), right - left]) / 6
        values = np.interp(points, self.wavelengths, self.values)
        if self.kind not in _ZERO_OUTSIDE:  # its ends are held, and the ends of the grid have half a triangle
            shared, whole = (_shared_out(each, points, wavelengths) for each in (values * weights, weights))
            return np.clip(shared / whole, self.values.min(), self.values.max())
        # Where the measured range ends the spectrum steps to zero: the last knot counts on its inner side only.
        inside = np.tile((left >= self.wavelengths[0]) & (right <= self.wavelengths[-1]), 3)
        power = values * weights * inside
        # The end samples stand for half a triangle; dividing by the full step keeps the total power.
        return _shared_out(power, points, wavelengths) / np.gradient(wavelengths)

    def to_dict(self) -> dict[str, str | list[float]]:
        """A JSON-able description, for image headers and scene properties."""
        return {
            "name": self.name,
            "kind": self.kind,
            "source": self.source,
            "wavelengths": self.wavelengths.tolist(),
            "values": self.values.tolist(),
        }

    @classmethod
    def from_dict(cls, description: Mapping) -> Self:
        """The inverse of `to_dict`. Raises SpectrumError."""
        try:
            return cls(
                description["wavelengths"],
                description["values"],
                name=str(description.get("name", "")),
                kind=str(description.get("kind", "reflectance")),
                source=str(description.get("source", "")),
            )
        except (KeyError, TypeError, AttributeError):
            raise SpectrumError("not the description of a spectrum: it needs wavelengths and values") from None


def _shared_out(amounts: np.ndarray, points: np.ndarray, grid: np.ndarray) -> np.ndarray:
    """Each of the amounts (n,) at points (n,) shared linearly by its two neighbours on `grid` (m,) -> (m,).

    What lies outside the grid is dropped.
    """
    within = (points >= grid[0]) & (points <= grid[-1])
    amounts, points = amounts[within], points[within]
    below = np.minimum(np.searchsorted(grid, points, side="right") - 1, grid.size - 2)
    part = (points - grid[below]) / (grid[below + 1] - grid[below])
    shares = np.concatenate([amounts * (1 - part), amounts * part])
    return np.bincount(np.concatenate([below, below + 1]), shares, minlength=grid.size)
