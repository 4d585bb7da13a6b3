"""Makes the two .blend files beside it, with the Relume 0.1.0 of commit d3106ab and Blender 5.0.1. Kept for the record.

    git worktree add /tmp/old/relume d3106ab
    PYTHONPATH=/tmp/old python3.11 tests/data/make_saved_by_0_1_0.py

`saved_by_0_1_0.blend` is a scene that is set up, with two light groups, a snapshot and an animated gain;
`removed_by_0_1_0.blend` is the same after *Remove*.
"""

from pathlib import Path

import bpy

import relume
from relume.addon.graph import glass, spectra
from relume.addon.scene import setup
from relume.core.model import bases
from relume.core.spectra import library

HERE = Path(__file__).parent


def make():
    relume.register()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = 16
    scene.cycles.samples, scene.cycles.use_denoising = 4, False
    scene.frame_start, scene.frame_end = 1, 10
    scene.gravity[2] = -9.0
    scene.keyframe_insert("gravity", frame=1)
    scene.world = bpy.data.worlds.new("dim")
    background = scene.world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (0.1, 0.2, 0.3, 1.0)

    bpy.ops.mesh.primitive_cube_add()
    cube = bpy.context.object
    rgb, measured, prism = (bpy.data.materials.new(name) for name in ("rgb", "measured", "prism"))
    rgb.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.7, 0.2, 0.1, 1.0)
    red = spectra.new_reflectance(library.reflectance("ColorChecker: red"))
    spectra.assign(measured, measured.node_tree.nodes["Principled BSDF"].inputs["Base Color"], red)
    node = prism.node_tree.nodes.new("ShaderNodeBsdfGlass")
    prism.node_tree.links.new(node.outputs[0], prism.node_tree.nodes["Material Output"].inputs["Surface"])
    glass.replace(node, library.glass("BK7"))
    for number, material in enumerate((rgb, measured, prism)):
        cube.data.materials.append(material)
        cube.data.polygons[number].material_index = number

    for name, place, color in (("key", (3, -3, 4), (1.0, 0.8, 0.5)), ("fill", (-3, -3, 2), (1.0, 1.0, 1.0))):
        lamp = bpy.data.lights.new(name, "POINT")
        lamp.energy, lamp.color, lamp.use_nodes = 500.0, color, True
        thing = bpy.data.objects.new(name, lamp)
        thing.location, thing.lightgroup = place, name
        scene.collection.objects.link(thing)
    bpy.ops.object.camera_add(location=(0, -6, 1), rotation=(1.4, 0, 0))
    scene.camera = bpy.context.object

    setup.set_up(scene, bases.fitted(6))
    settings = scene.relume
    settings.light_groups["key"].illuminant = "HP1"
    settings.light_groups["fill"].source, settings.light_groups["fill"].temperature = "PLANCKIAN", 3200
    bpy.ops.relume.take_snapshot()
    settings.light_groups["key"].illuminant = "FL11"
    settings.white_balance = 0.5
    for frame, stops in ((1, 0.0), (10, -3.0)):
        settings.light_groups["fill"].stops = stops
        settings.light_groups["fill"].keyframe_insert("stops", frame=frame)
    scene.frame_set(1)
    save(HERE / "saved_by_0_1_0.blend")
    setup.remove(scene)
    save(HERE / "removed_by_0_1_0.blend")


def save(path: Path):
    for block in list(bpy.data.linestyles) + list(bpy.data.brushes):
        block.user_clear()
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=True)


if __name__ == "__main__":
    make()
