"""What several tests of the window do: clicks, drags and keys, the panel beside the render."""

from pathlib import Path

__all__ = ["ROOM", "STEPS"]

ROOM = Path(__file__).resolve().parents[2] / "assets/room.blend"

STEPS = """
import bpy


def event(kind, value, x, y, **options):
    bpy.context.window.event_simulate(type=kind, value=value, x=int(x), y=int(y), **options)


def move(x, y):
    event("MOUSEMOVE", "NOTHING", x - 2, y)
    event("MOUSEMOVE", "NOTHING", x, y)
    yield


def click(x, y):
    yield from move(x, y)
    event("LEFTMOUSE", "PRESS", x, y)
    event("LEFTMOUSE", "RELEASE", x, y)
    yield


def drag(path):
    (x, y), *rest = path
    yield from move(x, y)
    event("LEFTMOUSE", "PRESS", x, y)
    yield
    for x, y in rest:
        event("MOUSEMOVE", "NOTHING", x, y)
        yield
    event("LEFTMOUSE", "RELEASE", x, y)
    yield


def press(key, x, y, **modifiers):
    yield from move(x, y)
    event(key, "PRESS", x, y, **modifiers)
    event(key, "RELEASE", x, y)
    yield


def type_text(text, x, y):
    for letter in text:
        key = letter.upper() if letter.isalpha() else "SPACE"
        event(key, "PRESS", x, y, unicode=letter)
        event(key, "RELEASE", x, y)
        yield


def area_of(kind):
    return next(area for area in bpy.context.screen.areas if area.type == kind)


def region_of(area, kind="UI"):
    return next(region for region in area.regions if region.type == kind)


def layout():
    # The 3D view on the left with the panel, the render on the right
    area = area_of("VIEW_3D")
    area.spaces.active.show_region_ui = True
    with bpy.context.temp_override(area=area, region=region_of(area, "WINDOW")):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=0.5)
    yield
    left, right = sorted((a for a in bpy.context.screen.areas if a.type == "VIEW_3D"), key=lambda a: a.x)
    right.type = "IMAGE_EDITOR"
    left.spaces.active.show_region_ui = True
    yield
    region_of(left).active_panel_category = "Relume"
    yield


def render():
    scene = bpy.context.scene
    scene.render.resolution_percentage = 50
    scene.cycles.samples = 96
    bpy.ops.render.render()
    area = area_of("IMAGE_EDITOR")
    area.spaces.active.image = bpy.data.images["Render Result"]
    yield
    with bpy.context.temp_override(area=area, region=region_of(area, "WINDOW")):
        bpy.ops.image.view_all(fit_view=True)
    bpy.ops.ed.undo_push(message="Render")
    yield


def groups():
    return bpy.context.scene.relume.light_groups
"""
