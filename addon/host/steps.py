"""Work that is done piece by piece, by generators: what may be waited for yields, and returns what it found."""

from collections.abc import Generator

__all__ = ["finished"]


def finished(steps: Generator):
    """Do all the work of a generator at once; what it returns."""
    while True:
        try:
            next(steps)
        except StopIteration as done:
            return done.value
