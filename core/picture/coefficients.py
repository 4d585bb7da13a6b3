"""Coefficient images: what the coefficient passes of a render hold, as one EXR, and the pictures made of them.

A coefficient image has, for every light group, p channels: the picture that each spectral coefficient paints under
lamps of 1. The picture under any illuminants is a sum of 3×p matrices times these channels
(`recombination.recombination_matrices`).
"""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from .. import results
from ..errors import CoefficientImageError, ResultError, UsageError
from . import blender_exr, description, exr, noise
from .blender_exr import read_guides, read_materials, read_pass, read_render, read_render_times
from .coefficient_image import EVERYTHING_ELSE, Block, CoefficientImage, gathered
from .description import Description
from .exr import read_rgb

__all__ = [
    "EVERYTHING_ELSE",
    "CoefficientImage",
    "CoefficientImageError",
    "bottom_up_rgba",
    "channel_names",
    "describe",
    "describe_all",
    "is_own",
    "read",
    "read_guides",
    "read_materials",
    "read_pass",
    "read_render",
    "read_render_times",
    "read_rgb",
    "recombine",
    "relit",
    "to_xyz",
    "write",
]

_HEADER = "relume"
_GUIDES = ("Albedo", "Normal")
_ROWS = 64  # recombined and written at a time: the temporary arrays stay in the cache


def recombine(groups: Sequence[np.ndarray], matrices: np.ndarray) -> np.ndarray:
    """(height, width, 3) float32: the sum over light groups of `matrices[g]` (3, p) on `groups[g]` (height, width, p).

    Works through the image a few rows at a time, in float32; nothing is clamped.
    """
    if len(groups) != len(matrices):
        raise UsageError(f"{len(groups)} light groups but {len(matrices)} matrices")
    height, width, _ = groups[0].shape
    transposed = [np.ascontiguousarray(matrix.T, dtype=np.float32) for matrix in matrices]
    picture = np.empty((height, width, 3), dtype=np.float32)
    for top in range(0, height, _ROWS):
        rows = slice(top, top + _ROWS)
        tile = groups[0][rows] @ transposed[0]
        for coefficients, matrix in zip(groups[1:], transposed[1:], strict=True):
            tile += coefficients[rows] @ matrix
        picture[rows] = tile
    return picture


def to_xyz(image: CoefficientImage, lights: Mapping) -> np.ndarray:
    """(height, width, 3) XYZ of a coefficient image with a `mix.Light` for each group."""
    matrices = [lights[group].gain * image.model.relight(lights[group].illuminant) for group in image.groups]
    return recombine(list(image.groups.values()), np.array(matrices))


def bottom_up_rgba(rgb: np.ndarray, alpha: np.ndarray) -> np.ndarray:
    """Flat float32 RGBA from the lowest row up, as Blender keeps images, of (height, width, 3) and (height, width)."""
    rgba = np.empty((*alpha.shape, 4), np.float32)
    rgba[..., :3], rgba[..., 3] = rgb[::-1], alpha[::-1]
    return rgba.ravel()


def channel_names(group: str, channels: int) -> list[str]:
    """Layer, pass and channel as Blender names them, so that its compositor can read the file as well."""
    return [f"Coefficients {k // 3 + 1}.{group}.{'RGB'[k % 3]}" for k in range(channels)]


def write(path: str | Path, image: CoefficientImage, picture: np.ndarray) -> None:
    """Write a coefficient image as one multilayer float EXR, its first layer the `picture` (height, width, 3).

    The file appears whole or not at all. Raises ResultError when it cannot be written.
    """
    from . import header

    names = ["R", "G", "B", "A"]
    for group in image.groups:
        names += channel_names(group, image.model.channels)
    stacks = [picture, image.alpha[..., None], *image.groups.values()]
    _write_exr(Path(path), stacks, names, {_HEADER: json.dumps(header.to_dict(image)), "BlenderMultiChannel": "Relume"})


def _write_exr(path: Path, stacks: Sequence[np.ndarray], names: list[str], attributes: Mapping[str, str]) -> None:
    """stacks: (height, width, channels) each, written side by side, a few rows at a time."""
    import OpenImageIO as oiio

    height, width, _ = stacks[0].shape
    spec = oiio.ImageSpec(width, height, len(names), "float")
    spec.channelnames = names
    spec.attribute("compression", "zip")
    spec.attribute("DateTime", "")  # else the time of writing: the same picture would be other bytes each time
    for key, value in attributes.items():
        spec.attribute(key, value)
    with results.replacing(path) as partial:
        output = oiio.ImageOutput.create(str(partial))
        if output is None:
            raise ResultError(f"{path}: cannot be written ({oiio.geterror().strip()})")
        done = output.open(str(partial), spec)
        for top in range(0, height, _ROWS):
            rows = slice(top, min(top + _ROWS, height))
            pixels = np.concatenate([stack[rows] for stack in stacks], axis=-1, dtype=np.float32)
            done = done and output.write_scanlines(rows.start, rows.stop, 0, pixels)
        message = output.geterror().strip().replace(str(partial), path.name)
        done = output.close() and done
        if not done:
            raise ResultError(f"{path}: cannot be written; is the disk full? ({message})")


def is_own(path: str | Path) -> bool:
    """Whether an EXR is one that `write` wrote."""
    return exr.attribute(path, _HEADER) is not None


def _described(path: Path, scene: Description | None, layer: str | None) -> tuple[CoefficientImage, tuple[str, ...]]:
    """The description of an EXR, and the view layers of its passes: none in a file of Relume's own."""
    text = exr.attribute(path, _HEADER)
    if text is None:
        found = description.of_file(path, scene)
        try:
            return found.image, found.passes(layer)
        except CoefficientImageError as error:
            raise CoefficientImageError(f"{path}: {error}") from None
    from . import header

    try:
        return header.parse(text)[0], ()
    except CoefficientImageError as error:
        raise CoefficientImageError(f"{path}: the Relume header is damaged: {error}") from None


def _wanted(image: CoefficientImage) -> dict[str | None, list[str]]:
    """The channels of each light group in a file of Relume's own, and of alpha, which is none."""
    return {None: ["A"]} | {group: channel_names(group, image.model.channels) for group in image.illuminants}


def describe(path: str | Path, scene: Description | None = None, layer: str | None = None) -> CoefficientImage:
    """What `read` reads, with groups and alpha of the right shapes that hold zeros and take no memory."""
    path = Path(path)
    image, layers = _described(path, scene, layer)
    groups = list(image.illuminants)
    if layers:
        width, height = blender_exr.size(path, image.model, layers, groups)
    else:
        width, height = exr.size(path, [name for each in _wanted(image).values() for name in each])
    shape, nothing = (height, width, image.model.channels), np.float32(0.0)
    zeros = {group: np.broadcast_to(nothing, shape) for group in groups}
    return replace(image, groups=zeros, alpha=np.broadcast_to(nothing, (height, width)))


def describe_all(
    paths: Iterable[str | Path], scene: Description | None = None, layer: str | None = None
) -> list[CoefficientImage]:
    """What `describe` says of each file of a sequence.

    Raises CoefficientImageError where one has other light groups, channels or size than the first.
    """
    found, first = [], None
    for path in paths:
        each = describe(path, scene, layer)
        alike = list(each.groups), each.model.channels, each.size
        first = first or (path, alike)
        if alike != first[1]:
            raise CoefficientImageError(
                f"{path}: other light groups, channels or size than {Path(first[0]).name}: "
                f"{each.size[0]} × {each.size[1]}, {each.model.channels} channels, {', '.join(each.groups)}"
            )
        found.append(each)
    return found


def read(path: str | Path, scene: Description | None = None, layer: str | None = None) -> CoefficientImage:
    """Read a coefficient image that `write` wrote, or the coefficient passes of a render that any Blender wrote.

    Where such a render stored what guides a denoiser in every pass, noise of colour is taken out (`noise.estimated`).
    scene: see `description.of_file`. layer: which of the artist's view layers, if not the first.
    CoefficientImageError says what the file lacks.
    """
    path = Path(path)
    image, layers = _described(path, scene, layer)
    groups, alpha = gathered(_blocks(path, image, layers))
    return replace(image, groups=groups, alpha=alpha)


def relit(
    path: str | Path,
    matrices: Callable[[CoefficientImage], np.ndarray],
    scene: Description | None = None,
    layer: str | None = None,
) -> tuple[CoefficientImage, np.ndarray]:
    """What `recombine` makes of a file that `read` reads: (height, width, 3), and the image without its coefficients.

    Its coefficients are never in memory all at once. matrices: the (groups, 3, p) for the image that is described.
    """
    path = Path(path)
    image, layers = _described(path, scene, layer)
    chosen = matrices(image)
    picture = alpha = np.empty((0, 0), np.float32)
    for block in _blocks(path, image, layers):
        if not alpha.size:
            alpha = np.empty((block.height, *block.alpha.shape[1:]), np.float32)
            picture = np.empty((*alpha.shape, 3), np.float32)
        alpha[block.rows] = block.alpha
        picture[block.rows] = recombine(list(block.groups.values()), chosen)
    return replace(image, alpha=alpha), picture


def _blocks(path: Path, image: CoefficientImage, layers: Sequence[str]) -> Iterator[Block]:
    """The coefficients of a file that is described so, a few rows at a time."""
    if layers:
        groups = list(image.illuminants)
        blender_exr.check_unknown(path, layers, groups)
        blocks = blender_exr.render_blocks(path, image.model, layers, groups)
        if blender_exr.has_guides(path, layers):
            held, alpha = gathered(blocks)
            guides = read_guides(path, layers, _GUIDES)
            blocks = iter([Block(slice(0, len(alpha)), len(alpha), noise.estimated(held, guides), alpha)])
        yield from blocks
        return
    for rows, height, found in exr.blocks(path, _wanted(image)):
        yield Block(rows, height, {group: found[group] for group in image.illuminants}, found[None][..., 0])
