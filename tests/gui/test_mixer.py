"""The mixer as an artist meets it, by clicks, drags and keys; its pictures are those of docs/mixer.md."""

import pytest
from gestures import ROOM, STEPS


def test_choose_a_lamp_solo_undo_snapshot_save_and_reopen(window, tmp_path):
    window(
        STEPS
        + f"""
SAVED = {str(tmp_path / "saved.blend")!r}
"""
        + """
# From the upper right corner of the panel's region, at an interface scale of 1
LAMP, SOLO, GAIN = (-150, -103), (-77, -83), (-140, -83)


def at(place):
    region = region_of(area_of("VIEW_3D"))
    return region.x + region.width + place[0], region.y + region.height + place[1]


def steps():
    bpy.context.scene.relume.channels = "6"
    bpy.context.preferences.view.show_statusbar_stats = False
    yield from layout()
    assert bpy.ops.relume.set_up() == {"FINISHED"}
    yield from render()
    yield "mixer_rendered.png"
    yield from click(*at(LAMP))
    yield from type_text("sod", *at(LAMP))
    yield "mixer_search.png"
    yield from press("RET", *at(LAMP))
    yield
    assert groups()[0].illuminant.startswith("Sodium"), groups()[0].illuminant
    yield "mixer_sodium.png"
    yield from click(*at(SOLO))
    assert groups()[0].solo
    yield "mixer_solo.png"
    yield from press("Z", *at((-600, -400)), ctrl=True)
    assert not groups()[0].solo and groups()[0].illuminant.startswith("Sodium"), "solo is one step of undo"
    yield from press("Z", *at((-600, -400)), ctrl=True)
    assert groups()[0].illuminant == "A", "and so is the lamp"
    yield from press("Z", *at((-600, -400)), ctrl=True, shift=True)
    assert groups()[0].illuminant.startswith("Sodium")
    assert bpy.ops.relume.take_snapshot() == {"FINISHED"}
    groups()[0].source = "PLANCKIAN"
    x, y = at(GAIN)
    yield from drag([(x, y), (x - 20, y), (x - 60, y), (x - 60, y)])
    assert groups()[0].stops < 0.0, groups()[0].stops
    assert bpy.ops.relume.compare() == {"FINISHED"}
    yield "mixer_compare.png"
    bpy.ops.wm.save_as_mainfile(filepath=SAVED)
    bpy.ops.wm.open_mainfile(filepath=SAVED)
    yield
    assert bpy.context.scene.relume.comparing == "Mix 1"
    assert bpy.ops.relume.compare() == {"FINISHED"}
    assert bpy.ops.relume.apply_snapshot() == {"FINISHED"}
    assert groups()[0].illuminant.startswith("Sodium") and groups()[0].stops == 0.0
    yield "mixer_reopened.png"
""",
        ROOM,
        "--enable-event-simulate",
    )


def test_the_light_dial_and_the_spectrum_under_the_cursor(window):
    window(
        STEPS
        + """
def steps():
    bpy.context.scene.relume.channels = "6"
    yield from layout()
    assert bpy.ops.relume.set_up() == {"FINISHED"}
    yield from render()
    row = groups()[0]
    row.source, row.is_open = "BLEND", True
    row.blend.add().illuminant = "Sodium (low pressure)"
    row.blend.add().illuminant = "HP1"
    picture = region_of(area_of("IMAGE_EDITOR"), "WINDOW")
    assert bpy.ops.relume.light_dial("INVOKE_DEFAULT", group=0) == {"RUNNING_MODAL"}
    yield
    x, y = picture.x + 150, picture.y + 150  # the middle of the dial
    yield from drag([(x, y), (x + 20, y), (x + 70, y), (x + 100, y), (x + 100, y)])
    weights = [round(part.weight, 2) for part in groups()[0].blend]
    assert weights[1] > 0.9, weights
    yield "mixer_dial.png"
    yield from press("RET", x, y)
    x, y = picture.x + picture.width // 2, picture.y + picture.height // 2
    assert bpy.ops.relume.inspect("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    yield from click(x - 60, y)
    yield from move(x + 40, y - 20)
    yield "mixer_inspect.png"
    yield from press("ESC", x, y)
    assert bpy.ops.relume.pick_white("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    yield from click(x, y)
    assert bpy.context.scene.relume.white_source == "PIXEL"
    assert bpy.context.scene.relume.problem == ""
    yield "mixer_picked.png"
""",
        ROOM,
        "--enable-event-simulate",
    )


@pytest.mark.parametrize(("theme", "scale"), [("dark", 1.0), ("light", 1.5)])
def test_the_panels_in_both_themes_and_at_two_scales(window, theme, scale):
    name = f"mixer_{theme}_{scale}.png"
    pictures = window(
        STEPS
        + f"""
THEME, SCALE, NAME = {theme!r}, {scale!r}, {name!r}
"""
        + """
import os


def steps():
    preferences = bpy.context.preferences
    if THEME == "light":
        folder = bpy.utils.preset_paths("interface_theme")[0]
        bpy.ops.script.execute_preset(
            filepath=os.path.join(folder, "Blender_Light.xml"), menu_idname="USERPREF_MT_interface_theme_presets"
        )
    preferences.view.ui_scale = SCALE
    yield from layout()
    bpy.context.scene.relume.channels = "6"
    assert bpy.ops.relume.set_up() == {"FINISHED"}
    rows = groups()
    rows[0].source, rows[0].temperature, rows[0].is_open = "PLANCKIAN", 2700, True
    rows[1].source, rows[1].is_open = "BLEND", True
    rows[1].mute = True
    bpy.ops.relume.take_snapshot()
    yield
    yield NAME
""",
        ROOM,
    )
    assert list(pictures) == [name]


def test_a_row_without_lights_says_so_until_it_is_removed(window):
    pictures = window(
        STEPS
        + """
def steps():
    scene = bpy.context.scene
    groups()["tungsten"].stops = 1.0
    bpy.data.objects["tungsten"].lightgroup = "fluorescent"
    bpy.ops.relume.set_up()
    assert [row.name for row in groups()] == ["fluorescent", "tungsten"]
    yield from layout()
    yield "without.png"
    bpy.ops.relume.remove_empty_groups()
    yield
    assert [row.name for row in groups()] == ["fluorescent"]
    yield "removed.png"
""",
        ROOM,
    )
    assert set(pictures) == {"without.png", "removed.png"}


def test_the_render_that_is_there_becomes_a_web_page(window, tmp_path):
    window(
        STEPS
        + f"""
def steps():
    import os

    os.environ["BROWSER"] = "true"  # a program that shows nothing
    bpy.context.scene.relume.channels = "6"
    yield from layout()
    assert bpy.ops.relume.set_up() == {{"FINISHED"}}
    yield from render()
    groups()[0].illuminant = "Mercury"
    yield
    assert bpy.ops.relume.share_as_web_page(filepath={str(tmp_path / "room.html")!r}, size=120) == {{"FINISHED"}}
    yield "mixer_web.png"
""",
        ROOM,
        "--enable-event-simulate",
    )
    page = (tmp_path / "room.html").read_text(encoding="utf-8")
    assert '"name":"room"' in page and '"name":"Mercury"' in page and 'id="plane11"' in page


def test_many_groups_a_dropped_file_and_german_in_a_narrow_sidebar(window, tmp_path):
    (tmp_path / "Ochre.csv").write_text("nm,Ochre\n400,0.1\n550,0.4\n700,0.6\n")
    pictures = window(
        STEPS
        + f"""
FOLDER = {str(tmp_path)!r}
"""
        + """
import os
from bpy_extras.view3d_utils import location_3d_to_region_2d


def steps():
    scene, preferences = bpy.context.scene, bpy.context.preferences
    folder = bpy.utils.preset_paths("interface_theme")[0]
    bpy.ops.script.execute_preset(
        filepath=os.path.join(folder, "Blender_Light.xml"), menu_idname="USERPREF_MT_interface_theme_presets"
    )
    if "de_DE" in {item.identifier for item in preferences.view.bl_rna.properties["language"].enum_items}:
        preferences.view.language = "de_DE"
    for number in range(38):
        lamp = bpy.data.objects.new(f"lamp {number}", bpy.data.lights.new("lamp", "POINT"))
        scene.collection.objects.link(lamp)
        lamp.lightgroup, lamp.location = f"group {number:02d}", (number, 50, 50)
        scene.view_layers[0].lightgroups.add(name=lamp.lightgroup)
    yield from layout()
    scene.relume.channels = "6"
    assert bpy.ops.relume.set_up() == {"FINISHED"}
    assert len(groups()) == 40
    groups()[3].solo, groups()[4].stops, scene.relume.active_light_group = True, -1.5, 4
    yield
    yield "home_many.png"
    for thing in scene.objects:
        thing.hide_set(True)
    mesh, paint = bpy.data.meshes.new("board"), bpy.data.materials.new("paint")
    mesh.from_pydata([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [], [(0, 1, 2, 3)])
    mesh.materials.append(paint)
    board = bpy.data.objects.new("board", mesh)
    scene.collection.objects.link(board)
    yield
    area = area_of("VIEW_3D")
    region = region_of(area, "WINDOW")
    x, y = location_3d_to_region_2d(region, area.spaces.active.region_3d, board.location)
    yield from move(region.x + x, region.y + y)
    with bpy.context.temp_override(area=area, region=region):
        bpy.ops.wm.drop_import_file("INVOKE_DEFAULT", directory=FOLDER, files=[{"name": "Ochre.csv"}])
    yield
    link = paint.node_tree.nodes["Principled BSDF"].inputs["Base Color"].links[0]
    assert link.from_node.node_tree.name == "Ochre", "what is under the cursor has the spectrum"
    bpy.context.view_layer.objects.active = board
    yield from move(region.x + 60, region.y + 400)
    with bpy.context.temp_override(area=area, region=region):
        bpy.ops.wm.call_menu(name="VIEW3D_MT_object_context_menu")
    yield "home_menu.png"
    yield from press("ESC", region.x + 60, region.y + 400)
    preferences.view.ui_scale = 1.6
    yield
    side = region_of(area_of("VIEW_3D"))
    x, y = side.x + 1, side.y + 200
    yield from drag([(x, y), (x + 20, y), (x + 90, y), (x + 90, y)])
    yield
    yield "home_narrow.png"
""",
        ROOM,
        "--enable-event-simulate",
    )
    assert set(pictures) == {"home_many.png", "home_menu.png", "home_narrow.png"}
