"""How the samples of a render are shared among its passes, as settings of Cycles.

Passes that take parts of one low-discrepancy sequence add up to what is nearly as smooth as one render with all its
samples; with seeds of their own, each pass is smooth by itself only.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..model.factor_model import FactorModel
from ..spectra.arrays import Array
from .mix import Light

__all__ = ["Sampling", "adaptive", "dealt", "independent", "same", "shares"]

_SEEDS = 2**31  # Cycles' seeds are below it


@dataclass(frozen=True)
class Sampling:
    """What Cycles samples in each pass.

    samples: of each pass's view layer, 0 for as many as the scene has. driven: {setting of `scene.cycles`: its value
    in each pass}. otherwise: its value in view layers that are no passes.
    """

    samples: tuple[int, ...]
    driven: dict[str, tuple[int, ...]] = field(default_factory=dict)
    otherwise: dict[str, int] = field(default_factory=dict)


def same(passes: int, samples: int = 0) -> Sampling:
    """`samples` in every pass, with the same random numbers: noise of the passes is the same."""
    return Sampling((samples,) * passes)


def independent(passes: int, samples: int = 0, seed: int = 0) -> Sampling:
    """`samples` in every pass, with seeds from `seed` on: noise of the passes is independent."""
    return Sampling((samples,) * passes, {"seed": tuple((seed + k) % _SEEDS for k in range(passes))}, {"seed": seed})


def dealt(parts: Sequence[float], first: int, count: int) -> Sampling:
    """The `count` samples of one sequence from the sample `first` on, dealt out to the passes by their `parts` of 1.

    Every pass has at least one sample, so that there may be more than `count` in all.

    >>> dealt([0.5, 0.25, 0.25], first=0, count=8).driven
    {'sample_offset': (0, 4, 6), 'sample_subset_length': (4, 2, 2)}
    """
    ends = np.rint(np.cumsum(parts) * count).astype(int)
    counts = np.maximum(np.diff(ends, prepend=0), 1)
    starts = first + np.cumsum(counts) - counts
    return Sampling(
        samples=(int(first + counts.sum()),) * len(counts),
        driven={"sample_offset": tuple(starts.tolist()), "sample_subset_length": tuple(counts.tolist())},
        otherwise={"sample_offset": first, "sample_subset_length": count},
    )


def shares(model: FactorModel, lights: Sequence[Light]) -> Array:
    """Part of all samples that each pass is to have (passes,): half of it even, half by luminance under `lights`.

    The variance of luminance, sum of y_k^2 / n_k over passes that add y_k with n_k samples, is least for n_k in
    proportion to y_k. The even half keeps it within twice that of an even share when the light is changed later, and
    keeps the noise of hue small, to which dark passes add more than to luminance.
    """
    added = np.zeros(model.passes)
    for light in lights:
        luminance = light.gain * model.relight(light.illuminant)[1]
        added += np.abs([part.sum() for part in np.array_split(luminance, range(3, model.channels, 3))])
    even = np.full(model.passes, 1 / model.passes)
    return (even + added / added.sum()) / 2 if added.sum() > 0 else even


def adaptive(threshold: float, minimum: int, samples: int, passes: int) -> tuple[float, int]:
    """Noise threshold and least number of samples of each pass, for those of a single render with up to `samples`.

    Independent noise of the passes averages out, so each may have more: by passes^(1/2) if Cycles judged a pass as it
    does a picture; found by experiment, passes^(3/4) gives as much noise for nearly as much time. 0 is Cycles' own
    choice.
    """
    if passes == 1:
        return threshold, minimum
    threshold = threshold or max(0.001, 1 / samples)
    minimum = minimum or math.ceil(16 * threshold**-0.3)
    return min(threshold * passes**0.75, 1.0), max(math.ceil(minimum / passes), 4)
