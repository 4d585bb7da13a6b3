"""In a window each render denoises once, and changes of light after it nothing; no file and no render knows of it."""

from pathlib import Path

from .test_following import PREPARE

ROOM = Path(__file__).resolve().parents[2] / "assets/room.blend"

STEPS = (
    PREPARE
    + """
import tempfile
from pathlib import Path

import numpy as np

FOLDER = Path(tempfile.mkdtemp())


def render():
    assert bpy.ops.render.render("INVOKE_DEFAULT") in ({"RUNNING_MODAL"}, {"FINISHED"})
    begin = time.monotonic()
    while bpy.app.is_job_running("RENDER") or time.monotonic() < begin + 1.0:
        yield
    yield from shown()


def shown():
    # As long as it takes to follow, and to composite what is shown
    yield from pause(1.5)
    while bpy.app.is_job_running("COMPOSITE"):
        yield


def picture():
    scene, path = bpy.context.scene, str(FOLDER / "shown.exr")
    scene.render.image_settings.file_format = "OPEN_EXR"
    bpy.data.images["Render Result"].save_render(path, scene=scene)
    image = bpy.data.images.load(path, check_existing=False)
    values = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(values)
    bpy.data.images.remove(image)
    return values.reshape(-1, 4)[:, :3]


def fed_by():
    # What kind of node gives the recombination its coefficients
    tree = bpy.context.scene.compositing_node_group
    trees = {n: getattr(n, "node_tree", None) for n in tree.nodes}
    (node,) = [n for n, group in trees.items() if group and group["relume_role"] == "recombination"]
    return {socket.links[0].from_node.type for socket in node.inputs if socket.name != "Alpha"}


def writers():
    return [n for n in bpy.context.scene.compositing_node_group.nodes if n.type == "OUTPUT_FILE"]


def light(name):
    row = bpy.context.scene.relume.light_groups[0]
    row.source, row.illuminant = "LIBRARY", name
    edited(f"lit by {name}")
    yield from shown()


def steps():
    scene = bpy.context.scene
    bpy.context.preferences.view.render_display_type = "AREA"
    scene.render.resolution_percentage, scene.cycles.samples = 25, 8
    scene.cycles.use_denoising, scene.relume.channels = True, "9"
    scene.relume.light_groups.clear()
    operate(bpy.ops.relume.set_up)
    yield from pause()
    assert fed_by() == {"GROUP"}
    yield from render()
    assert fed_by() == {"IMAGE"} and not writers(), "what was denoised is kept"
    first = picture()
    edited("rendered")  # a step of before knows no Render Result
    yield "1_rendered.png"

    yield from light("Sodium (low pressure)")
    sodium = picture()
    assert np.abs(sodium - first).max() > 0.1
    yield "2_sodium.png"

    path = str(FOLDER / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
    with bpy.data.libraries.load(path) as (held, _):
        assert not [name for name in held.images if "Relume" in name], held.images
    assert fed_by() == {"IMAGE"}, "after it was saved too"

    yield from undo()
    yield from shown()
    assert fed_by() == {"IMAGE"} and np.abs(picture() - first).max() < 1e-5
    yield from undo(shift=True)
    yield from shown()
    assert fed_by() == {"IMAGE"} and np.abs(picture() - sodium).max() < 1e-5

    yield from render()
    again = picture()
    assert np.abs(again - sodium).max() < 1e-3 * sodium.max(), "a render denoises as the kept coefficients were"

    scene = bpy.context.scene
    scene.cycles.samples = 9
    edited("other samples")
    yield from shown()
    assert fed_by() == {"IMAGE"}, "until the next render"
    scene.cycles.use_denoising = False
    edited("no denoising")
    yield from shown()
    assert fed_by() == {"GROUP"}, "noise of colour is taken out of what was not kept"
    yield from render()
    assert fed_by() == {"IMAGE"}
    yield "3_without.png"
    scene.relume.reduce_color_noise = False
    edited("all noise")
    yield from shown()
    assert fed_by() == {"R_LAYERS"}
    scene.cycles.use_denoising = True
    edited("denoising")
    yield from shown()
    assert fed_by() == {"GROUP"}

    scene.frame_start, scene.frame_end = 1, 2
    scene.render.filepath = str(FOLDER / "frame")
    assert bpy.ops.render.render("INVOKE_DEFAULT", animation=True) in ({"RUNNING_MODAL"}, {"FINISHED"})
    yield
    while bpy.app.is_job_running("RENDER"):
        yield
    yield from shown()
    assert fed_by() == {"GROUP"} and not writers(), "an animation keeps nothing"

    yield from render()
    assert fed_by() == {"IMAGE"}
    assert bpy.ops.relume.remove() == {"FINISHED"} and scene.compositing_node_group is None
    assert not [image for image in bpy.data.images if "Relume" in image.name]
    assert bpy.ops.relume.set_up() == {"FINISHED"}
    yield from pause()
    yield from render()
    assert fed_by() == {"IMAGE"}
    (module,) = [name for name in bpy.context.preferences.addons.keys() if name.endswith("relume")]
    bpy.ops.preferences.addon_disable(module=module)
    assert fed_by() == {"GROUP"}, "without the add-on the file is as it is saved"
    yield "4_disabled.png"
"""
)


def test_a_light_is_changed_without_denoising_again(window):
    assert len(window(STEPS, str(ROOM), "--enable-event-simulate")) == 4
