"""Plays so many edits of a scripted artist and prints a tally: `python -m tests.artist EDITS [--seed N] …`."""

import argparse
import re
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from .play import Crew, play, sequence, shrunk, told


def _listed(text: str) -> list[str]:
    return [name for name in text.split(",") if name]


def main() -> int:
    """The status is 1 where anything differed."""
    parser = argparse.ArgumentParser(prog="python -m tests.artist")
    parser.add_argument("edits", type=int)
    parser.add_argument("--seed", type=int, default=0, help="that of the first sequence")
    parser.add_argument("--length", type=int, default=40, help="edits in a sequence")
    parser.add_argument("--every", type=int, default=4, help="edits between checks")
    parser.add_argument("--pictures", type=float, default=0.05, help="part of the checks that render")
    parser.add_argument("--scenes", type=_listed, default=[])
    parser.add_argument("--kinds", type=_listed, default=[], help="only these")
    parser.add_argument("--without", type=_listed, default=[], help="none of these")
    parser.add_argument("--ignore", type=re.compile, default="(?!)", help="differences that do not count: a pattern")
    parser.add_argument("--shrink", type=float, default=60.0, help="seconds for shortening a sequence that fails")
    parser.add_argument("--lines", type=int, default=12, help="differences printed of each failure")
    given = parser.parse_args()
    played, failed, causes, seed, began = 0, 0, Counter(), given.seed, time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        crew = Crew(Path(folder))
        kinds = [kind for kind in given.kinds or crew.kinds if kind not in given.without]
        try:
            while played < given.edits:
                take = sequence(seed, min(given.length, given.edits - played), given.scenes or crew.scenes, kinds)
                failure = play(crew, take, given.every, given.pictures, given.ignore)
                played += failure.at if failure else len(take.edits)
                if failure:
                    failed += 1
                    new = failure.causes - causes.keys()
                    causes.update(failure.causes)
                    if new:
                        print(told(seed, *shrunk(crew, take, failure, new, given.shrink), given.lines), flush=True)
                    else:
                        print(f"seed {seed}, {take}: again {min(failure.causes)}", flush=True)
                seed += 1
        finally:
            crew.stop()
    print(f"{played} edits in {seed - given.seed} sequences, {failed} failed, {time.monotonic() - began:.0f} s")
    for cause, count in causes.most_common(40):
        print(f"{count:6} {cause}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
