"""The asset library in the real application: there while the extension is enabled, gone afterwards, saved never."""


def test_the_library_is_offered_in_a_window_only(blender_app):
    blender_app.python("""
        import bpy
        assert "Relume" not in bpy.context.preferences.filepaths.asset_libraries
    """)


def test_assets_are_there_while_the_extension_is(window):
    pictures = window("""
        import addon_utils
        import bpy

        def steps():
            preferences = bpy.context.preferences
            libraries = preferences.filepaths.asset_libraries
            assert [entry.import_method for entry in libraries if entry.name == "Relume"] == ["APPEND"]
            preferences.is_dirty = False  # the driver has changed some
            area = next(a for a in bpy.context.screen.areas if a.type == "VIEW_3D")
            area.ui_type = "ASSETS"
            yield
            area.spaces.active.params.asset_library_reference = "Relume"
            yield
            yield
            yield "assets.png"
            name = next(n for n in preferences.addons.keys() if n.endswith(".relume"))
            addon_utils.disable(name)
            assert "Relume" not in libraries and not preferences.is_dirty
            addon_utils.enable(name)
            assert "Relume" in libraries
    """)
    assert list(pictures) == ["assets.png"]


DRAG = """
import bpy
from bpy_extras.view3d_utils import location_3d_to_region_2d

PAINT = "Red (ColorChecker)"


def event(kind, value, x, y):
    bpy.context.window.event_simulate(type=kind, value=value, x=int(x), y=int(y))


def region_of(area, kind="WINDOW"):
    return next(region for region in area.regions if region.type == kind)


def drag(start, end):
    for offset in (-2, 0):
        event("MOUSEMOVE", "NOTHING", start[0] + offset, start[1])
        yield
    event("LEFTMOUSE", "PRESS", *start)
    yield
    for part in (0.02, 0.1, 0.3, 0.6, 0.9, 1.0, 1.0):
        event("MOUSEMOVE", "NOTHING", *(a + part * (b - a) for a, b in zip(start, end)))
        yield
    event("LEFTMOUSE", "RELEASE", *end)
    yield


def place_of(view, thing):
    region = region_of(view)
    x, y = location_3d_to_region_2d(region, view.spaces.active.region_3d, thing.matrix_world.translation)
    return region.x + x, region.y + y


def spectrum_in(paint):
    trees = [node.node_tree for node in paint.node_tree.nodes if node.type == "GROUP"]
    return next(tree for tree in trees if tree.get("relume_role") == "spectrum")


def steps():
    scene, cube = bpy.context.scene, bpy.data.objects["Cube"]
    view = next(area for area in bpy.context.screen.areas if area.type == "VIEW_3D")
    with bpy.context.temp_override(area=view, region=region_of(view)):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=0.5)
    yield
    left, right = sorted((a for a in bpy.context.screen.areas if a.type == "VIEW_3D"), key=lambda area: area.x)
    left.ui_type = "ASSETS"
    yield
    browser = left.spaces.active
    browser.params.asset_library_reference = "Relume"
    browser.params.filter_search = PAINT
    for _ in range(6):
        yield
    tile = region_of(left)
    start = tile.x + 60, tile.y + tile.height - 60
    yield "listed.png"
    yield from drag(start, place_of(right, cube))
    for _ in range(4):
        yield
    paint = cube.active_material
    assert paint.name == PAINT, paint.name
    group = spectrum_in(paint)
    assert [node for node in group.nodes if node.type == "RGB"], "it shows its colour"
    assert "relume_filled" not in group, "and nothing else yet"
    scene.render.engine = "CYCLES"
    right.spaces.active.shading.type = "RENDERED"
    for _ in range(12):
        yield
    yield "not_set_up.png"
    right.spaces.active.shading.type = "SOLID"
    scene.relume.channels = "6"
    assert bpy.ops.relume.set_up() == {"FINISHED"}
    assert "relume_filled" in group
    browser.params.filter_search = "Foliage (ColorChecker)"
    for _ in range(6):
        yield
    yield from drag(start, place_of(right, cube))
    for _ in range(6):
        yield  # it follows once the artist pauses
    yield "set_up.png"
    assert cube.active_material.name == "Foliage (ColorChecker)", [paint.name for paint in bpy.data.materials]
    assert "relume_filled" in spectrum_in(cube.active_material), "it is spectral at once"
"""


def test_a_paint_is_dragged_onto_an_object(window):
    pictures = window(DRAG, "--enable-event-simulate")
    assert sorted(pictures) == ["listed.png", "not_set_up.png", "set_up.png"]
