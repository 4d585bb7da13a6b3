"""`relume web`: a page in which anyone can choose the light."""

import argparse
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

__all__ = ["plain_name", "run", "shown"]


def run(options: argparse.Namespace) -> None:
    """`relume web`: one HTML file of an EXR, of a sequence or of a folder."""
    from ...core.web import page

    if options.out.suffix.lower() not in (".html", ".htm"):
        raise UsageError(f"{options.out}: a page's name ends in .html")
    pictures = _pictures(options.coefficients, options.described, options.layer)
    with results.folder(options.out.parent):
        results.expect(options.out)
        reached = page.write(
            options.out,
            pictures,
            names=options.lamps or ("all",),
            size=options.size,
            quality=options.quality,
            title=options.title,
            bare=options.bare,
            show=shown,
            progress=console.say,
        )
    for name, difference in reached.items():
        if difference > options.quality:
            console.say(f"{name}: ΔE {difference:.2f} of 98 % is the best that can be reached")
    console.wrote(options.out)


def _pictures(path: Path, described, layer: str | None) -> list["Picture"]:
    """The pictures of a page: of a file, of a sequence, or of all coefficient images in a folder."""
    from ...core.web import page

    def read(file: Path):
        return partial(coefficients.read, file, described, layer)

    if sequences.is_pattern(path):
        files = sequences.files(path)
        coefficients.describe_all(files.values(), described, layer)
        return [page.Picture(plain_name(path), {n: read(file) for n, file in files.items()})]
    found = []
    for file in sorted(path.glob("[!.]*.exr")) if path.is_dir() else [path]:
        try:
            coefficients.describe(file, described, layer)
            found.append(page.Picture(file.stem, {1: read(file)}))
        except CoefficientImageError as error:
            if file == path:
                raise
            console.say(f"left out: {error}")
    if not found:
        raise CoefficientImageError(f"{path}: no coefficient images in this folder; expected EXRs of `relume render`")
    return found


def plain_name(path: Path) -> str:
    """What a file is called, or a sequence such as shot.####.exr: without its ending and its number."""
    return path.stem.replace("#", "").rstrip("._- ") or path.stem


def shown(rgb: np.ndarray, image: coefficients.CoefficientImage) -> np.ndarray:
    """What Blender's view transform makes of linear RGB (height, width, 3) on an sRGB display: 0..1, encoded."""
    flat = replace(
        image, groups={}, alpha=np.ones(rgb.shape[:2], np.float32), view={**image.view, "display_device": "sRGB"}
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "shown.png"
        render.save_picture(path, rgb, flat)
        return exr.read_rgb(path)
