"""Filters that share a weighting (`studies.partition`), rendered: noise over RGB at the same samples, as rendered.

`python -m relume.benchmarks.shared_filters [--scenes NAME ...] [--samples N] [--percent P] [--runs R] [--long N]
[--iterations N] [--passes K ...]`

Before recombination the channels of each pass, in each light group, are divided by their own brightness and get the
mean of all passes': per pixel, without blurring anything. Ratios to RGB: mean CIEDE2000 of a run to a long render,
RGB's own or that of today's nine channels; variance of luminance, the mean over pixels as part of the mean luminance
squared. *Beside* is the CIEDE2000 of a long divided render: its noise, and the bias of dividing.
"""

import argparse
import tempfile
from dataclasses import dataclass, field, replace
from pathlib import Path
from unittest import mock

import bpy
import numpy as np

from ..addon.scene import render, setup
from ..core.colour import differences
from ..core.model import bases, channel_order, optimise, relight, upsample
from ..core.model.factor_model import FactorModel
from ..core.picture import recombination
from ..core.spectra import library
from ..core.spectra.spectrum import WAVELENGTHS
from ..studies import partition
from ..studies.levers import cie_lights
from . import overhead

_NOISE = 0.03  # how much the noise counts beside the squared errors when the filters are made


@dataclass
class Row:
    """A model, None for RGB, how its channels sum to brightness, and its pictures (height, width, 3)."""

    name: str
    model: FactorModel | None = None
    brightness: np.ndarray | None = None
    undivided: list = field(default_factory=list)
    pictures: list = field(default_factory=list)
    long_run: np.ndarray | None = None
    beside: float = 0.0


def shared(passes: int, iterations: int) -> tuple[FactorModel, np.ndarray]:
    """The model, and (3 k,) what the channels of a pass sum to brightness by."""
    power = np.stack([relight.power_weights(light.sampled(), library.observer()) for light in cie_lights()])
    start = partition.interleaved(passes)
    with optimise.one_thread():
        for noise in (0.0, _NOISE):
            start = partition.optimised(start, partition.Aim(power[:: partition.EVERY], noise, passes), iterations)
    found = partition.Shared.of(start)
    return FactorModel("fitted", WAVELENGTHS, found.filters), found.brightness


def divided(image, brightness: np.ndarray):
    """A coefficient image whose passes all have the mean brightness of them, in each light group."""
    groups = {}
    for name, values in image.groups.items():
        parts = (values * brightness.astype(np.float32)).reshape(*values.shape[:2], -1, 3).sum(axis=-1)
        mean = parts.mean(axis=-1, keepdims=True)
        ratio = np.divide(mean, parts, out=np.ones_like(parts), where=parts > 0)
        groups[name] = values * np.repeat(ratio, 3, axis=-1)
    return replace(image, groups=groups)


def _render(row: Row, path: Path, arguments, seed: int, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """The picture as it is and divided, in Rec.709."""
    bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
    scene = bpy.context.scene
    scene.render.resolution_percentage, scene.cycles.samples = arguments.percent, samples
    scene.cycles.seed = 100 * seed
    if row.model is None:
        overhead.color_lamps(scene)
        _, picture, _ = overhead.plain(scene, path.with_name("plain.exr"))
        return picture, picture
    keeps = (lambda model: model) if row.brightness is not None else channel_order.balanced
    with mock.patch.object(channel_order, "balanced", keeps):
        scene.relume.reduce_color_noise = False
        setup.set_up(scene, row.model)
        image = render.render(scene, path.parent).image
    lights = {group.name: group.light() for group in scene.relume.light_groups}
    picture = render.picture(image, lights)
    if row.brightness is None:
        return picture, picture
    return picture, render.picture(divided(image, row.brightness), lights)


def _measure(path: Path, arguments, models) -> list[str]:
    rows = [Row("RGB"), Row("p = 9", bases.fitted(9))]
    for model, brightness in models:
        rows.append(Row(f"shared, p = {model.channels}", model, brightness))
    to_xyz = upsample.rgb_to_xyz()

    def error(pictures, truth) -> float:
        return float(differences.picture_delta_E(np.array(pictures) @ to_xyz.T, truth @ to_xyz.T, white).mean())

    sides = [_render(row, path, arguments, 0, arguments.long) for row in rows]
    white = recombination.mixed_white(bases.bands(), setup.lighting(bpy.context.scene))  # of the last, which is set up
    truth = sides[1][0]  # today's filters: the shared ones, not divided, have noise even in long renders
    for row, (plain, done) in zip(rows, sides, strict=True):
        row.long_run = truth if row.model else plain
        row.beside = error([done], row.long_run)
    for run in range(arguments.runs):
        for row in rows:
            plain, done = _render(row, path, arguments, run + 1, arguments.samples)
            row.undivided.append(plain)
            row.pictures.append(done)
    lines = ["| over RGB | ΔE2000, not divided | divided | variance of luminance, not divided | divided | beside |"]
    lines.append("|---" * 6 + "|")

    def variance(pictures) -> float:
        luminance = np.array(pictures) @ to_xyz[1]
        return luminance.var(axis=0, ddof=1).mean() / luminance.mean() ** 2

    base = error(rows[0].pictures, rows[0].long_run), variance(rows[0].pictures)
    for row in rows:
        cells = [error(each, row.long_run) / base[0] for each in (row.undivided, row.pictures)]
        cells += [variance(each) / base[1] for each in (row.undivided, row.pictures)]
        lines.append(f"| {row.name} |" + "".join(f" {cell:.2f} |" for cell in [*cells, row.beside]))
    return lines


def main(argv: list[str] | None = None):
    parser = argparse.ArgumentParser(prog="python -m relume.benchmarks.shared_filters", description=__doc__)
    parser.add_argument("--scenes", nargs="+", choices=overhead.SCENES, default=list(overhead.SCENES), metavar="NAME")
    parser.add_argument("--samples", type=int, default=48, help="per pixel, of all passes together (48)")
    parser.add_argument("--percent", type=int, default=12, help="of the scenes' own resolution (12)")
    parser.add_argument("--runs", type=int, default=4, help="renders of each (4)")
    parser.add_argument("--long", type=int, default=1536, metavar="N", help="samples of the long renders (1536)")
    parser.add_argument("--iterations", type=int, default=300, metavar="N", help="of making the filters (300)")
    parser.add_argument("--passes", type=int, nargs="+", default=[3, 4], metavar="K", help="of shared filters (3 4)")
    arguments = parser.parse_args(argv)
    if arguments.runs < 2:
        parser.error("variance needs 2 runs or more")

    from .. import register

    register()
    models = [shared(passes, arguments.iterations) for passes in arguments.passes]
    with tempfile.TemporaryDirectory() as temporary:
        for name in arguments.scenes:
            overhead.SCENES[name]()
            path = Path(temporary) / f"{name}.blend"
            bpy.ops.wm.save_as_mainfile(filepath=str(path))
            lines = _measure(path, arguments, models)
            print(
                "\n".join(["", f"{name}, {arguments.samples} samples, {arguments.runs} runs:", "", *lines]), flush=True
            )


if __name__ == "__main__":
    main()
