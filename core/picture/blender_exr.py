"""The multilayer EXR that Blender writes: view layers, their passes, and what Cycles notes in the header.

A channel is called LAYER.PASS.CHANNEL, whether every pass has a part of its own or all are interleaved in one.
"""

import json
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np

from ..errors import CoefficientImageError
from ..model.factor_model import FactorModel
from . import exr
from .coefficient_image import EVERYTHING_ELSE, Block, gathered

__all__ = [
    "check_unknown",
    "light_pass",
    "has_guides",
    "read_guides",
    "read_materials",
    "read_pass",
    "read_render",
    "read_render_times",
    "render_blocks",
    "size",
]

_COMPLETE = "render all view layers of the scene as it was set up"


def light_pass(group: str) -> str:
    """Name of the render pass that holds a light group; Blender has no dots in the names of passes."""
    return "Combined" if group == EVERYTHING_ELSE else f"Combined_{group.replace('.', '_')}"


def _channels_of(layers: Sequence[str], pass_name: str, channels: int) -> list[str]:
    return [f"{layer}.{pass_name}.{c}" for layer in layers for c in "RGB"][:channels]


def _wanted(model: FactorModel, layers: Sequence[str], groups: Iterable[str]) -> list[str]:
    names = [name for group in groups for name in _channels_of(layers, light_pass(group), model.channels)]
    return [*names, _alpha(layers)]


def _alpha(layers: Sequence[str]) -> str:
    return f"{layers[0]}.Combined.A"


def _check(path: Path, wanted: Sequence[str], found: Iterable[str], why: str) -> None:
    missing = set(wanted) - set(found)
    if missing:
        first = next(name for name in wanted if name in missing)
        raise CoefficientImageError(f"{path}: pass {first.rpartition('.')[0]!r} is missing; {why}")


def size(path: str | Path, model: FactorModel, layers: Sequence[str], groups: Sequence[str]) -> tuple[int, int]:
    """(width, height) of a render whose coefficient passes are all there and whole. Raises CoefficientImageError."""
    path, wanted = Path(path), _wanted(model, layers, groups)
    _check(path, wanted, exr.names(path), _COMPLETE)
    return exr.size(path, wanted)


def read_render(
    path: str | Path, model: FactorModel, layers: Sequence[str], groups: Sequence[str]
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """{group: (height, width, p) float32} and (height, width) alpha of what `render_blocks` reads."""
    return gathered(render_blocks(path, model, layers, groups))


def render_blocks(
    path: str | Path, model: FactorModel, layers: Sequence[str], groups: Sequence[str]
) -> Iterator[Block]:
    """Coefficients and alpha of a multilayer EXR that Blender wrote, a few rows at a time.

    layers: the view layers of the coefficient passes, in order. groups: light groups to read; `EVERYTHING_ELSE` among
    them is worked out from the combined pass. Raises CoefficientImageError.
    """
    path = Path(path)
    _check(path, _wanted(model, layers, groups), exr.names(path), _COMPLETE)
    wanted: dict[str | None, list[str]] = {None: [_alpha(layers)]}
    wanted |= {group: _channels_of(layers, light_pass(group), model.channels) for group in groups}
    for rows, height, found in exr.blocks(path, wanted):
        named = {group: found[group] for group in groups}
        if EVERYTHING_ELSE in named:
            named[EVERYTHING_ELSE] -= sum(named[group] for group in groups if group != EVERYTHING_ELSE)
        yield Block(rows, height, named, found[None][..., 0])


def check_unknown(path: str | Path, layers: Sequence[str], groups: Sequence[str]) -> None:
    """Raise CoefficientImageError where a light group that is not among `groups` shines: its light would be lost."""
    known = {light_pass(group) for group in groups}
    first = f"{layers[0]}.Combined_"
    unknown = [n for n in exr.names(path) if n.startswith(first) and n[len(layers[0]) + 1 : -2] not in known]
    for name, values in (exr.channels(path, unknown) if unknown else {}).items():
        if values.any():
            raise CoefficientImageError(
                f"{path}: pass {name[:-2]!r} holds the light of a group that its description does not name; set the "
                "scene up again, or give the one that was rendered with --scene FILE.blend"
            )


def read_pass(path: str | Path, model: FactorModel, layers: Sequence[str], name: str) -> np.ndarray:
    """(height, width, p) float32 of one pass of all `layers`, as an AOV. Raises CoefficientImageError."""
    path, wanted = Path(path), _channels_of(layers, name, model.channels)
    _check(path, wanted, exr.names(path), "render again with it")
    return exr.stacks(path, {name: wanted})[name]


def read_materials(path: str | Path, layer: str) -> dict[str, np.ndarray]:
    """{material: (height, width) float32, the part of each pixel that is it}, of the Cryptomatte of a view layer.

    Raises CoefficientImageError where the render stored none.
    """
    path = Path(path)
    header = exr.attributes(path, "cryptomatte/")
    about = [key.rpartition("/")[0] for key, value in header.items() if value == f"{layer}.CryptoMaterial"]
    beginning = f"{layer}.CryptoMaterial"
    wanted = [name for name in exr.names(path) if name.startswith(beginning)]
    if not about or not wanted:
        raise CoefficientImageError(f"{path}: no Cryptomatte of materials is in it; render again with it")
    channels = exr.channels(path, wanted)
    order = sorted(wanted, key=lambda name: (name.rpartition(".")[0], "rgba".index(name[-1].lower())))
    ids = [np.ascontiguousarray(channels[name]).view(np.uint32) for name in order[::2]]
    parts = [channels[name] for name in order[1::2]]
    found: dict[str, np.ndarray] = {}
    for material, code in json.loads(header[f"{about[0]}/manifest"]).items():
        covered = np.zeros_like(parts[0])
        for each, part in zip(ids, parts, strict=True):
            covered += np.where(each == int(code, 16), part, np.float32(0.0))
        if covered.any():
            found[material] = covered
    return found


def has_guides(path: str | Path, layers: Sequence[str]) -> bool:
    """Whether `read_guides` has albedo and normal to read in every view layer."""
    names = set(exr.names(Path(path)))
    return all(f"{layer}.Denoising {name}" in names for layer in layers for name in ("Albedo.R", "Normal.X"))


def read_guides(path: str | Path, layers: Sequence[str], names: Sequence[str]) -> list[dict[str, np.ndarray]]:
    """For each view layer {name: (height, width, 3)} of what Cycles noted for its denoiser: "Albedo", "Normal".

    Raises CoefficientImageError where the render did not store them.
    """
    path, parts = Path(path), {"Albedo": "RGB", "Normal": "XYZ"}
    wanted = {(layer, n): [f"{layer}.Denoising {n}.{c}" for c in parts[n]] for layer in layers for n in names}
    every = [channel for each in wanted.values() for channel in each]
    _check(path, every, exr.names(path), "the denoiser needs it")
    stacked = exr.stacks(path, wanted)
    return [{name: stacked[layer, name] for name in names} for layer in layers]


def read_render_times(path: str | Path, layers: Sequence[str]) -> dict[str, dict[str, float]]:
    """{view layer: {"seconds", "sync_seconds"}}, of the layers for which Cycles notes them in the EXR."""
    times = {}
    for layer in layers:
        total = exr.attribute(path, f"cycles.{layer}.total_time")
        sync = exr.attribute(path, f"cycles.{layer}.synchronization_time")
        if total and sync:
            times[layer] = {"seconds": _seconds(total), "sync_seconds": _seconds(sync)}
    return times


def _seconds(clock: str) -> float:
    """Seconds of a time written as [hours:]minutes:seconds."""
    seconds = 0.0
    for part in clock.split(":"):
        seconds = 60.0 * seconds + float(part)
    return seconds
