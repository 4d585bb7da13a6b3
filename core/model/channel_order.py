"""Which channels share a pass, so that the noise of a pass is a change of brightness rather than of colour."""

from functools import lru_cache
from itertools import combinations

import numpy as np

from ..spectra import library
from ..spectra.arrays import Array
from . import relight
from .factor_model import FactorModel

__all__ = ["balanced"]

LIGHTS = ("D65", "A", "FL2", "LED-B3")


@lru_cache(maxsize=16)
def balanced(model: FactorModel) -> FactorModel:
    """The same model with its channels in an order in which every three of them make up a third of white.

    The noise of the channels of one pass is the same; that of the passes is independent. With v_k the XYZ of a white
    surface that pass k adds, a picture's variance is that of the sum of e_k v_k, so the sum of `|v_k|²` is made least,
    in the metric of CIEDE2000 at white. Where all v_k are equal it is that of an RGB render with as many samples.
    In every pass the channel of the longest wavelengths comes first, as red does: an RGB colour that nothing upsamples
    is then taken as a spectrum of three steps. Models whose last pass is part empty, and RGB ones, stay as they are.
    """
    count = model.passes
    if model.channels % 3:
        return model
    # From the shortest wavelengths on, whatever order they came in: what is balanced already stays as it is
    model = model.reordered(np.argsort(_centroids(model), kind="stable").tolist())
    parts = _white_parts(model)
    passes = [list(range(k, model.channels, count)) for k in range(count)]
    better = True
    while better:
        better = False
        for a, b in combinations(range(count), 2):
            better |= _swap(passes[a], passes[b], parts)
    centroids = _centroids(model)
    order = [channel for members in passes for channel in sorted(members, key=lambda k: -centroids[k])]
    return model.reordered(order)


def _centroids(model: FactorModel) -> Array:
    """The mean wavelength of each channel -> (p,)."""
    weights = np.abs(model.filters)
    return model.wavelengths @ weights / weights.sum(axis=0)


def _white_parts(model: FactorModel) -> Array:
    """What each channel adds to a white surface under several lights, in units of CIEDE2000 -> (3 lights, p)."""
    rows = []
    for name in LIGHTS:
        matrix = model.relight(library.illuminant(name))
        white = matrix.sum(axis=1)
        rows.append(relight.local_metric(white[None], white)[0] @ matrix)
    return np.concatenate(rows)


def _swap(first: list[int], second: list[int], parts: Array) -> bool:
    """Exchange the two channels whose exchange makes the noise of two passes least; whether one was exchanged."""

    def noise(one: list[int], other: list[int]) -> float:
        return sum(np.square(parts[:, members].sum(axis=1)).sum() for members in (one, other))

    best, choice = noise(first, second) * (1 - 1e-9), None
    for i in range(len(first)):
        for j in range(len(second)):
            one, other = first.copy(), second.copy()
            one[i], other[j] = second[j], first[i]
            if noise(one, other) < best:
                best, choice = noise(one, other), (one, other)
    if choice is None:
        return False
    first[:], second[:] = choice
    return True
