"""Memory that coefficients take in Relume's hands: to write a file of them, to read it, to relight it.

`python -m relume.benchmarks.memory [--megapixels A B] [--groups N]`

Two sizes are measured, each in a process of its own that has done the same in small before; what the larger one held
more, over its additional pixels, leaves out what does not grow. In floats for each pixel: nine channels of two light
groups are 18 of them, a picture with alpha 4. *Relight* ends in a PNG, which Blender makes of a picture of its own.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

_CHANNELS = 9
_FLOAT = 4  # bytes
_WORKS = ("write", "read", "relight")


def _held(which: str) -> int:
    """Bytes that this process holds ("VmRSS"), or held at most ("VmHWM")."""
    words = Path("/proc/self/status").read_text(encoding="ascii").split()
    return int(words[words.index(f"{which}:") + 1]) * 1024


def _image(side: int, groups: int):
    """A square coefficient image of noise, and its picture."""
    from ..core.model import bases
    from ..core.picture.coefficients import CoefficientImage
    from ..core.spectra import library

    random, names = np.random.default_rng(side), [f"group {n}" for n in range(groups)]
    pixels = {name: random.random((side, side, _CHANNELS), dtype=np.float32) for name in names}
    illuminants = {name: library.illuminant("A") for name in names}
    image = CoefficientImage(bases.fitted(_CHANNELS), pixels, illuminants, np.ones((side, side), np.float32))
    return image, random.random((side, side, 3), dtype=np.float32)


def _do(work: str, side: int, groups: int, path: Path) -> int:
    """Bytes held at most, over those held before; what is written stays."""
    from ..addon.cli import commands
    from ..core.picture import coefficients

    given = _image(side, groups) if work == "write" else ()
    before = _held("VmRSS")
    if work == "write":
        coefficients.write(path, *given)
    elif work == "read":
        coefficients.read(path)
    elif commands.execute(["relight", str(path), "--light", "group 0=D65", "--out", str(path.with_suffix(".png"))]):
        raise RuntimeError(f"{path} could not be relit")
    return _held("VmHWM") - before


def _point(work: str, side: int, groups: int, folder: str) -> None:
    from .. import register

    register()
    small, path = Path(folder) / "small.exr", Path(folder) / f"{side}.exr"
    for each in ("write", work):
        _do(each, 64, groups, small)
    print(json.dumps(_do(work, side, groups, path)), flush=True)


def _in_a_process(*asked) -> float:
    command = [sys.executable, "-m", __spec__.name, "--point", *map(str, asked)]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode:
        raise RuntimeError(f"{asked} failed:\n{done.stdout}")
    return json.loads(done.stdout.splitlines()[-1])


def main(argv: list[str] | None = None):
    parser = argparse.ArgumentParser(prog="python -m relume.benchmarks.memory", description=__doc__)
    parser.add_argument("--megapixels", type=float, nargs=2, default=[1.0, 3.0], metavar=("A", "B"), help="(1 3)")
    parser.add_argument("--groups", type=int, default=2, help="light groups (2)")
    parser.add_argument("--point", nargs=4, metavar=("WORK", "SIDE", "GROUPS", "FOLDER"), help=argparse.SUPPRESS)
    arguments = parser.parse_args(argv)
    if arguments.point:
        work, side, groups, folder = arguments.point
        return _point(work, int(side), int(groups), folder)
    sides = sorted(round((1e6 * size) ** 0.5) for size in arguments.megapixels)
    print(f"| floats for each pixel, {arguments.groups} light groups | held at most | over the coefficients' own |")
    print("|---|---|---|")
    coefficients = arguments.groups * _CHANNELS
    with tempfile.TemporaryDirectory() as folder:
        for work in _WORKS:
            less, more = (_in_a_process(work, side, arguments.groups, folder) for side in sides)
            floats = (more - less) / _FLOAT / (sides[1] ** 2 - sides[0] ** 2)
            print(f"| {work} | {floats:.1f} | {floats / coefficients:.2f} |", flush=True)


if __name__ == "__main__":
    main()
