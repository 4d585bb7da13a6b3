"""The palette editor as an artist meets it: two paints that match in daylight and part under tungsten.

Its pictures are those of docs/palette.md.
"""

from gestures import STEPS as GESTURES

STEPS = (
    GESTURES
    + '''

def below(place, kind="VIEW_3D"):
    """The same from its lower right corner, where the panel ends once it is scrolled."""
    region = region_of(area_of(kind))
    return region.x + region.width + place[0], region.y + place[1]


def scroll(steps, kind="VIEW_3D"):
    """Scroll the panel down, or up; a positive number far enough shows its end."""
    area = area_of(kind)
    with bpy.context.temp_override(window=bpy.context.window, area=area, region=region_of(area)):
        for _ in range(abs(steps)):
            (bpy.ops.view2d.scroll_down if steps > 0 else bpy.ops.view2d.scroll_up)(deltay=60)
    yield


def to_the_end():
    # What is scrolled to grows when its panels open
    yield from scroll(40)
    yield from scroll(40)


def choose(place):
    """Click a button that opens a menu or a dialog, and take what it offers first."""
    yield from click(*place)
    yield
    yield from press("RET", *place)
    yield


def design():
    return bpy.context.scene.relume_palettes[bpy.context.scene.relume_palette_active]


def beside_the_render():
    """The palette on the left, the render on the right; nothing else in the tab."""
    for name in [name for name in dir(bpy.types) if name.startswith("VIEW3D_PT_relume") and "palette" not in name]:
        bpy.utils.unregister_class(getattr(bpy.types, name))
    panel = bpy.types.VIEW3D_PT_relume_palette
    bpy.utils.unregister_class(panel)
    panel.bl_options = set()
    bpy.utils.register_class(panel)
    yield from layout(0.6)


def scene_of_two():
    """Two spheres of one grey under one lamp, in a light group that is daylight."""
    scene = bpy.context.scene
    for thing in list(bpy.data.objects):
        if thing.type in {"MESH", "LIGHT"}:
            bpy.data.objects.remove(thing)
    for name, x in (("left", -1.1), ("right", 1.1)):
        bpy.ops.mesh.primitive_uv_sphere_add(location=(x, 0, 0))
        bpy.ops.object.shade_smooth()
        material = bpy.data.materials.new(name)
        material.node_tree.nodes["Principled BSDF"].inputs["Roughness"].default_value = 1.0
        material.node_tree.nodes["Principled BSDF"].inputs["Specular IOR Level"].default_value = 0.0
        bpy.context.object.name = name
        bpy.context.object.data.materials.append(material)
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 3.0, (0.5, 0.2, 0.0)
    scene.collection.objects.link(sun)
    scene.view_layers[0].lightgroups.add(name="lamp")
    sun.lightgroup = "lamp"
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.02, 0.02, 0.02, 1.0)
    scene.camera.location, scene.camera.rotation_euler = (0.0, -8.0, 0.0), (1.5708, 0.0, 0.0)
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y, scene.cycles.samples = 480, 300, 32
    scene.view_settings.view_transform = "Standard"
    scene.cycles.use_denoising = False
    area = area_of("VIEW_3D")
    area.spaces.active.region_3d.view_perspective = "CAMERA"
    area.spaces.active.overlay.show_overlays = False
'''
)


def test_two_paints_that_match_in_daylight_and_part_under_tungsten(window):
    """The ten steps of docs/palette.md, each with its picture."""
    window(
        STEPS
        + """
NEW, EMPTY, MORE, DESIGNED_ROW, FIRST_CELL = (-49, -46), (-11, -71), (-256, -119), (-212, -277), (-180, -253)
DEMANDS, DIFFERENCE, CREATE = (-172, 133), (-221, 144), (-148, -625)
MATERIALS, GROUP = (-148, 87), (-148, 67)


def steps():
    scene_of_two()
    scene = bpy.context.scene
    scene.relume.channels = "9"
    yield from beside_the_render()
    yield "palette_1.png"
    yield from click(*at(NEW))
    yield from click(*at(EMPTY))
    assert [light.name for light in design().lights] == ["D65", "A"]
    yield "palette_2.png"
    yield from click(*at(MORE))
    yield from click(*at(DESIGNED_ROW))
    d = design()
    assert [row.designed for row in d.reflectances] == [True, True]
    for row, name in zip(d.reflectances, ("left", "right")):
        row.name, row.material = name, bpy.data.materials[name]
    yield "palette_3.png"
    yield from click(*at(FIRST_CELL))
    assert (d.row, d.column) == (0, 0)
    d.cells[0].target = (0.2, 0.21, 0.24)
    bpy.ops.ed.undo_push(message="Wanted")
    yield
    yield "palette_wanted.png"
    assert bpy.ops.relume.set_up() == {"FINISHED"}
    yield from to_the_end()
    yield from click(*below(DEMANDS))
    yield from to_the_end()
    yield from click(*below(DIFFERENCE))
    design().differences[0].kind, design().differences[0].amount = "MOST", 0.1
    bpy.ops.relume.palette_select(row=0, column=1)
    yield from to_the_end()
    yield "palette_5.png"
    yield from click(*below(DIFFERENCE))
    one = design().differences[1]
    assert (one.first, one.second, one.light) == ("left", "right", "A")
    one.amount = 20.0
    yield from to_the_end()
    yield "palette_6.png"
    yield from scroll(-80)
    yield from click(*at(CREATE))
    yield
    assert design().reflectances[1].spectrum, design().remarks
    yield "palette_7.png"
    yield from to_the_end()
    yield from click(*below(MATERIALS))
    groups = [tree.name for tree in bpy.data.node_groups if tree.name in ("left (Palette)", "right (Palette)")]
    assert len(groups) == 2, "both materials have their spectra"
    yield "palette_8.png"
    bpy.ops.relume.palette_select(column=0)
    yield from to_the_end()
    yield from click(*below(GROUP))
    yield "palette_group.png"
    yield from press("RET", *below(GROUP))
    yield
    parts = scene.relume.light_groups["lamp"].blend
    assert [(part.illuminant, part.weight) for part in parts] == [("D65", 1.0), ("A", 0.0)]
    yield "palette_9.png"
    yield from scroll(-80)
    yield from render(100, 32)
    yield "palette_daylight.png"
    parts = scene.relume.light_groups["lamp"].blend
    parts[0].weight, parts[1].weight = 0.0, 1.0
    yield
    yield "palette_tungsten.png"
""",
        "--enable-event-simulate",
    )


def test_patches_buttons_and_undo_by_clicks(window):
    window(
        STEPS
        + """
# Of a matrix of two lights and two reflectances; lower where a wanted colour is shown
RIGHT_PATCH, LEFT_PATCH = (-90, -253), (-180, -253)
FIT, CREATE, DESIGNED, ROW_DESIGNED = (-220, -471), (-148, -648), (-96, -517), (-54, -165)
VIEW, COLOUR, BLACK = (-101, -389), (-215, -389), (-54, -494)


def steps():
    yield from beside_the_render()
    bpy.ops.relume.palette_new(example="EMPTY")
    bpy.ops.relume.palette_add_designed(kind="REFLECTANCE")
    bpy.ops.relume.palette_select(row=0, column=0)
    design().cells[0].target = (0.25, 0.12, 0.05)
    bpy.ops.ed.undo_push(message="Wanted")
    yield
    yield from click(*at(RIGHT_PATCH))
    assert (design().row, design().column) == (0, 1), (design().row, design().column)
    yield "palette_clicked.png"
    yield from click(*at(FIT))
    assert design().cells[1].use == "TARGET", [cell.use for cell in design().cells]
    yield from press("Z", *at((-600, -400)), ctrl=True)
    assert design().cells[1].use == "NONE", "Fit Colour is one step of undo"
    yield from click(*at(LEFT_PATCH))
    assert (design().row, design().column) == (0, 0)
    yield from click(*at(CREATE))
    yield
    assert design().reflectances[0].spectrum and design().cells[0].error < 0.1, design().remarks
    yield "palette_created_by_click.png"
    yield from press("Z", *at((-600, -400)), ctrl=True)
    assert not design().reflectances[0].spectrum, "and so is Create Spectra"
    yield from press("Z", *at((-600, -400)), ctrl=True, shift=True)
    assert design().reflectances[0].spectrum
    yield from click(*at(DESIGNED))
    assert design().lights[0].designed, "one click makes a light one that is designed"
    yield "palette_designed_light.png"
    yield from click(*at(ROW_DESIGNED))
    assert not design().reflectances[0].designed, "and beside its name a row one that is given"
    yield from click(*at(ROW_DESIGNED))
    yield from click(*at(BLACK))
    row = design().reflectances[0]
    assert tuple(design().cells[0].target) == (0, 0, 0) and (row.own_bounds, row.lower) == (True, -1.0)
    bpy.context.scene.view_settings.view_transform = "AgX"
    before = tuple(design().cells[1].full)
    yield from click(*at(VIEW))
    seen = tuple(design().cells[1].full)
    assert max(abs(a - b) for a, b in zip(before, seen)) > 0.02, "through the view transform"
    bpy.context.scene.view_settings.exposure = 1.0
    yield
    yield
    assert sum(design().cells[1].full) > sum(seen) + 0.1, "which the patches follow"
    yield "palette_view.png"
    yield from click(*at(COLOUR))
    assert tuple(design().cells[1].full) == before
""",
        "--enable-event-simulate",
    )


def test_spectra_from_everywhere_by_clicks(window, tmp_path):
    file = tmp_path / "paint.csv"
    file.write_text("".join(f"{nm},{0.2 + 0.001 * (nm - 380):.3f}\n" for nm in range(380, 781, 20)))
    window(
        STEPS
        + f"""
FILE = {str(file)!r}
"""
        + """
import json

MORE, BLACK_BODY, LIBRARY, ROW_FILE = (-256, -119), (-203, -228), (-200, -298), (-208, -319)
NORMALISE_LIGHT, BY = (-75, -573), (-135, -582)


def spectrum(entry):
    return json.loads(entry.spectrum)["values"]


def steps():
    bpy.context.preferences.view.filebrowser_display_type = "SCREEN"
    yield from beside_the_render()
    bpy.ops.relume.palette_new(example="EMPTY")
    yield from click(*at(MORE))
    yield from choose(at(BLACK_BODY))
    assert [light.name for light in design().lights] == ["D65", "A", "Planckian 2856 K"]
    yield from click(*at(MORE))
    yield from click(*at(LIBRARY))
    x, y = at(LIBRARY)
    for letter in "CES 30":
        event("SPACE" if letter == " " else letter if letter.isalpha() else {"3": "THREE", "0": "ZERO"}[letter],
              "PRESS", x, y, unicode=letter)
        yield
    yield "palette_search.png"
    yield from press("RET", x, y)
    yield
    assert design().reflectances[-1].name == "CES 30", [row.name for row in design().reflectances]
    yield from click(*at(MORE))
    yield from click(*at(ROW_FILE))
    yield
    area = area_of("FILE_BROWSER")
    folder, _, name = FILE.rpartition("/")
    area.spaces.active.params.directory, area.spaces.active.params.filename = folder.encode(), name
    with bpy.context.temp_override(area=area):
        bpy.ops.file.execute()
    yield
    yield
    assert design().reflectances[-1].name == "paint", "read from its file"
    d = design()
    bpy.ops.relume.palette_select(row=1, column=2)
    bpy.ops.ed.undo_push(message="Selected")
    yield
    yield "palette_loaded.png"
    yield from click(*at(NORMALISE_LIGHT))
    yield
    yield from click(*at(BY))
    yield "palette_normalise.png"
    yield from press("N", *at(BY))
    yield from press("RET", *at(BY))
    yield
    assert abs(sum(value**2 for value in spectrum(design().lights[2])) - 1.0) < 1e-6, "its L2 norm"
""",
        "--enable-event-simulate",
    )


def test_tried_on_picked_and_inspected_in_a_render_that_is_there(window):
    window(
        STEPS
        + """
TRY_ON, PICK, CARRY = (-169, 41), (-48, 41), (-148, 20)


def in_picture(across, up):
    region = region_of(area_of("IMAGE_EDITOR"), "WINDOW")
    return region.x + region.width * across, region.y + region.height * up


def steps():
    scene_of_two()
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_plane_add(size=20, location=(0, 0, -1))
    bpy.context.object.data.materials.append(bpy.data.materials.new("floor"))
    yield from beside_the_render()
    scene.relume.channels, scene.cycles.samples = "9", 16
    bpy.ops.relume.set_up()
    bpy.ops.relume.palette_new(example="three_metamers")
    bpy.ops.relume.palette_create()
    d = design()
    for row, name in zip(d.reflectances, ("left", "right")):
        row.material = bpy.data.materials[name]
    for row in (0, 1):
        d.cells[2 * row].target = (0.4, 0.1, 0.05) if row else (0.05, 0.2, 0.4)
    for _ in range(5):
        bpy.ops.relume.palette_add_demand(what="DIFFERENCE", remove=0)
    bpy.ops.relume.palette_create()
    bpy.ops.ed.undo_push(message="Created")
    yield from to_the_end()
    yield from click(*below(CARRY))
    assert all("Relume Surface" in layer.aovs for layer in scene.view_layers if layer.use)
    yield "palette_carried.png"
    yield from render(100, 32)
    yield from to_the_end()
    yield from click(*below(TRY_ON))
    yield
    image = area_of("IMAGE_EDITOR").spaces.active.image
    assert image.name == "Relume Try-On" and design().trial.startswith("Tried on: left, right."), design().trial
    yield from to_the_end()
    yield "palette_tried_on.png"
    bpy.ops.relume.palette_show_render()
    yield
    area = area_of("IMAGE_EDITOR")
    region = region_of(area, "WINDOW")
    assert area.spaces.active.image.type == "RENDER_RESULT"
    bpy.ops.relume.palette_select(row=0, column=0)
    for place, name in (((0.65, 0.5), "second"), ((0.5, 0.38), "floor")):
        with bpy.context.temp_override(window=bpy.context.window, area=area, region=region):
            assert bpy.ops.relume.palette_pick_row("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
        yield
        yield from click(*in_picture(*place))
        yield
        assert design().reflectances[design().row].name == name
    assert design().reflectances[-1].material == bpy.data.materials["floor"], "which had no row"
    with bpy.context.temp_override(window=bpy.context.window, area=area, region=region):
        bpy.ops.relume.inspect("INVOKE_DEFAULT")
    for across in (0.34, 0.35):
        event("MOUSEMOVE", "NOTHING", *in_picture(across, 0.5))
        yield
    yield "palette_inspected.png"
    yield from press("ESC", *in_picture(0.35, 0.5))
    assert bpy.ops.relume.palette_assign() == {"FINISHED"}
    yield from render(100, 32)
    yield "palette_rendered.png"
""",
        "--enable-event-simulate",
    )


def test_both_themes_and_the_image_editor(window):
    pictures = window(
        STEPS
        + """
import os


def steps():
    folder = bpy.utils.preset_paths("interface_theme")[0]
    bpy.ops.script.execute_preset(
        filepath=os.path.join(folder, "Blender_Light.xml"), menu_idname="USERPREF_MT_interface_theme_presets"
    )
    yield from beside_the_render()
    panel = bpy.types.IMAGE_PT_relume_palette
    bpy.utils.unregister_class(panel)
    panel.bl_options, panel.bl_order = set(), -1
    bpy.utils.register_class(panel)
    area = area_of("IMAGE_EDITOR")
    area.spaces.active.show_region_ui = True
    yield
    region_of(area).active_panel_category = "Relume"
    for example in ("black", "three_metamers"):
        bpy.ops.relume.palette_new(example=example)
        assert bpy.ops.relume.palette_create() == {"FINISHED"}
    yield
    yield "palette_light.png"
"""
    )
    assert list(pictures) == ["palette_light.png"]
