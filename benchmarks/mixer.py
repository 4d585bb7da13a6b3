"""What a click in the mixer takes: from the changed property to the numbers in the sockets, compositor and preview.

    python -m relume.benchmarks.mixer [--materials 10 2000] [--groups 8] [--channels 12] [--composited 1080x1 ...]

A scene of spheres with a material each and lamps in groups of their own; every click gives one group an illuminant
that it has not had, so that its relight matrix is fitted. What the error dots take comes after it, in processor time;
the advice for a mix is worked out in pieces, of 3 and of 6 channels. Blender's own compositing is timed apart, on
coefficients that it reads from a file, without a render: as it is after a render in a window; and with what every
render does once: noise of colour taken out, or each light group of each pass denoised. Between the two, the picture
denoised at each change of light.
"""

import argparse
import time

import bpy
import numpy as np

import relume

from ..addon.graph import noise_nodes
from ..addon.scene import content, exr, render, setup
from ..addon.ui import expected
from ..core.model import bases
from ..core.picture import coefficients, expectation, noise, recombination
from ..core.picture.mix import Light
from ..core.spectra import library

__all__ = ["main"]


def _scene(materials: int, groups: int):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    mesh = bpy.data.meshes.new("point")
    for i in range(materials):
        thing = bpy.data.objects.new(f"thing {i}", mesh.copy())
        material = bpy.data.materials.new(f"material {i}")
        principled = material.node_tree.nodes["Principled BSDF"]
        principled.inputs["Base Color"].default_value = (i / materials, 0.5, 1.0 - i / materials, 1.0)
        thing.data.materials.append(material)
        scene.collection.objects.link(thing)
    for g in range(groups):
        lamp = bpy.data.objects.new(f"lamp {g}", bpy.data.lights.new(f"lamp {g}", "POINT"))
        lamp.lightgroup = f"group {g}"
        scene.collection.objects.link(lamp)
    scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(scene.camera)
    return scene


def _clicks(scene, names: list[str]) -> np.ndarray:
    """Seconds of each change of an illuminant."""
    seconds = []
    rows = scene.relume.light_groups
    for number, name in enumerate(names):
        start = time.perf_counter()
        rows[number % len(rows)].illuminant = name
        seconds.append(time.perf_counter() - start)
        bpy.context.view_layer.update()
    return np.array(seconds)


def _dots(scene, names: list[str]) -> tuple[np.ndarray, np.ndarray]:
    """Seconds of processor time that the dots take for each change, and each piece of the advice for the mix."""
    rows, changes, pieces = scene.relume.light_groups, [], []
    expected.work_out(scene)
    for number, name in enumerate(names):
        rows[number % len(rows)].illuminant = name
        start = time.process_time()
        expected.work_out(scene)
        changes.append(time.process_time() - start)
    shows = content.content_of(scene)
    for channels in (3, 6):
        steps = expectation.advising(bases.fitted(channels), shows, setup.lighting(scene))
        done = False
        while not done:
            start = time.process_time()
            done = next(steps, steps) is steps
            pieces.append(time.process_time() - start)
    return np.array(changes), np.array(pieces)


def _compositing(folder, height: int, groups: int, channels: int) -> dict[str, float]:
    """Seconds in which Blender composites a 16:9 frame of coefficients from a file, by way of denoising."""
    model = bases.fitted(channels)
    names = [f"group {g}" for g in range(groups)]
    size = (height, height * 16 // 9)
    pixels = np.random.default_rng(1).random((*size, channels), dtype=np.float32)
    image = coefficients.CoefficientImage(
        model=model,
        groups=dict.fromkeys(names, pixels),
        illuminants=dict.fromkeys(names, library.illuminant("D65")),
        alpha=np.ones(size, np.float32),
    )
    path = folder / f"{height} {groups}.exr"
    coefficients.write(path, image, render.picture(image, dict.fromkeys(names, Light(library.illuminant("D65")))))
    scene = exr.new_scene(path)
    scene.render.compositor_device = "CPU"
    tree = scene.compositing_node_group
    (output,) = (node for node in tree.nodes if node.type == "GROUP_OUTPUT")
    (recombination_node,) = (node for node in tree.nodes if node.type == "GROUP")
    guides = {name: _flat(tree, name, size) for name in ("Albedo", "Normal")}
    seconds = {"read": _switches(scene, "A", "FL2", "FL11")}
    estimating = noise_nodes.estimating_group("estimating", names, channels)
    denoising = noise_nodes.denoising_group(
        "denoising", names, model.passes, noise.to_picture(model), list(guides), "Accurate"
    )
    for way, group in (("estimated", estimating), ("denoised", denoising)):
        node = _before(tree, recombination_node, group, guides)
        seconds[way] = _switches(scene, "A")
        _take_out(tree, node)
    _denoise_before(tree, output.inputs[0], guides)
    seconds["picture denoised"] = _switches(scene, "A")
    bpy.data.scenes.remove(scene)
    return seconds


def _switches(scene, *illuminants: str) -> float:
    """The fewest seconds that a change to one of them takes."""
    times = []
    for name in illuminants:
        scene.relume.light_groups[0].source = "LIBRARY"
        scene.relume.light_groups[0].illuminant = name
        start = time.perf_counter()
        bpy.ops.render.render(scene=scene.name)
        times.append(time.perf_counter() - start)
    return min(times)


def _flat(tree, name: str, size: tuple[int, int]):
    """The output of a node that shows an even image, of 1 in blue: a normal, and an albedo."""
    source = tree.nodes.new("CompositorNodeImage")
    source.image = bpy.data.images.new(name, *reversed(size), float_buffer=True)
    source.image.colorspace_settings.name = "Non-Color"
    source.image.generated_color = (0.0, 0.0, 1.0, 1.0)
    return source.outputs["Image"]


def _before(tree, recombination_node, group, guides: dict):
    node = tree.nodes.new("CompositorNodeGroup")
    node.node_tree = group
    for socket in node.inputs:
        held = recombination_node.inputs.get(socket.name)
        tree.links.new(held.links[0].from_socket if held else guides[socket.name.split()[1]], socket)
    for socket in node.outputs:
        tree.links.new(socket, recombination_node.inputs[socket.name])
    return node


def _take_out(tree, node) -> None:
    for socket in node.outputs:
        for link in list(socket.links):
            tree.links.new(node.inputs[socket.name].links[0].from_socket, link.to_socket)
    tree.nodes.remove(node)


def _denoise_before(tree, socket, guides: dict) -> None:
    node = tree.nodes.new("CompositorNodeDenoise")
    tree.links.new(socket.links[0].from_socket, node.inputs["Image"])
    for name, source in guides.items():
        tree.links.new(source, node.inputs[name])
    tree.links.new(node.outputs["Image"], socket)


def main():
    import tempfile
    from pathlib import Path

    parser = argparse.ArgumentParser(prog="python -m relume.benchmarks.mixer", description=__doc__.splitlines()[0])
    parser.add_argument("--materials", type=int, nargs="+", default=[10, 2000])
    parser.add_argument("--groups", type=int, default=8)
    parser.add_argument("--channels", type=int, default=12)
    frames = ["1080x1", "1080x4", "1080x12", "2160x1", "2160x4"]
    parser.add_argument("--composited", nargs="*", default=frames, metavar="HEIGHTxGROUPS", help="(%(default)s)")
    arguments = parser.parse_args()
    relume.register()
    families = library.illuminants()
    names = [name for family in ("Fluorescent", "LED", "Discharge") for name in families[family]][:40]
    print(f"{arguments.groups} light groups, p = {arguments.channels}, {len(names)} clicks")
    dots = "dots, median ms | 95th percentile ms | longest piece of advice ms"
    print(f"| materials | median ms | 95th percentile ms | a known illuminant, median ms | {dots} |")
    print("|---|---|---|---|---|---|---|")
    for materials in arguments.materials:
        scene = _scene(materials, arguments.groups)
        setup.set_up(scene, bases.fitted(arguments.channels))
        recombination.relight_matrix.cache_clear()
        setup.relight(scene)
        new, known = _clicks(scene, names), _clicks(scene, names[1:] + names[:1])
        changes, pieces = _dots(scene, [name for name in families["Fluorescent"] if name not in names[-8:]])
        print(
            f"| {materials} | {1000 * np.median(new):.1f} | {1000 * np.percentile(new, 95):.1f} | "
            f"{1000 * np.median(known):.1f} | {1000 * np.median(changes):.1f} | "
            f"{1000 * np.percentile(changes, 95):.1f} | {1000 * pieces.max():.1f} |",
            flush=True,
        )
    print("\nCompositing, seconds on this machine's CPU, p = 9")
    print(
        "| height | light groups | read | colour noise taken out, over that | picture denoised | each pass denoised |"
    )
    print("|---|---|---|---|---|---|")
    for frame in arguments.composited:
        height, groups = map(int, frame.split("x"))
        with tempfile.TemporaryDirectory() as folder:
            seconds = _compositing(Path(folder), height, groups, 9)
        ratios = [seconds[way] / seconds["read"] for way in ("estimated", "picture denoised", "denoised")]
        shown = " | ".join(f"{ratio:.1f}" for ratio in ratios)
        print(f"| {height} | {groups} | {seconds['read']:.2f} | {shown} |", flush=True)


if __name__ == "__main__":
    main()
