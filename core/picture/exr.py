"""Reading OpenEXR: named channels, checked to be whole and finite."""

import re
from collections import Counter
from collections.abc import Collection, Hashable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from ..errors import CoefficientImageError

if TYPE_CHECKING:
    from OpenImageIO import ImageInput, ImageSpec

__all__ = ["attribute", "attributes", "blocks", "channels", "names", "read_rgb", "size", "stacks"]

_ROWS = 64  # read at a time: a few of what any codec packs together
_Key = TypeVar("_Key", bound=Hashable)


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
    """Channel name -> (height, width) float32, of the channels with these full names. Raises as `blocks` does."""
    return {name: stack[..., 0] for name, stack in stacks(path, {name: [name] for name in wanted}).items()}


def stacks(path: str | Path, wanted: Mapping[_Key, Sequence[str]]) -> dict[_Key, np.ndarray]:
    """{key: (height, width, channels) float32} of the channels that each key wants. Raises as `blocks` does."""
    found: dict[_Key, np.ndarray] = {}
    for rows, height, read in blocks(path, wanted):
        for key, block in read.items():
            found.setdefault(key, np.empty((height, *block.shape[1:]), np.float32))[rows] = block
    return found


def blocks(
    path: str | Path, wanted: Mapping[_Key, Sequence[str]]
) -> Iterator[tuple[slice, int, dict[_Key, np.ndarray]]]:
    """Yield (rows, height of the picture, {key: (rows, width, channels) float32}) from the highest row down.

    wanted: the full names of each key's channels, in whatever parts. No more than a few rows are in memory. Raises
    CoefficientImageError where one is missing or cropped, or has pixels that are not finite numbers; these are not
    yielded.
    """
    path, bad = Path(path), Counter[str]()
    with _opened(path) as image:
        parts = _holding(path, image, [name for each in wanted.values() for name in each])
        for _, spec, held in parts:
            _check_part(path, image, spec, held)
        # Tiles lie across rows: a part of them is read at once
        whole = {part: _pixels(path, image, part, spec, held) for part, spec, held in parts if spec.tile_width}
        height = parts[0][1].height if parts else 0
        for top in range(0, height, _ROWS):
            rows = slice(top, min(top + _ROWS, height))
            found: dict[str, np.ndarray] = {}
            for part, spec, held in parts:
                block = whole[part][rows] if part in whole else _pixels(path, image, part, spec, held, rows)
                first = min(held.values())
                found |= {name: block[..., index - first] for name, index in held.items()}
            for name, values in found.items():
                bad[name] += values.size - int(np.count_nonzero(np.isfinite(values)))
            if not any(bad.values()):
                yield rows, height, {key: np.stack([found[name] for name in each], -1) for key, each in wanted.items()}
    _check_finite(path, bad)


def _pixels(
    path: Path, image: "ImageInput", part: int, spec: "ImageSpec", held: Mapping[str, int], rows: slice | None = None
) -> np.ndarray:
    """(rows, width, channels) of a part, from its first wanted channel to its last."""
    first, last = min(held.values()), max(held.values()) + 1
    if rows is None:
        block = image.read_image(part, 0, first, last, "float")
    else:
        block = image.read_scanlines(part, 0, spec.y + rows.start, spec.y + rows.stop, 0, first, last, "float")
    if block is None:
        raise CoefficientImageError(f"{path}: the file is damaged or cut short ({_reason(image)})")
    return np.asarray(block).reshape(-1, spec.width, last - first)


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


def _check_finite(path: Path, bad: Mapping[str, int]) -> None:
    """Infinity times a matrix of either sign is not a number; half floats reach it at 65504."""
    for name, count in bad.items():
        if count:
            raise CoefficientImageError(
                f"{path}: channel {name!r} has {count} pixels that are not finite numbers; if the file is half float, "
                "render again as full (32-bit) float"
            )


def read_rgb(path: str | Path) -> np.ndarray:
    """(height, width, 3) float32 of the channels R, G and B of an image. Raises CoefficientImageError."""
    return stacks(path, {"": "RGB"})[""]
