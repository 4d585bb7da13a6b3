"""Previews of the asset library: sheets, rendered once and relit with daylight on the left and tungsten on the right.

A lamp's preview shows four paints of the same sheet in its own light.
"""

import tempfile
from collections.abc import Sequence
from pathlib import Path

import bpy
import numpy as np

from ..addon.cli.web import shown
from ..addon.graph import nodes, spectra
from ..addon.host import denoising
from ..addon.host.console import Progress
from ..addon.scene import render, setup
from ..core.model import bases
from ..core.picture.mix import Light
from ..core.spectra import library

__all__ = ["SIZE", "render_all"]

SIZE = 128  # pixels of a preview
_COLUMNS = 16
_SAMPLES = 15  # in all passes together
_CLEARER = 12  # times as many for what light goes through
_ADAPTED = 0.6  # how far the eye has adapted to daylight and tungsten; to a lamp of the library not at all
_PAINTS = ("white 9.5", "red", "green", "blue")  # of the ColorChecker, in a lamp's preview
_PICTURED = {
    "Spectral Mix": {"First": "ColorChecker: cyan", "Second": "ColorChecker: orange"},
    "Spectral Ramp": {
        "Start": "ColorChecker: red",
        "Middle": "ColorChecker: yellow",
        "End": "ColorChecker: bluish green",
    },
    "Beer–Lambert Absorption": {"Absorption": "ColorChecker: cyan"},
    "Gel": {"Transmittance": "ColorChecker: magenta"},
}
_NUMBERS = {
    "Beer–Lambert Absorption": {"Thickness": 2.0},
    "Water by Thickness": {"Thickness": 6.0},
    "Thin Film": {"IOR": 2.2},
}
# The input that grows from left to right, and what it has at the right end
_ALONG = {
    "Spectral Mix": ("Factor", 1.0),
    "Spectral Ramp": ("Factor", 1.0),
    "Spectral Transfer Function": ("Value", 1.0),
    "Thin Film": ("Thickness", 900.0),
}


def render_all(things: Sequence, samples: int = _SAMPLES) -> dict:
    """Previews of materials, objects, collections and node groups of the file -> {name: (SIZE, SIZE, 4) top-down}.

    Lamps among them get one in their own light. The file is left with the sheet in it: open another afterwards.
    """
    lamps = [thing for thing in things if getattr(thing, "type", "") == "LIGHT"]
    clear = [thing for thing in things if isinstance(thing, bpy.types.Material) and _is_clear(thing)]
    pictured = [thing for thing in things if thing not in (*lamps, *clear)]
    found = {}
    for sheet, times in ((clear, _CLEARER), (pictured, 1)):
        image = _rendered(sheet, times * samples)
        day, evening = (_in_light(image, name, _ADAPTED) for name in ("D65", "A"))
        left = np.add.outer(np.arange(SIZE), np.arange(SIZE)) < SIZE
        places = {thing.name: _cell(k) for k, thing in enumerate(sheet)}
        found |= {name: np.where(left[..., None], day[cell], evening[cell]) for name, cell in places.items()}
    paints = [next(cell for name, cell in places.items() if name.lower() == f"{p} (colorchecker)") for p in _PAINTS]
    by_illuminant = {}
    for lamp in lamps:
        name = lamp.data["relume_illuminant"]
        if name not in by_illuminant:
            by_illuminant[name] = _quarters(_in_light(image, name), paints)
        found[lamp.name] = by_illuminant[name]
    return found


def _rendered(things: Sequence, samples: int):
    """A sheet as coefficients, denoised; the scene is as empty as before afterwards."""
    scene = _sheet(things, samples)
    setup.set_up(scene, bases.fitted(9))
    guides = denoising.guides_of(scene)
    with tempfile.TemporaryDirectory() as temporary:
        rendered = render.render(scene, Path(temporary), Progress(scene.relume.model().passes), guides)
    image = denoising.denoised_image(rendered.image, rendered.guides, denoising.prefilter_of(scene))
    setup.remove(scene)
    for thing in list(scene.collection.objects):
        bpy.data.objects.remove(thing)
    return image


def _cell(number: int) -> tuple[slice, slice]:
    row, column = divmod(number, _COLUMNS)
    return np.s_[row * SIZE : (row + 1) * SIZE, column * SIZE : (column + 1) * SIZE]


def _quarters(picture, cells) -> np.ndarray:
    """Four cells at half their size, in a square."""
    small = [picture[cell].reshape(SIZE // 2, 2, SIZE // 2, 2, 4).mean(axis=(1, 3)) for cell in cells]
    return np.vstack([np.hstack(small[:2]), np.hstack(small[2:])])


def _in_light(image, illuminant: str, adapted: float = 0.0) -> np.ndarray:
    lights = {group: Light(library.illuminant(illuminant)) for group in image.groups}
    rgb = shown(render.picture(image, lights, adapted), image)
    # Few steps: what the file keeps of a preview is compressed
    return np.concatenate([np.round(rgb * 85) / 85, np.round(image.alpha[..., None] * 15) / 15], axis=2)


def _sheet(things: Sequence, samples: int):
    """A scene with a cell for each thing, seen along y without perspective."""
    scene = bpy.context.scene
    rows = -(-len(things) // _COLUMNS)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=0.46)
    ball = bpy.context.object.data
    ball.shade_smooth()
    heat = ball.attributes.new("kelvin", "FLOAT", "POINT")
    heat.data.foreach_set("value", [1500.0 + 12000.0 * (vertex.co.z + 0.46) for vertex in ball.vertices])
    bpy.data.objects.remove(bpy.context.object)
    ball.materials.append(None)
    for number, thing in enumerate(things):
        row, column = divmod(number, _COLUMNS)
        shown_by = _shown_by(thing, ball)
        shown_by.location = (column + 0.5, 0.0, -row - 0.5)
        shown_by.visible_diffuse = shown_by.visible_shadow = False
        if not (isinstance(thing, bpy.types.Material) and _is_clear(thing)):
            shown_by.visible_glossy = shown_by.visible_transmission = False
        scene.collection.objects.link(shown_by)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.sensor_fit = "ORTHO", "HORIZONTAL"
    camera.data.ortho_scale = _COLUMNS
    camera.location, camera.rotation_euler = (_COLUMNS / 2, -5.0, -rows / 2), (np.pi / 2, 0.0, 0.0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.engine, scene.render.film_transparent = "CYCLES", True
    scene.render.resolution_x, scene.render.resolution_y = SIZE * _COLUMNS, SIZE * rows
    scene.view_settings.view_transform = "Standard"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = samples, False, False
    _world(scene)
    return scene


def _is_clear(material) -> bool:
    return any(nodes.role(node) == "glass" for node in material.node_tree.nodes)


def _shown_by(thing, ball):
    """An object that shows a thing in its cell."""
    if isinstance(thing, bpy.types.Object | bpy.types.Collection):
        source = thing if isinstance(thing, bpy.types.Object) else thing.objects[0]
        one = source.copy()
        size = max(one.dimensions) or 1.0
        corners = np.array([corner[:] for corner in one.bound_box])
        extent = (corners.max(0) - corners.min(0)).max()
        one.scale = (0.9 / (extent or size),) * 3
        one.rotation_euler = (np.pi / 2, 0.0, 0.0) if extent < 0.5 else (0.0, 0.0, 0.0)
        if extent >= 0.5:  # a booth stands on its floor: its middle into the middle of the cell
            one.delta_location = (0.0, 0.0, -0.45)
        return one
    one = bpy.data.objects.new(thing.name, ball)
    one.material_slots[0].link = "OBJECT"
    one.material_slots[0].material = thing if isinstance(thing, bpy.types.Material) else _using(thing)
    return one


def _using(group):
    """A material that shows a node group at work."""
    material = bpy.data.materials.new(f"preview of {group.name}")
    tree, principled = material.node_tree, material.node_tree.nodes["Principled BSDF"]
    principled.inputs["Roughness"].default_value = 0.3
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    for name, reflectance in _PICTURED.get(group.name, {}).items():
        spectra.assign(material, node.inputs[name], spectra.new_reflectance(library.reflectance(reflectance)))
    for name, number in _NUMBERS.get(group.name, {}).items():
        node.inputs[name].default_value = number
    if group.name in _ALONG:
        name, most = _ALONG[group.name]
        place, parts = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeSeparateXYZ")
        along = tree.nodes.new("ShaderNodeMath")
        along.operation, along.inputs[1].default_value = "MULTIPLY", most
        tree.links.new(place.outputs["Generated"], parts.inputs[0])
        tree.links.new(parts.outputs["X"], along.inputs[0])
        tree.links.new(along.outputs[0], node.inputs[name])
    if "Emission" in node.outputs:
        tree.links.new(node.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    else:
        tree.links.new(node.outputs[0], principled.inputs["Base Color"])
    return material


def _world(scene):
    """A grey room with one bright window to the upper left, infinitely far away: the same for every cell."""
    scene.world = bpy.data.worlds.new("studio")
    tree = scene.world.node_tree
    place = tree.nodes.new("ShaderNodeTexCoord")
    towards = tree.nodes.new("ShaderNodeVectorMath")
    towards.operation, towards.inputs[1].default_value = "DOT_PRODUCT", (-0.48, -0.62, 0.62)
    tree.links.new(place.outputs["Generated"], towards.inputs[0])
    window = tree.nodes.new("ShaderNodeMapRange")
    window.interpolation_type = "SMOOTHSTEP"
    for name, number in (("From Min", 0.86), ("From Max", 0.9), ("To Min", 0.0), ("To Max", 5.5)):
        window.inputs[name].default_value = number
    tree.links.new(towards.outputs["Value"], window.inputs["Value"])
    parts = tree.nodes.new("ShaderNodeSeparateXYZ")
    tree.links.new(place.outputs["Generated"], parts.inputs[0])
    sky = tree.nodes.new("ShaderNodeMapRange")
    for name, number in (("From Min", -0.7), ("From Max", 0.9), ("To Min", 0.1), ("To Max", 0.62)):
        sky.inputs[name].default_value = number
    tree.links.new(parts.outputs["Z"], sky.inputs["Value"])
    total = tree.nodes.new("ShaderNodeMath")
    tree.links.new(window.outputs[0], total.inputs[0])
    tree.links.new(sky.outputs[0], total.inputs[1])
    background = tree.nodes["Background"]
    background.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    tree.links.new(total.outputs[0], background.inputs["Strength"])
