"""What stands on the table of the still life, and the room around it."""

import math
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

from ..addon.graph import spectra
from ..core import palette
from . import shapes, surfaces

__all__ = ["bowl_of_fruit", "candlestick", "glasses", "landscape", "lemons", "napkin", "room"]


def _box(scene, name, low, high, material):
    corners = [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return shapes.mesh_object(scene, name, corners, faces, material)


def room(scene):
    wood, tree, principled = surfaces.new("walnut")
    principled.inputs["Roughness"].default_value = 0.32
    grain = surfaces.noise(tree, 5.0, (0.36, 0.66), stretch=(1.0, 14.0, 6.0), detail=9.0)
    surfaces.mixed(wood, principled.inputs["Base Color"], grain, "CES 03", "CES 18")
    surfaces.bump(wood, grain, 0.0004)
    table = _box(scene, "table", (-0.85, -0.3, -0.035), (0.85, 0.42, 0.0), wood)
    bevel = table.modifiers.new("Bevel", "BEVEL")
    bevel.width, bevel.segments = 0.006, 3
    wall = surfaces.painted("plaster", "CES 69", "CES 63", roughness=0.9, scale=2.2, contrast=(0.25, 0.8))
    corners = [(-3, 0.75, -1.2), (3, 0.75, -1.2), (3, 0.75, 2.2), (-3, 0.75, 2.2)]
    shapes.mesh_object(scene, "wall", corners, [(0, 1, 2, 3)], wall)


def landscape(scene):
    """A landscape of three metamers in a frame: sky, sun and hills."""
    designed = palette.create(palette.read(Path(__file__).with_name("palettes") / "three_metamers.toml"))
    inks = []
    for entry in designed.palette.reflectances:
        material, _, principled = surfaces.new(f"ink, {entry.spectrum.name}")
        principled.inputs["Roughness"].default_value = 0.8
        tree = spectra.new_reflectance(entry.spectrum, f"ink, {entry.spectrum.name}")
        spectra.assign(material, principled.inputs["Base Color"], tree)
        inks.append(material)
    left, right, low, high, y = -0.1, 0.21, 0.135, 0.31, 0.742
    paper = [(left, y, low), (right, y, low), (right, y, high), (left, y, high)]
    shapes.mesh_object(scene, "print: sky", paper, [(0, 1, 2, 3)], inks[0])
    angles = np.linspace(0, 2 * np.pi, 96, endpoint=False)
    sun = [(0.1 + 0.05 * math.cos(a), y - 0.0006, 0.245 + 0.05 * math.sin(a)) for a in angles]
    shapes.mesh_object(scene, "print: sun", sun, [range(96)], inks[1])
    x = np.linspace(left, right, 80)
    ridge = low + 0.055 + 0.022 * np.sin(17 * x + 2.2) + 0.01 * np.sin(37 * x)
    hills = [
        *((u, y - 0.0012, v) for u, v in zip(x, ridge, strict=True)),
        (right, y - 0.0012, low),
        (left, y - 0.0012, low),
    ]
    shapes.mesh_object(scene, "print: hills", hills, [range(len(hills))[::-1]], inks[2])
    mount = surfaces.painted("mount", "ColorChecker: white 9.5 (.05 D)", roughness=0.9)
    frame = surfaces.painted("frame", "ColorChecker: black 2 (1.5 D)", roughness=0.3)
    for name, out, near, far, material in (("mount", 0.03, 0.744, 0.75, mount), ("frame", 0.038, 0.73, 0.75, frame)):
        edge = (0.013, 0.0)[name == "mount"]
        if name == "mount":
            _box(scene, name, (left - out, near, low - out), (right + out, far, high + out), material)
            continue
        wide, tall = (left - out, right + out), (low - out, high + out)
        for side in wide:
            _box(
                scene,
                name,
                (side - edge / 2, near, tall[0] - edge / 2),
                (side + edge / 2, far, tall[1] + edge / 2),
                material,
            )
        for side in tall:
            _box(scene, name, (wide[0], near, side - edge / 2), (wide[1], far, side + edge / 2), material)


def _apple(scene, name, radius, place, tilt, turn, skins=("CES 31", "CES 07")):
    material, tree, principled = surfaces.new(name)
    principled.inputs["Roughness"].default_value = 0.28
    principled.inputs["Coat Weight"].default_value = 0.25
    blush = surfaces.noise(tree, 13.0, (0.3, 0.62), stretch=(1.0, 1.0, 0.22))
    flank = surfaces.noise(tree, 5.0, (0.3, 0.62), detail=1.0)
    surfaces.mixed(material, principled.inputs["Base Color"], surfaces.product(tree, blush, flank, "ADD"), *skins)
    thing = shapes.lathe(scene, name, shapes.apple(radius), material)
    return _lay(scene, thing, place, tilt, turn, (0, 0, 1.12 * radius), radius)


def _lay(scene, thing, place, tilt, turn, top, radius):
    """Tilt a fruit, turn it, put it where it belongs, and give it a stalk."""
    thing.rotation_euler, thing.location = (tilt[0], tilt[1], turn), place
    wood = bpy.data.materials.get("stalk") or surfaces.painted("stalk", "CES 03", roughness=0.7)
    if top is not None:
        grown = shapes.stalk(
            scene, f"{thing.name}, stalk", top, (0.25 * radius, 0.1 * radius, 0.62 * radius), 0.0013, wood
        )
        grown.parent = thing
    return thing


def _orange(scene, name, radius, place, turn=0.0):
    material = bpy.data.materials.get("orange peel")
    if material is None:
        material = surfaces.painted("orange peel", "CES 20", "CES 22", roughness=0.36, scale=3.0)
        tree = material.node_tree
        pores = tree.nodes.new("ShaderNodeTexVoronoi")
        pores.inputs["Scale"].default_value = 480.0
        tree.links.new(next(n for n in tree.nodes if n.type == "TEX_COORD").outputs["Object"], pores.inputs["Vector"])
        surfaces.bump(material, pores.outputs["Distance"], 0.0007, 0.7)
    t = np.linspace(0, np.pi, 64)
    profile = (
        np.stack([np.sin(t), -0.95 * np.cos(t) + 0.06 * np.exp(-((np.sin(t) / 0.1) ** 2)) * np.cos(t)], 1) * radius
    )
    profile[[0, -1], 0] = 0.0
    return _lay(scene, shapes.lathe(scene, name, profile, material), place, (0.5, 0.4), turn, None, radius)


def bowl_of_fruit(scene):
    copper = surfaces.metal("beaten copper", "Copper", 0.16)
    dents = copper.node_tree.nodes.new("ShaderNodeTexVoronoi")
    dents.feature, dents.inputs["Scale"].default_value = "SMOOTH_F1", 62.0
    place = copper.node_tree.nodes.new("ShaderNodeTexCoord")
    copper.node_tree.links.new(place.outputs["Object"], dents.inputs["Vector"])
    surfaces.bump(copper, dents.outputs["Distance"], 0.0022, 0.45)
    outside = shapes.profile("0 0  62 0  66 6  50 20  75 34  125 62  152 103  158 112")
    inside = shapes.profile("156 114  148 104  121 66  70 39  0 32")
    profile = np.vstack([shapes.smooth_profile(outside), shapes.smooth_profile(inside)])
    bowl = shapes.lathe(scene, "copper bowl", profile, copper, 96)
    bowl.location = (-0.245, 0.12, 0.0)
    x, y = bowl.location[:2]
    _apple(scene, "apple", 0.043, (x - 0.072, y - 0.045, 0.083), (0.35, -0.45), 0.4)
    _apple(scene, "second apple", 0.041, (x + 0.02, y + 0.055, 0.09), (-0.2, 0.3), 1.9, ("CES 26", "CES 13"))
    _orange(scene, "orange", 0.045, (x + 0.08, y - 0.03, 0.107), 0.3)
    _orange(scene, "second orange", 0.043, (x - 0.075, y + 0.05, 0.105), 1.2)
    _orange(scene, "third orange", 0.042, (x + 0.005, y - 0.075, 0.098), 2.2)
    material, tree, principled = surfaces.new("pear")
    principled.inputs["Roughness"].default_value = 0.4
    ripe = surfaces.mixed(material, None, surfaces.noise(tree, 120.0, (0.52, 0.7)), "CES 32", "CES 17")
    blush = surfaces.product(tree, surfaces.noise(tree, 4.0, (0.35, 0.7), detail=2.0), surfaces.height(tree, 0.0, 0.06))
    surfaces.mixed(material, principled.inputs["Base Color"], blush, ripe, "CES 12")
    pear = shapes.lathe(scene, "pear", shapes.pear(0.038), material)
    _lay(scene, pear, (x - 0.012, y + 0.0, 0.118), (0.14, 0.2), 0.5, (0, 0, 0.1), 0.05)


def _grape_material():
    material, tree, principled = surfaces.new("grape")
    skin, bloom = surfaces.noise(tree, 14.0, (0.3, 0.7)), surfaces.noise(tree, 60.0, (0.45, 0.75), detail=3.0)
    dark = surfaces.mixed(material, None, skin, "CES 87", "CES 03")
    factor = tree.nodes.new("ShaderNodeMath")
    factor.operation, factor.inputs[1].default_value = "MULTIPLY", 0.3
    tree.links.new(bloom, factor.inputs[0])
    surfaces.mixed(material, principled.inputs["Base Color"], factor.outputs[0], dark, "CES 79")
    principled.inputs["Roughness"].default_value = 0.3
    principled.inputs["Coat Weight"].default_value = 0.3
    return material


def lemons(scene):
    peel = surfaces.painted("lemon peel", "CES 29", "CES 26", roughness=0.34, scale=3.0)
    tree = peel.node_tree
    pores = tree.nodes.new("ShaderNodeTexVoronoi")
    pores.inputs["Scale"].default_value = 420.0
    tree.links.new(next(n for n in tree.nodes if n.type == "TEX_COORD").outputs["Object"], pores.inputs["Vector"])
    surfaces.bump(peel, pores.outputs["Distance"], 0.0007, 0.7)
    for name, place, turn in (("lemon", (0.115, -0.11, 0.0295), 0.5), ("second lemon", (0.175, -0.035, 0.0295), 2.3)):
        thing = shapes.lathe(scene, name, shapes.lemon(0.0295), peel)
        thing.rotation_euler, thing.location = (0.0, math.pi / 2, turn), place
    grape = _grape_material()
    stalks = bpy.data.materials["stalk"]
    places = shapes.grapes(52, 0.0115, 0.15, 0.055)
    mesh = shapes.lathe(scene, "grape", _grape_profile(0.0112), grape, 32)
    for k, place in enumerate(places):
        thing = mesh if k == 0 else mesh.copy()
        if k:
            scene.collection.objects.link(thing)
        angle = 2.6
        turned = (
            place[0] * math.cos(angle) - place[1] * math.sin(angle),
            place[0] * math.sin(angle) + place[1] * math.cos(angle),
        )
        thing.location = (turned[0] + 0.03, turned[1] - 0.13, place[2])
        thing.rotation_euler = (0.7 * math.sin(7 * k), 0.9 * math.cos(5 * k), k)
    shapes.stalk(scene, "grapes, stalk", (0.02, -0.12, 0.02), (0.05, 0.012, 0.02), 0.0017, stalks)


def _grape_profile(radius):
    t = np.linspace(0, np.pi, 32)
    profile = np.stack([np.sin(t), -1.15 * np.cos(t)], axis=1) * radius
    profile[[0, -1], 0] = 0.0
    return profile


def glasses(scene):
    crystal = surfaces.clear("crystal", "BK7")
    wine = surfaces.clear("red wine", "Water", "CES 12", "CES 12")
    outside = shapes.profile("0 0  36 1  36 3  12 7  4.2 18  3.8 50  4.6 78  16 90  34 112  40 140  36 172  31.5 198")
    inside = shapes.profile("30.7 198  35.2 172  39.2 140  33.2 113.5  15.5 92.5  0 87")
    goblet = shapes.lathe(
        scene, "goblet", np.vstack([shapes.smooth_profile(outside, 64), shapes.smooth_profile(inside, 44)]), crystal, 72
    )
    # The wine reaches a little into the glass, so that there is no air between them
    bowl = shapes.smooth_profile(inside, 60)[::-1]
    filled = bowl[bowl[:, 1] < 0.143] + (0.0003, -0.0003)
    filled[0, 0] = 0.0
    held = shapes.lathe(scene, "wine", np.vstack([filled, [(0.0, filled[-1, 1])]]), wine, 72)
    goblet.location = held.location = (0.055, 0.1, 0.0)
    outside = shapes.profile("0 0  30 0  34.5 3  36.5 50  38.5 100")
    inside = shapes.profile("37.2 100  35.2 50  33 12  30 10  0 10")
    tumbler = shapes.lathe(scene, "tumbler", np.vstack([_straight(outside), _straight(inside)]), crystal, 72)
    inside = shapes.profile("0 9.7  30.2 9.7  33.3 12  35.5 50  36.1 66  0 66")
    water = shapes.lathe(scene, "water", _straight(inside), surfaces.clear("water", "Water"), 72)
    tumbler.location = water.location = (0.33, -0.03, 0.0)


def _straight(points):
    """A profile whose corners stay corners, rounded by a millimetre of extra points."""
    points, found = np.asarray(points, float), []
    for k, point in enumerate(points):
        for other in (points[max(k - 1, 0)], point, points[min(k + 1, len(points) - 1)]):
            step = other - point
            length = np.linalg.norm(step)
            found.append(point + (step * min(0.0006 / length, 0.4) if length else 0.0))
    found = np.array(found)
    found[np.array([0, -1]), 0] = points[[0, -1], 0]
    return found


def candlestick(scene):
    brass = surfaces.metal("brass", "Brass", 0.09)
    points = shapes.profile(
        "0 0  58 0  60 5  50 12  24 20  12 34  10 50  17 62  19 70  10 80  8.5 115  11 124  26 132  27.5 136  14 139"
        "  14.5 152  12.5 153  0 150"
    )
    stick = shapes.lathe(scene, "candlestick", shapes.smooth_profile(points, 110), brass, 64)
    wax = surfaces.painted("wax", "CES 23", roughness=0.45, Subsurface_Weight=0.35, Subsurface_Scale=0.01)
    points = shapes.profile("0 145  11.8 147  11.8 226  11.4 228.5  8.5 226.5  0 224.5")
    candle = shapes.lathe(scene, "candle", _straight(points), wax, 64)
    wick = surfaces.painted("wick", "ColorChecker: black 2 (1.5 D)", roughness=0.9)
    thread = shapes.stalk(scene, "wick", (0, 0, 0.224), (0.002, 0.0, 0.012), 0.0007, wick)
    material, tree, principled = surfaces.new("flame")
    tree.nodes.remove(principled)
    emission, clear, add = (
        tree.nodes.new(f"ShaderNode{kind}") for kind in ("Emission", "BsdfTransparent", "AddShader")
    )
    span = surfaces.height(tree, 0.0, 0.011)
    strength = tree.nodes.new("ShaderNodeMath")
    strength.operation, strength.inputs[1].default_value = "MULTIPLY", 26.0
    tree.links.new(span, strength.inputs[0])
    tree.links.new(strength.outputs[0], emission.inputs["Strength"])
    tree.links.new(emission.outputs[0], add.inputs[0])
    tree.links.new(clear.outputs[0], add.inputs[1])
    tree.links.new(add.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    material.cycles.emission_sampling = "NONE"  # the lamp in it lights the room
    points = shapes.profile("0 0  3.2 3.5  4.3 9  3.2 18  1.3 27  0 33")
    flame = shapes.lathe(scene, "flame", shapes.smooth_profile(points, 40), material, 32)
    flame.lightgroup, flame.visible_shadow, flame.visible_diffuse = "candle", False, False
    light = bpy.data.lights.new("candle", "POINT")
    light.energy, light.shadow_soft_size = 1.8, 0.007
    lamp = bpy.data.objects.new("candle flame", light)
    lamp.lightgroup = "candle"
    scene.collection.objects.link(lamp)
    where = Vector((0.27, 0.17, 0.0))
    for thing in (stick, candle, thread):
        thing.location = where
    flame.location, lamp.location = where + Vector((0.002, 0, 0.231)), where + Vector((0.001, 0, 0.246))


def napkin(scene):
    linen = surfaces.painted("linen", "CES 36", "CES 01", roughness=0.85, scale=9.0, Sheen_Weight=0.25)
    tree = linen.node_tree
    weave = []
    for axis in ("X", "Y"):
        wave = tree.nodes.new("ShaderNodeTexWave")
        wave.bands_direction, wave.inputs["Scale"].default_value = axis, 260.0
        tree.links.new(next(n for n in tree.nodes if n.type == "TEX_COORD").outputs["Object"], wave.inputs["Vector"])
        weave.append(wave.outputs["Factor" if "Factor" in wave.outputs else "Fac"])
    surfaces.bump(linen, surfaces.product(tree, *weave), 0.0003, 0.35)
    solid = [scene.objects[name] for name in ("table",)]
    for thing in solid:
        thing.modifiers.new("Collision", "COLLISION")
        thing.collision.thickness_outer, thing.collision.cloth_friction = 0.003, 30.0
    napkin = shapes.cloth(scene, "napkin", (0.52, 0.4), (-0.255, -0.18, 0.05), 0.16, linen)
    for thing in solid:
        thing.modifiers.remove(thing.modifiers["Collision"])
    napkin.modifiers.new("Subdivision", "SUBSURF").render_levels = 1
