"""The command `relume palette`: a design solved, with its spectra, pictures and a table of what it came to."""

import argparse
import sys
from pathlib import Path

from ..core.errors import RelumeError
from ..core.palette import colours, pictures
from ..core.palette.report import report
from ..core.palette.solve import create
from ..core.palette.tables import read
from ..core.spectra import files
from . import figures, reports

__all__ = ["main", "sections"]


def sections(solution, told):
    """The report of a design as sections of words and tables."""
    head = ("cell", "wanted", "full spectra", "ΔE2000", "model", "ΔE2000 of both", "nearest alone", "ΔE2000 of it")
    rows = tuple(
        (
            cell.where,
            colours.encoded(cell.wanted),
            colours.encoded(cell.full),
            f"{cell.error:.2f}",
            "" if cell.model is None else colours.encoded(cell.model),
            "" if cell.model is None else f"{cell.model_error:.2f}",
            "" if cell.nearest is None else colours.encoded(cell.nearest),
            "" if cell.nearest is None else f"{cell.nearest_error:.2f}",
        )
        for cell in told.cells
    )
    words = "\n".join(told.remarks) or "Every demand is met."
    yield reports.Section(solution.palette.title or "Palette", words, head if rows else (), rows)
    if told.differences:
        asked = tuple((words, demand, f"{reached:.2f}") for words, demand, reached, _ in told.differences)
        yield reports.Section("Differences", "CIEDE2000 between reflectances.", ("between", "asked for", "is"), asked)
    if told.constancies:
        kept = tuple((words, f"{largest:.2f}") for words, largest in told.constancies)
        yield reports.Section("Constancy", "The largest CIEDE2000 between lights.", ("reflectance", "is"), kept)
    if solution.free:
        found = tuple((name, colours.encoded(colours.xyz_from_rgb(rgb))) for name, rgb in sorted(solution.free.items()))
        yield reports.Section("Free colours", "What they came to.", ("free colour", "is"), found)


@reports.survive_closed_output
def main(argv=None):
    """`relume palette DESIGN.toml [--out DIR]` -> exit status."""
    parser = argparse.ArgumentParser(
        prog="relume palette", description="Find the lights and reflectances that make the colours of a design."
    )
    parser.add_argument("design", metavar="DESIGN.toml", type=Path, help="docs/palette.md says what it holds")
    parser.add_argument("--out", type=Path, metavar="DIR", help="write spectra, pictures and tables there")
    options = parser.parse_args(argv)
    try:
        solution = create(read(options.design))
        reports.publish("palette", sections(solution, report(solution)), options.out)
        if options.out:
            _write(solution, options.out)
            print(f"written to {options.out}")
    except BrokenPipeError:
        raise
    except (OSError, RelumeError) as error:
        print(f"relume palette: {error}", file=sys.stderr)
        return 1
    return 0


def _write(solution, folder):
    """The designed spectra as CSV, and the pictures where matplotlib is there to draw them."""
    palette = solution.palette
    for name, entries in (("lights", palette.lights), ("reflectances", palette.reflectances)):
        made = [entry.spectrum for entry in entries if entry.designed]
        if made:
            files.write(folder / f"{name}.csv", made)
    if figures.available():
        pictures.matrix(folder / "matrix.png", palette, report(solution))
        pictures.curves(folder / "curves.png", palette)
    else:
        print("no pictures without matplotlib", file=sys.stderr)
