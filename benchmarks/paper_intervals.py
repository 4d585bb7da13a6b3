"""Which intervals [DF] may have had, by how near Table 1 comes to the printed rows: even ones, for p = 9 free ones too.

`python -m relume.benchmarks.paper_intervals --reflectances CSV`

[DF] prints its intervals for p = 5 only. Tried are evenly spaced centres, ten nanometres apart at either end, with
several widths. Nearness is the mean, over 1 to 5 reflections, of |log(here / printed)|. At p = 9 none come near:
there each interval is moved and widened by itself, downhill, for Table 1 alone and for Tables 1 and 3 together; and the
basis is made of signals that are scaled otherwise.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

from ..core.colour import differences
from ..core.errors import ModelError
from ..core.model import sharpening
from ..core.spectra import files
from ..studies import multispectral as paper
from ..studies import printed
from ..studies.reports import Section, publish, status

# channels: first centres, last centres, half-widths in nm
TRIED = {
    3: (range(400, 461, 10), range(600, 701, 10), (10, 20, 30, 40, 50)),
    7: (range(400, 431, 10), range(650, 701, 10), (0, 5, 10, 15, 20)),
    9: (range(400, 431, 10), range(650, 701, 10), (0, 5, 10, 15, 20)),
}
TRIALS, SHOWN = 12, 5
FREE, STEPS = 9, 600  # channels whose intervals are free, and how many changes are tried
EVEN = paper.evenly(FREE, 410, 690, 10)
MOVES = (-20, -10, -5, 0, 5, 10, 20)  # nm, of a centre or a half-width


def medians(models, surfaces, lights, seed=2003):
    """Rows of Table 1 and of Table 3 for each of several models -> (models, 5), (models, 5)."""
    random, cmfs = np.random.default_rng(seed), paper.observer()
    found = []
    for _ in range(TRIALS):
        chosen = np.tile(np.arange(len(surfaces)), (paper.BOUNCES, 1))
        chosen[1:] = random.integers(len(surfaces), size=(paper.BOUNCES - 1, len(surfaces)))
        light, series = lights[random.integers(len(lights), size=len(surfaces))], surfaces[chosen]
        true, white = light * paper.accumulated(series, "paper"), light @ cmfs
        rows = []
        for model in models:
            made = paper.factors(model)(light, series, "paper")
            apart = differences.delta_E_1976(made @ cmfs, true @ cmfs, white)
            rows.append([np.median(values, axis=1) for values in (apart, paper.relative_error(made, true))])
        found.append(rows)
    return tuple(np.moveaxis(np.median(found, axis=0), 1, 0))


def apart(rows, table, p):
    """How far rows (..., 5) are from the printed one of eq. 12."""
    return np.abs(np.log(rows / np.array(printed.RANDOM_TABLES[table][p, "eq. 12"]))).mean(axis=-1)


def descended(basis, surfaces, lights, tables, seed=1):
    """Intervals that do not overlap, changed one after the other wherever rows of `tables` come nearer -> Intervals."""
    random = np.random.default_rng(seed)

    def cost(intervals):
        rows = medians([paper.eq_12(basis, intervals)], surfaces, lights)
        return sum(apart(rows[table // 2][0], table, FREE) for table in tables)

    best = EVEN
    least = cost(best)
    for _ in range(STEPS):
        tried = [list(interval) for interval in best]
        for index in random.integers(FREE, size=random.integers(1, 4)):
            move, wider = random.choice(MOVES), random.choice(MOVES) / 2
            low, high = tried[index][0] + move - wider, tried[index][1] + move + wider
            tried[index] = [min(low, high), max(low, high)]
        ordered = [end for interval in tried for end in interval]
        if ordered != sorted(ordered) or ordered[0] < 395 or ordered[-1] > 705:
            continue
        try:
            now = cost(tried)
        except ModelError:
            continue  # an interval without a sample
        if now < least:
            best, least = [tuple(interval) for interval in tried], now
    return best


def free_section(surfaces, lights):
    """What free intervals, and other scales of the signals, make of Tables 1 and 3."""
    signals = (lights[:, None] * surfaces).reshape(-1, paper.WAVELENGTHS.size)
    basis = paper.components(FREE, lights, surfaces)
    chosen = {
        "even": (basis, EVEN),
        "free, to Table 1": (basis, descended(basis, surfaces, lights, (1,))),
        "free, to Tables 1 and 3": (basis, descended(basis, surfaces, lights, (1, 3))),
        "even, signals of length 1": (_components(signals / np.linalg.norm(signals, axis=1, keepdims=True)), EVEN),
        "even, lights of length 1": (
            _components(lights[:, None] / np.linalg.norm(lights, axis=1)[:, None, None] * surfaces),
            EVEN,
        ),
        "even, reflectances alone": (_components(surfaces), EVEN),
    }
    rows = []
    for table, unit in ((1, "CIE 1976"), (3, "RMS %")):
        theirs = printed.RANDOM_TABLES[table][FREE, "eq. 12"]
        rows.append([f"Table {table}, {unit}", "printed", "", *(f"{value:.2f}" for value in theirs)])
        for name, (vectors, intervals) in chosen.items():
            found = medians([paper.eq_12(vectors, intervals)], surfaces, lights)[table // 2][0]
            cells = (f"{value:.2f}" for value in found)
            rows.append([f"Table {table}, {unit}", name, f"{apart(found, table, FREE):.3f}", *cells])
    words = "; ".join(
        f"{name}: {', '.join(f'{low:g}-{high:g}' for low, high in intervals)}"
        for name, (_, intervals) in chosen.items()
        if name.startswith("free")
    )
    head = ("", "intervals and basis", "apart", *map(str, range(1, paper.BOUNCES + 1)))
    return Section(f"p = {FREE}, free intervals", f"{STEPS} changes tried for each. {words} nm.", head, rows)


def _components(signals):
    return sharpening.principal_components(signals.reshape(-1, paper.WAVELENGTHS.size), FREE)


def sections(reflectances):
    """The nearest intervals for each p, and free ones for the p where none is near."""
    surfaces, lights = paper.sampled(reflectances), np.stack([paper.paper_light(name) for name in paper.LIGHTS])
    for p, (firsts, lasts, halves) in TRIED.items():
        basis, models = paper.components(p, lights, surfaces), {}
        for first, last, half in ((a, b, c) for a in firsts for b in lasts for c in halves):
            try:
                models[first, last, half] = paper.eq_12(basis, paper.evenly(p, first, last, half))
            except ModelError:
                continue  # an interval without a sample
        theirs = np.array(printed.RANDOM_TABLES[1][p, "eq. 12"])
        rows, _ = medians(models.values(), surfaces, lights)
        distances = apart(rows, 1, p)
        order = np.argsort(distances)[:SHOWN]
        names = list(models)
        shown = [["printed", "", *(f"{value:.2f}" for value in theirs)]]
        for index in order:
            first, last, half = names[index]
            centres = f"{first} to {last} ± {half}"
            shown.append([centres, f"{distances[index]:.3f}", *(f"{value:.2f}" for value in rows[index])])
        words = f"{len(models)} tried. Median CIE 1976 difference over 1 to 5 reflections."
        yield Section(f"p = {p}", words, ("centres, nm", "apart", *map(str, range(1, paper.BOUNCES + 1))), shown)
    yield free_section(surfaces, lights)


def main(argv=None):
    """Print the nearest intervals -> exit status."""
    parser = argparse.ArgumentParser(prog="python -m relume.benchmarks.paper_intervals", description=__doc__)
    parser.add_argument("--reflectances", type=Path, metavar="CSV", required=True, help="the 170 of Vrhel and others")
    parser.add_argument("--out", type=Path, metavar="DIR", help="write Markdown and CSV files there too")
    options = parser.parse_args(argv)
    return status("intervals", lambda: publish("intervals", sections(files.read(options.reflectances)), options.out))


if __name__ == "__main__":
    sys.exit(main())
