"""Factor models that others have, on the same reflectances and lights, as published and with our matrix.

`python -m relume.benchmarks.prior_work [--reflectances CSV] [--out DIR]`

What of each description is inferred stands in `studies/prior_work.py`.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

from ..core.model import bases
from ..core.model.relight import power_weights, reconstructed_matrix
from ..core.spectra import files, library
from ..studies import levers, prior_work
from ..studies.reports import Section, publish, status

CHANNELS = (6, 9)
BOUNCES = (1, 3)


def codes(channels):
    """{name: (Code, or None where it is only filters; FactorModel)} for p."""
    made = {}
    if channels == 9:
        made["Lark's nine bins"] = prior_work.lark()
    made |= {name: make(channels) for name, make in prior_work.MAKERS.items()}
    found = {name: (code, code.model(name)) for name, code in made.items()}
    limits = levers.LIMITS
    for name, model in {
        "eq. 11 [DF]": bases.sharpened(channels, "lagrange", limits=limits),
        "eq. 12 [DF]": bases.sharpened(channels, limits=limits),
        "boxes, 420 to 680 nm": bases.block(channels, levers.NARROW),
        "ours": bases.fitted(channels),
    }.items():
        found[name] = prior_work.Code(model.filters, np.linalg.pinv(model.filters.T)), model
    return found


def as_published(code):
    """The light is one more factor, and the decoder makes the spectrum whose colour is seen."""

    def colours(model, light):
        observer = library.observer()
        power = light.sampled() / (light.sampled() @ observer[:, 1])
        # `model` has filters that sum to 1; numbers of the published code are those times the sums.
        sums = code.encoder.sum(axis=0)
        return observer.T @ (code.decoder * sums**2) * model.coefficients(power)

    return colours


def light_in_the_matrix(code):
    """The light at full resolution on what the decoder rebuilds, and white made exact."""
    sums = code.encoder.sum(axis=0)
    return lambda model, light: reconstructed_matrix(
        code.decoder * sums**2, power_weights(light.sampled(), library.observer())
    )


def sections(reflectances):
    """A table for each number of bounces."""
    values, lights = np.stack([spectrum.sampled() for spectrum in reflectances]), levers.cie_lights()
    every = {p: codes(p) for p in CHANNELS}
    for count in BOUNCES:
        rows = []
        for p, found in every.items():
            for name, (code, model) in found.items():
                ways = as_published(code), light_in_the_matrix(code), levers.fitted_matrix
                errors = (levers.way_errors(model, way, values, lights, count) for way in ways)
                rows.append([p, name, *map(levers.summary, errors)])
        words = (
            f"CIEDE2000 of {len(values) if count == 1 else 400} products under {len(lights)} CIE illuminants, median / "
            "90th / 99th percentile. As published, the light is one more factor."
        )
        head = ("p", "model", "light as a factor", "light in the matrix", "our fitted matrix")
        yield Section(f"{count} bounce{'s' * (count > 1)}", words, head, rows)


def main(argv=None):
    """Print the tables -> exit status."""
    parser = argparse.ArgumentParser(prog="python -m relume.benchmarks.prior_work", description=__doc__)
    parser.add_argument("--reflectances", type=Path, metavar="CSV", help="default: the CES, which were trained on")
    parser.add_argument("--out", type=Path, metavar="DIR", help="write Markdown and CSV files there too")
    options = parser.parse_args(argv)

    def make():
        spectra = files.read(options.reflectances) if options.reflectances else library.reflectances("ces")
        publish("prior_work", sections(spectra), options.out)

    return status("prior_work", make)


if __name__ == "__main__":
    sys.exit(main())
