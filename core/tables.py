"""The tables and figures of Drew & Finlayson, made again: `relume tables`.

[DF] M. S. Drew, G. D. Finlayson, "Multispectral processing without spectra", JOSA A 20 (2003) 1181-1193.

What the paper does not say is inferred, and the report says so.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

from . import bases, experiments, files, library, metamers, reports
from .factor_model import ModelError
from .spectrum import WAVELENGTHS, SpectrumError

__all__ = ["main"]

LIGHTS = ("A", "C", "D 4800 K", "D55", "D65", "D75", "D 10000 K")
CHANNELS = (3, 5, 7, 9)
BOUNCES = 5
PAIRS = 414
# Printed in [DF], over 1 to 5 bounces: {(table, p, method): ...}
PRINTED = {
    (1, None, "multiply XYZ"): (1.76, 1.99, 2.27, 2.67, 3.16),
    (1, 5, "best linear model"): (0.95, 0.96, 1.12, 1.34, 1.70),
    (1, 5, "eq. 12"): (2.51, 2.92, 3.58, 4.35, 6.25),
    (1, 7, "eq. 12"): (1.13, 1.31, 1.44, 1.78, 2.09),
    (1, 9, "eq. 12"): (0.88, 1.04, 1.15, 1.25, 1.81),
    (3, 5, "eq. 12"): (7.59, 7.50, 7.35, 7.90, 8.61),
}
TABLES = {
    1: ("Median CIE 1976 difference", lambda values: np.median(values, axis=(0, 1))),
    2: (
        "90th percentile over trials of the median over lights, CIE 1976",
        lambda values: np.percentile(np.median(values, axis=1), 90, axis=0),
    ),
    3: ("Median relative error of the rebuilt spectra, percent", lambda values: np.median(values, axis=(0, 1))),
}
RULES = {"paper": "", "physical": ", bounces added as S1 + S1 S2 + ..."}
INFERRED = f"""\
Reflectances: {{reflectances}}. What the paper does not say, or this project does not know of it, is inferred:

- Lights {", ".join(LIGHTS)}, from {experiments.PAPER_LIMITS[0]} to {experiments.PAPER_LIMITS[1]} nm.
- Bounces accumulate as a <- a (1 + S): so does the printed row of multiplied XYZ. What light between two surfaces does,
  S1 + S1 S2 + S1 S2 S3 + ..., stands in tables of its own.
- Table 2 is the 90th percentile over trials of the median over lights.
- Intervals are of equal width; the paper gives its own, for p = 5 only.
- Eq. 12 leaves the least energy outside its interval for unit area inside. With the least area outside instead, the
  rows for p = 7 and 9 come nearer to the printed ones.

The printed rows are of the 170 reflectances of Vrhel, Gershon and Iwan: give their file with --reflectances.
"""


def bounce_sections(reflectances, lights):
    """Tables 1 to 3, by either rule of accumulation, and what they say."""
    differences = {}
    for rule, suffix in RULES.items():
        results = {p: experiments.bounces(p, reflectances, lights, rule, BOUNCES) for p in CHANNELS}
        for number, (words, summary) in TABLES.items():
            rows = []
            for p in CHANNELS:
                for method, values in results[p][number == 3].items():
                    if method == "multiply XYZ" and p != CHANNELS[0]:
                        continue
                    shown = None if method == "multiply XYZ" else p
                    rows.append([shown or "-", method, *(f"{value:.2f}" for value in summary(values))])
                    printed = PRINTED.get((number, shown, method)) if rule == "paper" else None
                    if printed:
                        rows.append([shown or "-", f"{method}, printed", *(f"{value:.2f}" for value in printed)])
            head = ("p", "method", *map(str, range(1, BOUNCES + 1)))
            yield reports.Section(f"Table {number}{', physical' if suffix else ''}", f"{words}{suffix}.", head, rows)
        differences[rule] = {p: {m: float(np.median(v)) for m, v in results[p][0].items()} for p in CHANNELS}
    yield _findings(differences["paper"])


def _findings(medians):
    """Where the claims of [DF] hold and where not, from {p: {method: median difference over all bounces}}."""
    rows = []
    for p, by_method in medians.items():
        lagrange = by_method["eq. 11"]
        ratios = [by_method[m] / lagrange for m in ("eq. 12", "eq. 12, least area", "block filters", "fitted (ours)")]
        ratios += [by_method["eq. 12"] / by_method["multiply XYZ"], by_method["block filters"] / by_method["eq. 12"]]
        rows.append([p, *(f"{ratio:.2f}" for ratio in ratios)])
    return reports.Section(
        "What the tables say",
        "Median differences over all bounces as ratios. Eq. 12 buys filters that are nowhere negative, at the price "
        'of the first column. The paper calls block filters "overwhelmingly worse": adjoining blocks are so only '
        "where the last column is well above 1.",
        (
            "p",
            "eq. 12 / eq. 11",
            "least area / eq. 11",
            "block / eq. 11",
            "fitted / eq. 11",
            "eq. 12 / multiply XYZ",
            "block / eq. 12",
        ),
        rows,
    )


def three_bounce_section():
    """[DF] section 3.D."""
    rows = []
    for p in CHANNELS:
        for method, difference in experiments.three_bounces(p).items():
            if method != "multiply XYZ" or p == CHANNELS[-1]:
                rows.append(["-" if method == "multiply XYZ" else p, method, f"{difference:.2f}"])
    return reports.Section(
        "Section 3.D",
        "CIE 1976 difference after FL2 met light skin, foliage and blue sky; the published bases are specialised to "
        "the ColorChecker under FL2, ours is not.",
        ("p", "method", "difference"),
        rows,
    )


def metamer_sections():
    """Tables 4 and 5, on metamers constructed here."""
    for number, matched, others in ((4, "D65", ("A", "FL11")), (5, "A", ("D65", "FL2"))):
        pairs = metamers.metamers(library.illuminant(matched), PAIRS)
        models = {("eq. 12", p): bases.sharpened(p, "nonnegative") for p in CHANNELS[1:]}
        models |= {("fitted (ours)", p): bases.fitted(p) for p in (3, 6, 9, 12, 15)}
        rows = []
        for (method, p), model in models.items():
            for name in (matched, *others):
                true, seen = experiments.metamer_splits(model, pairs, library.illuminant(name))
                error = "-" if name == matched else f"{100 * experiments.split_error(true, seen):.1f}"
                rows.append([p, method, name, f"{np.median(true):.2f}", f"{np.median(seen):.2f}", error])
        yield reports.Section(
            f"Table {number}",
            f"{PAIRS} constructed pairs that match under {matched}: medians of the CIEDE2000 between the two of a "
            "pair, and of the error of their split where it is above 1.",
            ("p", "method", "light", "true", "seen", "error of the split, %"),
            rows,
        )


def draw_figures(out):
    """Figures 1 and 2 of [DF] as PNG: basis vectors, and spectra over three bounces. Raises ImportError."""
    from matplotlib.figure import Figure

    light, chart = library.illuminant("FL2"), library.reflectances("colorchecker")
    figure = Figure(figsize=(12, 7), layout="constrained")
    models = {
        "principal components": None,
        **experiments.published(5, [light], chart, experiments.PAPER_LIMITS),
        "fitted (ours)": bases.fitted(5),
    }
    for axes, (title, model) in zip(figure.subplots(2, 3).flat, models.items(), strict=False):
        # The components span what eq. 11 makes of them.
        shown = np.linalg.qr(models["eq. 11"].filters)[0] if model is None else model.filters
        axes.plot(WAVELENGTHS, shown)
        axes.set(title=f"{title}, p = 5", xlabel="wavelength, nm")
    figure.delaxes(figure.axes[-1])
    figure.savefig(out / "figure_1.png", dpi=110)

    surfaces = experiments.three_surfaces()
    figure = Figure(figsize=(12, 3.6), layout="constrained")
    models = {
        "eq. 12, p = 9": bases.sharpened(9, "nonnegative", [light], chart, limits=experiments.PAPER_LIMITS),
        "fitted, p = 9": bases.fitted(9),
    }
    for count, axes in enumerate(figure.subplots(1, 3), start=1):
        axes.plot(WAVELENGTHS, surfaces[:count].prod(axis=0), "k", label="true")
        for label, model in models.items():
            product = model.coefficients(surfaces[:count]).prod(axis=0)
            axes.plot(WAVELENGTHS, model.reconstruct(product), "--", label=label)
        axes.set(title=f"{count} bounce{'s' * (count > 1)}", xlabel="wavelength, nm", ylabel="reflectance")
        axes.legend()
    figure.savefig(out / "figure_2.png", dpi=110)


def draw_table(section, out):
    """Table 1 as a PNG: difference over bounces, a panel for each p. Raises ImportError."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(14, 4), layout="constrained")
    steps = np.arange(1, BOUNCES + 1)
    colours = {}
    for axes, p in zip(figure.subplots(1, len(CHANNELS), sharey=True), CHANNELS, strict=True):
        for shown, label, *values in section.rows:
            if shown in (p, "-"):
                method, printed, _ = label.partition(", printed")
                colour = colours.setdefault(method, f"C{len(colours)}")
                axes.semilogy(steps, [float(v) for v in values], ":" if printed else "-", color=colour, label=label)
        axes.set(title=f"p = {p}", xlabel="bounces", xticks=steps)
    figure.axes[0].set_ylabel("median CIE 1976 difference")
    lines = {line.get_label(): line for axes in figure.axes for line in axes.lines}
    figure.legend(lines.values(), lines.keys(), loc="outside right upper", fontsize="small")
    figure.savefig(out / "table_1.png", dpi=110)


@reports.survive_closed_output
def main(argv=None):
    """The command `relume tables` -> exit status."""
    parser = argparse.ArgumentParser(prog="relume tables", description="Print the tables of Drew & Finlayson (2003).")
    parser.add_argument("--reflectances", type=Path, metavar="CSV", help="light bounces off these; default: the CES")
    parser.add_argument("--out", type=Path, metavar="DIR", help="write Markdown, CSV and PNG files there too")
    options = parser.parse_args(argv)

    def sections():
        reflectances = files.read(options.reflectances) if options.reflectances else library.reflectances("ces")
        source = options.reflectances.name if options.reflectances else "the CES (CIE 224)"
        yield reports.Section("Inferred", INFERRED.format(reflectances=f"{len(reflectances)} of {source}"))
        yield from bounce_sections(reflectances, [library.illuminant(light) for light in LIGHTS])
        yield three_bounce_section()
        yield from metamer_sections()

    try:
        done = reports.publish("tables", sections(), options.out)
        if options.out:
            draw_figures(options.out)
            draw_table(next(section for section in done if section.name == "Table 1"), options.out)
            print(f"written to {options.out}")
    except ImportError as error:
        print(f"relume tables: no pictures without {error.name}", file=sys.stderr)
        return 1
    except BrokenPipeError:
        raise
    except (OSError, SpectrumError, ModelError, library.LibraryError) as error:
        print(f"relume tables: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
