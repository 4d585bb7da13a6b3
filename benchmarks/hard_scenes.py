"""Two scenes with more noise than the room: many lamps, and glass over a glossy floor. Built afresh at each call."""

import bpy
import numpy as np

from ..assets import make_room, room

__all__ = ["glossy_and_glass", "many_lights"]

_SEED = 20240612
_LAMPS = 48
_ILLUMINANTS = ("A", "FL2", "LED-B3", "D65")


def many_lights():
    """The room with 48 small lamps of uneven power all over it, in four light groups; returns the scene."""
    scene = make_room.build()
    for lamp in room.ROOM.lamps:
        bpy.data.objects.remove(bpy.data.objects[lamp.name])
    scene.relume.light_groups.clear()
    random = np.random.default_rng(_SEED)
    width, depth, height = room.SIZE
    low, high = (-0.48 * width, 0.1 * depth, 0.1 * height), (0.48 * width, 0.98 * depth, 0.97 * height)
    places = random.uniform(low, high, (_LAMPS, 3))
    for index, (place, watts) in enumerate(zip(places, random.uniform(1.0, 6.0, _LAMPS), strict=True)):
        light = bpy.data.lights.new(f"lamp {index}", "POINT")
        light.energy, light.shadow_soft_size = watts, 0.03
        lamp = bpy.data.objects.new(light.name, light)
        lamp.location, lamp.lightgroup = place, _ILLUMINANTS[index % len(_ILLUMINANTS)]
        scene.collection.objects.link(lamp)
    for name in _ILLUMINANTS:
        row = scene.relume.light_groups.add()
        row["name"] = row["illuminant"] = name
    return scene


def glossy_and_glass():
    """The room with a sphere of rough green glass beside the golden one and a varnished floor; returns the scene."""
    scene = make_room.build()
    _cover("green plastic", "ShaderNodeBsdfGlass", {"Color": (0.7, 0.9, 0.75, 1.0), "Roughness": 0.05})
    varnish = {"Base Color": (0.4, 0.2, 0.1, 1.0), "Roughness": 0.3, "Coat Weight": 1.0}
    _cover("floor", "ShaderNodeBsdfPrincipled", varnish)
    return scene


def _cover(thing: str, shader: str, inputs: dict):
    material = bpy.data.materials.new(shader)
    tree = material.node_tree
    tree.nodes.clear()
    surface, output = tree.nodes.new(shader), tree.nodes.new("ShaderNodeOutputMaterial")
    for name, value in inputs.items():
        surface.inputs[name].default_value = value
    tree.links.new(surface.outputs[0], output.inputs["Surface"])
    bpy.data.objects[thing].data.materials[0] = material
