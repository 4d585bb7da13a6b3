"""The tables and figures of Drew & Finlayson, made again: `relume tables`.

[DF] M. S. Drew, G. D. Finlayson, "Multispectral processing without spectra", JOSA A 20 (2003) 1181-1193.

What the paper does not say is inferred, and the report says so.
"""

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from ..core import palette
from ..core.model import bases
from ..core.spectra import library
from ..core.spectra.spectrum import WAVELENGTHS, Spectrum
from . import experiments, figures, reports

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
  S1 + S1 S2 + S1 S2 S3 + ..., has tables of its own.
- Table 2 is the 90th percentile over trials of the median over lights.
- Intervals are of equal width; the paper gives its own, for p = 5 only.
- Eq. 12 leaves the least energy outside its interval for unit area inside. With the least area outside instead, the
  rows for p = 7 and 9 come nearer to the printed ones.

The printed rows are of the 170 reflectances of Vrhel, Gershon and Iwan: give their file with --reflectances.
"""


def bounce_sections(reflectances: list[Spectrum], lights: list[Spectrum]) -> Iterator[reports.Section]:
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


def _findings(medians: dict[int, dict[str, float]]) -> reports.Section:
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


def three_bounce_section() -> reports.Section:
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


def metamer_sections() -> Iterator[reports.Section]:
    """Tables 4 and 5, on metamers constructed here."""
    for number, matched, others in ((4, "D65", ("A", "FL11")), (5, "A", ("D65", "FL2"))):
        pairs = palette.metamers(library.illuminant(matched), PAIRS)
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


def draw_figures(out: Path) -> None:
    """Figures 1 and 2 of [DF] as PNG: basis vectors, and spectra over three bounces. Raises ImportError."""
    light, chart = library.illuminant("FL2"), library.reflectances("colorchecker")
    models = experiments.published(5, [light], chart, experiments.PAPER_LIMITS) | {"fitted (ours)": bases.fitted(5)}
    # The components span what eq. 11 makes of them.
    shown = {"principal components": np.linalg.qr(models["eq. 11"].filters)[0]}
    shown |= {title: model.filters for title, model in models.items()}
    nm = "wavelength, nm"
    panels = [
        figures.Panel(nm, [("", WAVELENGTHS, column, "-") for column in columns.T], title=f"{title}, p = 5")
        for title, columns in shown.items()
    ]
    figures.curves(out / "figure_1.png", panels, columns=3)

    surfaces, panels = experiments.three_surfaces(), []
    models = {
        "eq. 12, p = 9": bases.sharpened(9, "nonnegative", [light], chart, limits=experiments.PAPER_LIMITS),
        "fitted, p = 9": bases.fitted(9),
    }
    for count in (1, 2, 3):
        lines = [("true", WAVELENGTHS, surfaces[:count].prod(axis=0), "-k")]
        for label, model in models.items():
            product = model.coefficients(surfaces[:count]).prod(axis=0)
            lines.append((label, WAVELENGTHS, model.reconstruct(product), "--"))
        panels.append(figures.Panel(nm, lines, "reflectance", f"{count} bounce{'s' * (count > 1)}"))
    figures.curves(out / "figure_2.png", panels)


def draw_table(section: reports.Section, out: Path) -> None:
    """Table 1 as a PNG: difference over bounces, a panel for each p. Raises ImportError."""
    steps = np.arange(1, BOUNCES + 1)
    colours: dict[str, str] = {}
    panels = []
    for p in CHANNELS:
        lines = []
        for shown, label, *values in section.rows:
            if shown in (p, "-"):
                method, printed, _ = label.partition(", printed")
                colour = colours.setdefault(method, f"C{len(colours)}")
                lines.append((label, steps, [float(value) for value in values], (":" if printed else "-") + colour))
        panels.append(figures.Panel("bounces", lines, "median CIE 1976 difference", f"p = {p}", "y", steps))
    figures.curves(out / "table_1.png", panels)


def sections(reflectances: list[Spectrum], source: str) -> Iterator[reports.Section]:
    """Every table, for reflectances from `source`."""
    yield reports.Section("Inferred", INFERRED.format(reflectances=f"{len(reflectances)} of {source}"))
    yield from bounce_sections(reflectances, [library.illuminant(light) for light in LIGHTS])
    yield three_bounce_section()
    yield from metamer_sections()


def draw(done: list[reports.Section], reflectances: list[Spectrum], out: Path) -> None:
    """The figures and table 1 as PNG. Raises ImportError."""
    draw_figures(out)
    draw_table(next(section for section in done if section.name == "Table 1"), out)


def main(argv: Sequence[str] | None = None) -> int:
    """The command `relume tables` -> exit status."""
    words = "Print the tables of Drew & Finlayson (2003)."
    return reports.run("tables", words, "light bounces off these", sections, draw, argv)


if __name__ == "__main__":
    sys.exit(main())
