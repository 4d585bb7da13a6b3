"""What a spectral render costs: time and noise over Blender's own RGB, at the same total of samples or noise threshold.

`python -m relume.benchmarks.overhead [--samples N] [--percent P] [--runs R] [--channels P ...] [--scenes NAME ...]
[--illuminant NAME] [--threshold NOISE] [--variants] [--settings]`

The scenes are set up as an artist would: the passes share the samples. In RGB, lamps have the colours of their
illuminants. The set-ups take turns, so that a busy machine slows all of them; what is printed are ratios to RGB. Time:
the processor's, median over runs. Variance of luminance over runs: in the median pixel and on average over pixels, as
part of the pixel's own luminance squared; and in the picture, the mean variance as part of the mean luminance squared.
Colour error: mean CIEDE2000 of a run to a long render of its own kind: as sampled; as shown, with noise of colour taken
out; what was sampled, denoised by the picture alone; denoised with albedo and normal as guides, Blender's own way; and
denoised as Relume does it by default. RGB has but one way to be denoised with guides. All variances are those as shown.
Below the table stands what taking noise of colour out does to the long render of the first number of channels, and to
that without its own noise, denoised.
`--variants` takes away, one after the other, what keeps noise low. `--settings` changes one of Cycles' own settings of
sampling at a time, of RGB as well: all are held against RGB as Cycles sets it, at the same samples.
"""

import argparse
import sys
import tempfile
import time
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from unittest import mock

import bpy
import numpy as np

from ..addon.host import denoising
from ..addon.scene import passes, render, setup
from ..assets import make_room
from ..core.colour import differences, spaces
from ..core.model import bases, channel_order, upsample
from ..core.picture import coefficients, noise, recombination, sampling
from . import hard_scenes

_SEED_STEP = 100  # passes with seeds of their own take those that follow each other
LONG_RUN = 0  # its seed
GUIDES = ("Albedo", "Normal")
SCENES = {"room": make_room.build, "lamps": hard_scenes.many_lights, "glass": hard_scenes.glossy_and_glass}
# Each takes away one more: (words, module, function, what stands in for it); with a noise threshold, only the other
_VARIANTS = [
    ("even shares", sampling, "shares", lambda model, lights: np.full(model.passes, 1 / model.passes)),
    ("and seeds of their own", passes, "sampling_for", lambda scene, model: _with_seeds(scene, model)),
    ("and channels by wavelength", channel_order, "balanced", lambda model: model),
    ("and the same seed", passes, "sampling_for", lambda scene, model: _with_one_seed(scene, model)),
]
_SETTINGS = {
    "without light tree": {"use_light_tree": False},
    "guided paths": {"use_guiding": True},
    "blue noise": {"sampling_pattern": "BLUE_NOISE"},
    "classic": {"sampling_pattern": "TABULATED_SOBOL"},
    "adaptive": {"use_adaptive_sampling": True, "adaptive_threshold": 0.05},
}
_THRESHOLD = [("one threshold for all", sampling, "adaptive", lambda threshold, minimum, *_: (threshold, minimum))]


@dataclass
class Row:
    """A way to render, and what its runs gave: seconds, linear pictures (height, width, 3) as rendered, denoised."""

    words: str
    channels: int = 0  # 0 for Blender's own RGB
    without: list = field(default_factory=list)  # what is taken away
    settings: dict = field(default_factory=dict)  # of Cycles
    seconds: list = field(default_factory=list)
    pictures: list = field(default_factory=list)
    clean: list = field(default_factory=list)  # of each run, as sampled, and denoised: alone, with guides, by default
    long_run: np.ndarray | None = None
    long_versions: list = field(
        default_factory=list
    )  # what it shows; and denoised, before and after colour noise is taken


def _with_seeds(scene, model) -> sampling.Sampling:
    return sampling.independent(model.passes, -(-scene.cycles.samples // model.passes), scene.cycles.seed)


def _with_one_seed(scene, model) -> sampling.Sampling:
    return sampling.same(model.passes, -(-scene.cycles.samples // model.passes))


def _render(row: Row, path: Path, arguments, seed: int, samples: int) -> tuple[float, np.ndarray, list]:
    """Seconds, the picture (height, width, 3) in Rec.709 and, but for the long run, its other versions."""
    bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
    scene = bpy.context.scene
    scene.render.resolution_percentage, scene.cycles.samples = arguments.percent, samples
    scene.cycles.seed = _SEED_STEP * seed
    if arguments.threshold and seed != LONG_RUN:
        scene.cycles.use_adaptive_sampling, scene.cycles.adaptive_threshold = True, arguments.threshold
    if seed != LONG_RUN:
        for name, value in row.settings.items():
            setattr(scene.cycles, name, value)
    if arguments.illuminant:
        for light_group in scene.relume.light_groups:
            light_group.illuminant = arguments.illuminant
    if not row.channels:
        color_lamps(scene)
        return _plain(scene, path.with_name("plain.exr"), seed)
    with ExitStack() as patches:
        for _, module, name, stand_in in row.without:
            patches.enter_context(mock.patch.object(module, name, stand_in))
        setup.set_up(scene, bases.fitted(row.channels))
    began = time.process_time()
    rendered = render.render(scene, path.parent, guides=GUIDES)
    seconds = time.process_time() - began
    lights = {group.name: group.light() for group in scene.relume.light_groups}
    image = replace(rendered.image, groups=rendered.sampled)
    sampled = render.picture(image, lights)
    clean = denoising.denoised_image(image, rendered.guides)
    apart = render.picture(clean, lights)
    if seed == LONG_RUN:
        guides = [{name: denoising.denoised(each) for name, each in guide.items()} for guide in rendered.guides]
        again = replace(image, groups=noise.estimated(clean.groups, guides))
        return seconds, sampled, [render.picture(rendered.image, lights), apart, render.picture(again, lights)]
    clean = [sampled, denoising.denoised(sampled), denoising.denoised(sampled, rendered.guides[0]), apart]
    return seconds, render.picture(rendered.image, lights), clean


def color_lamps(scene):
    """Give each lamp the colour of what shines in its light group."""
    model, to_rgb = bases.bands(), spaces.xyz_to_rgb()
    for thing in scene.objects:
        if thing.type == "LIGHT":
            light = scene.relume.light_groups[thing.lightgroup].light()
            thing.data.color = np.maximum(to_rgb @ model.relight(light.illuminant).sum(axis=1), 0.0)


def _plain(scene, path: Path, seed: int) -> tuple[float, np.ndarray, list]:
    seconds, picture, guides = plain(scene, path)
    if seed == LONG_RUN:
        return seconds, picture, []
    guided = denoising.denoised(picture, guides)
    return seconds, picture, [picture, denoising.denoised(picture), guided, guided]


def plain(scene, path: Path) -> tuple[float, np.ndarray, dict]:
    """Blender's own render of a scene: seconds, the picture (height, width, 3), what its denoiser may look at."""
    output, (layer,) = scene.render.image_settings, scene.view_layers
    output.media_type, output.file_format = "MULTI_LAYER_IMAGE", "OPEN_EXR_MULTILAYER"
    output.color_depth = "32"
    layer.cycles.denoising_store_passes = True
    scene.render.filepath = str(path)
    began = time.process_time()
    bpy.ops.render.render(write_still=True)
    seconds = time.process_time() - began
    groups, _ = coefficients.read_render(path, bases.rgb(), [layer.name], [coefficients.EVERYTHING_ELSE])
    (guides,) = coefficients.read_guides(path, [layer.name], GUIDES)
    return seconds, groups[coefficients.EVERYTHING_ELSE], guides


def _variance(row: Row) -> np.ndarray:
    """Variance of luminance over runs: in the median pixel, on average, and of the picture; each relative."""
    luminance = np.array(row.pictures) @ upsample.rgb_to_xyz()[1]
    variance, mean = luminance.var(axis=0, ddof=1), luminance.mean(axis=0)
    relative = variance / np.maximum(mean, 1e-6) ** 2
    return np.array([np.median(relative), relative.mean(), variance.mean() / mean.mean() ** 2])


def _color_error(row: Row, white: np.ndarray) -> np.ndarray:
    """Mean CIEDE2000 to the long run: as shown, as sampled, and denoised in each way."""
    to_xyz = upsample.rgb_to_xyz()
    truth = row.long_run @ to_xyz.T
    ways = [row.pictures, *zip(*row.clean, strict=True)]
    return np.array([differences.picture_delta_E(np.array(way) @ to_xyz.T, truth, white).mean() for way in ways])


def _table(rows: list[Row], white: np.ndarray) -> list[str]:
    plain = rows[0]
    head = "| over RGB | time | variance: median pixel | mean | picture | ΔE2000 as shown | as sampled "
    head += "| denoised: picture alone | with guides | by default |"
    lines = [head, "|---|" + "---|" * 9]
    for row in rows:
        ratios = [np.median(np.array(row.seconds) / np.array(plain.seconds))]
        ratios += [*(_variance(row) / _variance(plain)), *(_color_error(row, white) / _color_error(plain, white))]
        lines.append(f"| {row.words} |" + "".join(f" {ratio:.2f} |" for ratio in ratios))
    shown = " / ".join(f"{error:.2f}" for error in _color_error(plain, white))
    return [*lines, "", f"ΔE2000 of RGB itself: {shown}"]


def _converged(sampled: np.ndarray, versions: list, white: np.ndarray) -> str:
    """What taking out noise of colour does to a long render, as sampled and denoised; mean and 99th percentile."""
    to_xyz = upsample.rgb_to_xyz()
    shown, clean, again = versions
    said = []
    for words, before, after in (("as sampled", sampled, shown), ("denoised", clean, again)):
        difference = differences.picture_delta_E(after @ to_xyz.T, before @ to_xyz.T, white)
        said.append(f"{words} {difference.mean():.3f}, p99 {np.quantile(difference, 0.99):.2f}")
    return f"ΔE2000 by which noise of colour taken out changes the long render: {'; '.join(said)}"


def _measure(path: Path, arguments) -> list[Row]:
    """All rows of one scene."""
    rows = [Row("RGB"), *(Row(f"p = {p}", p) for p in arguments.channels)]
    long_runs = {row.channels: _render(row, path, arguments, LONG_RUN, arguments.long)[1:] for row in rows}
    if arguments.variants:
        p = arguments.channels[0]
        variants = _THRESHOLD if arguments.threshold else _VARIANTS
        rows += [Row(f"p = {p}, {words}", p, variants[: n + 1]) for n, (words, *_) in enumerate(variants)]
    if arguments.settings:
        kinds = {"RGB": 0, **{f"p = {p}": p for p in arguments.channels}}
        rows += [
            Row(f"{kind}, {words}", p, [], {**each}) for words, each in _SETTINGS.items() for kind, p in kinds.items()
        ]
    for run in range(arguments.runs):
        for row in rows:
            row.long_run, row.long_versions = long_runs[row.channels]
            seconds, picture, clean = _render(row, path, arguments, run + 1, arguments.samples)
            row.seconds.append(seconds)
            row.pictures.append(picture)
            row.clean.append(clean)
    return rows


def main(argv: list[str] | None = None):
    parser = argparse.ArgumentParser(prog="python -m relume.benchmarks.overhead", description=__doc__)
    parser.add_argument("--samples", type=int, default=48, help="per pixel, of all passes together (48)")
    parser.add_argument("--percent", type=int, default=20, help="of the scenes' own resolution (20)")
    parser.add_argument("--runs", type=int, default=16, help="renders of each, with seeds of their own (16)")
    parser.add_argument("--long", type=int, default=1536, metavar="N", help="samples of the long renders (1536)")
    parser.add_argument("--channels", type=int, nargs="+", default=[9, 6, 12], metavar="P", help="(9 6 12)")
    parser.add_argument("--scenes", nargs="+", choices=SCENES, default=list(SCENES), metavar="NAME", help="(all)")
    parser.add_argument("--illuminant", metavar="NAME", help="of every light group (the scene's own)")
    parser.add_argument("--threshold", type=float, metavar="NOISE", help="of adaptive sampling, up to --samples (off)")
    parser.add_argument("--variants", action="store_true", help="of the first number of channels")
    parser.add_argument("--settings", action="store_true", help="of Cycles' sampling, one changed at a time")
    arguments = parser.parse_args(argv)
    if arguments.runs < 2:
        parser.error("variance needs 2 runs or more")

    from .. import register

    register()
    with tempfile.TemporaryDirectory() as temporary:
        for name in arguments.scenes:
            scene, path = SCENES[name](), Path(temporary) / f"{name}.blend"
            size = [n * arguments.percent // 100 for n in (scene.render.resolution_x, scene.render.resolution_y)]
            bpy.ops.wm.save_as_mainfile(filepath=str(path))
            rows = _measure(path, arguments)
            white = recombination.mixed_white(bases.bands(), setup.lighting(bpy.context.scene))
            print(f"\n{name}, {size[0]} × {size[1]} pixels, {arguments.samples} samples, {arguments.runs} runs:\n")
            print("\n".join([*_table(rows, white), _converged(rows[1].long_run, rows[1].long_versions, white), ""]))
            sys.stdout.flush()


if __name__ == "__main__":
    main()
