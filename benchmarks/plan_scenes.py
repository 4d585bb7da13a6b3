"""Does the planner keep its word? Generated scenes rendered as planned, one pass cheaper, and in full spectra.

`python -m relume.benchmarks.plan_scenes [--scenes N] [--samples N] [--tolerance T] [--out DIR]`

Scenes differ in materials (measured, RGB, textured, grey, metal), lamps, bounces and in what the light may be switched
to; every fourth is hard: gels and saturated paints of `studies.judges`, LEDs and lines, and in every other of these a
block that absorbs. Scene number n is always the same; `--first` begins with others. Full spectra are 81 channels; in
hard scenes, whose spectra are of 1 nm, five renders of them, 401 in all. All renders of a scene share their random
numbers. Prints for each scene the planned and the measured 98th percentile of CIEDE2000, whether one pass less would
have done, and how the error that the panel would say of its own lights compares with what they show.
"""

import argparse
import json
import tempfile
from pathlib import Path

import bpy
import numpy as np

from ..addon.graph import spectra
from ..addon.scene import content, render, render_settings, setup
from ..core.colour import differences
from ..core.model import bases
from ..core.model.factor_model import FactorModel
from ..core.model.integration import FINE
from ..core.model.rules import Reconstructed
from ..core.picture import coefficients, expectation, pixels, plan, recombination
from ..core.picture.mix import Light, Mix
from ..core.spectra import library
from ..studies import judges

_SIZE = (48, 36)
_LAMPS = ("D65", "D50", "A", "FL2", "FL11", "LED-B1", "LED-B3", "HP1")
_METALS = ("gold", "copper", "silver")
_MATERIALS = ("measured", "rgb", "texture", "grey", "metal")
_HARD = ("film", "saturated", "measured")
_EVERY = 4  # nth scene is hard
_FACTOR, _SMALL = 1.5, 0.1  # an error is foretold within a factor, or both are so small that no factor means anything
_COMBS = 5  # renders of 81 channels that take a wavelength of 1 nm each


def _material(kind: str, random):
    material = bpy.data.materials.new(kind)
    tree = material.node_tree
    surface = tree.nodes["Material Output"].inputs["Surface"]
    # A single closure: Cycles chooses among several by their colours, and noise would not be the same in all renders
    shader = tree.nodes.new("ShaderNodeBsdfMetallic" if kind == "metal" else "ShaderNodeBsdfDiffuse")
    tree.links.new(shader.outputs[0], surface)
    shader.inputs["Roughness"].default_value = random.uniform(0.2, 1.0)
    if kind == "measured":
        samples = library.reflectances(random.choice(["ces", "colorchecker"]))
        spectra.assign(
            material, shader.inputs["Color"], spectra.new_reflectance(samples[random.integers(len(samples))])
        )
    elif kind in _HARD:
        samples = judges.films() if kind == "film" else judges.saturated()
        spectra.assign(
            material, shader.inputs["Color"], spectra.new_reflectance(samples[random.integers(len(samples))])
        )
    elif kind == "rgb":
        shader.inputs["Color"].default_value = (*random.random(3) ** 2.2, 1.0)
    elif kind == "texture":
        texture = tree.nodes.new("ShaderNodeTexVoronoi")
        texture.inputs["Scale"].default_value = random.uniform(2, 12)
        tree.links.new(texture.outputs["Color"], shader.inputs["Color"])
    elif kind == "grey":
        shader.inputs["Color"].default_value = (*[random.uniform(0.05, 0.9)] * 3, 1.0)
    else:
        shader.fresnel_type = "PHYSICAL_CONDUCTOR"
        name = random.choice(_METALS)
        group = spectra.new_conductor(name, *library.conductor(name))
        for socket in ("IOR", "Extinction"):
            spectra.assign(material, shader.inputs[socket], group, socket)
    return material


def _make_narrow(row, random) -> None:
    """Have a coloured LED, a mixture of LEDs or a line shine in a row of the mixer."""
    kind = random.integers(3)
    if kind == 2:
        row["illuminant"] = f"{random.integers(440, 661)} nm"
        return
    lamps = judges.led_mixtures() if kind else judges.coloured_leds()
    lamp = lamps[random.integers(len(lamps))]
    row.source = "FILE"
    row["measured"], row["path"] = json.dumps(lamp.to_dict()), lamp.name


def _add_block(scene, random) -> None:
    """A block of a medium that absorbs, of an optical depth up to 10 and more, before the camera."""
    material = bpy.data.materials.new("medium")
    tree = material.node_tree
    tree.nodes.remove(tree.nodes["Principled BSDF"])
    medium = tree.nodes.new("ShaderNodeVolumeAbsorption")
    tree.links.new(medium.outputs[0], tree.nodes["Material Output"].inputs["Volume"])
    medium.inputs["Density"].default_value = random.uniform(1, 8)
    samples = judges.saturated()
    tinted = spectra.new_reflectance(samples[random.integers(len(samples))])
    spectra.assign(material, medium.inputs["Color"], tinted)
    place = (random.uniform(-1, 1), random.uniform(-1, 0), random.uniform(1.5, 3))
    bpy.ops.mesh.primitive_cube_add(size=1, location=place, rotation=random.uniform(0, 1, 3))
    bpy.context.object.data.materials.append(material)


def build(number: int):
    """Empty the file and build scene `number`; returns it."""
    random = np.random.default_rng(6000 + number)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.world = None
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = _SIZE
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.cycles.max_bounces = int(random.choice([0, 1, 2, 4, 8]))
    scene.cycles.sample_clamp_indirect, scene.cycles.blur_glossy = 0.0, 0.0
    hard = _is_hard(number)
    kinds = random.choice(_HARD if hard else _MATERIALS, size=random.integers(1, 4), replace=False)
    materials = [_material(str(random.choice(kinds)), random) for _ in range(random.integers(1, 9))]
    bpy.ops.mesh.primitive_cube_add(size=6, location=(0, 0, 3))
    bpy.context.object.data.materials.append(materials[0])
    for _ in range(random.integers(2, 8)):
        add = random.choice([bpy.ops.mesh.primitive_uv_sphere_add, bpy.ops.mesh.primitive_monkey_add])
        add(location=(random.uniform(-2, 2), random.uniform(-1, 2.5), random.uniform(0.5, 2.5)))
        bpy.context.object.scale = [random.uniform(0.4, 1.0)] * 3
        bpy.context.object.data.materials.append(materials[random.integers(len(materials))])
    for number_of_lamp in range(random.integers(1, 4)):
        lamp = bpy.data.lights.new("lamp", "AREA")
        lamp.size, lamp.energy = random.uniform(0.5, 2.0), random.uniform(50, 200)
        thing = bpy.data.objects.new("lamp", lamp)
        thing.location = (random.uniform(-2, 2), random.uniform(-2, 2), 5.9)
        thing.lightgroup = f"lamp {number_of_lamp + 1}"
        scene.collection.objects.link(thing)
        row = scene.relume.light_groups.add()
        row["name"], row["illuminant"] = thing.lightgroup, str(random.choice(_LAMPS))
        if hard and random.random() < 0.6:
            _make_narrow(row, random)
    bpy.ops.object.camera_add(location=(0, -2.9, 2.6), rotation=(1.45, 0, 0))
    scene.camera = bpy.context.object
    scene.camera.data.lens = 22
    scene.relume.switching = str(random.choice(["LIT", "COMMON", "ANY"], p=[0.4, 0.4, 0.2]))
    if hard and number // _EVERY % 2:
        _add_block(scene, random)
        scene.camera = bpy.data.objects["Camera"]
    return scene


def _is_hard(number: int) -> bool:
    return number % _EVERY == _EVERY - 1


def _rendered(scene, model, samples: int) -> coefficients.CoefficientImage:
    scene.cycles.samples = samples
    render_settings.compare(scene)
    setup.set_up(scene, model)
    with tempfile.TemporaryDirectory() as folder:
        return render.render(scene, Path(folder)).image


def _full_spectra(scene, samples: int, fine: bool) -> dict[str, np.ndarray]:
    """{light group: (height, width, 81 or 401) light by wavelength}."""
    models = [bases.bands(81)]
    if fine:
        models = [_comb(FINE[first::_COMBS]) for first in range(_COMBS)]
    total: dict[str, np.ndarray] = {}
    for model in models:
        image = _rendered(scene, model, samples)
        for group, found in image.groups.items():
            total[group] = total.get(group, 0.0) + found @ image.model.filters.T
    return total


def _comb(taken: np.ndarray) -> FactorModel:
    """A model whose channels are single wavelengths of FINE."""
    filters = (FINE[:, None] == taken).astype(float)
    between = np.stack([np.interp(FINE, taken, row) for row in np.eye(len(taken))], axis=1)
    return FactorModel("comb", FINE, filters, rule=Reconstructed(between))


def _measured(image, full, lights, choices) -> float:
    """98th percentile of CIEDE2000, under the worst of the lightings that the planner looked at."""
    worst = 0.0
    for lighting in [lights, *({group: Light(light) for group in lights} for light in choices)]:
        true = 0.0
        for group, found in full.items():
            light = lighting[group]
            true += light.gain * found @ pixels.true_weights(light.illuminant, fine=found.shape[-1] == FINE.size)
        white = recombination.mixed_white(image.model, Mix(lighting))
        errors = differences.picture_delta_E(coefficients.to_xyz(image, lighting), true, white)
        worst = max(worst, differences.statistics(errors)["p98"])
    return worst


def _judge(number: int, samples: int, tolerance: float) -> dict:
    scene = build(number)
    contents = content.content_of(scene)
    found = plan.choose(contents, tolerance)
    reference = _full_spectra(scene, samples, _is_hard(number))
    lights = {row.name: row.light() for row in scene.relume.light_groups}
    image = _rendered(scene, found.model, samples)
    measured = _measured(image, reference, lights, contents.choices)
    said = expectation.expected(found.model, contents, Mix(lights))
    shown = _measured(image, reference, lights, ())
    cheaper = [c for c in found.rejected if c.model.passes == found.passes - 1]
    less = min(cheaper, key=lambda candidate: candidate.error) if cheaper else None
    below = _measured(_rendered(scene, less.model, samples), reference, lights, contents.choices) if less else None
    return {
        "scene": number,
        "model": found.chosen.words,
        "passes": found.passes,
        "planned": found.chosen.error,
        "measured": measured,
        "one pass less": below,
        "switching": scene.relume.switching,
        "bounces": scene.cycles.max_bounces,
        "holds": bool(measured <= tolerance),
        "smallest": bool(below is None or below > tolerance),
        "said": said.p98,
        "shown": shown,
        "foretold": bool(max(said.p98, shown) < _SMALL or 1 / _FACTOR <= said.p98 / shown <= _FACTOR),
    }


def main(argv: list[str] | None = None):
    parser = argparse.ArgumentParser(prog="python -m relume.benchmarks.plan_scenes", description=__doc__)
    parser.add_argument("--scenes", type=int, default=40, help="number of scenes (40)")
    parser.add_argument("--first", type=int, default=0, help="number of the first (0)")
    parser.add_argument("--samples", type=int, default=64, help="per pixel, in every pass (64)")
    parser.add_argument("--tolerance", type=float, default=1.0, help="CIEDE2000 at the 98th percentile (1)")
    parser.add_argument("--out", type=Path, default=Path("out/plan_scenes"), metavar="DIR")
    arguments = parser.parse_args(argv)

    from .. import register

    register()
    arguments.out.mkdir(parents=True, exist_ok=True)
    head = f"{'scene':>5}{'passes':>8}{'planned':>9}{'measured':>10}{'one less':>10}{'said':>7}{'shown':>7}"
    print(f"{head}  light may change, bounces: model")
    judged = []
    for number in range(arguments.first, arguments.first + arguments.scenes):
        found = _judge(number, arguments.samples, arguments.tolerance)
        judged.append(found)
        less = "" if found["one pass less"] is None else f"{found['one pass less']:.2f}"
        marks = ("" if found["holds"] else "  FAILS") + ("" if found["smallest"] else "  too many")
        print(
            f"{number:>5}{found['passes']:>8}{found['planned']:>9.2f}{found['measured']:>10.2f}{less:>10}"
            f"{found['said']:>7.2f}{found['shown']:>7.2f}"
            f"  {found['switching']}, {found['bounces']}: {found['model']}{marks}",
            flush=True,
        )
    holds, smallest = (sum(found[key] for found in judged) for key in ("holds", "smallest"))
    print(f"within the tolerance: {holds} of {len(judged)}; fewest passes that are: {smallest} of {len(judged)}")
    foretold = sum(found["foretold"] for found in judged)
    within = f"within a factor of {_FACTOR:g}, or both below ΔE {_SMALL:g}"
    print(f"errors under their own lights foretold {within}: {foretold} of {len(judged)}")
    (arguments.out / "plan_scenes.json").write_text(json.dumps(judged, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
