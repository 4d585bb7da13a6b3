"""How set-up, render and recombination grow: with materials, light groups, channels, resolution and frames.

`python -m relume.benchmarks.growth [--axes NAME ...] [--long] [--out DIR]`

Each point is measured in a process of its own, all of whose memory is therefore the point's. Seconds are those of the
processor, on all cores together, so that a busy machine says the same; those of Cycles' synchronisation are by the
clock. *RGB render* is Blender's own render of the same scene, with the samples of one pass; *with light groups*, the
same where it stores those of the spectral render as well. Memory: the most that the process held, less what it held
when the scene was made. The exponent is the slope of each column on logarithmic axes, over the upper half of the
points: 1 is linear, 0 does not grow; what grows faster than `n^1.15` is marked.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import bpy
import numpy as np

from ..addon.cli import commands
from ..addon.scene import render, setup
from ..assets import make_room
from ..core.model import bases
from ..studies import figures
from . import conversion

_COLUMNS = (
    "RGB render",
    "with light groups",
    "set up",
    "remove",
    "synchronisation",
    "render",
    "recombination",
    "memory",
)
_AXES = {
    "materials": (1, 10, 100, 1000, 3000),
    "light groups": (1, 2, 4, 8, 16, 32),
    "channels": (3, 6, 9, 12, 15, 33),
    "megapixels": (0.5, 2.1, 8.3, 33.2),  # 960 × 540 to 7680 × 4320, in the same shape
    "frames": (1, 2, 4, 8, 16),
}
_MANY = 10000  # materials, with --long
_CAUSES = {
    "materials": "Blender looks through all node trees of the file whenever what reaches the output of one changes, "
    "which takes two looks for each material. Synchronisation and render are Blender's own, as in the RGB render.",
    "light groups": "Blender looks through a node tree at each node and link that is added; the recombination has four "
    "nodes for each pass of each light group.",
}
_CHANNELS = 9
_FASTER = 1.15  # exponents above it are marked
_FELT = 0.3  # seconds: what takes less is noise, and marked by no exponent
_SMALL = (240, 180)
_WIDE = 16 / 9


def _warm_up():
    """What happens once in a session: libraries and Cycles' kernels are loaded."""
    scene, model = _materials(1)
    setup.set_up(scene, model)
    with tempfile.TemporaryDirectory() as folder:
        render.render(scene, Path(folder))


def _materials(count):
    scene = conversion.generate(count)
    return _quick(scene, (16, 16)), bases.fitted(_CHANNELS)


def _light_groups(count):
    scene = _room(_SMALL)
    lamps = [thing for thing in scene.objects if thing.type == "LIGHT"]
    for lamp in lamps[1:]:
        bpy.data.objects.remove(lamp)
    scene.relume.light_groups.clear()
    lamps[0].lightgroup = "lamp 0"
    for index in range(1, count):
        lamp = lamps[0].copy()
        lamp.lightgroup = f"lamp {index}"
        scene.collection.objects.link(lamp)
    return scene, bases.fitted(_CHANNELS)


def _channels(count):
    return _room(_SMALL), bases.bands(count) if count >= 33 else bases.fitted(count)


def _megapixels(count):
    height = round((count * 1e6 / _WIDE) ** 0.5)
    scene = _room((round(_WIDE * height), height))
    # As little as can be: what is asked is what the size of the picture costs
    scene.cycles.samples, scene.cycles.max_bounces = 1, 0
    return scene, bases.fitted(_CHANNELS)


def _room(size):
    bpy.ops.wm.open_mainfile(filepath=str(make_room.PATH), load_ui=False)
    return _quick(bpy.context.scene, size)


def _quick(scene, size):
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    scene.cycles.samples, scene.cycles.use_adaptive_sampling, scene.cycles.use_denoising = 3, False, False
    scene.relume.split_samples = False
    return scene


def _memory(which: str) -> float:
    """MB that this process holds ("VmRSS"), or held at most ("VmHWM"); nan where the system does not tell."""
    try:
        words = Path("/proc/self/status").read_text(encoding="ascii").split()
    except OSError:
        return float("nan")
    return int(words[words.index(f"{which}:") + 1]) / 1024


def _seconds(work, *arguments):
    """What `work` returns, and the processor's seconds that it took."""
    began = time.process_time()
    done = work(*arguments)
    return done, time.process_time() - began


def _point(axis: str, count: float) -> tuple[float, ...]:
    """The columns of one point, in a process that does nothing else."""
    from .. import register

    register()
    _warm_up()
    if axis == "frames":
        return _frames(count)
    scene, model = {
        "materials": _materials,
        "light groups": _light_groups,
        "channels": _channels,
        "megapixels": _megapixels,
    }[axis](count)
    before = _memory("VmRSS")
    _, plain = _seconds(bpy.ops.render.render)
    _, grouped = _seconds(_render_groups, scene)
    _, set_up = _seconds(setup.set_up, scene, model)
    lights = {group.name: group.light() for group in scene.relume.light_groups}
    with tempfile.TemporaryDirectory() as folder:
        rendered, seconds = _seconds(render.render, scene, Path(folder))
    render.picture(rendered.image, lights)  # fits the matrices
    _, recombination = _seconds(render.picture, rendered.image, lights)
    memory = _memory("VmHWM") - before
    sync = sum(times["sync_seconds"] for times in rendered.times.values())
    _, remove = _seconds(setup.remove, scene)
    return plain, grouped, set_up, remove, sync, seconds, recombination, memory


def _render_groups(scene) -> None:
    """Blender's own render of a scene, which stores its light groups while it lasts."""
    (layer,) = scene.view_layers
    for row in scene.relume.light_groups:
        layer.lightgroups.add(name=row.name)
    bpy.ops.render.render()
    while layer.lightgroups:
        bpy.ops.scene.view_layer_remove_lightgroup()


def _in_a_process(axis: str, count: float) -> list[float]:
    """`_point` in a Python of its own, which prints it last. Raises RuntimeError with what that Python said."""
    command = [sys.executable, "-m", __spec__.name, "--point", axis, str(count)]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode:
        raise RuntimeError(f"{axis} {count:g} failed:\n{done.stdout}")
    return json.loads(done.stdout.splitlines()[-1])


def _frames(count: int) -> tuple[float, ...]:
    """`relume render` of a few frames, and `relume relight` of what it wrote."""
    _room(_SMALL)
    with tempfile.TemporaryDirectory() as folder:
        blend = Path(folder) / "shot.blend"
        bpy.ops.wm.save_as_mainfile(filepath=str(blend))
        before = _memory("VmRSS")
        render_it = ["render", str(blend), "--frame", f"1-{count}", "--channels", str(_CHANNELS), "--out", folder]
        relight = ["relight", f"{folder}/shot_####.exr", "--out", f"{folder}/lit_####.exr"]
        taken = [_seconds(commands.execute, arguments) for arguments in (render_it, relight)]
        if any(status for status, _ in taken):
            raise RuntimeError(f"{count} frames could not be rendered and relit")
        nothing = float("nan")
        return nothing, nothing, nothing, nothing, nothing, taken[0][1], taken[1][1], _memory("VmHWM") - before


def exponent(counts, values) -> float:
    """Slope of values over counts on logarithmic axes, over the upper half of the points; nan without any."""
    half = len(counts) // 2
    counts, values = np.array(counts[half:], float), np.array(values[half:], float)
    known = values > 0
    return np.polyfit(np.log(counts[known]), np.log(values[known]), 1)[0] if known.sum() > 1 else float("nan")


def _cell(value: float) -> str:
    return "–" if np.isnan(value) else f"{value:.3g}" if value < 1000 else f"{value:.0f}"


def _table(axis: str, counts, points) -> list[str]:
    lines = [f"| {axis} |" + "".join(f" {name} |" for name in _COLUMNS), "|" + "---|" * (1 + len(_COLUMNS))]
    lines += [f"| {n} |" + "".join(f" {_cell(v)} |" for v in row) for n, row in zip(counts, points, strict=True)]
    slopes = [exponent(counts, column) for column in zip(*points, strict=True)]
    marks = [" faster" if s > _FASTER and last > _FELT else "" for s, last in zip(slopes, points[-1], strict=True)]
    lines.append("| exponent |" + "".join(f" {_cell(s)}{m} |" for s, m in zip(slopes, marks, strict=True)))
    if any(marks) and axis in _CAUSES:
        lines += ["", _CAUSES[axis]]
    return lines


def main(argv: list[str] | None = None):
    parser = argparse.ArgumentParser(prog="python -m relume.benchmarks.growth", description=__doc__)
    parser.add_argument("--axes", nargs="+", choices=_AXES, default=list(_AXES), metavar="NAME", help="(all)")
    parser.add_argument("--long", action="store_true", help=f"{_MANY} materials too: ten minutes more")
    parser.add_argument("--out", type=Path, default=Path("out/growth"), metavar="DIR")
    parser.add_argument("--point", nargs=2, metavar=("NAME", "N"), help=argparse.SUPPRESS)
    arguments = parser.parse_args(argv)

    if arguments.point:
        axis, count = arguments.point[0], float(arguments.point[1])
        print(json.dumps(_point(axis, count if axis == "megapixels" else int(count))), flush=True)
        return
    lines, panels = ["Seconds, and megabytes."], []
    for axis in arguments.axes:
        counts = [*_AXES[axis], *([_MANY] if arguments.long and axis == "materials" else [])]
        points = [_in_a_process(axis, count) for count in counts]
        table = ["", *_table(axis, counts, points)]
        print("\n".join(table), flush=True)
        lines += table
        columns = zip(_COLUMNS, zip(*points, strict=True), strict=True)
        drawn = [(name, counts, column) for name, column in columns]
        panels.append(figures.Panel(axis, drawn, "seconds; megabytes", log="xy"))
    arguments.out.mkdir(parents=True, exist_ok=True)
    (arguments.out / "growth.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
    figures.curves(arguments.out / "growth.png", panels)
    print(f"\n{arguments.out / 'growth.md'}\n{arguments.out / 'growth.png'}")


if __name__ == "__main__":
    main()
