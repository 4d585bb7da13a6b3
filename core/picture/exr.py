"""Reading OpenEXR: named channels, checked to be whole and finite."""

import re
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

from ..errors import CoefficientImageError

if TYPE_CHECKING:
    from OpenImageIO import ImageInput, ImageSpec

__all__ = ["attribute", "attributes", "channels", "names", "read_rgb", "size"]


@contextmanager
def _opened(path: Path) -> Iterator["ImageInput"]:
    import OpenImageIO as oiio

    if not path.is_file():
        raise CoefficientImageError(f"{path}: {'is a folder; expected an EXR' if path.is_dir() else 'no such file'}")
    image = oiio.ImageInput.open(str(path))
    if image is None:
        raise CoefficientImageError(f"{path}: not an image that can be read ({_reason(oiio)})")
    try:
        yield image
    except UnicodeDecodeError:
        raise CoefficientImageError(f"{path}: a name or an attribute in its header is not UTF-8 text") from None
    finally:
        image.close()


def _reason(source: "ImageInput | ModuleType") -> str:
    """The beginning of what OpenImageIO, or an image of its, says of the last error: without line breaks and path."""
    try:
        words = " ".join(re.sub(r"EXR Error \(.*?\): ", "", source.geterror()).split())
    except UnicodeDecodeError:
        return "names in it are not UTF-8 text"
    return (words[:117] + "...") if len(words) > 120 else words or "no reason given"


def _parts(image: "ImageInput") -> Iterator[tuple[int, "ImageSpec"]]:
    """Yield (number, spec) of every part."""
    part = 0
    while image.seek_subimage(part, 0):
        yield part, image.spec()
        part += 1


def attribute(path: str | Path, name: str) -> str | None:
    """A text in the header of the first part, None where there is none."""
    path = Path(path)
    with _opened(path) as image:
        value = image.spec().getattribute(name)
    return value if isinstance(value, str) else None


def attributes(path: str | Path, beginning: str) -> dict[str, str]:
    """{name: text} of the texts in the header of the first part whose names begin so."""
    with _opened(Path(path)) as image:
        found = {each.name: each.value for each in image.spec().extra_attribs if each.name.startswith(beginning)}
    return {name: value for name, value in found.items() if isinstance(value, str)}


def names(path: str | Path) -> list[str]:
    """The full names of all channels, part after part."""
    with _opened(Path(path)) as image:
        return [name for _, spec in _parts(image) for name in spec.channelnames]


def size(path: str | Path, wanted: Collection[str]) -> tuple[int, int]:
    """(width, height) of the wanted channels, all of which are there, uncropped and not cut short.

    Reads their last row only. Raises CoefficientImageError.
    """
    path = Path(path)
    with _opened(path) as image:
        for part, spec, held in _holding(path, image, wanted):
            _check_part(path, image, spec, held)
            last = spec.y + spec.height - 1
            if not spec.tile_width and image.read_scanlines(part, 0, last, last + 1, 0, 0, 1, "float") is None:
                raise CoefficientImageError(f"{path}: the file is damaged or cut short ({_reason(image)})")
        return spec.width, spec.height


def channels(path: str | Path, wanted: Collection[str]) -> dict[str, np.ndarray]:
    """Channel name -> (height, width) float32, of the channels with these full names.

    Raises CoefficientImageError where a wanted one is missing or cropped, or has pixels that are not finite
    numbers.
    """
    path = Path(path)
    found: dict[str, np.ndarray] = {}
    with _opened(path) as image:
        for part, spec, held in _holding(path, image, wanted):
            _check_part(path, image, spec, held)
            first, last = min(held.values()), max(held.values()) + 1
            block = image.read_image(part, 0, first, last, "float")
            if block is None:
                raise CoefficientImageError(f"{path}: the file is damaged or cut short ({_reason(image)})")
            block = np.asarray(block).reshape(spec.height, spec.width, last - first)
            chosen = {name: block[..., index - first] for name, index in held.items()}
            _check_finite(path, chosen)
            found |= chosen
    return found


def _holding(path: Path, image: "ImageInput", wanted: Collection[str]) -> list[tuple[int, "ImageSpec", dict[str, int]]]:
    """(part, spec, {channel: its index}) of the parts that hold wanted channels; all of these are somewhere."""
    holding, missing = [], set(wanted)
    for part, spec in _parts(image):
        held: dict[str, int] = {}
        for index, name in enumerate(spec.channelnames):
            if name in missing:
                held.setdefault(name, index)
        missing -= set(held)
        if held:
            holding.append((part, spec, held))
    if missing:
        first = min(missing, key=list(wanted).index)
        raise CoefficientImageError(f"{path}: channel {first!r} is missing")
    return holding


def _check_part(path: Path, image: "ImageInput", spec: "ImageSpec", held: Mapping[str, int]) -> None:
    """A part that is flat and not cropped has the size of the picture, which all parts share."""
    for name, index in held.items():
        if image.format_name() == "openexr" and str(spec.channelformat(index)) not in ("half", "float"):
            raise CoefficientImageError(f"{path}: channel {name!r} holds whole numbers; expected half or full float")
    name = next(iter(held))
    window = (spec.x, spec.y, spec.width, spec.height)
    whole = (spec.full_x, spec.full_y, spec.full_width, spec.full_height)
    if spec.deep:
        raise CoefficientImageError(f"{path}: channel {name!r} is deep; expected one value for each pixel")
    if window != whole:
        raise CoefficientImageError(
            f"{path}: channel {name!r} is cropped to {window[2]} × {window[3]} at {window[0]}, {window[1]} "
            f"of {whole[2]} × {whole[3]}; expected the whole picture"
        )


def _check_finite(path: Path, pixels: Mapping[str, np.ndarray]) -> None:
    """Infinity times a matrix of either sign is not a number; half floats reach it at 65504."""
    for name, values in pixels.items():
        bad = values.size - np.count_nonzero(np.isfinite(values))
        if bad:
            raise CoefficientImageError(
                f"{path}: channel {name!r} has {bad} pixels that are not finite numbers; if the file is half float, "
                "render again as full (32-bit) float"
            )


def read_rgb(path: str | Path) -> np.ndarray:
    """(height, width, 3) float32 of the channels R, G and B of an image. Raises CoefficientImageError."""
    found = channels(path, "RGB")
    return np.stack([found[name] for name in "RGB"], axis=-1)
