"""From the zip to a relit picture as a newcomer does it: by clicks and keys alone, counted, listed and photographed.

The list is that of docs/blender.md.
"""

import json
from pathlib import Path

import OpenImageIO as oiio

ROOT = Path(__file__).resolve().parents[2]
ROOM = ROOT / "assets/room.blend"
MOST = 6

STEPS = """
import json
import time

import bpy

DONE = []  # what the artist did, in words
VIEW = (500, 400)


def send(kind, value, place, **options):
    main.event_simulate(type=kind, value=value, x=place[0], y=place[1], **options)


def point_at(place):
    send("MOUSEMOVE", "NOTHING", (place[0] - 3, place[1]))
    yield
    send("MOUSEMOVE", "NOTHING", place)
    yield


def click(what, place):
    DONE.append(what)
    yield from point_at(place)
    send("LEFTMOUSE", "PRESS", place)
    send("LEFTMOUSE", "RELEASE", place)
    yield


def press(what, key, place):
    DONE.append(what)
    yield from point_at(place)
    send(key, "PRESS", place)
    send(key, "RELEASE", place)
    yield


def type_and_enter(what, letters, place):
    DONE.append(what)
    for letter in letters:
        send(letter.upper(), "PRESS", place, unicode=letter)
        send(letter.upper(), "RELEASE", place)
        yield
    yield "first_5_typed.png"
    send("RET", "PRESS", place)
    send("RET", "RELEASE", place)
    yield


TAB, SET_UP, LAMP = (1299, 573), (1156, 590), (1165, 650)


def steps():
    global main
    main, began = bpy.context.window_manager.windows[0], time.monotonic()
    scene = bpy.context.scene
    assert not scene.relume.is_set_up
    yield "first_0_opened.png"
    yield from press("**N** over the 3D view: the sidebar", "N", VIEW)
    yield from click("the tab **Relume**", TAB)
    yield "first_1_panel.png"
    yield from click("**Set Up Spectral Render**", SET_UP)
    while not scene.relume.is_set_up:
        yield
    yield
    yield "first_2_set_up.png"
    yield from press("**F12**", "F12", VIEW)
    while len(bpy.context.window_manager.windows) < 2 or bpy.app.is_job_running("RENDER"):
        yield
    for _ in range(4):
        yield
    yield "first_3_rendered.png"
    yield from click("the illuminant of a light group", LAMP)
    yield "first_4_search.png"
    yield from type_and_enter("type *sod*, **Enter**", "sod", LAMP)
    for _ in range(6):
        yield
    yield "first_6_relit.png"
    assert scene.relume.light_groups[0].illuminant == "Sodium (low pressure)", scene.relume.light_groups[0].illuminant
    with open(FILE, "w") as file:
        json.dump({"steps": DONE, "seconds": round(time.monotonic() - began)}, file)
"""

LITTLE = """
import bpy

scene = bpy.context.scene
assert not scene.relume.is_set_up
scene.render.resolution_percentage = 50
scene.cycles.samples = 16
bpy.ops.wm.save_as_mainfile(filepath=FILE)
"""


def test_from_the_zip_to_a_relit_picture_in_six_steps(window, blender_app, tmp_path):
    scene = tmp_path / "room.blend"
    blender_app.python(LITTLE.replace("FILE", repr(str(scene))), ROOM)
    done = tmp_path / "done.json"
    pictures = window(STEPS.replace("FILE", repr(str(done))), scene, "--enable-event-simulate")
    found = json.loads(done.read_text(encoding="utf-8"))
    steps = found["steps"]
    print(f"{len(steps)} steps, {found['seconds']} s")
    assert len(steps) <= MOST
    listed = (ROOT / "docs/blender.md").read_text(encoding="utf-8")
    for number, step in enumerate(steps, 1):
        assert f"{number}. {step[:1].upper()}{step[1:]}" in listed, "docs/blender.md lists what was done"
    before, after = (_blue_in_the_render(pictures[name]) for name in ("first_3_rendered.png", "first_6_relit.png"))
    assert after < 0.8 * before, "the picture on the screen has another light"


def _blue_in_the_render(picture: Path) -> float:
    """Mean blue where the window of the render shows the middle of the room."""
    image = oiio.ImageBuf(str(picture))
    return oiio.ImageBufAlgo.computePixelStats(image, roi=oiio.ROI(110, 310, 660, 810, 0, 1, 0, 3)).avg[2]
