"""The command `relume palette`: a design solved, with its spectra, pictures and a table of what it came to."""

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from ..core.palette import colours
from ..core.palette.report import Report, report
from ..core.palette.solve import Solution, create
from ..core.palette.tables import read
from ..core.spectra import files
from ..core.spectra.arrays import Array
from ..core.spectra.spectrum import WAVELENGTHS
from . import figures, reports

__all__ = ["main", "sections"]


def sections(solution: Solution, found: Report) -> Iterator[reports.Section]:
    """The report of a design as sections of words and tables."""
    head = ("cell", "wanted", "full spectra", "ΔE2000", "model", "ΔE2000 of both", "nearest alone", "ΔE2000 of it")
    rows = tuple(
        (
            cell.where,
            colours.encoded(cell.wanted),
            *_colour(cell.full, cell.error),
            *_colour(cell.model, cell.model_error),
            *_colour(cell.nearest, cell.nearest_error),
        )
        for cell in found.cells
    )
    words = "\n".join(found.remarks) or "Every demand is met."
    yield reports.Section(solution.palette.title or "Palette", words, head if rows else (), rows)
    if found.differences:
        asked = tuple((words, demand, f"{reached:.2f}") for words, demand, reached, _ in found.differences)
        yield reports.Section("Differences", "CIEDE2000 between reflectances.", ("between", "asked for", "is"), asked)
    if found.constancies:
        kept = tuple((words, f"{largest:.2f}") for words, largest in found.constancies)
        yield reports.Section("Constancy", "The largest CIEDE2000 between lights.", ("reflectance", "is"), kept)
    if solution.free:
        free = tuple((name, colours.encoded(colours.xyz_from_rgb(rgb))) for name, rgb in sorted(solution.free.items()))
        yield reports.Section("Free colours", "What they came to.", ("free colour", "is"), free)


def _colour(xyz: Array | None, error: float | None) -> tuple[str, str]:
    """The words for a colour and its error; none where there is none."""
    return ("", "") if xyz is None else (colours.encoded(xyz), f"{error:.2f}")


def main(argv: Sequence[str] | None = None) -> int:
    """`relume palette DESIGN.toml [--out DIR]` -> exit status."""
    parser = argparse.ArgumentParser(
        prog="relume palette", description="Find the lights and reflectances that make the colours of a design."
    )
    parser.add_argument("design", metavar="DESIGN.toml", type=Path, help="docs/palette.md says what it holds")
    parser.add_argument("--out", type=Path, metavar="DIR", help="write spectra, pictures and tables there")
    options = parser.parse_args(argv)

    def make() -> None:
        solution = create(read(options.design))
        found = report(solution)
        reports.publish("palette", sections(solution, found), options.out)
        if options.out:
            _write(solution, found, options.out)
            print(f"written to {options.out}")

    return reports.status("palette", make)


def _write(solution: Solution, found: Report, folder: Path) -> None:
    """The designed spectra as CSV, and the pictures where matplotlib is there to draw them."""
    palette, panels = solution.palette, []
    for kind, entries in (("light", palette.lights), ("reflectance", palette.reflectances)):
        made = [entry.spectrum for entry in entries if entry.designed and entry.spectrum]
        if made:
            files.write(folder / f"{kind}s.csv", made)
        peaks = [np.abs(values).max() or 1.0 if kind == "light" else 1.0 for values in palette.sampled(kind)]
        lines = [
            (entry.name, WAVELENGTHS, values / peak, "-" if entry.designed else "--")
            for entry, values, peak in zip(entries, palette.sampled(kind), peaks, strict=True)
        ]
        panels.append(figures.Panel("nm", lines, title=f"{kind}s, those designed solid"))
    if figures.available():
        figures.design_matrix(folder / "matrix.png", palette, found)
        figures.curves(folder / "curves.png", panels)
    else:
        print("no pictures without matplotlib", file=sys.stderr)
