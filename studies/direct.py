"""One more matrix, for light that is reflected once: what it gives over one matrix for everything.

    python -m relume.studies.direct [--reflectances FILE]

Cycles stores direct and indirect light apart, so they could be recombined by matrices of their own: one fitted to
single reflectances, one to products of two and three. *Exact* is a scene's own model for lamps that are known, with
which the first bounce is exact by construction.
"""

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from ..core.model import bases, relight, training
from ..core.model.factor_model import FactorModel
from ..core.model.optimise import BOUNCES
from ..core.spectra import files, library
from ..core.spectra.arrays import Array
from ..core.spectra.spectrum import Spectrum
from .levers import cie_lights, summary, way_errors
from .reports import Section, publish

CHANNELS = (3, 6, 9)
KNOWN = ("A", "FL2")


def fitted_to(bounces: Sequence[float]) -> Callable[[FactorModel, Spectrum], Array]:
    """A way to make the matrix: fitted to products of 1, 2 and 3 reflectances that count so much."""

    def matrix(model: FactorModel, light: Spectrum) -> Array:
        spectra = training.reflectances()
        drawn = training.products(spectra, bounces, most=500)
        truth, metric, white = relight.targets(drawn, relight.power_weights(light.sampled(), library.observer())[None])
        coefficients = drawn.coefficients(model.coefficients(spectra))
        return relight.fitted_matrices(coefficients, truth, metric, white)[0]

    return matrix


def section(spectra: Array) -> Section:
    """One matrix and two, for one bounce and for two."""
    lights, rows = cie_lights()[::4], []
    ways = {"one matrix": (BOUNCES, BOUNCES), "two matrices": ((1.0, 0.0, 0.0), (0.0, *BOUNCES[1:]))}
    for p in CHANNELS:
        for name, kinds in ways.items():
            made = [way_errors(bases.fitted(p), fitted_to(kinds[n]), spectra, lights, n + 1) for n in range(2)]
            rows.append([p, name, *map(summary, made)])
    known = [library.illuminant(name) for name in KNOWN]
    for p in CHANNELS[1:]:
        for exact in (False, True):
            model = bases.scene(p, library.reflectances("colorchecker"), known, exact=exact)
            made = [way_errors(model, lambda m, light: m.relight(light), spectra, known, n + 1) for n in range(2)]
            rows.append([p, f"{'exact' if exact else 'not exact'} for {' and '.join(KNOWN)}", *map(summary, made)])
    words = (
        f"CIEDE2000 of {len(spectra)} reflectances and of products of two, median / 90th / 99th percentile, under "
        f"{len(lights)} CIE illuminants; in the last rows filters are those of a scene with the ColorChecker's "
        "reflectances and two lamps, under these."
    )
    return Section("A matrix for direct light", words, ("p", "matrices", "one bounce", "two"), rows)


def main(argv: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m relume.studies.direct", description=__doc__)
    parser.add_argument("--reflectances", type=Path, metavar="FILE", help="to judge by (the CES of colour-science)")
    options = parser.parse_args(argv)
    judges = files.read(options.reflectances, "reflectance") if options.reflectances else library.reflectances("ces")
    publish("direct", [section(np.stack([spectrum.sampled() for spectrum in judges]))])
    return 0


if __name__ == "__main__":
    sys.exit(main())
