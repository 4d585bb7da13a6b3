"""Numbered files: a name with #### for the frame."""

import re
from pathlib import Path

from ..errors import SequenceError

__all__ = ["SequenceError", "files", "is_pattern", "numbered"]


def is_pattern(path) -> bool:
    """Whether a path stands for a sequence: its name has a # and is not that of a file that is there."""
    return "#" in Path(path).name and not Path(path).is_file()


def _split(path: Path) -> tuple[str, int, str]:
    found = re.fullmatch(r"([^#]*)(#+)([^#]*)", path.name)
    if not found:
        raise SequenceError(f"{path}: expected one run of # for the frame number, as in shot.####.exr")
    return found[1], len(found[2]), found[3]


def numbered(pattern, frame: int) -> Path:
    """The file of one frame; the number has at least as many digits as the pattern has #. Raises SequenceError."""
    pattern = Path(pattern)
    before, digits, after = _split(pattern)
    return pattern.with_name(f"{before}{frame:0{digits}d}{after}")


def files(pattern) -> dict[int, Path]:
    """{frame: path} of a sequence in order. Raises SequenceError where frames are missing, or there twice."""
    pattern = Path(pattern)
    before, digits, after = _split(pattern)
    name = re.compile(rf"{re.escape(before)}(\d{{{digits},}}){re.escape(after)}")
    folder = pattern.parent
    found = {}
    for path in folder.iterdir() if folder.is_dir() else ():
        match = name.fullmatch(path.name)
        if match:
            other = found.setdefault(int(match[1]), path)
            if other != path:
                raise SequenceError(f"{pattern}: {other.name} and {path.name} are both frame {int(match[1])}")
    if not found:
        raise SequenceError(f"{pattern}: no such files")
    missing = [frame for frame in range(min(found), max(found) + 1) if frame not in found]
    if missing:
        raise SequenceError(f"{pattern}: frames are missing: {_ranges(missing)}")
    return dict(sorted(found.items()))


def _ranges(frames: list[int]) -> str:
    """Sorted numbers in words: "3, 7-9"."""
    runs = []
    for frame in frames:
        if runs and frame == runs[-1][1] + 1:
            runs[-1][1] = frame
        else:
            runs.append([frame, frame])
    return ", ".join(str(a) if a == b else f"{a}-{b}" for a, b in runs)
