"""The room of [WE] section 3, rendered with every model and held against the reference: their Table 1, and ours.

`python -m relume.benchmarks.room_accuracy [--samples N] [--percent P] [--paper] [--out DIR]`

With --paper, all 21 combinations of [WE] Table 1 beside the printed ones, with the error maps as one sheet.

All renders share their random numbers, and Cycles is kept from ending paths or leaving out lamps by a channel's own
brightness, so that what differs is the model. What noise is left comes from the plastic, whose mirror Cycles samples
by the weight that it has in a pass: the last row, a second reference of 48 bands, shows it together with what 36 bands
themselves leave out.
"""

import argparse
import tempfile
from pathlib import Path

import bpy
import numpy as np

from ..addon.host.console import Progress
from ..addon.scene import render, render_settings, setup
from ..assets import make_room
from ..core.colour import differences
from ..core.model import bases
from ..core.picture import coefficients, recombination
from ..core.picture.mix import Light, Mix
from ..core.spectra import library

LIGHTINGS = {
    "A": {"tungsten": "A", "fluorescent": None},
    "FL2": {"tungsten": None, "fluorescent": "FL2"},
    "both": {"tungsten": "A", "fluorescent": "FL2"},
}
_FAMILIES = ("Daylight", "Tungsten", "Equal energy", "Fluorescent", "LED", "Discharge")


def _models():
    """{row: model} in the order of the table; naive models know no illuminant, prefiltered ones know theirs."""
    models = {"naive sRGB": bases.rgb(), "naive Sharp": bases.prefiltered(library.illuminant("E"), "sharp")}
    for name in ("A", "FL2"):
        for space, words in (("srgb", "sRGB"), ("sharp", "Sharp")):
            models[f"prefiltered {words}, {name}"] = bases.prefiltered(library.illuminant(name), space)
    return models | {f"p = {p}": bases.fitted(p) for p in (6, 9, 12)}


def open_room(samples: int, percent: int):
    """The room's scene, set so that renders with different models have the same noise."""
    bpy.ops.wm.open_mainfile(filepath=str(make_room.PATH), load_ui=False)
    scene = bpy.context.scene
    scene.render.resolution_percentage, scene.cycles.samples = percent, samples
    render_settings.compare(scene)
    return scene


def render_room(scene, model, words: str) -> coefficients.CoefficientImage:
    """Set a scene up for a model and render it, telling the terminal in `words`."""
    setup.set_up(scene, model)
    progress = Progress(model.passes, f"{words:<24}")
    try:
        with tempfile.TemporaryDirectory() as folder:
            return render.render(scene, Path(folder), progress).image
    finally:
        progress.done()


def lit_xyz(image: coefficients.CoefficientImage, lighting: dict[str, str | None]) -> np.ndarray:
    """(height, width, 3) XYZ, with an illuminant for each light group; None is a lamp that is off."""
    model = image.model
    matrices = [
        model.relight(library.illuminant(lighting[group])) if lighting[group] else np.zeros((3, model.channels))
        for group in image.groups
    ]
    return coefficients.recombine(list(image.groups.values()), np.array(matrices))


def white_of(model, lighting: dict[str, str | None]) -> np.ndarray:
    lights = {group: Light(library.illuminant(name)) for group, name in lighting.items() if name}
    return recombination.mixed_white(model, Mix(lights))


def _difference(image, truth, lighting, method=differences.delta_E_2000) -> dict[str, float]:
    white = white_of(truth.model, lighting)
    return differences.statistics(
        differences.picture_delta_E(lit_xyz(image, lighting), lit_xyz(truth, lighting), white, method)
    )


def _table_1(images, truth) -> list[str]:
    head = "".join(f" {light}: ΔE94 p50 / p98 | {light}: ΔE2000 p50 / p98 |" for light in LIGHTINGS)
    lines = [f"| model |{head}", "|---" * (1 + 2 * len(LIGHTINGS)) + "|"]
    for name, image in images.items():
        cells = []
        for lighting in LIGHTINGS.values():
            for method in (differences.delta_E_1994, differences.delta_E_2000):
                found = _difference(image, truth, lighting, method)
                cells.append(f" {found['median']:.2f} / {found['p98']:.2f} |")
        lines.append(f"| {name} |{''.join(cells)}")
    return lines


def _table_2(images, truth) -> list[str]:
    """Every CIE illuminant, put on both lamps after the render."""
    families = library.illuminants()
    names = [name for family in _FAMILIES for name in families[family]]
    lines = [
        f"| model | ΔE2000 p50: median and worst of {len(names)} illuminants | p98: median and worst |",
        "|---|---|---|",
    ]
    for model, image in images.items():
        found = {name: _difference(image, truth, dict.fromkeys(image.groups, name)) for name in names}
        cells = []
        for key in ("median", "p98"):
            worst = max(found, key=lambda name: found[name][key])
            middle = np.median([row[key] for row in found.values()])
            cells.append(f" {middle:.2f}, {found[worst][key]:.2f} ({worst}) |")
        lines.append(f"| {model} |{''.join(cells)}")
    return lines


def main(argv: list[str] | None = None):
    parser = argparse.ArgumentParser(prog="python -m relume.benchmarks.room_accuracy", description=__doc__)
    parser.add_argument("--samples", type=int, default=128, help="per pixel, in every pass (128)")
    parser.add_argument("--percent", type=int, default=50, help="of the room's own resolution (50)")
    parser.add_argument("--out", type=Path, default=Path("out/room_accuracy"), metavar="DIR")
    parser.add_argument("--paper", action="store_true", help="Table 1 of [WE] as it is printed, and its error maps")
    arguments = parser.parse_args(argv)

    from .. import register

    register()
    scene = open_room(arguments.samples, arguments.percent)
    if arguments.paper:
        from . import room_paper

        arguments.out.mkdir(parents=True, exist_ok=True)
        room_paper.run(scene, arguments.out)
        return
    truth = render_room(scene, bases.bands(36), "reference, 36 bands")
    images = {name: render_room(scene, model, name) for name, model in _models().items()}
    finer = {"reference, 48 bands": render_room(scene, bases.bands(48), "reference, 48 bands")}
    ours = {name: image for name, image in images.items() if name.startswith("p =")} | finer
    width, height = truth.size
    lines = [f"{width} × {height} pixels, {arguments.samples} samples in every pass.", ""]
    lines += [*_table_1(images | finer, truth), "", *_table_2(ours, truth)]
    arguments.out.mkdir(parents=True, exist_ok=True)
    report = arguments.out / "room_accuracy.md"
    report.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(["", *lines, "", str(report)]))


if __name__ == "__main__":
    main()
