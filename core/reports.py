"""Reports of the command line: sections of words and a table, printed and written as Markdown and CSV."""

import csv
import os
import re
import sys
from dataclasses import dataclass

from . import results

__all__ = ["Section", "publish", "survive_closed_output"]


@dataclass(frozen=True)
class Section:
    """A heading, what to know about the table, its head and its rows; no table where there is no head."""

    name: str
    words: str
    head: tuple = ()
    rows: tuple = ()

    def markdown(self):
        """The section as text."""
        lines = [f"## {self.name}", "", self.words, ""]
        if self.head:
            cells = [self.head, ["---"] * len(self.head), *self.rows]
            lines += ["| " + " | ".join(str(cell) for cell in row) + " |" for row in cells] + [""]
        return "\n".join(lines)


def publish(title, sections, out=None):
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


def survive_closed_output(command):
    """Decorate a command: when what reads its output goes away, as `head` does, it ends without a word."""

    def wrapped(argv=None):
        try:
            return command(argv)
        except BrokenPipeError:
            # Python flushes the standard output at exit, which would fail again.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 1

    wrapped.__doc__ = command.__doc__
    return wrapped
