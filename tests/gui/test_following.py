"""A scene that is set up follows its artist, in the window: edits, undo and redo, F12, another engine, a saved file.

Blender ends, rather than raise anything, where undo meets a data-block that came without a step of undo.
"""

PREPARE = """
import sys
import time

import bpy

FOLLOWER = next(module for name, module in sys.modules.items() if name.endswith("relume.addon.scene.follower"))


def event(kind, value, x, y, **options):
    bpy.context.window.event_simulate(type=kind, value=value, x=x, y=y, **options)


def press(key, x=500, y=300, **modifiers):
    event("MOUSEMOVE", "NOTHING", x, y)
    yield
    event(key, "PRESS", x, y, **modifiers)
    event(key, "RELEASE", x, y)
    yield


def area_of(kind):
    return next(area for area in bpy.context.screen.areas if area.type == kind)


def operate(operator, **settings):
    # As a button does: in the 3D view, and with a step of undo
    area = area_of("VIEW_3D")
    with bpy.context.temp_override(area=area, region=next(r for r in area.regions if r.type == "WINDOW")):
        assert operator("EXEC_DEFAULT", True, **settings) == {"FINISHED"}


def edited(words):
    bpy.ops.ed.undo_push(message=words)  # as Blender does after every edit of a property


def pause(seconds=0):
    # Some edits Blender tells nobody: they are seen within a second
    begin = time.monotonic()
    end = begin + 20
    while True:
        yield
        if time.monotonic() < begin + seconds:
            continue
        if not bpy.app.timers.is_registered(FOLLOWER.tick):
            return
        assert time.monotonic() < end, "the follower does not come to an end"


def undo(**shift):
    yield from press("Z", ctrl=True, **shift)
    yield from pause()


def prepare():
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 240, 135
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = 16, False, False
    cube = bpy.data.materials["Material"].node_tree.nodes["Principled BSDF"].inputs["Base Color"]
    cube.default_value = (0.8, 0.8, 0.8, 1.0)
    edited("prepared")


def roles(tree):
    groups = [node.node_tree for node in tree.nodes if getattr(node, "node_tree", None)]
    return sorted(tree["relume_role"] for tree in groups if "relume_role" in tree)


def make_the_cube_red():
    tree = bpy.data.materials["Material"].node_tree
    socket = tree.nodes["Principled BSDF"].inputs["Base Color"]
    if socket.is_linked:  # the panel then shows the colour of the node before it
        socket = socket.links[0].from_node.inputs[0]
    socket.default_value = (0.8, 0.02, 0.02, 1.0)
    edited("the cube is red")


def add_a_lamp():
    operate(bpy.ops.object.light_add, type="POINT", location=(2, -4, 3))


def make_the_lamp_red():
    light = bpy.data.lights["Point"]
    light.color, light.energy = (1.0, 0.1, 0.1), 300.0
    edited("the lamp is red")


def passes():
    return [layer for layer in bpy.context.scene.view_layers if "relume_pass" in layer]


def samples():
    return sum(layer.get("relume_cycles_sample_subset_length", 0) for layer in passes())


def check(cube=True, lamp=True, red=True, total=256):
    # What the scene carries is what its artist's edits ask for
    scene, lights = bpy.context.scene, bpy.data.lights
    assert scene.relume.is_set_up and scene.relume.problem == "", scene.relume.problem
    assert roles(bpy.data.materials["Material"].node_tree) == ["upsample"] * cube, "the cube"
    assert roles(lights["Light"].node_tree) == ["light"], "the lamp of before"
    assert ("Point" in lights and bool(lights["Point"].users)) == lamp
    if lamp:
        assert roles(lights["Point"].node_tree) == ["light"], "the lamp"
        (node,) = [n for n in lights["Point"].node_tree.nodes if n.type == "GROUP"]
        assert tuple(lights["Point"].color) == (1.0, 1.0, 1.0), "its colour stands in its node"
        assert (node.inputs["Tint"].default_value[1] < 0.2) == red, "and there it is"
    drivers = {curve.data_path for curve in scene.animation_data.drivers}
    assert drivers == {"cycles.sample_offset", "cycles.sample_subset_length"}, drivers
    assert len(passes()) == scene.relume.model().passes and samples() == total, samples()
    assert [node.layer for node in scene.compositing_node_group.nodes if node.type == "R_LAYERS"] == [
        layer.name for layer in passes()
    ]
"""

EDITS = (
    PREPARE
    + """
SAMPLES = (1123, 512)  # in render properties that fill the window


def click(x, y):
    event("MOUSEMOVE", "NOTHING", x - 3, y)
    event("MOUSEMOVE", "NOTHING", x, y)
    yield
    event("LEFTMOUSE", "PRESS", x, y)
    event("LEFTMOUSE", "RELEASE", x, y)
    yield


def raise_samples():
    area = area_of("PROPERTIES")
    area.spaces.active.context = "RENDER"
    with bpy.context.temp_override(area=area):
        bpy.ops.screen.screen_full_area()
    yield
    yield from click(*SAMPLES)
    for key, letter in (("TWO", "2"), ("FIVE", "5"), ("SIX", "6"), ("RET", "")):
        event(key, "PRESS", *SAMPLES, unicode=letter)
        event(key, "RELEASE", *SAMPLES)
    yield
    yield "1_samples.png"
    bpy.ops.screen.back_to_previous()


def steps():
    prepare()
    operate(bpy.ops.relume.set_up)
    yield from pause()
    check(cube=False, lamp=False, total=16)
    make_the_cube_red()
    yield from pause()
    check(lamp=False, total=16)
    add_a_lamp()
    yield from pause()
    make_the_lamp_red()
    yield from pause()
    check(total=16)
    yield from raise_samples()
    yield from pause()
    assert bpy.context.scene.cycles.samples == 256
    check()
    yield "2_edited.png"

    yield from undo()
    check(total=16)
    yield from undo()
    check(red=False, total=16)
    yield from undo()
    check(lamp=False, total=16)
    yield from undo()
    check(cube=False, lamp=False, total=16)
    yield from undo()
    scene = bpy.context.scene
    assert not scene.relume.is_set_up and scene.render.engine == "BLENDER_EEVEE" and len(scene.view_layers) == 1
    yield "3_undone.png"
    for kept in ({"cube": False, "lamp": False}, {"lamp": False}, {"red": False}, {}):
        yield from undo(shift=True)
        check(**kept, total=16)
    yield from undo(shift=True)
    check()
    yield "4_redone.png"
"""
)


def test_edits_undo_and_redo(window):
    assert len(window(EDITS, "--enable-event-simulate")) == 4


ELSEWHERE = (
    PREPARE
    + """
import tempfile
from pathlib import Path

BACK = (1165, 751)  # Back to Cycles, in the sidebar


def open_sidebar():
    area = area_of("VIEW_3D")
    area.spaces.active.show_region_ui = True
    yield
    next(region for region in area.regions if region.type == "UI").active_panel_category = "Relume"
    yield


def click(x, y):
    event("MOUSEMOVE", "NOTHING", x, y)
    yield
    event("LEFTMOUSE", "PRESS", x, y)
    event("LEFTMOUSE", "RELEASE", x, y)
    yield


def sources():
    return sorted({layer["relume_pass"] for layer in passes()}), len(passes())


def steps():
    prepare()
    yield from open_sidebar()
    scene = bpy.context.scene
    scene.world, scene.relume.channels = None, "6"  # the lamp is alone in its light group
    operate(bpy.ops.relume.set_up)
    yield from pause()
    assert len(passes()) == 2

    scene.render.engine = "BLENDER_EEVEE"
    edited("EEVEE")
    yield from pause()
    assert not passes()
    yield "1_another_engine.png"
    yield from click(*BACK)
    yield from pause()
    assert bpy.context.scene.render.engine == "CYCLES" and len(passes()) == 2
    yield "2_back.png"

    operate(bpy.ops.scene.view_layer_add, type="NEW")
    yield from pause(1.5)
    assert len(passes()) == 4, "the new view layer has passes of its own"
    yield from undo()
    assert len(passes()) == 2
    yield from undo(shift=True)
    assert len(passes()) == 4
    yield from undo()

    light = bpy.data.lights["Light"]
    light.use_temperature, light.temperature = True, 2700.0
    edited("a black body")
    yield from pause()
    assert bpy.context.scene.relume.light_groups[0].illuminant == "Planckian 2700 K"
    yield "3_black_body.png"
    yield from undo()
    assert bpy.context.scene.relume.light_groups[0].illuminant == "D65"
    yield from undo(shift=True)
    assert bpy.context.scene.relume.light_groups[0].illuminant == "Planckian 2700 K"

    first = bpy.context.scene.name
    operate(bpy.ops.scene.new, type="FULL_COPY")
    yield from pause(1.5)
    bpy.context.scene.relume.light_groups[0].illuminant = "FL11"
    edited("another light in the copy")
    yield from pause()
    assert bpy.data.scenes[first].relume.light_groups[0].illuminant == "Planckian 2700 K"
    trees = [next(n for n in s.compositing_node_group.nodes if roles_of(n)).node_tree for s in bpy.data.scenes]
    assert trees[0] != trees[1], "each scene has its own recombination"
    yield "4_copied.png"

    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / "saved.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path)
        bpy.ops.wm.open_mainfile(filepath=path)
        yield from pause()
        assert bpy.context.scene.relume.light_groups[0].illuminant == "FL11" and bpy.context.scene.relume.problem == ""
        yield from open_sidebar()
        yield "5_opened.png"
        operate(bpy.ops.relume.remove)
        yield
        assert not passes()
        yield "6_removed.png"


def roles_of(node):
    return getattr(node, "node_tree", None) and node.node_tree.get("relume_role") == "recombination"
"""
)


def test_engines_layers_black_bodies_copies_and_files(window):
    assert len(window(ELSEWHERE, "--enable-event-simulate")) == 6
