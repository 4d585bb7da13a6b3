"""The filters that ship with Relume, and simple ones to start from."""

from pathlib import Path

import numpy as np

from ..spectra import library
from ..spectra.arrays import Array
from ..spectra.spectrum import WAVELENGTHS

__all__ = ["REFERENCE", "SHIPPED", "read_filters", "start_filters", "write_filters"]

SHIPPED = Path(__file__).with_name("data") / "fitted.csv"
DECIMALS = 7

# nm; the 36 of the 81 wavelengths between which the training set interpolates best under the CIE illuminants: 5 nm
# apart where the eye and the lines of lamps need it, found by dropping the least important one at a time.
_TO_GREEN = (390, 405, 420, 435, 445, 450, 460, 465, 475, 490, 505, 510, 520, 530, 535, 540, 545, 550, 555, 560, 565)
REFERENCE = (*_TO_GREEN, 570, 575, 580, 585, 590, 595, 600, 605, 610, 615, 630, 645, 655, 675, 720)


def start_filters(channels: int, random: np.random.Generator | None = None, total: Array | None = None) -> Array:
    """Adjoining bands weighted by `total` (81,), edges blurred -> (81, p).

    Their edges share out a power of `total`, by default the sum of the matching functions, equally; `random` (a numpy
    Generator) varies them.
    """
    total = library.observer().sum(axis=1) if total is None else total
    power, blur = (1 / 3, 3.0) if random is None else (random.uniform(0.25, 1), random.uniform(1, 10))
    share = total**power * (1 if random is None else np.exp(random.normal(0, 0.15, total.size)))
    share = np.concatenate([[0], np.cumsum(share) / share.sum()])
    borders = np.arange(WAVELENGTHS[0] - 2.5, WAVELENGTHS[-1] + 5, 5)
    edges = np.interp(np.arange(channels + 1) / channels, share, borders)
    low, high = WAVELENGTHS[:, None] - 2.5, WAVELENGTHS[:, None] + 2.5
    bands = np.clip(np.minimum(high, edges[1:]) - np.maximum(low, edges[:-1]), 0, None)
    spread = np.exp(-0.5 * (np.subtract.outer(WAVELENGTHS, WAVELENGTHS) / blur) ** 2)
    filters = (spread @ bands) * total[:, None]
    return filters / filters.sum(axis=0)


def write_filters(path: Path, filters: dict[int, Array]) -> None:
    """Write {channels: filters (81, p)} as CSV: one row per wavelength, one column per filter."""
    head = ["wavelength_nm"] + [f"p{p}_{j + 1}" for p in filters for j in range(p)]
    rows = np.concatenate([WAVELENGTHS[:, None], *filters.values()], axis=1)
    lines = [",".join(head)]
    for wavelength, *values in rows:
        lines.append(",".join([f"{wavelength:g}", *(f"{round(value, DECIMALS):g}" for value in values)]))
    Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")


def read_filters(path: Path = SHIPPED) -> dict[int, Array]:
    """The inverse of `write_filters`; columns are made to sum to 1 exactly."""
    with open(path, encoding="utf-8") as file:
        head = file.readline().strip().split(",")[1:]
        table = np.loadtxt(file, delimiter=",")[:, 1:]
    sizes = [int(name[1:].split("_")[0]) for name in head]
    groups = {p: table[:, [j for j, size in enumerate(sizes) if size == p]] for p in dict.fromkeys(sizes)}
    return {p: filters / filters.sum(axis=0) for p, filters in groups.items()}
