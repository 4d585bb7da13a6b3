"""The palette editor as an artist meets it: two paints that match in daylight and part under tungsten.

Its pictures are those of docs/palette.md.
"""

STEPS = '''
import bpy


def event(kind, value, x, y, **options):
    bpy.context.window.event_simulate(type=kind, value=value, x=int(x), y=int(y), **options)


def click(x, y):
    event("MOUSEMOVE", "NOTHING", x - 2, y)
    event("MOUSEMOVE", "NOTHING", x, y)
    yield
    event("LEFTMOUSE", "PRESS", x, y)
    event("LEFTMOUSE", "RELEASE", x, y)
    yield


def press(key, x, y, **modifiers):
    event("MOUSEMOVE", "NOTHING", x, y)
    yield
    event(key, "PRESS", x, y, **modifiers)
    event(key, "RELEASE", x, y)
    yield


def area_of(kind):
    return next(area for area in bpy.context.screen.areas if area.type == kind)


def region_of(area, kind="UI"):
    return next(region for region in area.regions if region.type == kind)


def at(place, kind="VIEW_3D"):
    """A place from the upper right corner of the panel's region, at an interface scale of 1."""
    region = region_of(area_of(kind))
    return region.x + region.width + place[0], region.y + region.height + place[1]


def design():
    return bpy.context.scene.relume_palettes[bpy.context.scene.relume_palette_active]


def layout():
    # The 3D view with the palette on the left, the render on the right; nothing else in the tab
    for name in [name for name in dir(bpy.types) if name.startswith("VIEW3D_PT_relume") and "palette" not in name]:
        bpy.utils.unregister_class(getattr(bpy.types, name))
    panel = bpy.types.VIEW3D_PT_relume_palette
    bpy.utils.unregister_class(panel)
    panel.bl_options = set()
    bpy.utils.register_class(panel)
    area = area_of("VIEW_3D")
    area.spaces.active.show_region_ui = True
    with bpy.context.temp_override(area=area, region=region_of(area, "WINDOW")):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=0.6)
    yield
    left, right = sorted((a for a in bpy.context.screen.areas if a.type == "VIEW_3D"), key=lambda a: a.x)
    right.type = "IMAGE_EDITOR"
    left.spaces.active.show_region_ui = True
    yield
    region_of(left).active_panel_category = "Relume"
    yield


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


def render():
    bpy.ops.render.render()
    area = area_of("IMAGE_EDITOR")
    area.spaces.active.image = bpy.data.images["Render Result"]
    yield
    with bpy.context.temp_override(area=area, region=region_of(area, "WINDOW")):
        bpy.ops.image.view_all(fit_view=True)
    bpy.ops.ed.undo_push(message="Render")
    yield
'''


def test_two_paints_that_match_in_daylight_and_part_under_tungsten(window):
    window(
        STEPS
        + """
def steps():
    scene_of_two()
    yield from layout()
    bpy.ops.relume.palette_new(example="EMPTY")
    bpy.ops.relume.palette_add_designed(kind="REFLECTANCE")
    d = design()
    d.reflectances[0].name, d.reflectances[1].name = "left", "right"
    for row in d.reflectances:
        row.material = bpy.data.materials[row.name]
    bpy.ops.relume.palette_select(row=0, column=0)
    d.cells[0].target = (0.2, 0.21, 0.24)
    yield "palette_new.png"
    bpy.ops.relume.palette_add_demand(what="DIFFERENCE")
    d.differences[0].kind, d.differences[0].amount = "MOST", 0.1
    bpy.ops.relume.palette_select(row=0, column=1)
    bpy.ops.relume.palette_add_demand(what="DIFFERENCE")
    d.differences[1].amount = 20.0
    yield "palette_wanted.png"
    assert bpy.ops.relume.palette_create() == {"FINISHED"}
    bpy.ops.ed.undo_push(message="Create")
    yield "palette_created.png"
    scene = bpy.context.scene
    scene.relume.channels = "9"
    assert bpy.ops.relume.set_up() == {"FINISHED"}
    assert bpy.ops.relume.palette_assign() == {"FINISHED"}
    bpy.ops.relume.palette_select(column=0)
    assert bpy.ops.relume.palette_assign_lights(group="lamp") == {"FINISHED"}
    yield from render()
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
RIGHT_PATCH, LEFT_PATCH = (-85, -229), (-166, -229)
FIT, FIT_BELOW, CREATE, DESIGNED = (-214, -398), (-214, -421), (-147, -550), (-97, -444)


def steps():
    yield from layout()
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
    yield from layout()
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
