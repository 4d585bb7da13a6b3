"""Spheres of paints on grey ground under the sun and a bright sky: what shows paints side by side."""

from collections.abc import Sequence

import bpy

from ..addon.graph import spectra
from ..core.spectra import library
from ..core.spectra.spectrum import Spectrum

__all__ = ["PAINTS", "build"]

PAINTS = ("ColorChecker: red", "ColorChecker: blue", "ColorChecker: yellow", "ColorChecker: green", "CES 30")
_GROUND = "ColorChecker: neutral 5 (.70 D)"
_SPACING = 2.1


def build(paints: Sequence[Spectrum], varnished: int = 0):
    """A sphere for each paint, one of them varnished, in an emptied file -> scene; light groups sun and sky.

    Materials are called as their paints.
    """
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.use_denoising = "CYCLES", False
    scene.render.resolution_x, scene.render.resolution_y = 480, 240
    for index, paint in enumerate(paints):
        place = (_SPACING * (index - (len(paints) - 1) / 2), 0, 1)
        bpy.ops.mesh.primitive_uv_sphere_add(location=place, segments=64, ring_count=32)
        bpy.ops.object.shade_smooth()
        _paint(paint, index == varnished)
    bpy.ops.mesh.primitive_plane_add(size=40)
    _paint(library.reflectance(_GROUND), False)
    _light(scene)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location, camera.rotation_euler = (0.0, -2.8 * len(paints), 0.6 * len(paints)), (1.43, 0.0, 0.0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    return scene


def _paint(paint: Spectrum, varnished: bool):
    material = bpy.data.materials.new(paint.name)
    principled = material.node_tree.nodes["Principled BSDF"]
    principled.inputs["Specular IOR Level"].default_value = 0.5 if varnished else 0.0
    principled.inputs["Roughness"].default_value = 0.2
    spectra.assign(material, principled.inputs["Base Color"], spectra.new_reflectance(paint))
    bpy.context.object.data.materials.append(material)


def _light(scene):
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.data.angle, sun.rotation_euler = 3.0, 0.02, (0.7, 0.3, 0.0)
    sun.lightgroup = "sun"
    scene.collection.objects.link(sun)
    scene.world = bpy.data.worlds.new("sky")
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.5, 0.7, 1.0, 1.0)
    scene.world.lightgroup = "sky"
    for name in ("sun", "sky"):
        scene.view_layers[0].lightgroups.add(name=name)
