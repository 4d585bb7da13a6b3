"""Build an interior of `room.py` in Blender; save the room as a .blend: `python -m relume.assets.make_room [PATH]`."""

import math
from pathlib import Path

import bpy
from mathutils import Vector

from ..addon.graph import spectra
from ..core.spectra import library
from . import room
from .saving import save_built

__all__ = ["PATH", "build", "main"]

PATH = Path(__file__).with_name("room.blend")


def build(interior: room.Interior = room.ROOM):
    """Empty the file and build an interior in it; returns the scene."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.name = interior.name
    scene.world = None
    walls = {w.reflectance: _matte(w.reflectance.split(": ")[1], w.reflectance) for w in interior.walls}
    for wall in interior.walls:
        mesh = bpy.data.meshes.new(wall.name)
        mesh.from_pydata(wall.corners, [], [(0, 1, 2, 3)])
        mesh.materials.append(walls[wall.reflectance])
        scene.collection.objects.link(bpy.data.objects.new(wall.name, mesh))
    for sphere in interior.spheres:
        _add_sphere(scene, sphere)
    for lamp in interior.lamps:
        _add_lamp(scene, lamp)
    for group, illuminant in interior.lighting.items():
        row = scene.relume.light_groups.add()
        row["name"], row["illuminant"] = group, illuminant
    _add_camera(scene, interior.camera)
    _choose_settings(scene, interior)
    return scene


def _material(name: str):
    material = bpy.data.materials.new(name)
    material.node_tree.nodes.clear()
    output = material.node_tree.nodes.new("ShaderNodeOutputMaterial")
    output.location = (500, 0)
    return material, material.node_tree, output.inputs["Surface"]


def _reflectance(name: str):
    tree = bpy.data.node_groups.get(name.split(": ")[1])
    return tree or spectra.new_reflectance(library.reflectance(name), name.split(": ")[1])


def _diffuse(material, reflectance: str):
    diffuse = material.node_tree.nodes.new("ShaderNodeBsdfDiffuse")
    spectra.assign(material, diffuse.inputs["Color"], _reflectance(reflectance))
    return diffuse


def _matte(name: str, reflectance: str):
    material, tree, surface = _material(name)
    tree.links.new(_diffuse(material, reflectance).outputs[0], surface)
    return material


def _plastic(sphere: room.Sphere):
    """Diffuse under a clear mirror that takes `specular` of the light, whatever the angle."""
    material, tree, surface = _material(sphere.name)
    mirror = tree.nodes.new("ShaderNodeBsdfAnisotropic")
    mirror.location = (0, -200)
    mirror.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    mirror.inputs["Roughness"].default_value = 0.0
    mix = tree.nodes.new("ShaderNodeMixShader")
    mix.location = (250, 0)
    mix.inputs[0].default_value = sphere.specular
    tree.links.new(_diffuse(material, sphere.spectrum).outputs[0], mix.inputs[1])
    tree.links.new(mirror.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], surface)
    return material


def _metal(sphere: room.Sphere):
    material, tree, surface = _material(sphere.name)
    metal = tree.nodes.new("ShaderNodeBsdfMetallic")
    metal.fresnel_type = "PHYSICAL_CONDUCTOR"
    metal.inputs["Roughness"].default_value = 0.0
    group = spectra.new_conductor(sphere.spectrum, *library.conductor(sphere.spectrum))
    for socket in ("IOR", "Extinction"):
        spectra.assign(material, metal.inputs[socket], group, socket)
    tree.links.new(metal.outputs[0], surface)
    return material


def _glass(sphere: room.Sphere):
    material, tree, surface = _material(sphere.name)
    glass = tree.nodes.new("ShaderNodeBsdfGlass")
    glass.distribution = "GGX"
    glass.inputs["Roughness"].default_value, glass.inputs["IOR"].default_value = sphere.roughness, sphere.index
    spectra.assign(material, glass.inputs["Color"], _reflectance(sphere.spectrum))
    tree.links.new(glass.outputs[0], surface)
    return material


_MATERIALS = {"plastic": _plastic, "conductor": _metal, "glass": _glass}


def _add_sphere(scene, sphere: room.Sphere):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=128, ring_count=64, radius=sphere.radius, location=sphere.centre)
    thing = bpy.context.object
    thing.name = thing.data.name = sphere.name
    thing.data.shade_smooth()
    thing.data.materials.append(_MATERIALS[sphere.material](sphere))


def _add_lamp(scene, lamp: room.Lamp):
    light = bpy.data.lights.new(lamp.name, "AREA")
    light.size, light.energy = lamp.side, lamp.watts
    thing = bpy.data.objects.new(lamp.name, light)
    thing.location, thing.visible_camera = lamp.centre, True
    thing.lightgroup = lamp.light_group
    thing.rotation_euler = Vector(lamp.facing).to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(thing)


def _add_camera(scene, described: room.Camera):
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.angle = "HORIZONTAL", math.radians(described.horizontal_degrees)
    data.clip_start = 0.01
    camera = bpy.data.objects.new("camera", data)
    camera.location = described.position
    aim = Vector(described.target) - camera.location
    camera.rotation_euler = aim.to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(camera)
    scene.camera = camera


def _choose_settings(scene, interior: room.Interior):
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = interior.camera.resolution
    scene.view_settings.view_transform = "Standard"
    cycles = scene.cycles
    cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = 192, False, False
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = interior.max_bounces
    # Clamping and blurred caustics are not linear: they would act on every pass by itself
    cycles.sample_clamp_indirect = cycles.sample_clamp_direct = 0.0
    cycles.blur_glossy = 0.0


def main(arguments=None):
    save_built(build, PATH, arguments)


if __name__ == "__main__":
    main()
