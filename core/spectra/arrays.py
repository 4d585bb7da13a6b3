"""Arrays of numbers: their type, and how they are taken from a caller or a file."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ModelError
from .spectrum import WAVELENGTHS

__all__ = ["Array", "ArrayLike", "numbers", "resampled"]

Array = NDArray[np.float64]


def numbers(values: object, what: str) -> Array:
    """Finite numbers, read-only. Raises ModelError for anything else.

    >>> numbers([1, 2], "primaries")
    array([1., 2.])
    """
    try:
        array = np.asarray(values)
    except (TypeError, ValueError):
        raise ModelError(f"{what} must be numbers, as many in each row") from None
    if array.dtype.kind not in "iuf":
        raise ModelError(f"{what} must be numbers")
    array = np.array(array, dtype=np.float64, order="C")
    if not np.isfinite(array).all():
        raise ModelError(f"{what} must be finite numbers")
    array.setflags(write=False)
    return array


def resampled(rows: Array, wavelengths: Array) -> Array:
    """Rows (m, 81) on WAVELENGTHS -> (m, n) on `wavelengths`, linear between samples."""
    if np.array_equal(wavelengths, WAVELENGTHS):
        return rows
    return np.stack([np.interp(wavelengths, WAVELENGTHS, row) for row in rows])
