"""Reading OpenEXR: named channels, checked to be whole, of one size and finite."""

from collections.abc import Collection, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from .errors import CoefficientImageError

__all__ = ["attribute", "channels", "names", "read_rgb", "size"]


@contextmanager
def _opened(path: Path):
    import OpenImageIO as oiio

    if not path.is_file():
        raise CoefficientImageError(f"{path}: no such file")
    image = oiio.ImageInput.open(str(path))
    if image is None:
        raise CoefficientImageError(f"{path}: not an image that can be read ({_line(oiio.geterror())})")
    try:
        yield image
    finally:
        image.close()


def _line(message: str) -> str:
    """A library's message without its line breaks, nor the name of the file at its beginning."""
    return " ".join(message.split()) or "no reason given"


def _parts(image):
    """Yield (number, spec) of every part."""
    part = 0
    while image.seek_subimage(part, 0):
        yield part, image.spec()
        part += 1


def attribute(path: str | Path, name: str) -> str | None:
    """A text in the header of the first part, None where there is none."""
    path = Path(path)
    with _opened(path) as image:
        try:
            value = image.spec().getattribute(name)
        except UnicodeDecodeError:
            raise CoefficientImageError(f"{path}: the attribute {name!r} in its header is not text") from None
    return value if isinstance(value, str) else None


def names(path: str | Path) -> list[str]:
    """The full names of all channels, part after part."""
    with _opened(Path(path)) as image:
        return [name for _, spec in _parts(image) for name in spec.channelnames]


def size(path: str | Path, wanted: Collection[str]) -> tuple[int, int]:
    """(width, height) of the wanted channels, all of which are there, uncropped, of one size and not cut short.

    Reads their last row only. Raises CoefficientImageError.
    """
    path = Path(path)
    with _opened(path) as image:
        shape = None
        for part, spec, _ in _holding(path, image, wanted):
            shape = _checked(path, spec, wanted, shape)
            last = spec.y + spec.height - 1
            if not spec.tile_width and image.read_scanlines(part, 0, last, last + 1, 0, 0, 1, "float") is None:
                raise CoefficientImageError(f"{path}: the file is damaged or cut short ({_line(image.geterror())})")
    return shape[1], shape[0]


def channels(path: str | Path, wanted: Collection[str], optional: Collection[str] = ()) -> dict[str, np.ndarray]:
    """Channel name -> (height, width) float32, of the channels with these full names.

    Raises CoefficientImageError where a wanted one is missing, cropped, of another size than the first, or has pixels
    that are not finite numbers.
    """
    path, found, shape = Path(path), {}, None
    with _opened(path) as image:
        for part, spec, held in _holding(path, image, wanted, optional):
            shape = _checked(path, spec, {*wanted, *optional}, shape)
            first, last = min(held.values()), max(held.values()) + 1
            block = image.read_image(part, 0, first, last, "float")
            if block is None:
                raise CoefficientImageError(f"{path}: the file is damaged or cut short ({_line(image.geterror())})")
            block = np.asarray(block).reshape(spec.height, spec.width, last - first)
            chosen = {name: block[..., index - first] for name, index in held.items()}
            _check_finite(path, chosen)
            found |= chosen
    return found


def _holding(path: Path, image, wanted: Collection[str], optional: Collection[str] = ()) -> list:
    """(part, spec, {channel: its index}) of the parts that hold wanted channels; all of these are somewhere."""
    holding, missing = [], set(wanted)
    for part, spec in _parts(image):
        held = {}
        for index, name in enumerate(spec.channelnames):
            if name in missing or (name in optional and name not in wanted):
                held.setdefault(name, index)
        missing -= set(held)
        if held:
            holding.append((part, spec, held))
    if missing:
        first = min(missing, key=list(wanted).index)
        raise CoefficientImageError(f"{path}: channel {first!r} is missing")
    return holding


def _checked(path: Path, spec, wanted: Collection[str], first: tuple[int, int] | None) -> tuple[int, int]:
    """(height, width) of a part that is flat, not cropped, and of the size of the first."""
    name = next(name for name in spec.channelnames if name in wanted)
    window = (spec.x, spec.y, spec.width, spec.height)
    whole = (spec.full_x, spec.full_y, spec.full_width, spec.full_height)
    if spec.deep:
        raise CoefficientImageError(f"{path}: channel {name!r} is deep; expected one value for each pixel")
    if window != whole:
        raise CoefficientImageError(
            f"{path}: channel {name!r} is cropped to {window[2]} × {window[3]} at {window[0]}, {window[1]} "
            f"of {whole[2]} × {whole[3]}; expected the whole picture"
        )
    if first not in (None, (spec.height, spec.width)):
        raise CoefficientImageError(
            f"{path}: channel {name!r} is {spec.width} × {spec.height}, the first is {first[1]} × {first[0]}"
        )
    return spec.height, spec.width


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
