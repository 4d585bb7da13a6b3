"""How a case of hostile input ends: with the right result, or with one clear line and the right exit status.

Anything else is an AssertionError: a traceback, several lines, silence, a wrong status, a result that is wrong.
"""

import os
import re
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

__all__ = ["RIGHT", "SAID", "Ended", "files_of", "of_call", "of_command", "seeds", "typed"]

RIGHT, SAID = "right", "said"
ROOT = Path(__file__).parents[2]
_LONGEST = 600  # characters that a reader still takes as one sentence, with a path in it
_LEFTOVERS = re.compile(r"\.relume-|\.part(ial)?\b")


@dataclass(frozen=True)
class Ended:
    """A command that came to its end: its exit status and what it printed."""

    status: int
    out: str
    err: str


def seeds(fast: int, torture: int) -> list[int]:
    """Seeds of a parametrised test: `fast` of them, or `torture` times RELUME_TORTURE when that variable is set.

    RELUME_SEED is the first one; the same number makes the same cases again.
    """
    first, scale = int(os.environ.get("RELUME_SEED", "0")), os.environ.get("RELUME_TORTURE")
    count = round(torture * float(scale)) if scale else fast
    return list(range(first, first + count))


def typed(line: str, folder: Path, shell: str = "bash", seconds: float = 300, **environment) -> Ended:
    """What a shell makes of a line typed in a folder, with the `relume` of this checkout on PATH."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    done = subprocess.run(
        [shell, "-c", line],
        cwd=folder,
        env=os.environ | {"PATH": path} | environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        errors="replace",
        timeout=seconds,
    )
    return Ended(done.returncode, done.stdout, done.stderr)


def of_command(ended: Ended, right: Callable[[], None] = lambda: None, status: Sequence[int] = (1, 2)) -> str:
    """`RIGHT` where a command succeeded and `right()` finds its results so; `SAID` where it refused in one line."""
    where = f"status {ended.status}\n{ended.out}\n{ended.err}"
    assert "Traceback" not in ended.err + ended.out, where
    if ended.status == 0:
        right()
        return RIGHT
    assert ended.status in status, where
    lines = ended.err.strip().splitlines()
    errors = [line for line in lines if line.startswith("relume") and not line.startswith("relume: warning")]
    assert errors and lines[-1] == errors[-1], f"the last line says nothing: {where}"
    assert len(errors) == 1, f"more than one line: {where}"
    _sentence(errors[0].partition(": ")[2])
    return SAID


def of_call(call: Callable[[], None]) -> str:
    """`RIGHT` where a call returns, `SAID` where it raises one of Relume's own errors with one line."""
    from relume.core.errors import RelumeError

    try:
        call()
    except RelumeError as error:
        _sentence(str(error))
        return SAID
    return RIGHT


def _sentence(words: str):
    assert words.strip(), "an error without words"
    assert "\n" not in words, words
    assert len(words) <= _LONGEST, words
    for raw in ("Traceback", "<class '", "object at 0x", "NoneType", "Error: Error"):
        assert raw not in words, words


def files_of(folder: Path) -> dict[str, bytes]:
    """{path: bytes} of all that is in a folder; fails where a run left something half-done behind."""
    found = {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}
    left = [str(p) for p in folder.rglob("*") if _LEFTOVERS.search(p.name)]
    assert not left, f"left behind: {left}"
    return found
