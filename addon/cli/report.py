"""Error against run time of one scene: `relume report`.

Every model renders the scene twice over. Once with the same noise as the reference, so that the difference is the
model's; twice as an artist would, with samples shared out and seeds of their own, which gives the time and the noise.
Each model's figures are kept in the report's folder: a stopped report goes on where it was.
"""

import argparse
import hashlib
import json
import os
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import bpy
import numpy as np

from ...core import results
from ...core.colour import differences, spaces
from ...core.errors import CoefficientImageError, UsageError
from ...core.model import bases
from ...core.model.factor_model import FactorModel
from ...core.picture import coefficients, plan, recombination, scatter
from ...core.picture.coefficients import CoefficientImage
from ...core.picture.mix import Light, Mix
from ...studies import figures
from ..host import console
from ..host.blend_file import open_scene
from ..scene import content, render, render_settings, setup
from . import jobs

__all__ = ["run"]

_REFERENCE = "reference"
_EXPLANATION = """\
Colour differences are CIEDE2000 to the reference. *Model*: same noise on both sides, so that only the model differs.
*Noise*: two renders with seeds of their own, samples shared among passes. *Worst lamp*: put on every light after the
render. The first render of a run loads Cycles: of two the faster counts."""

_UNDRAWN = """\
The maps of colour differences need matplotlib, which Blender's Python lacks: `relume report` outside of Blender draws
them in this folder, and renders nothing again."""
_PLOT, _TITLE = "error_over_time.svg", "Error against run time: dot with noise, dash the model alone"


@dataclass(frozen=True)
class Row:
    """What one model took, and how far it is from the reference; colour differences are CIEDE2000.

    model: as the scene is lit, without noise: median, 98th percentile, largest. worst: 98th percentile under the worst
    of the illuminants that the light may be switched to. total: with noise, as rendered. noise: median between renders.
    """

    name: str
    channels: int
    passes: int
    seconds: float
    sync_seconds: float
    model: dict
    worst: float
    worst_light: str
    total: dict
    noise: float
    megabytes: float


def run(options: argparse.Namespace) -> None:
    """Render the scene of the file that is open with every model asked for; write the report and print its paths."""
    blend = Path(bpy.data.filepath)
    if not blend.name:
        raise UsageError("save the scene first: a report opens its file once for each model")

    def wait() -> None:
        console.say(f"{options.out}: another process makes a report there; waiting for it to end")

    with (
        results.folder(options.out) as folder,
        results.claim(folder / "report.json", wait),
        results.folder(folder / "renders") as renders,
    ):
        _report(blend, folder, renders, options)


def _report(blend: Path, folder: Path, renders: Path, options: argparse.Namespace) -> None:
    key = _key(blend, options)
    scene = _open(blend, options)
    chosen = plan.choose(content.content_of(scene), scene.relume.tolerance)
    models = _models(scene, options, chosen.model)
    models[_REFERENCE] = bases.bands()
    takes = _Takes(blend, options, renders, key)
    passes = takes.waiting(models)
    console.event("passes", number=passes) or console.say(f"{passes} passes to render")
    reference = takes.comparable(_REFERENCE, models[_REFERENCE])
    rows, pictures = [], {}
    for name, model in models.items():
        rows.append(takes.row(name, model, reference))
        pictures[name] = takes.comparable(name, model)
    _write(folder, blend, rows, chosen, pictures, takes.lights())


def _key(blend: Path, options: argparse.Namespace) -> str:
    """Changes with the file and with all that a render depends on."""
    settings = [blend.read_bytes(), str((options.samples, options.percent, options.frame)).encode()]
    return hashlib.sha256(b"".join(settings)).hexdigest()


def _open(blend: Path, options: argparse.Namespace):
    scene = open_scene(blend, remarks=False)  # they were made when it was opened first
    if scene.relume.is_set_up:
        setup.remove(scene)
    if options.samples:
        scene.cycles.samples = options.samples
    if options.percent:
        scene.render.resolution_percentage = options.percent
    if options.frame is not None:
        scene.frame_set(options.frame)
    return scene


def _models(scene, options: argparse.Namespace, chosen: FactorModel) -> dict:
    """{name: model} in the order of their passes; the planner's choice is among them."""
    lights = content.content_of(scene).lights
    made = {}
    if "rgb" in options.models:
        made["RGB"] = bases.rgb()
    if "prefiltered" in options.models:
        made |= {f"prefiltered, {light.name}": bases.prefiltered(light) for light in lights}
    for channels in options.channels:
        if "fitted" in options.models:
            made[f"{channels} channel{'s' if channels > 1 else ''}"] = bases.fitted(channels)
        if "block" in options.models:
            made[f"block, {channels}"] = bases.block(channels)
        if "sharpened" in options.models:
            made[f"sharpened, {channels}"] = bases.sharpened(channels)
    made["automatic"] = chosen
    return dict(sorted(made.items(), key=lambda item: item[1].passes))


class _Takes:
    """Renders of one scene, kept in a folder under the key of what they depend on."""

    def __init__(self, blend: Path, options: argparse.Namespace, folder: Path, key: str) -> None:
        self.blend, self.options, self.folder, self.key = blend, options, folder, key

    def lights(self) -> dict[str, Light]:
        """What shines in each light group of the scene that was rendered last."""
        return {row.name: row.light() for row in bpy.context.scene.relume.lit}

    def waiting(self, models: dict) -> int:
        """Passes that are still to be rendered for {name: model}."""
        renders = {
            name: (self._kept_image(name, model) is None) + 2 * (self._kept_row(name, model) is None)
            for name, model in models.items()
        }
        return sum(count * models[name].passes for name, count in renders.items())

    def comparable(self, name: str, model: FactorModel) -> coefficients.CoefficientImage:
        """The scene without differences of noise: one seed, no path ended by a channel's own brightness."""
        kept = self._kept_image(name, model)
        if kept is None:
            scene = _open(self.blend, self.options)
            render_settings.compare(scene)
            image, _ = self._render(scene, name, model)
            coefficients.write(self._path(name, model, "exr"), image, render.picture(image, self.lights()))
            return self._kept_image(name, model)
        if not bpy.context.scene.relume.is_set_up:
            setup.set_up(_open(self.blend, self.options), model)
        return kept

    def _kept_image(self, name: str, model: FactorModel) -> coefficients.CoefficientImage | None:
        """What was rendered already; a file that is damaged is taken away, to be made again."""
        path = self._path(name, model, "exr")
        try:
            return coefficients.read(path) if path.exists() else None
        except CoefficientImageError as error:
            return _discard(path, error)

    def _kept_row(self, name: str, model: FactorModel) -> Row | None:
        path = self._path(name, model, "json")
        try:
            row = Row(**json.loads(path.read_text(encoding="utf-8")))
            _table([row])
            _markdown(self.blend, [row], "", [])
            return row
        except FileNotFoundError:
            return None
        except (ValueError, TypeError, KeyError) as error:
            return _discard(path, error)

    def row(self, name: str, model: FactorModel, reference: CoefficientImage) -> Row:
        """The figures of a model, from the folder where they are there."""
        kept = self._kept_row(name, model)
        if kept is not None:
            return kept
        image = self.comparable(name, model)
        lights, choices = self.lights(), content.content_of(bpy.context.scene).choices
        worst, worst_light = 0.0, "as it is lit"
        for light in choices:
            all_alike = {group: Light(light) for group in lights}
            found = differences.statistics(_difference(image, reference, all_alike))["p98"]
            if found > worst:
                worst, worst_light = found, light.name
        taken = [self._as_an_artist(name, model, seed) for seed in (1, 2)]
        first, second = (coefficients.to_xyz(image, lights) for image, _ in taken)
        white = recombination.mixed_white(reference.model, Mix(lights))
        truth = coefficients.to_xyz(reference, lights)
        row = Row(
            name=name,
            channels=model.channels,
            passes=model.passes,
            seconds=min(times["seconds"] for _, times in taken),
            sync_seconds=min(times["sync_seconds"] for _, times in taken),
            model=differences.statistics(_difference(image, reference, lights)),
            worst=worst,
            worst_light=worst_light,
            total=differences.statistics(differences.picture_delta_E(first, truth, white)),
            noise=differences.statistics(differences.picture_delta_E(first, second, white))["median"],
            megabytes=max(times["megabytes"] for _, times in taken),
        )
        results.write_text(self._path(name, model, "json"), json.dumps(asdict(row)))
        return row

    def _as_an_artist(self, name: str, model: FactorModel, seed: int) -> tuple[CoefficientImage, dict[str, float]]:
        scene = _open(self.blend, self.options)
        scene.relume.same_seed, scene.relume.split_samples = False, True
        scene.cycles.seed = 1000 * seed
        return self._render(scene, name, model)

    def _render(self, scene, name: str, model: FactorModel) -> tuple[CoefficientImage, dict[str, float]]:
        """(coefficient image, {"seconds", "sync_seconds", "megabytes"}) of a scene set up for `model`."""
        setup.set_up(scene, model)
        progress = console.Progress(model.passes, name)
        began = time.perf_counter()
        try:
            rendered = render.render(scene, self.folder, progress)
        finally:
            progress.done()
        seconds = time.perf_counter() - began
        sync = sum(times["sync_seconds"] for times in rendered.times.values())
        return rendered.image, {"seconds": seconds, "sync_seconds": sync, "megabytes": _megabytes()}

    def _path(self, name: str, model: FactorModel, ending: str) -> Path:
        described = f"{self.key}{name}{json.dumps(model.to_dict())}"
        return self.folder / f"{jobs.file_name(name)}-{hashlib.sha256(described.encode()).hexdigest()[:12]}.{ending}"


def _discard(path: Path, error: Exception) -> None:
    console.say(f"{path}: damaged, and made again ({error})")
    path.unlink()


def _megabytes() -> float:
    """Memory of this process now, where the system says."""
    try:
        with open("/proc/self/statm", encoding="ascii") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20
    except OSError:
        return float("nan")


def _difference(image: CoefficientImage, reference: CoefficientImage, lights: dict[str, Light]) -> np.ndarray:
    white = recombination.mixed_white(reference.model, Mix(lights))
    return differences.picture_delta_E(
        coefficients.to_xyz(image, lights), coefficients.to_xyz(reference, lights), white
    )


def _write(folder: Path, blend: Path, rows: list[Row], chosen: plan.Plan, pictures: dict, lights: dict) -> None:
    """report.json, report.md and the pictures."""
    record = {"scene": str(blend), "reason": chosen.reason, "rows": [asdict(row) for row in rows]}
    shown = {name: pictures[name] for name in ("RGB", "automatic", _REFERENCE) if name in pictures}
    draw = _draw if figures.available() else _save_pictures
    points = [scatter.Point(row.name, row.seconds, row.total["p98"], row.model["p98"]) for row in rows]
    plot = scatter.svg(points, "automatic", _TITLE, "seconds", "ΔE2000 to the reference, 98th percentile")
    with results.together():
        drawn = [_PLOT, *draw(folder, shown, lights)]
        results.write_text(folder / _PLOT, plot)
        results.write_text(folder / "report.json", json.dumps(record, indent=2, ensure_ascii=False) + "\n")
        results.write_text(folder / "report.md", _markdown(blend, rows, chosen.reason, drawn))
    if not console.event("rows", rows=record["rows"]):
        print(_table(rows))
        print(f"\nautomatic: {chosen.reason}")
    for name in ("report.md", "report.json", *drawn):
        console.wrote(folder / name)


def _draw(folder: Path, shown: dict, lights: dict) -> list[str]:
    """The pictures side by side, and their colour differences -> the files' names."""
    drawn = ["side_by_side.png", "delta_e.png"]
    row = [(name, spaces.srgb_encoded(render.picture(image, lights))) for name, image in shown.items()]
    reference = shown[_REFERENCE]
    maps = [(name, _difference(image, reference, lights)) for name, image in shown.items() if image is not reference]
    with results.replacing(folder / drawn[0]) as partial:
        figures.picture_row(partial, row)
    with results.replacing(folder / drawn[1]) as partial:
        figures.delta_e_maps(partial, maps)
    return drawn


def _save_pictures(folder: Path, shown: dict, lights: dict) -> list[str]:
    """What Blender can draw by itself: one picture for each model -> the files' names."""
    for name, image in shown.items():
        render.save_picture(folder / f"{name}.png", render.picture(image, lights), image)
    return [f"{name}.png" for name in shown]


def _table(rows: list[Row]) -> str:
    lines = [
        f"{'':<24}{'passes':>7}{'seconds':>9}{'sync':>7}{'MB':>7}{'model p50':>11}{'p98':>7}{'worst':>7}{'noise':>7}"
    ]
    for row in rows:
        lines.append(
            f"{row.name:<24}{row.passes:>7}{row.seconds:>9.1f}{row.sync_seconds:>7.1f}{row.megabytes:>7.0f}"
            f"{row.model['median']:>11.2f}{row.model['p98']:>7.2f}{row.worst:>7.2f}{row.noise:>7.2f}"
        )
    return "\n".join(["", *lines])


def _markdown(blend: Path, rows: list[Row], reason: str, drawn: list[str]) -> str:
    head = "| | channels | passes | seconds | of it sync | MB | model: median / 98 % / max | worst lamp: 98 % "
    head += "| noise | with noise: median / 98 % |"
    lines = [f"# {blend.name}: error against run time", "", f"Automatic: {reason}.", ""]
    lines += [head, "|" + "---|" * 10]
    for row in rows:
        model, total = row.model, row.total
        lines.append(
            f"| {row.name} | {row.channels} | {row.passes} | {row.seconds:.1f} | {row.sync_seconds:.1f} "
            f"| {row.megabytes:.0f} | {model['median']:.2f} / {model['p98']:.2f} / {model['max']:.2f} "
            f"| {row.worst:.2f} ({row.worst_light}) | {row.noise:.2f} | {total['median']:.2f} / {total['p98']:.2f} |"
        )
    lines += ["", *_EXPLANATION.splitlines(), ""]
    if f"{_REFERENCE}.png" in drawn:
        lines += [*_UNDRAWN.splitlines(), ""]
    for name in drawn:
        lines += [f"![{Path(name).stem.replace('_', ' ')}]({name})", ""]
    return "\n".join(lines)
