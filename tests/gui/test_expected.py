"""The dots of the mixer in Blender's window: green, yellow and red, and the line of the whole mix."""

from pathlib import Path

import numpy as np
import OpenImageIO as oiio

ROOM = Path(__file__).resolve().parents[2] / "assets/room.blend"

STEPS = """
import time
import bpy
from bl_ext.user_default.relume.addon.ui import expected
from bl_ext.user_default.relume.core.picture.expectation import Expectation


def steps():
    scene = bpy.context.scene
    area = next(area for area in bpy.context.screen.areas if area.type == "VIEW_3D")
    area.spaces.active.show_region_ui = True
    yield
    region = next(region for region in area.regions if region.type == "UI")
    region.active_panel_category = "Relume"
    with bpy.context.temp_override(area=area, region=region):
        area.spaces.active.shading.type = "SOLID"
    for number, name in enumerate(("third", "fourth")):
        lamp = bpy.data.lights.new(name, "POINT")
        thing = bpy.data.objects.new(name, lamp)
        scene.collection.objects.link(thing)
        scene.view_layers[0].lightgroups.add(name=name)
        thing.lightgroup = name
    scene.relume.channels = "9"
    assert bpy.ops.relume.set_up() == {"FINISHED"}
    rows = scene.relume.lit
    for row, name in zip(rows, ("D65", "A", "532 nm", "405 nm")):
        row.illuminant = name
    # Lines on this room's few surfaces: one of them is seen side by side, none of the lamps and 405 nm at once
    for name in ("650 nm", "600 nm", "500 nm", "480 nm", "430 nm"):
        rows[2].illuminant = name
        until = time.monotonic() + 20
        yield
        while time.monotonic() < until:
            found = [expected._found.get(expected._of_row(scene.relume, row)) for row in rows]
            if all(isinstance(each, Expectation) for each in found):
                break
            yield
        levels = [each.level for each in found]
        if levels[2] == "yellow":
            break
    assert levels == ["green", "green", "yellow", "red"], found
    until = time.monotonic() + 20
    while time.monotonic() < until and not any(expected._advice.values()):
        yield
    assert "channels" in expected._better(scene.relume)
    for _ in range(2):
        yield
    yield "expected.png"
"""


def test_dots_are_green_yellow_and_red(window):
    picture = window(STEPS, ROOM)["expected.png"]
    pixels = oiio.ImageBuf(str(picture)).get_pixels(oiio.FLOAT)[..., :3]
    for colour in ((0.26, 0.72, 0.33), (0.95, 0.76, 0.13), (0.93, 0.25, 0.2)):
        near = (np.abs(pixels - np.array(colour)) < 0.08).all(axis=-1)
        assert near.sum() > 20, colour
