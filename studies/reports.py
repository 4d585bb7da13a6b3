"""Reports of the command line: sections of words and a table, printed and written as Markdown and CSV."""

import argparse
import csv
import os
import re
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from ..core import results
from ..core.errors import RelumeError
from ..core.spectra import files, library
from ..core.spectra.spectrum import Spectrum

__all__ = ["Section", "publish", "run", "status"]


@dataclass(frozen=True)
class Section:
    """A heading, what to know about the table, its head and its rows; no table where there is no head."""

    name: str
    words: str
    head: Sequence[str] = ()
    rows: Sequence[Sequence] = ()

    def markdown(self) -> str:
        """The section as text."""
        lines = [f"## {self.name}", "", self.words, ""]
        if self.head:
            cells = [self.head, ["---"] * len(self.head), *self.rows]
            lines += ["| " + " | ".join(str(cell) for cell in row) + " |" for row in cells] + [""]
        return "\n".join(lines)


def publish(title: str, sections: Iterable[Section], out: Path | None = None) -> list[Section]:
    """Print each section as soon as it is made -> all of them. With `out`, a folder, write <title>.md and CSV files.

    Raises OSError.
    """
    if out:
        out.mkdir(parents=True, exist_ok=True)
    done = []
    for section in sections:
        print(section.markdown(), flush=True)
        done.append(section)
        if out and section.head:
            path = out / (re.sub("[^a-z0-9]+", "_", section.name.lower()).strip("_") + ".csv")
            with results.replacing(path) as partial, open(partial, "w", newline="", encoding="utf-8") as file:
                csv.writer(file).writerows([section.head, *section.rows])
    if out:
        results.write_text(out / f"{title}.md", "\n".join(section.markdown() for section in done))
    return done


def status(title: str, make: Callable[[], object]) -> int:
    """Make what the command `relume <title>` makes -> its exit status; what goes wrong is printed as a sentence.

    When what reads its output goes away, as `head` does, it ends without a word.
    """
    try:
        make()
        return 0
    except BrokenPipeError:
        # Python flushes the standard output at exit, which would fail again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except ImportError as error:
        print(f"relume {title}: no pictures without {error.name}", file=sys.stderr)
    except (OSError, RelumeError) as error:
        print(f"relume {title}: {error}", file=sys.stderr)
    return 1


def run(
    title: str,
    description: str,
    use: str,
    sections: Callable[[list[Spectrum], str], Iterable[Section]],
    draw: Callable[[list[Section], list[Spectrum], Path], None],
    argv: Sequence[str] | None = None,
) -> int:
    """The command `relume <title>`, which publishes sections(reflectances, where they are from) -> exit status.

    use: what the reflectances are for. With --out it draws too.
    """
    parser = argparse.ArgumentParser(prog=f"relume {title}", description=description)
    parser.add_argument("--reflectances", type=Path, metavar="CSV", help=f"{use}; default: the CES")
    parser.add_argument("--out", type=Path, metavar="DIR", help="write Markdown, CSV and PNG files there too")
    options = parser.parse_args(argv)

    def make() -> None:
        spectra = files.read(options.reflectances) if options.reflectances else library.reflectances("ces")
        source = options.reflectances.name if options.reflectances else "the CES (CIE 224)"
        done = publish(title, sections(spectra, source), options.out)
        if options.out:
            draw(done, spectra, options.out)
            print(f"written to {options.out}")

    return status(title, make)
