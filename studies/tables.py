"""The tables and figures of Drew & Finlayson, made again beside what they print: `relume tables`.

[DF] M. S. Drew, G. D. Finlayson, "Multispectral processing without spectra", JOSA A 20 (2003) 1181-1193.

What the paper does not say is inferred, and the report says so.
"""

import sys
from collections.abc import Iterator, Sequence

from ..core.spectra.spectrum import Spectrum
from . import levers, paper_figures, paper_tables, reports
from . import multispectral as paper

__all__ = ["main", "sections"]

INFERRED = f"""\
Reflectances: {{reflectances}}. Taken from the paper: {paper.WAVELENGTHS.size} samples from \
{paper.WAVELENGTHS[0]:.0f} to {paper.WAVELENGTHS[-1]:.0f} nm; lights {", ".join(paper.LIGHTS)}; eq. 12 with unit L2 \
norm over all wavelengths, then columns that sum to 1; its intervals for p = 5; the light as a factor, in every row \
but our own. Inferred:

- Intervals for the other p: {{intervals}}. Of the even ones that `python -m relume.benchmarks.paper_intervals` \
tries, those for 3 and 7 come nearest to the printed rows of Table 1. At 9 no even ones do; those are found by moving \
each towards the rows of Tables 1 and 3.
- FL2 is averaged over 10 nm; the other lights are sampled.
- Each light has Y = 1 for a white among the colour signals that the basis is made of.
- Bounces accumulate as a <- a (1 + S): so does the printed row of multiplied XYZ. What light between two surfaces \
does, S1 + S1 S2 + S1 S2 S3 + ..., has a table of its own.
- Table 2 lies a few percent above Table 1, so it cannot be a percentile over reflectances. Read as the 90th \
percentile, over repeated trials of random lights and bounces, of the median over the reflectances, it is reached.
- Its block filters are boxes on its intervals, which leave the wavelengths between them out.

The printed rows are of the 170 reflectances of Vrhel, Gershon and Iwan: give their file with --reflectances.
"""


def sections(reflectances: list[Spectrum], source: str) -> Iterator[reports.Section]:
    """Every table, for reflectances from `source`."""
    intervals = "; ".join(
        f"p = {p}: {', '.join(f'{low:.0f}-{high:.0f}' for low, high in paper.INTERVALS[p])}"
        for p in paper.CHANNELS
        if p != 5
    )
    words = INFERRED.format(reflectances=f"{len(reflectances)} of {source}", intervals=intervals)
    yield reports.Section("Inferred", words)
    yield paper_tables.signal_section(reflectances)
    yield paper_tables.three_bounces(reflectances)
    yield from paper_tables.random_sections(reflectances)
    yield from paper_tables.metamer_sections(reflectances)
    yield levers.section(reflectances)


def main(argv: Sequence[str] | None = None) -> int:
    """The command `relume tables` -> exit status."""
    words = "Print the tables of Drew & Finlayson (2003), beside what they print."
    return reports.run("tables", words, "light bounces off these", sections, paper_figures.draw, argv)


if __name__ == "__main__":
    sys.exit(main())
