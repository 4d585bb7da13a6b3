"""The panel as an artist meets it: set up, render, choose another light, and see the picture follow."""

from pathlib import Path

import OpenImageIO as oiio

ROOM = Path(__file__).resolve().parents[2] / "assets/room.blend"

PREPARE = """
import bpy


def area_of(kind):
    return next(area for area in bpy.context.screen.areas if area.type == kind)


def open_sidebar():
    area = area_of("VIEW_3D")
    area.spaces.active.show_region_ui = True
    return area


def choose_tab(area):
    next(region for region in area.regions if region.type == "UI").active_panel_category = "Relume"
"""


def _mean(picture: Path, left: float, top: float, right: float, bottom: float):
    """Mean RGB of a part of a picture, its bounds as parts of the whole."""
    image = oiio.ImageBuf(str(picture))
    width, height = image.spec().width, image.spec().height
    roi = oiio.ROI(int(left * width), int(right * width), int(top * height), int(bottom * height))
    return oiio.ImageBufAlgo.computePixelStats(image, roi=roi).avg[:3]


def test_set_up_render_and_change_the_light(window):
    pictures = window(
        PREPARE
        + """
def steps():
    scene = bpy.context.scene
    scene.render.resolution_percentage = 50
    scene.cycles.samples = 12
    area = open_sidebar()
    yield
    choose_tab(area)
    yield "1_before.png"
    assert bpy.ops.relume.set_up() == {"FINISHED"}
    yield "2_set_up.png"
    # The viewport shows the chosen light too, before anything is rendered
    area.spaces.active.region_3d.view_perspective = "CAMERA"
    area.spaces.active.shading.type = "RENDERED"
    for _ in range(12):
        yield
    yield "preview_as_lit.png"
    for row in scene.relume.light_groups:
        row.illuminant = "Sodium (low pressure)"
    for _ in range(12):
        yield
    yield "preview_sodium.png"
    scene.relume.light_groups[0].illuminant, scene.relume.light_groups[1].illuminant = "A", "FL2"
    area.spaces.active.shading.type = "SOLID"
    bpy.ops.render.render()
    with bpy.context.temp_override(area=area, region=next(r for r in area.regions if r.type == "WINDOW")):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=0.55)
    left, right = sorted((a for a in bpy.context.screen.areas if a.type == "VIEW_3D"), key=lambda a: a.x)
    left.spaces.active.show_region_ui = True
    right.type = "IMAGE_EDITOR"
    right.spaces.active.image = bpy.data.images["Render Result"]
    yield
    choose_tab(left)
    yield "3_rendered.png"
    for row in scene.relume.light_groups:
        row.illuminant = "Sodium (low pressure)"
    yield
    yield "4_sodium.png"
    scene.relume.light_groups[0].illuminant = "Sodum"
    yield "5_problem.png"
    bpy.ops.relume.remove()
    yield "6_removed.png"
""",
        ROOM,
    )
    as_lit, preview = (_mean(pictures[f"preview_{name}.png"], 0.35, 0.35, 0.45, 0.45) for name in ("as_lit", "sodium"))
    assert preview[2] < 0.4 * as_lit[2], "the viewport follows the illuminant"
    rendered, sodium = (_mean(pictures[name], 0.17, 0.42, 0.28, 0.55) for name in ("3_rendered.png", "4_sodium.png"))
    assert sodium[2] < 0.4 * rendered[2], "the picture on the screen follows the illuminant, without a new render"


EVENTS = """
import sys

OPERATORS = next(module for name, module in sys.modules.items() if name.endswith("relume.addon.ui.operators"))


def fill_the_scene(scene):
    # So many materials that setting up takes a while; returns what has to go for it to be as before
    made = []
    for number in range(1500):
        mesh, material = bpy.data.meshes.new("fill"), bpy.data.materials.new("fill")
        material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (number / 1500, 0.2, 0.1, 1)
        mesh.materials.append(material)
        thing = bpy.data.objects.new("fill", mesh)
        scene.collection.objects.link(thing)
        made += [thing, mesh, material]
    return made


SET_UP, FIELD = (1156, 590), (1165, 650)  # the button, and then the illuminant of the first light group


def event(kind, value, x, y, **options):
    bpy.context.window.event_simulate(type=kind, value=value, x=x, y=y, **options)


def click(x, y):
    event("MOUSEMOVE", "NOTHING", x, y)
    yield
    event("LEFTMOUSE", "PRESS", x, y)
    event("LEFTMOUSE", "RELEASE", x, y)
    yield


def type_text(text, x, y):
    for letter in text:
        event(letter.upper() if letter.isalpha() else "SPACE", "PRESS", x, y, unicode=letter)
        event(letter.upper() if letter.isalpha() else "SPACE", "RELEASE", x, y)
        yield


def press(key, x, y, **modifiers):
    event("MOUSEMOVE", "NOTHING", x, y)
    yield
    event(key, "PRESS", x, y, **modifiers)
    event(key, "RELEASE", x, y)
    yield
"""


def test_clicks_and_keys(window):
    window(
        PREPARE
        + EVENTS
        + """
def steps():
    scene = bpy.context.scene
    area = open_sidebar()
    yield
    choose_tab(area)
    yield
    fill, layers = fill_the_scene(scene), len(scene.view_layers)
    yield from click(*SET_UP)
    assert OPERATORS.is_at_work(), "a large scene takes a while"
    yield "0_working.png"
    yield from press("ESC", *SET_UP)
    assert not OPERATORS.is_at_work() and not scene.relume.is_set_up and len(scene.view_layers) == layers
    bpy.data.batch_remove(fill)
    yield from click(*SET_UP)
    for _ in range(40):
        yield
        if not OPERATORS.is_at_work():
            break
    assert scene.relume.is_set_up
    yield
    yield "1_clicked.png"
    yield from click(*FIELD)
    yield "2_search.png"
    yield from type_text("led b", *FIELD)
    yield "3_typed.png"
    yield from press("RET", *FIELD)
    assert scene.relume.light_groups[0].illuminant.startswith("LED-B"), scene.relume.light_groups[0].illuminant
    yield "4_chosen.png"
    yield from press("Z", 500, 300, ctrl=True)
    scene = bpy.context.scene
    assert scene.relume.light_groups[0].illuminant == "A", "one undo step takes the choice back"
    yield "5_undone.png"
    yield from press("Z", 500, 300, ctrl=True)
    assert not bpy.context.scene.relume.is_set_up, "the next takes the set-up back"
    yield "6_not_set_up.png"
""",
        ROOM,
        "--enable-event-simulate",
    )


def test_the_render_properties_have_the_panel_too(window):
    assert window(
        """
import bpy


def steps():
    parts = [getattr(bpy.types, name) for name in dir(bpy.types) if name.startswith("RENDER_PT_relume_")]
    panels = [bpy.types.RENDER_PT_relume, *parts]
    for panel in reversed(panels):
        bpy.utils.unregister_class(panel)
        panel.bl_options = set()  # open
    for panel in panels:
        bpy.utils.register_class(panel)
    properties = next(area for area in bpy.context.screen.areas if area.type == "PROPERTIES")
    assert bpy.ops.relume.set_up() == {"FINISHED"}
    properties.spaces.active.context = "RENDER"
    with bpy.context.temp_override(area=properties):
        bpy.ops.screen.screen_full_area()
    yield
    for _ in range(30):
        for kind, value in (("MOUSEMOVE", "NOTHING"), ("WHEELDOWNMOUSE", "PRESS")):
            bpy.context.window.event_simulate(type=kind, value=value, x=800, y=400)
        yield
    yield "render_properties.png"
""",
        ROOM,
        "--enable-event-simulate",
    ).keys() == {"render_properties.png"}
