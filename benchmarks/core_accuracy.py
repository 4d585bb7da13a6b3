"""How near the models come to spectral integration, beside what was aimed at.

`python -m relume.benchmarks.core_accuracy [--reflectances CSV] [--out DIR]`

The reflectances should be ones that nothing was fitted to, as the 170 of Vrhel, Gershon and Iwan.
"""

import argparse
import itertools
import sys
from pathlib import Path

import numpy as np

from ..core import palette
from ..core.colour import differences
from ..core.model import bases, upsample
from ..core.spectra import files, library
from ..studies import experiments
from ..studies.reports import Section, publish, status

# channels: median, 90th, 99th percentile of CIEDE2000; under the CIE illuminants, under lamps never fitted to
AIMS = {
    3: ((0.90, 2.2, 4.3), (1.2, 3.2, 5.4)),
    6: ((0.22, 0.70, 1.5), (0.30, 1.0, 1.9)),
    9: ((0.08, 0.23, 0.50), (0.09, 0.28, 0.65)),
    12: ((0.05, 0.14, 0.30), (0.06, 0.19, 0.45)),
    15: ((0.03, 0.08, 0.19), (0.04, 0.12, 0.30)),
}
MORE_BOUNCES = 1.2  # times the aim for one bounce
PERCENTILES = (50, 90, 99)


def lights():
    """The 52 CIE illuminants that reach 780 nm, and the 56 measured lamps of colour-science."""
    cie = [name for family in library.cie_illuminants().values() for name in family]
    lamps = [*library.illuminants()["Measured lamps"], *library.LAMPS]
    return tuple([library.illuminant(name) for name in names] for names in (cie, lamps))


def verdict(reached, aim):
    """ "yes", or which percentiles miss the aim at the two decimals that it has."""
    missed = [f"{100 * r / a - 100:.0f} % at p{q}" for r, a, q in zip(reached, aim, PERCENTILES, strict=True) if r > a]
    return "yes" if not missed else "misses by " + ", ".join(missed)


def product_section(reflectances):
    """Products of one to three reflectances under either set of lights."""
    rows = []
    cie, lamps = lights()
    for p, (aim, aim_lamps) in AIMS.items():
        model = bases.fitted(p)
        cases = [(cie, 1, aim), (lamps, 1, aim_lamps)]
        cases += [(cie, count, tuple(MORE_BOUNCES * value for value in aim)) for count in (2, 3)]
        for chosen, count, limit in cases:
            reached = np.percentile(experiments.product_errors(model, reflectances, chosen, count), PERCENTILES)
            rows.append(
                [
                    p,
                    f"{len(chosen)} {'CIE illuminants' if chosen is cie else 'unseen lamps'}",
                    count,
                    " / ".join(f"{value:.3f}" for value in reached),
                    " / ".join(f"{value:.2f}" for value in limit),
                    verdict(reached, limit),
                ]
            )
    return Section(
        "Products",
        f"{len(reflectances)} reflectances; CIEDE2000, median / 90th / 99th percentile. For two and three bounces, of "
        f"400 random products, the aim is {MORE_BOUNCES} times that for one.",
        ("p", "lights", "bounces", "reached", "aim", "met"),
        rows,
    )


def metamer_section():
    """Metamers that match under D65 must come apart under A as they truly do."""
    pairs = palette.metamers(library.illuminant("D65"), 414)
    rows = []
    for p, aim in ((9, 10), (12, 5)):
        error = 100 * experiments.split_error(
            *experiments.metamer_splits(bases.fitted(p), pairs, library.illuminant("A"))
        )
        rows.append([p, f"{error:.1f} %", f"{aim} %", "yes" if error <= aim else "no"])
    words = f"{len(pairs)} constructed pairs: median error of the split under A, of those that can be seen."
    return Section("Metamers matched under D65", words, ("p", "reached", "aim", "met"), rows)


def rgb_section():
    """The sRGB cube under D65, there and back."""
    steps = np.linspace(0, 1, 13)
    cube = np.array(list(itertools.product(steps, repeat=3)))
    light = library.illuminant("D65")
    truth = cube @ upsample.rgb_to_xyz().T
    rows = []
    for p, aim, slack in ((6, 0.3, None), (9, 0.01, 0.002), (12, 0.01, 0.002), (15, 0.01, 0.002)):
        model = bases.fitted(p)
        coefficients = cube @ upsample.rgb_matrix(model).T
        matrix = model.relight(light)
        error = differences.delta_E_2000(coefficients @ matrix.T, truth, matrix.sum(axis=1)).max()
        low, high = coefficients.min(), coefficients.max()
        met = error <= aim and (slack is None or (low >= -slack and high <= 1 + slack))
        rows.append([p, f"{error:.1e}", aim, f"{low:.4f} to {high:.4f}", "yes" if met else "no"])
    words = f"{len(cube)} colours of the sRGB cube: largest CIEDE2000 of the round trip under D65."
    return Section("RGB round trip", words, ("p", "reached", "aim", "coefficients", "met"), rows)


def scene_section(reflectances):
    """Scene models: their own products, what is not in the scene, and lights known exactly."""
    patches = library.reflectances("colorchecker")[:10]
    own = np.stack([patch.sampled() for patch in patches])
    cie, _ = lights()
    rows = []

    def p99(model, spectra, chosen, counts=(1, 2, 3)):
        errors = [experiments.product_errors(model, spectra, chosen, count).ravel() for count in counts]
        return np.percentile(np.concatenate(errors), 99)

    for names in (("A", "FL2"), ("D65", "FL11"), ("A", "LED-B3")):
        chosen = [library.illuminant(name) for name in names]
        model = bases.scene(6, patches, chosen)
        inside = p99(model, own, chosen)
        beyond = p99(model, reflectances, cie, (1,)) / p99(bases.fitted(6), reflectances, cie, (1,))
        rows.append([f"p = 6, {' and '.join(names)}: p99 of its own products, up to 3 bounces", f"{inside:.2f}", "0.5"])
        rows.append(["   p99 beyond the scene, times that of fitted", f"{beyond:.2f}", "reported"])
    random = np.random.default_rng(0).random((200, 81))
    for (p, names), lobes in itertools.product(((6, ("D65",)), (12, ("A", "FL11"))), (False, True)):
        chosen = [library.illuminant(name) for name in names]
        model = bases.scene(p, patches, chosen, lobes=lobes)
        largest = experiments.product_errors(model, np.concatenate([reflectances, random]), chosen).max()
        what = f"p = {p}, {' and '.join(names)}{', with lobes' if lobes else ''}"
        lowest = model.filters.min() / model.filters.max()
        rows.append([f"{what}: largest of any reflectance, 1 bounce", f"{largest:.1e}", "1e-6"])
        rows.append(
            ["   its lowest filter value, as a part of the largest", f"{lowest:.3f}", "reported" if lobes else "0"]
        )
        rows.append(
            ["   p99 of its own products, 2 and 3 bounces", f"{p99(model, own, chosen, (2, 3)):.2f}", "reported"]
        )
    return Section("Scene models", "10 patches of the ColorChecker; CIEDE2000.", ("what", "reached", "aim"), rows)


def main(argv=None):
    """Print the tables -> exit status."""
    parser = argparse.ArgumentParser(prog="python -m relume.benchmarks.core_accuracy", description=__doc__)
    parser.add_argument("--reflectances", type=Path, metavar="CSV", help="default: the CES, which were fitted to")
    parser.add_argument("--out", type=Path, metavar="DIR", help="write Markdown and CSV files there too")
    options = parser.parse_args(argv)
    spectra = files.read(options.reflectances) if options.reflectances else library.reflectances("ces")
    values = np.stack([spectrum.sampled() for spectrum in spectra])
    makers = (lambda: product_section(values), metamer_section, rgb_section, lambda: scene_section(values))
    return status("core_accuracy", lambda: publish("core_accuracy", (make() for make in makers), options.out))


if __name__ == "__main__":
    sys.exit(main())
