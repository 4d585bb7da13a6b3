"""`relume web`: a page in which anyone can choose the light."""

import argparse
import math
import tempfile
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...core import results
from ...core.errors import CoefficientImageError, UsageError
from ...core.picture import coefficients, exr, sequences
from ..host import console
from ..scene import render

if TYPE_CHECKING:
    from ...core.web.page import Picture  # the page is imported when one is made: registering has no time for it

__all__ = ["QUALITIES", "SIZES", "add_command", "run", "shown"]

SIZES = (16, 8192)  # pixels of the longer side
QUALITIES = (0.1, 20.0)  # ΔE


def add_command(commands, path, add_out):
    """`relume web` among the commands; path, add_out: how its caller takes paths and --out."""
    web = commands.add_parser("web", help="a web page of a coefficient EXR, in which anyone can choose the light")
    web.add_argument(
        "coefficients",
        metavar="COEFFICIENTS.exr|FOLDER",
        type=path,
        help="a file, a sequence such as shot.####.exr, or a folder of files",
    )
    web.add_argument(
        "--lamps",
        metavar="NAME",
        nargs="+",
        action="extend",
        default=[],
        help="illuminants to choose from; default: all",
    )
    web.add_argument(
        "--size", type=_size, metavar="PIXELS", default=1920, help="the longer side at most; default: 1920"
    )
    web.add_argument(
        "--quality",
        type=_quality,
        metavar="ΔE",
        default=1.0,
        help="what 98 %% of the picture keeps to under all lamps, against `relume relight`; default: 1",
    )
    web.add_argument("--title", metavar="TEXT", default="", help="default: the names of the files")
    web.add_argument("--bare", action="store_true", help="the picture alone, to embed in another page")
    add_out(web, "PAGE.html", "the page", required=True)
    return web


def _size(text: str) -> int:
    if not text.isascii() or not text.isdigit() or not SIZES[0] <= int(text[:9]) <= SIZES[1]:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from {SIZES[0]} to {SIZES[1]}")
    return int(text)


def _quality(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not QUALITIES[0] <= value <= QUALITIES[1]:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number from {QUALITIES[0]:g} to {QUALITIES[1]:g}")
    return value


def run(told: argparse.Namespace):
    """`relume web`: one HTML file of an EXR, of a sequence or of a folder."""
    from ...core.web import page

    if told.out.suffix.lower() not in (".html", ".htm"):
        raise UsageError(f"{told.out}: a page's name ends in .html")
    pictures = _pictures(told.coefficients, told.described, told.layer)
    with results.folder(told.out.parent):
        results.expect(told.out)
        reached = page.write(
            told.out,
            pictures,
            names=told.lamps or ("all",),
            size=told.size,
            quality=told.quality,
            title=told.title,
            bare=told.bare,
            show=shown,
            progress=console.say,
        )
    for name, difference in reached.items():
        if difference > told.quality:
            console.say(f"{name}: ΔE {difference:.2f} of 98 % is the best that can be reached")
    console.wrote(told.out)


def _pictures(path: Path, described, layer: str | None) -> list["Picture"]:
    """The pictures of a page: of a file, of a sequence, or of all coefficient images in a folder."""
    from ...core.web import page

    def read(file: Path):
        return partial(coefficients.read, file, described, layer)

    if sequences.is_pattern(path):
        files = sequences.files(path)
        coefficients.describe_all(files.values(), described, layer)
        name = path.stem.replace("#", "").rstrip("._- ")
        return [page.Picture(name or path.stem, {n: read(file) for n, file in files.items()})]
    if not path.is_dir():
        coefficients.describe(path, described, layer)
        return [page.Picture(path.stem, {1: read(path)})]
    found = []
    for file in sorted(path.glob("[!.]*.exr")):
        try:
            coefficients.describe(file, described, layer)
            found.append(page.Picture(file.stem, {1: read(file)}))
        except CoefficientImageError as error:
            console.say(f"left out: {error}")
    if not found:
        raise CoefficientImageError(f"{path}: no coefficient images in this folder; expected EXRs of `relume render`")
    return found


def shown(rgb: np.ndarray, image) -> np.ndarray:
    """What Blender's view transform makes of linear RGB (height, width, 3) on an sRGB display: 0..1, encoded."""
    flat = replace(
        image, groups={}, alpha=np.ones(rgb.shape[:2], np.float32), view={**image.view, "display_device": "sRGB"}
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "shown.png"
        render.save_picture(path, rgb, flat)
        return exr.read_rgb(path)
