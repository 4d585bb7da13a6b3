"""Figures 1 to 4 and 6 of Drew & Finlayson as curves; Figures 5 and 7 are renders (`make gallery`).

[DF] M. S. Drew, G. D. Finlayson, "Multispectral processing without spectra", JOSA A 20 (2003) 1181-1193.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..core.spectra.arrays import Array
from ..core.spectra.spectrum import WAVELENGTHS as FINE
from ..core.spectra.spectrum import Spectrum
from . import figures, paper_tables
from . import multispectral as paper
from .figures import Panel
from .reports import Section

__all__ = ["draw"]

NM = "wavelength, nm"


def draw(done: Sequence[Section], reflectances: Sequence[Spectrum], out: Path) -> None:
    """Write figure_1.png to figure_4.png, figure_6.png and table_1.png. Raises ImportError without matplotlib."""
    lights = np.stack([paper.paper_light(name) for name in paper.LIGHTS])
    surfaces = paper.sampled(reflectances)
    five, seven = (paper.components(p, lights, surfaces) for p in (5, paper_tables.SEVEN))
    figures.curves(out / "figure_1.png", figure_1(five))
    figures.curves(out / "figure_2.png", figure_2(five))
    figures.curves(out / "figure_3.png", figure_3())
    figures.curves(out / "figure_4.png", figure_4(seven))
    figures.curves(out / "figure_6.png", figure_6(), columns=6)
    table = next(section for section in done if section.name == "Table 1")
    figures.curves(out / "table_1.png", table_panels(table))


def figure_1(basis: Array) -> list[Panel]:
    """(a) the first five singular vectors, (b) what eq. 12 makes of them, and its filters of unit length."""
    filters = paper.eq_12(basis).filters
    shown = {"(a) singular vectors": basis, "(b) sharpened": filters / np.linalg.norm(filters, axis=0)}
    return [Panel(NM, [("", paper.WAVELENGTHS, column, "-") for column in v.T], title=t) for t, v in shown.items()]


def figure_2(basis: Array) -> list[Panel]:
    """D65 off light skin, foliage and blue sky: exact, best least squares, spectral factor model."""
    light, series = paper.paper_light("D65"), paper_tables.three_surfaces()
    model = paper.eq_12(basis)
    panels = []
    lines = {
        "exact": (light * paper.accumulated(series, "last"), "-k"),
        "best least squares": (paper.best_linear(basis)(light, series, "last"), ":C0"),
        "spectral factor model": (paper.factors(model)(light, series, "last"), "--C3"),
    }
    for bounce, letter in enumerate("abc"):
        drawn = [(name, paper.WAVELENGTHS, values[bounce], style) for name, (values, style) in lines.items()]
        panels.append(
            Panel(
                NM, drawn, "colour signal" if not bounce else "", f"({letter}) {bounce + 1} bounce{'s' * (bounce > 0)}"
            )
        )
    return panels


def figure_3() -> list[Panel]:
    """The three pairs."""
    return [
        Panel(NM, [("one", FINE, first, "-C0"), ("its metamer", FINE, second, "--C0")], title=f"({letter})")
        for letter, (first, second) in zip("abc", paper.metamer_pairs(), strict=True)
    ]


def figure_4(basis: Array) -> list[Panel]:
    """Colour signals of the pairs under A, and the spectral factor model of seven."""
    light, pairs = paper.paper_light("A"), paper.sampled_values(paper.metamer_pairs())
    made = paper.factors(paper.eq_12(basis))(light, pairs[None], "last")[0]
    panels = []
    for letter, pair, rebuilt in zip("abc", pairs, made, strict=True):
        lines = [("exact", paper.WAVELENGTHS, light * values, f"-C{i}") for i, values in enumerate(pair)]
        lines += [("factor model", paper.WAVELENGTHS, values, f"--C{i}") for i, values in enumerate(rebuilt)]
        panels.append(Panel(NM, lines, title=f"({letter})"))
    return panels


def figure_6() -> list[Panel]:
    """Colour signals of one to six bounces of D65 and A off the six metamers, accumulated."""
    six = paper.sampled_values(paper.metamer_pairs()).reshape(6, -1)
    basis = paper.components(paper_tables.SEVEN, np.stack([paper.paper_light(name) for name in ("D65", "A")]), six)
    model, panels = paper.eq_12(basis), []
    for name in ("D65", "A"):
        light = paper.paper_light(name)
        true, made = light * paper.accumulated(six, "paper"), paper.factors(model)(light, six, "paper")
        for bounce in range(6):
            lines = [
                ("exact", paper.WAVELENGTHS, true[bounce], "-k"),
                ("factor model", paper.WAVELENGTHS, made[bounce]),
            ]
            lines[1] = (*lines[1], "--C3")
            panels.append(Panel(NM, lines, title=f"{name}, {bounce + 1}"))
    return panels


def table_panels(section: Section) -> list[Panel]:
    """Table 1 as difference over bounces, a panel for each p."""
    steps = np.arange(1, paper.BOUNCES + 1)
    colours: dict[str, str] = {}
    panels = []
    for p in paper.CHANNELS:
        lines = []
        for shown, label, *values in section.rows:
            if shown in (p, "-"):
                method, printed, _ = label.partition(", printed")
                colour = colours.setdefault(method, f"C{len(colours)}")
                lines.append((label, steps, [float(value) for value in values], (":" if printed else "-") + colour))
        panels.append(Panel("bounces", lines, "median CIE 1976 difference", f"p = {p}", "y", steps))
    return panels
