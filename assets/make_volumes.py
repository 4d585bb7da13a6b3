"""Build the volumes of the gallery, after [DF] Fig. 7 and [BMD] Figs. 6 and 7, as .blend files.

`python -m relume.assets.make_volumes [FOLDER]`

[DF] M. S. Drew, G. D. Finlayson, "Multispectral processing without spectra", JOSA A 20 (2003).
[BMD] S. Bergner, T. Moller, M. S. Drew, "A spectral engine for visualization", SFU-CMPT-TR2004-06, section 5.1.

The papers' own data, a frog and an engine, are not here: two fields are made of ellipsoids, boxes and noise, the third
is measured (`volumes/brain.vdb`, made by `make_vdb`). Ranges of their values have spectra of a palette that is designed
(`volumes/*.toml`).
"""

import math
import shutil
import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import bpy
from mathutils import Vector

from ..addon.graph import spectra, transfer
from ..core import palette
from ..core.spectra.arrays import Array
from ..core.spectra.spectrum import WAVELENGTHS, Spectrum
from . import make_vdb

__all__ = ["SCENES", "Organ", "Volume", "build", "lightings", "main", "reflectances"]

PALETTES = Path(__file__).with_name("volumes")


@dataclass(frozen=True)
class Organ:
    """A part of a volume: its reflectance, the range of values that tells it from the others, its density in 1/m.

    shapes: where a field that is made has its middle value: (centre, radii, "ball" or "box"); parts of higher value
    take the place of lower ones. noise: how much of the shape noise leaves, 1 is all.
    """

    reflectance: str
    values: tuple[float, float]
    density: float
    shapes: tuple[tuple[tuple[float, float, float], tuple[float, float, float], str], ...] = ()
    noise: float = 1.0


@dataclass(frozen=True)
class Volume:
    """A scene: its palette's file, its parts by rising value, and four lightings as {light of the palette: share}.

    grid: an OpenVDB file in place of shapes.
    """

    palette: str
    organs: tuple[Organ, ...]
    lightings: dict[str, dict[str, float]]
    grid: str = ""


def _row(count: int, first, step, radii, shape: str):
    return tuple((tuple(a + i * b for a, b in zip(first, step, strict=True)), radii, shape) for i in range(count))


SCENES = {
    "anatomy": Volume(
        "anatomy",
        (
            Organ(
                "body",
                (0.1, 0.3),
                0.9,
                (((0, 0, 0), (1.3, 0.7, 0.75), "ball"), ((1.25, 0, 0.1), (0.55, 0.5, 0.45), "ball")),
            ),
            Organ("liver", (0.3, 0.5), 5.0, (((0.5, -0.1, 0.05), (0.35, 0.35, 0.4), "ball"),)),
            Organ(
                "stomach",
                (0.5, 0.7),
                7.0,
                (
                    ((-0.15, -0.15, 0.0), (0.38, 0.26, 0.24), "ball"),
                    ((-0.45, -0.15, -0.22), (0.24, 0.2, 0.2), "ball"),
                ),
            ),
            Organ("bone", (0.7, 0.9), 9.0, _row(11, (-1.1, 0.25, 0.35), (0.22, 0, 0.015), (0.075, 0.1, 0.1), "ball")),
        ),
        {
            "daylight": {"D65": 1.0},
            "tungsten": {"A": 1.0},
            "stomach light": {"stomach light": 1.0},
            "half daylight, half stomach light": {"D65": 0.5, "stomach light": 0.5},
        },
    ),
    "machine": Volume(
        "machine",
        (
            Organ("smoke", (0.1, 0.3), 1.6, (((0, 0, 1.05), (1.2, 0.8, 0.55), "ball"),), 0.55),
            Organ("hull", (0.3, 0.5), 2.2, (((0, 0, 0), (1.2, 0.75, 0.7), "box"),)),
            # What is inside the hull is empty, but for the parts
            Organ("", (0.5, 0.7), 0.0, (((0, 0, 0), (1.1, 0.65, 0.6), "box"),)),
            Organ(
                "parts",
                (0.7, 0.9),
                12.0,
                (
                    *_row(4, (-0.75, -0.1, 0.15), (0.5, 0, 0), (0.17, 0.3, 0.34), "box"),
                    ((0, 0, -0.35), (1.0, 0.13, 0.13), "ball"),
                ),
            ),
        ),
        {
            "daylight": {"D65": 1.0},
            "parts": {"parts": 1.0},
            "complement": {"complement": 1.0},
            "red smoke": {"red smoke": 1.0},
        },
    ),
    "brain": Volume(
        "brain",
        (
            Organ("fluid", (0.12, 0.5), 0.4),
            Organ("grey matter", (0.5, 0.8), 1.3),
            Organ("white matter", (0.8, 1.1), 5.0),
        ),
        {
            "daylight": {"D65": 1.0},
            "tungsten": {"A": 1.0},
            "white matter light": {"white matter light": 1.0},
            "half daylight, half white matter light": {"D65": 0.5, "white matter light": 0.5},
        },
        "brain.vdb",
    ),
}


@cache
def _solved(name: str) -> palette.Palette:
    return palette.create(palette.read(PALETTES / f"{name}.toml")).palette


def lightings(name: str) -> dict[str, tuple[Spectrum, float]]:
    """What a volume is lit by, four times over -> {lighting: (illuminant, gain)}, as `relume relight` takes them.

    The gain is the luminance that the design has: designed lights may be far brighter than daylight.
    """
    solved = _solved(SCENES[name].palette)
    power = {entry.name: row for entry, row in zip(solved.lights, solved.sampled("light"), strict=True)}
    found = {}
    for title, shares in SCENES[name].lightings.items():
        values = sum(share * power[light] for light, share in shares.items())
        illuminant = Spectrum(WAVELENGTHS, values, title, "illuminant", "designed")
        found[title] = illuminant, float(values @ palette.colours.xyz_weights()[1])
    return found


def reflectances(name: str) -> Array:
    """The designed reflectances of a volume -> (m, 81)."""
    return _solved(SCENES[name].palette).sampled("reflectance")


def build(name: str):
    """Empty the file and build a volume of SCENES in it; returns the scene."""
    volume = SCENES[name]
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.name, scene.world = name.capitalize(), None
    material = bpy.data.materials.new(name)
    material.node_tree.nodes.clear()
    field = _measured(scene, volume, material) if volume.grid else _made(material, volume.organs)
    made = {entry.name: entry.spectrum for entry in _solved(volume.palette).reflectances}
    function = transfer.new(f"Transfer Function of the {name}")
    for organ in volume.organs:
        if organ.reflectance:
            group = spectra.new_reflectance(made[organ.reflectance], organ.reflectance)
            transfer.add_range(function, *organ.values, group, organ.density)
    transfer.attach(material, function, field)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.angle = math.radians(30.0)
    camera.location = (-1.4, -7.0, 2.2)
    camera.rotation_euler = (Vector((0.1, 0, 0.15)) - camera.location).to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = 240, 180
    scene.view_settings.view_transform = "Standard"
    scene.cycles.samples, scene.cycles.use_denoising = 64, False
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.volume_step_rate, scene.cycles.volume_max_steps = 0.2, 1024
    if hasattr(scene.cycles, "volume_biased"):
        scene.cycles.volume_biased = True  # fields without scattering: a ray marched through has hardly any noise
    bpy.context.view_layer.update()
    return scene


def _measured(scene, volume: Volume, material):
    """A volume object of a grid -> the socket with its values."""
    data = bpy.data.volumes.new(volume.palette)
    data.filepath = str(PALETTES / volume.grid)
    data.materials.append(material)
    thing = bpy.data.objects.new(volume.palette, data)
    thing.rotation_euler, thing.scale = (0.0, 0.0, math.radians(-60.0)), (1.3, 1.3, 1.3)
    thing.location = (0.0, 0.0, 0.15)
    scene.collection.objects.link(thing)
    field = material.node_tree.nodes.new("ShaderNodeAttribute")
    field.attribute_name = make_vdb.GRID
    return field.outputs["Fac"]


def _made(material, organs: tuple[Organ, ...]):
    """A block in which nodes make the value of whatever is at a point -> socket."""
    bpy.ops.mesh.primitive_cube_add(size=2)
    thing, tree = bpy.context.object, material.node_tree
    thing.name, thing.scale = material.name, (2.0, 1.2, 1.7)
    thing.data.materials.append(material)
    place = tree.nodes.new("ShaderNodeTexCoord")
    place.location = (-1600, 0)
    value = None
    parts = [(organ, shape) for organ in organs for shape in organ.shapes]
    for column, (organ, shape) in enumerate(parts):
        at = -200 * column
        inside = _inside(tree, place.outputs["Object"], *shape, at)
        if organ.noise < 1:
            noise = _node(tree, "ShaderNodeTexNoise", -1000, at - 90)
            noise.inputs["Scale"].default_value = 2.5
            tree.links.new(place.outputs["Object"], noise.inputs["Vector"])
            thick = _math(tree, "GREATER_THAN", noise.outputs[0], 1 - organ.noise, -800, at - 90)
            inside = _math(tree, "MULTIPLY", inside, thick, -600, at)
        worth = _math(tree, "MULTIPLY", inside, sum(organ.values) / 2, -400, at)
        value = worth if value is None else _math(tree, "MAXIMUM", value, worth, -200, at)
    return value


def _inside(tree, point, centre, radii, shape: str, at: float):
    """1 inside an ellipsoid or a box of half-lengths `radii` in the object's own space, 0 outside -> socket."""
    scale = (2.0, 1.2, 1.7)  # of the object: shapes are given in metres
    moved = _node(tree, "ShaderNodeVectorMath", -1400, at, operation="SUBTRACT")
    moved.inputs[1].default_value = [c / s for c, s in zip(centre, scale, strict=True)]
    tree.links.new(point, moved.inputs[0])
    scaled = _node(tree, "ShaderNodeVectorMath", -1200, at, operation="DIVIDE")
    scaled.inputs[1].default_value = [r / s for r, s in zip(radii, scale, strict=True)]
    tree.links.new(moved.outputs[0], scaled.inputs[0])
    if shape == "ball":
        length = _node(tree, "ShaderNodeVectorMath", -1000, at, operation="LENGTH")
        tree.links.new(scaled.outputs[0], length.inputs[0])
        return _math(tree, "LESS_THAN", length.outputs["Value"], 1.0, -800, at)
    size = _node(tree, "ShaderNodeVectorMath", -1000, at, operation="ABSOLUTE")
    tree.links.new(scaled.outputs[0], size.inputs[0])
    parts = _node(tree, "ShaderNodeSeparateXYZ", -900, at)
    tree.links.new(size.outputs[0], parts.inputs[0])
    wider = _math(tree, "MAXIMUM", parts.outputs[0], parts.outputs[1], -850, at)
    return _math(tree, "LESS_THAN", _math(tree, "MAXIMUM", wider, parts.outputs[2], -800, at), 1.0, -700, at)


def _node(tree, kind: str, x: float, y: float, **settings):
    node = tree.nodes.new(kind)
    node.location = (x, y)
    for name, value in settings.items():
        setattr(node, name, value)
    return node


def _math(tree, operation: str, first, second, x: float, y: float):
    """A Math node of a socket and a socket or number -> its output."""
    node = _node(tree, "ShaderNodeMath", x, y, operation=operation)
    tree.links.new(first, node.inputs[0])
    if isinstance(second, float):
        node.inputs[1].default_value = second
    else:
        tree.links.new(second, node.inputs[1])
    return node.outputs[0]


def main(arguments=None):
    from .. import register

    if not hasattr(bpy.types.Scene, "relume"):
        register()
    folder = Path((arguments or sys.argv[1:] or [PALETTES.parent])[0])
    folder.mkdir(parents=True, exist_ok=True)
    for name in SCENES:
        build(name)
        path = folder / f"{name}.blend"
        for grid in bpy.data.volumes:
            shutil.copy(grid.filepath, folder)
            grid.filepath = f"//{Path(grid.filepath).name}"  # so that both can be taken elsewhere together
        bpy.ops.wm.save_as_mainfile(filepath=str(path.resolve()), compress=True)
        print(path)


if __name__ == "__main__":
    main()
