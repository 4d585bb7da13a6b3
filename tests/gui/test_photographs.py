"""All panels photographed: dark, light and of high contrast, at scales from 1 to 2, and in a narrow sidebar.

A machine cannot see what is clipped: look at them (where `--basetemp` says) before a change of a panel is sent. With
`-m ""` all five are taken, half a minute each; without, the one in which there is least room.
"""

import pytest
from gestures import ROOM
from gestures import STEPS as GESTURES

STEPS = (
    GESTURES
    + """
import os


def scroll(region, times):
    x, y = region.x + region.width // 2, region.y + region.height // 2
    event("MOUSEMOVE", "NOTHING", x, y)
    for number in range(times):
        event("WHEELDOWNMOUSE", "PRESS", x, y)
        if number % 10 == 9:
            yield
    yield
    event("MOUSEMOVE", "NOTHING", 400, 300)
    yield


def open_panels():
    names = [name for name in dir(bpy.types) if "_PT_relume" in name and name != "RELUME_PT_presets"]
    panels = sorted((getattr(bpy.types, name) for name in names), key=lambda panel: hasattr(panel, "bl_parent_id"))
    panels = [panel for panel in panels if panel.is_registered]
    for panel in reversed(panels):
        bpy.utils.unregister_class(panel)
    for panel in panels:
        panel.bl_options = set(getattr(panel, "bl_options", ())) - {"DEFAULT_CLOSED"}
        bpy.utils.register_class(panel)


def contrast(struct):
    # White and yellow on black, as those set a theme who see little else
    for known in struct.bl_rna.properties:
        name, value = known.identifier, None if known.identifier == "rna_type" else getattr(struct, known.identifier)
        if known.type == "POINTER" and value is not None and name != "rna_type":
            contrast(value)
        elif known.type == "FLOAT" and known.is_array and known.array_length in (3, 4):
            words, chosen = "text" in name or "title" in name, "sel" in name or "active" in name
            color = (0.0, 0.0, 0.0)
            if name == "item":
                color = (0.6, 0.6, 0.0)
            elif chosen and not words:
                color = (1.0, 1.0, 0.0)
            elif not chosen and (words or "outline" in name):
                color = (1.0, 1.0, 1.0)
            setattr(struct, name, (*color, 1.0)[: known.array_length])


def put_on(theme):
    preferences = bpy.context.preferences
    if theme == "light":
        folder = bpy.utils.preset_paths("interface_theme")[0]
        bpy.ops.script.execute_preset(
            filepath=os.path.join(folder, "Blender_Light.xml"), menu_idname="USERPREF_MT_interface_theme_presets"
        )
    elif theme == "contrast":
        own = preferences.themes[0]
        for part in (own.user_interface, own.view_3d.space, own.properties.space, own.regions):
            contrast(part)


def prepare():
    scene = bpy.context.scene
    scene.cycles.use_denoising = True
    scene.relume.channels = "6"
    assert bpy.ops.relume.set_up() == {"FINISHED"}
    rows = scene.relume.light_groups
    rows[0].source, rows[0].temperature, rows[0].is_open, rows[0].tint = "PLANCKIAN", 2700, True, (1.0, 0.6, 0.3)
    rows[1].source, rows[1].is_open, rows[1].mute, rows[1].stops = "BLEND", True, True, -1.5
    rows[1].keyframe_insert("stops", frame=1)
    scene.relume.white_balance, scene.relume.white_source = 0.5, "GROUP"
    bpy.ops.relume.take_snapshot()


def steps():
    preferences, scene = bpy.context.preferences, bpy.context.scene
    preferences.view.ui_scale = SCALE
    put_on(THEME)
    open_panels()
    area = area_of("VIEW_3D")
    area.spaces.active.show_region_ui = True
    yield
    region_of(area).active_panel_category = "Relume"
    yield
    yield "1_before.png"
    prepare()
    properties = area_of("PROPERTIES")
    bpy.context.view_layer.objects.active = bpy.data.objects["tungsten"]
    properties.spaces.active.context = "DATA"
    yield
    yield "2_lamp.png"
    bpy.context.view_layer.objects.active = bpy.data.objects["gold"]
    yield
    properties.spaces.active.context = "MATERIAL"
    bpy.ops.relume.new_transfer()
    yield
    yield from scroll(region_of(properties, "WINDOW"), 12)
    yield "3_material.png"
    with bpy.context.temp_override(area=area, region=region_of(area, "WINDOW")):
        bpy.ops.screen.screen_full_area(use_hide_panels=False)
    yield
    yield
    side = region_of(area_of("VIEW_3D"))
    if NARROW:
        x, y, wanted = side.x + 1, side.y + 60, side.x + side.width - 190 * SCALE
        yield from drag([(x + part * (wanted - x), y) for part in (0.0, 0.3, 0.7, 1.0)])
    for number in range(PAGES):
        yield
        yield f"4_sidebar_{number}.png"
        yield from scroll(region_of(area_of("VIEW_3D")), int(10 / SCALE))
    bpy.ops.relume.palette_new(example="three_metamers")
    for _ in range(2):
        yield
    yield from scroll(region_of(area_of("VIEW_3D")), int(60))
    yield "8_palette.png"
    bpy.ops.preferences.addon_show(module=next(n for n in preferences.addons.keys() if n.endswith(".relume")))
    for _ in range(3):
        yield
    yield "9_preferences.png"
"""
)


@pytest.mark.parametrize(
    ("theme", "scale", "narrow"),
    [
        ("dark", 2.0, True),
        pytest.param("contrast", 1.25, False, marks=pytest.mark.torture),
        pytest.param("dark", 1.0, False, marks=pytest.mark.torture),
        pytest.param("light", 1.5, True, marks=pytest.mark.torture),
        pytest.param("contrast", 1.0, True, marks=pytest.mark.torture),
    ],
)
def test_all_panels(window, theme, scale, narrow):
    pages = 4 if narrow or scale > 1.0 else 3  # that the sidebar is long
    chosen = f"THEME, SCALE, NARROW, PAGES = {theme!r}, {scale!r}, {narrow!r}, {pages}\n"
    assert len(window(chosen + STEPS, ROOM, "--enable-event-simulate")) == 5 + pages
