"""Coefficient images: what the coefficient passes of a render hold, as one EXR, and the pictures made of them.

A coefficient image has, for every light group, p channels: the picture that each spectral coefficient paints under
lamps of 1. The picture under any illuminants is a sum of 3×p matrices times these channels
(`view.recombination_matrices`).
"""

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from .errors import CoefficientImageError
from .factor_model import FactorModel
from .spectrum import Spectrum
from .view import OBSERVER

__all__ = [
    "EVERYTHING_ELSE",
    "CoefficientImage",
    "CoefficientImageError",
    "bottom_up_rgba",
    "channel_names",
    "describe",
    "read",
    "read_guides",
    "read_pass",
    "read_render",
    "read_render_times",
    "read_rgb",
    "recombine",
    "to_xyz",
    "write",
]

# What no light group holds: the combined pass less all the groups.
EVERYTHING_ELSE = "Everything else"

_HEADER = "relume"
_VERSION = 1
_ROWS = 64  # rows recombined at a time: the temporary arrays stay in the cache


@dataclass(frozen=True)
class CoefficientImage:
    """Coefficients of a rendered picture, with all that relighting it needs.

    groups: light group -> (height, width, p) float32. illuminants: light group -> what lit it. alpha: (height, width).
    view: how Blender would show it (`view_transform`, `look`, `exposure`, `gamma`), an empty mapping for plain sRGB.
    white, observer: as `view.recombination_matrices` takes them.
    """

    model: FactorModel
    groups: Mapping[str, np.ndarray]
    illuminants: Mapping[str, Spectrum]
    alpha: np.ndarray
    space: str = "Linear Rec.709"
    white_balance: float = 0.0
    white_balance_method: str = "bradford"
    view: Mapping[str, object] = field(default_factory=dict)
    gains: Mapping[str, float] = field(default_factory=dict)
    white: tuple[float, float, float] | None = None
    observer: str | tuple[Spectrum, Spectrum, Spectrum] = OBSERVER

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) in pixels."""
        return self.alpha.shape[1], self.alpha.shape[0]


def recombine(groups: Sequence[np.ndarray], matrices: np.ndarray) -> np.ndarray:
    """(height, width, 3) float32: the sum over light groups of `matrices[g]` (3, p) on `groups[g]` (height, width, p).

    Works through the image a few rows at a time, in float32; nothing is clamped.
    """
    if len(groups) != len(matrices):
        raise ValueError(f"{len(groups)} light groups but {len(matrices)} matrices")
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
    """(height, width, 3) XYZ of a coefficient image with a `view.Light` for each group."""
    matrices = [lights[group].gain * image.model.relight(lights[group].illuminant) for group in image.groups]
    return recombine(list(image.groups.values()), np.array(matrices))


def bottom_up_rgba(rgb: np.ndarray, alpha: np.ndarray) -> np.ndarray:
    """Flat float32 RGBA from the lowest row up, as Blender keeps images, of (height, width, 3) and (height, width)."""
    return np.dstack([rgb, alpha]).astype(np.float32)[::-1].ravel()


def _parts(path: Path):
    """Yield (channel names, spec, reader) of every part of an EXR; reader() gives (height, width, channels) float32."""
    import OpenImageIO as oiio

    if not path.is_file():
        raise CoefficientImageError(f"{path}: no such file")
    image = oiio.ImageInput.open(str(path))
    if image is None:
        raise CoefficientImageError(f"{path}: not an image that can be read ({oiio.geterror().strip()})")
    try:
        part = 0
        while image.seek_subimage(part, 0):
            spec = image.spec()
            yield (
                list(spec.channelnames),
                spec,
                lambda part=part, spec=spec: image.read_image(part, 0, 0, spec.nchannels, "float"),
            )
            part += 1
    finally:
        image.close()


def _channels(path: Path, wanted) -> dict[str, np.ndarray]:
    """Channel name -> (height, width) float32, for the channels of an EXR whose full name `wanted(name)` accepts."""
    found = {}
    for names, _, pixels in _parts(path):
        if any(wanted(name) for name in names):
            block = pixels()
            if block is None:
                raise CoefficientImageError(f"{path}: the file is damaged or cut short")
            chosen = {name: block[..., i] for i, name in enumerate(names) if wanted(name)}
            _check_finite(path, chosen)
            found |= chosen
    return found


def _check_finite(path: Path, channels: Mapping[str, np.ndarray]) -> None:
    """Infinity times a matrix of either sign is not a number; half floats reach it at 65504."""
    for name, values in channels.items():
        bad = values.size - np.count_nonzero(np.isfinite(values))
        if bad:
            raise CoefficientImageError(
                f"{path}: channel {name!r} has {bad} pixels that are not finite numbers; if the file is half float, "
                "render again as full (32-bit) float"
            )


def read_rgb(path: str | Path) -> np.ndarray:
    """(height, width, 3) float32 of the channels R, G and B of an image."""
    channels = _channels(Path(path), {"R", "G", "B"}.__contains__)
    if len(channels) < 3:
        raise CoefficientImageError(f"{path}: no channels R, G and B")
    return np.stack([channels[name] for name in "RGB"], axis=-1)


def read_render(
    path: str | Path, model: FactorModel, layers: Sequence[str], groups: Sequence[str]
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Coefficients and alpha of a multilayer EXR that Blender wrote.

    layers: the view layers of the coefficient passes, in order. groups: light groups to read; `EVERYTHING_ELSE` among
    them is worked out from the combined pass. Returns {group: (height, width, p) float32} and (height, width) alpha.
    """
    path = Path(path)
    passes = {group: f"Combined_{group}" for group in groups if group != EVERYTHING_ELSE}
    wanted = {f"{layer}.{name}.{c}" for layer in layers for name in [*passes.values(), "Combined"] for c in "RGBA"}
    channels = _channels(path, wanted.__contains__)

    def stacked(pass_name: str) -> np.ndarray:
        names = [f"{layer}.{pass_name}.{c}" for layer in layers for c in "RGB"][: model.channels]
        missing = [name for name in names if name not in channels]
        if missing:
            raise CoefficientImageError(f"{path}: pass {missing[0]!r} is missing; set the spectral render up again")
        return np.stack([channels[name] for name in names], axis=-1)

    coefficients = {group: stacked(pass_name) for group, pass_name in passes.items()}
    if EVERYTHING_ELSE in groups:
        coefficients[EVERYTHING_ELSE] = stacked("Combined") - sum(coefficients.values())
    alpha = channels.get(f"{layers[0]}.Combined.A")
    if alpha is None:
        alpha = np.ones(next(iter(coefficients.values())).shape[:2], dtype=np.float32)
    return {group: coefficients[group] for group in groups}, alpha


def read_pass(path: str | Path, model: FactorModel, layers: Sequence[str], name: str) -> np.ndarray:
    """(height, width, p) float32 of one pass of all `layers`, as an AOV. Raises CoefficientImageError."""
    path = Path(path)
    names = [f"{layer}.{name}.{c}" for layer in layers for c in "RGB"][: model.channels]
    channels = _channels(path, set(names).__contains__)
    missing = [channel for channel in names if channel not in channels]
    if missing:
        raise CoefficientImageError(f"{path}: pass {missing[0]!r} is missing; render again with it")
    return np.stack([channels[channel] for channel in names], axis=-1)


def read_guides(path: str | Path, layers: Sequence[str], names: Sequence[str]) -> list[dict[str, np.ndarray]]:
    """For each view layer {name: (height, width, 3)} of what Cycles noted for its denoiser: "Albedo", "Normal".

    Raises CoefficientImageError where the render did not store them.
    """
    path, parts = Path(path), {"Albedo": "RGB", "Normal": "XYZ"}
    wanted = {(layer, n): [f"{layer}.Denoising {n}.{c}" for c in parts[n]] for layer in layers for n in names}
    channels = _channels(path, {channel for each in wanted.values() for channel in each}.__contains__)
    missing = [channel for each in wanted.values() for channel in each if channel not in channels]
    if missing:
        raise CoefficientImageError(f"{path}: pass {missing[0]!r} is missing; the denoiser needs it")
    stacked = {key: np.stack([channels[channel] for channel in each], axis=-1) for key, each in wanted.items()}
    return [{name: stacked[layer, name] for name in names} for layer in layers]


def read_render_times(path: str | Path, layers: Sequence[str]) -> dict[str, dict[str, float]]:
    """{view layer: {"seconds", "sync_seconds"}}, of the layers for which Cycles notes them in the EXR."""
    _, spec, _ = next(iter(_parts(Path(path))))
    times = {}
    for layer in layers:
        noted = [spec.getattribute(f"cycles.{layer}.{name}") for name in ("total_time", "synchronization_time")]
        if all(noted):
            times[layer] = dict(zip(("seconds", "sync_seconds"), map(_seconds, noted), strict=True))
    return times


def _seconds(clock: str) -> float:
    """Seconds of a time written as [hours:]minutes:seconds."""
    seconds = 0.0
    for part in clock.split(":"):
        seconds = 60.0 * seconds + float(part)
    return seconds


def channel_names(group: str, channels: int) -> list[str]:
    """Layer, pass and channel as Blender names them, so that its compositor can read the file as well."""
    return [f"Coefficients {k // 3 + 1}.{group}.{'RGB'[k % 3]}" for k in range(channels)]


def write(path: str | Path, image: CoefficientImage, picture: np.ndarray) -> None:
    """Write a coefficient image as one multilayer float EXR, its first layer the `picture` (height, width, 3).

    The file appears whole or not at all. Raises OSError when it cannot be written.
    """
    header = {
        "version": _VERSION,
        "model": image.model.to_dict(),
        "groups": list(image.groups),
        "illuminants": {group: image.illuminants[group].to_dict() for group in image.groups},
        "gains": dict(image.gains),
        "space": image.space,
        "white_balance": image.white_balance,
        "white_balance_method": image.white_balance_method,
        "view": dict(image.view),
        "white": image.white,
        "observer": image.observer if isinstance(image.observer, str) else [one.to_dict() for one in image.observer],
    }
    names = ["R", "G", "B", "A"]
    for group in image.groups:
        names += channel_names(group, image.model.channels)
    pixels = np.concatenate([picture, image.alpha[..., None], *image.groups.values()], axis=-1, dtype=np.float32)
    _write_exr(Path(path), pixels, names, {_HEADER: json.dumps(header), "BlenderMultiChannel": "Relume"})


def _write_exr(path: Path, pixels: np.ndarray, names: list[str], attributes: Mapping[str, str]) -> None:
    import OpenImageIO as oiio

    height, width, count = pixels.shape
    spec = oiio.ImageSpec(width, height, count, "float")
    spec.channelnames = names
    spec.attribute("compression", "zip")
    for key, value in attributes.items():
        spec.attribute(key, value)
    partial = path.with_name(f".{path.stem}.partial.exr")
    output = oiio.ImageOutput.create(str(partial))
    try:
        done = output.open(str(partial), spec) and output.write_image(np.ascontiguousarray(pixels))
        message = output.geterror().strip()
        done = output.close() and done
        if not done:
            raise OSError(f"{path}: cannot be written ({message or 'disk full?'})")
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)


def _described(path: Path) -> tuple[dict, tuple[int, int]]:
    """The Relume header of an EXR and its (width, height)."""
    _, spec, _ = next(iter(_parts(path)))
    header = spec.getattribute(_HEADER)
    if header is None:
        raise CoefficientImageError(f"{path}: no Relume header; expected an EXR that `relume render` wrote")
    try:
        header = json.loads(header)
        version = header["version"]
    except (KeyError, TypeError, json.JSONDecodeError) as error:
        raise CoefficientImageError(f"{path}: the Relume header is damaged ({error})") from error
    if version > _VERSION:
        raise CoefficientImageError(f"{path}: written by a newer Relume (format {version})")
    return header, (spec.width, spec.height)


def _image(path: Path, header: dict, groups: Mapping[str, np.ndarray], alpha: np.ndarray) -> CoefficientImage:
    try:
        return CoefficientImage(
            model=FactorModel.from_dict(header["model"]),
            groups=groups,
            illuminants={group: Spectrum.from_dict(data) for group, data in header["illuminants"].items()},
            alpha=alpha,
            space=header["space"],
            white_balance=header["white_balance"],
            white_balance_method=header["white_balance_method"],
            view=header["view"],
            gains=header["gains"],
            white=header.get("white"),
            observer=_observer(header.get("observer", OBSERVER)),
        )
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise CoefficientImageError(f"{path}: the Relume header is damaged ({error})") from error


def describe(path: str | Path) -> CoefficientImage:
    """What `read` reads, with groups and alpha of the right shapes that hold zeros and take no memory."""
    path = Path(path)
    header, (width, height) = _described(path)
    nothing = np.float32(0.0)
    image = _image(path, header, {}, np.broadcast_to(nothing, (height, width)))
    shape = (height, width, image.model.channels)
    return replace(image, groups={group: np.broadcast_to(nothing, shape) for group in header["groups"]})


def read(path: str | Path) -> CoefficientImage:
    """Read a coefficient image that `write` wrote; CoefficientImageError says what the file lacks."""
    path = Path(path)
    header, _ = _described(path)
    empty = _image(path, header, {}, np.empty((0, 0)))
    names = {group: channel_names(group, empty.model.channels) for group in header["groups"]}
    wanted = {name for each in names.values() for name in each} | {"A"}
    channels = _channels(path, wanted.__contains__)
    missing = sorted(wanted - set(channels))
    if missing:
        raise CoefficientImageError(f"{path}: channel {missing[0]!r} is missing")
    groups = {group: np.stack([channels[name] for name in each], axis=-1) for group, each in names.items()}
    return replace(empty, groups=groups, alpha=channels["A"])


def _observer(described):
    return described if isinstance(described, str) else tuple(Spectrum.from_dict(one) for one in described)
