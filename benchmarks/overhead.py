"""What a spectral render costs: time and noise of nine channels over Blender's own RGB, at the same total of samples.

`python -m relume.benchmarks.overhead [--samples N] [--percent P] [--runs R] [--channels P ...]`

The room, as an artist would render it: every pass has its share of the samples and a seed of its own. The set-ups take
turns, so that a busy machine slows all of them; what is printed are ratios: the median over runs for time, and for
noise the variance of luminance over runs, as part of its square, in the median pixel and on average.
"""

import argparse
import tempfile
import time
from pathlib import Path

import bpy
import numpy as np

from ..addon import render, setup
from ..assets import make_room
from ..core import bases, coefficients, upsample, view

_SEED_STEP = 100  # the passes of one render take seeds that follow each other


def _open(samples: int, percent: int, seed: int):
    bpy.ops.wm.open_mainfile(filepath=str(make_room.PATH), load_ui=False)
    scene = bpy.context.scene
    scene.render.resolution_percentage, scene.cycles.samples = percent, samples
    scene.cycles.seed = _SEED_STEP * seed
    return scene


def _plain(scene, folder: Path) -> tuple[float, np.ndarray]:
    """Seconds, and luminance (height, width), of the scene as Blender itself renders it."""
    path = folder / "plain.exr"
    output = scene.render.image_settings
    output.media_type, output.file_format, output.color_depth = "IMAGE", "OPEN_EXR", "32"
    scene.render.filepath = str(path)
    began = time.perf_counter()
    bpy.ops.render.render(write_still=True)
    seconds = time.perf_counter() - began
    return seconds, coefficients.read_rgb(path) @ upsample.rgb_to_xyz()[1]


def _spectral(scene, folder: Path, channels: int) -> tuple[float, np.ndarray]:
    """The same of the scene with coefficient passes, the lights as they are."""
    setup.set_up(scene, bases.fitted(channels))
    began = time.perf_counter()
    image = render.render(scene, folder).image
    seconds = time.perf_counter() - began
    lights = [row.light() for row in scene.relume.light_groups]
    to_y = np.linalg.inv(view.xyz_to_rgb())[1] @ view.recombination_matrices(image.model, lights)
    return seconds, coefficients.recombine(list(image.groups.values()), np.repeat(to_y[:, None], 3, axis=1))[..., 0]


def _noise(luminance: np.ndarray) -> np.ndarray:
    """Variance of luminance (runs, height, width) as part of its square, (height, width)."""
    return luminance.var(axis=0, ddof=1) / np.maximum(luminance.mean(axis=0), 1e-6) ** 2


def main(argv: list[str] | None = None):
    parser = argparse.ArgumentParser(prog="python -m relume.benchmarks.overhead", description=__doc__)
    parser.add_argument("--samples", type=int, default=48, help="per pixel, of all passes together (48)")
    parser.add_argument("--percent", type=int, default=20, help="of the room's own resolution (20)")
    parser.add_argument("--runs", type=int, default=16, help="renders of each, with seeds of their own (16)")
    parser.add_argument("--channels", type=int, nargs="+", default=[6, 9, 12], metavar="P", help="(6 9 12)")
    arguments = parser.parse_args(argv)
    if arguments.runs < 2:
        parser.error("variance needs 2 runs or more")

    from .. import register

    register()
    names = ["RGB", *(f"p = {p}" for p in arguments.channels)]
    seconds, luminance = {name: [] for name in names}, {name: [] for name in names}
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        for run in range(arguments.runs):
            for name, channels in zip(names, [None, *arguments.channels], strict=True):
                scene = _open(arguments.samples, arguments.percent, run + 1)
                taken, picture = _spectral(scene, folder, channels) if channels else _plain(scene, folder)
                seconds[name].append(taken)
                luminance[name].append(picture)
    height, width = luminance["RGB"][0].shape
    print(f"\n{width} × {height} pixels, {arguments.samples} samples in all, {arguments.runs} runs; over Blender's RGB")
    print(f"{'':<8}{'time':>8}{'variance, median pixel':>26}{'mean':>8}")
    plain = _noise(np.array(luminance["RGB"]))
    for name in names:
        noise = _noise(np.array(luminance[name]))
        ratio = np.median(np.array(seconds[name]) / np.array(seconds["RGB"]))
        print(f"{name:<8}{ratio:>8.2f}{np.median(noise) / np.median(plain):>26.2f}{noise.mean() / plain.mean():>8.2f}")


if __name__ == "__main__":
    main()
