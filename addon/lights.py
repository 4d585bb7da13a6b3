"""Lamps and light groups: which groups a scene has; the colour of a lamp as a gel in front of the illuminant."""

import bpy

from ..core.coefficients import EVERYTHING_ELSE
from . import sockets

__all__ = ["convert", "has_emitters", "light_groups_of", "restore"]

_COLOR = "relume_color"  # the colour, temperature switch and node switch that the lamp had


def light_groups_of(scene) -> list[str]:
    """Names of the light groups that the scene's lamps, shining objects and world belong to, in order of appearance.

    `EVERYTHING_ELSE` comes last if anything that shines belongs to none.
    """
    names, outside = [], False
    shining = [(thing.lightgroup, thing) for thing in scene.objects if _shines(thing)]
    if scene.world and scene.world.node_tree and sockets.emits(scene.world.node_tree):
        shining.append((scene.world.lightgroup, scene.world))
    for name, _ in shining:
        if not name:
            outside = True
        elif name not in names:
            names.append(name)
    return [*names, EVERYTHING_ELSE] if outside else names


def has_emitters(scene) -> bool:
    return bool(light_groups_of(scene))


def _shines(thing) -> bool:
    if thing.type == "LIGHT":
        return True
    materials = {slot.material for slot in thing.material_slots if slot.material and slot.material.node_tree}
    return any(_tree_shines(material.node_tree) for material in materials)


def _tree_shines(tree) -> bool:
    if sockets.emits(tree):
        return True
    return any(node.type == "GROUP" and node.node_tree and _tree_shines(node.node_tree) for node in tree.nodes)


def convert(light) -> tuple[float, float, float]:
    """Take the colour out of a lamp, so that it can stand in its nodes; returns that colour."""
    if _COLOR not in light:
        tint = list(light.color)
        if light.use_temperature:
            tint = [a * b for a, b in zip(tint, light.temperature_color, strict=True)]
        light[_COLOR] = {
            "color": list(light.color),
            "tint": tint,
            "use_temperature": light.use_temperature,
            "use_nodes": light.use_nodes,
        }
    if not light.use_nodes:
        light.use_nodes = True
    light.use_temperature = False
    light.color = (1.0, 1.0, 1.0)
    return tuple(light[_COLOR]["tint"])


def restore(light):
    """Give a lamp back the colour that `convert` took."""
    if _COLOR not in light:
        return
    before = light[_COLOR].to_dict()
    light.color = before["color"]
    light.use_temperature = bool(before["use_temperature"])
    if not before["use_nodes"]:
        light.use_nodes = False
    del light[_COLOR]


def local_lights():
    return [light for light in bpy.data.lights if light.library is None]
