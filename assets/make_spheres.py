"""Build the spheres of [DF] Fig. 5 and save them as a .blend: `python -m relume.assets.make_spheres [PATH]`.

[DF] M. S. Drew, G. D. Finlayson, "Multispectral processing without spectra", JOSA A 20 (2003), section 3.E.2.

Three pairs of spheres that touch, each pair one colour in daylight and two under tungsten, over a plane of ColorChecker
patch 2. The pairs are designed (`palettes/metamer_pairs.toml`): those of the paper are not printed.
"""

import math
from pathlib import Path

import bpy
from mathutils import Vector

from ..addon.graph import spectra
from ..core.spectra import library
from ..core.spectra.spectrum import WAVELENGTHS, Spectrum
from ..studies import multispectral
from .saving import save_built

__all__ = ["BOUNCES", "NAMES", "PATH", "build", "main"]

PATH = Path(__file__).with_name("spheres.blend")
NAMES = ("grey", "green", "violet")
BOUNCES = 30  # scattering events of a ray, as in the paper
_RADIUS = 0.5
_SPACING = 2.3  # from pair to pair
_PLANE = "ColorChecker: light skin"


def build():
    """Empty the file and build the spheres in it; returns the scene."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.name = "Spheres"
    scene.world = None
    for index, (name, pair) in enumerate(zip(NAMES, multispectral.metamer_pairs(), strict=True)):
        for side, values in zip((-1, 1), pair, strict=True):
            title = name if side < 0 else f"{name}'s metamer"
            x = _SPACING * (index - 1) + side * _RADIUS
            bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=_RADIUS, location=(x, 0, _RADIUS))
            bpy.context.object.data.shade_smooth()
            _paint(bpy.context.object, title, Spectrum(WAVELENGTHS, values, title, source="designed"))
    bpy.ops.mesh.primitive_plane_add(size=40)
    _paint(bpy.context.object, "light skin", library.reflectance(_PLANE))
    _add_lamp(scene)
    _add_camera(scene)
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = 480, 216
    scene.view_settings.view_transform = "Standard"
    cycles = scene.cycles
    cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = 192, False, False
    cycles.max_bounces = cycles.diffuse_bounces = BOUNCES
    cycles.sample_clamp_indirect = cycles.sample_clamp_direct = 0.0  # clamping is not linear
    return scene


def _paint(thing, name: str, reflectance: Spectrum):
    """Give an object a matte material of a spectrum."""
    thing.name = thing.data.name = name
    material = bpy.data.materials.new(name)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    output, diffuse = nodes.new("ShaderNodeOutputMaterial"), nodes.new("ShaderNodeBsdfDiffuse")
    output.location = (300, 0)
    spectra.assign(material, diffuse.inputs["Color"], spectra.new_reflectance(reflectance, name))
    links.new(diffuse.outputs[0], output.inputs["Surface"])
    thing.data.materials.append(material)


def _add_lamp(scene):
    light = bpy.data.lights.new("lamp", "AREA")
    light.size, light.energy = 3.0, 700.0
    thing = bpy.data.objects.new("lamp", light)
    thing.location = (-2.5, -3.5, 5.0)
    thing.rotation_euler = (-thing.location + Vector((0, 0, 0.5))).to_track_quat("-Z", "Y").to_euler()
    thing.lightgroup = "lamp"
    scene.collection.objects.link(thing)
    row = scene.relume.light_groups.add()
    row["name"], row["illuminant"] = "lamp", "D65"


def _add_camera(scene):
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.angle = "HORIZONTAL", math.radians(42.0)
    camera = bpy.data.objects.new("camera", data)
    camera.location = (0.0, -8.6, 4.2)
    camera.rotation_euler = (Vector((0, 0, 0.42)) - camera.location).to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(camera)
    scene.camera = camera


def main(arguments=None):
    save_built(build, PATH, arguments)


if __name__ == "__main__":
    main()
