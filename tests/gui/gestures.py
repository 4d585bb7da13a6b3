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


def at(place, kind="VIEW_3D"):
    # A place from the upper right corner of the panel's region, at an interface scale of 1
    region = region_of(area_of(kind))
    return region.x + region.width + place[0], region.y + region.height + place[1]


def layout(factor=0.5):
    # The 3D view on the left with the panel, the render on the right
    area = area_of("VIEW_3D")
    area.spaces.active.show_region_ui = True
    with bpy.context.temp_override(area=area, region=region_of(area, "WINDOW")):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=factor)
    yield
    left, right = sorted((a for a in bpy.context.screen.areas if a.type == "VIEW_3D"), key=lambda a: a.x)
    right.type = "IMAGE_EDITOR"
    left.spaces.active.show_region_ui = True
    yield
    region_of(left).active_panel_category = "Relume"
    yield


def render(percent=50, samples=96):
    scene = bpy.context.scene
    scene.render.resolution_percentage, scene.cycles.samples = percent, samples
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
