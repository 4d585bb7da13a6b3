"""Which intervals [DF] may have had: even ones tried for p = 3, 7 and 9, by how near Table 1 comes to the printed rows.

`python -m relume.benchmarks.paper_intervals --reflectances CSV`

[DF] prints its intervals for p = 5 only. Tried are evenly spaced centres, ten nanometres apart at either end, with
several widths. Nearness is the mean, over 1 to 5 reflections, of |log(here / printed)|.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

from ..core.colour import differences
from ..core.errors import ModelError
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


def medians(models, surfaces, lights, seed=2003):
    """Table 1's row for each of several models -> (models, 5)."""
    random, cmfs = np.random.default_rng(seed), paper.observer()
    found = []
    for _ in range(TRIALS):
        chosen = np.tile(np.arange(len(surfaces)), (paper.BOUNCES, 1))
        chosen[1:] = random.integers(len(surfaces), size=(paper.BOUNCES - 1, len(surfaces)))
        light, series = lights[random.integers(len(lights), size=len(surfaces))], surfaces[chosen]
        xyz, white = light * paper.accumulated(series, "paper") @ cmfs, light @ cmfs
        made = (paper.factors(model)(light, series, "paper") @ cmfs for model in models)
        found.append([np.median(differences.delta_E_1976(each, xyz, white), axis=1) for each in made])
    return np.median(found, axis=0)


def sections(reflectances):
    """The nearest intervals for each p."""
    surfaces, lights = paper.sampled(reflectances), np.stack([paper.paper_light(name) for name in paper.LIGHTS])
    for p, (firsts, lasts, halves) in TRIED.items():
        basis, models = paper.components(p, lights, surfaces), {}
        for first, last, half in ((a, b, c) for a in firsts for b in lasts for c in halves):
            try:
                models[first, last, half] = paper.eq_12(basis, paper.evenly(p, first, last, half))
            except ModelError:
                continue  # an interval without a sample
        theirs = np.array(printed.RANDOM_TABLES[1][p, "eq. 12"])
        rows = medians(models.values(), surfaces, lights)
        apart = np.abs(np.log(rows / theirs)).mean(axis=1)
        order = np.argsort(apart)[:SHOWN]
        names = list(models)
        shown = [["printed", "", *(f"{value:.2f}" for value in theirs)]]
        for index in order:
            first, last, half = names[index]
            centres = f"{first} to {last} ± {half}"
            shown.append([centres, f"{apart[index]:.3f}", *(f"{value:.2f}" for value in rows[index])])
        words = f"{len(models)} tried. Median CIE 1976 difference over 1 to 5 reflections."
        yield Section(f"p = {p}", words, ("centres, nm", "apart", *map(str, range(1, paper.BOUNCES + 1))), shown)


def main(argv=None):
    """Print the nearest intervals -> exit status."""
    parser = argparse.ArgumentParser(prog="python -m relume.benchmarks.paper_intervals", description=__doc__)
    parser.add_argument("--reflectances", type=Path, metavar="CSV", required=True, help="the 170 of Vrhel and others")
    parser.add_argument("--out", type=Path, metavar="DIR", help="write Markdown and CSV files there too")
    options = parser.parse_args(argv)
    return status("intervals", lambda: publish("intervals", sections(files.read(options.reflectances)), options.out))


if __name__ == "__main__":
    sys.exit(main())
