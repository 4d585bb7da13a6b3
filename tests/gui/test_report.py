"""The panels *Left Out* and *Report* in the real window, and a report that a second Blender makes."""

import json
import shutil
from pathlib import Path

ROOM = Path(__file__).resolve().parents[2] / "assets/room.blend"


def test_what_was_left_out_and_a_report(window, tmp_path):
    scene = tmp_path / "little.blend"
    shutil.copy(ROOM, scene)
    pictures = window(
        """
import sys

import bpy


def scroll_down():
    for _ in range(20):
        for kind in ("MOUSEMOVE", "WHEELDOWNMOUSE"):
            value = "NOTHING" if kind == "MOUSEMOVE" else "PRESS"
            bpy.context.window.event_simulate(type=kind, value=value, x=1150, y=400)
        yield
    bpy.context.window.event_simulate(type="MOUSEMOVE", value="NOTHING", x=500, y=400)


def steps():
    for name in ("VIEW3D_PT_relume_left_out", "VIEW3D_PT_relume_report"):
        panel = getattr(bpy.types, name)
        bpy.utils.unregister_class(panel)
        panel.bl_options = set()  # open
        bpy.utils.register_class(panel)
    area = next(area for area in bpy.context.screen.areas if area.type == "VIEW_3D")
    area.spaces.active.show_region_ui = True
    yield
    next(region for region in area.regions if region.type == "UI").active_panel_category = "Relume"
    bpy.context.scene.cycles.use_denoising = True
    assert bpy.ops.relume.set_up() == {"FINISHED"}
    for _ in range(4):
        yield
    yield from scroll_down()
    yield "left_out.png"
    bpy.context.window.event_simulate(type="MOUSEMOVE", value="NOTHING", x=600, y=500)
    yield
    bpy.ops.relume.report("INVOKE_DEFAULT")
    yield
    yield "report_dialog.png"
    for value in ("PRESS", "RELEASE"):
        bpy.context.window.event_simulate(type="ESC", value=value, x=600, y=500)
    yield
    assert bpy.ops.relume.report(percent=10, samples=4, folder=FOLDER) == {"FINISHED"}
    report = sys.modules["bl_ext.user_default.relume.addon.cli.background"].current()
    while report.is_running and report.part < 0.3:
        yield
    yield "report_running.png"
    while report.is_running:
        yield
    assert report.words == "done", report.words
    yield from scroll_down()
    yield "report_done.png"
""".replace("FOLDER", repr(str(tmp_path / "report"))),
        scene,
        "--enable-event-simulate",
    )
    assert list(pictures) == ["left_out.png", "report_dialog.png", "report_done.png", "report_running.png"]
    assert len({picture.read_bytes() for picture in pictures.values()}) == len(pictures), "one shows what another does"
    rows = json.loads((tmp_path / "report/report.json").read_text())["rows"]
    assert {"RGB", "9 channels", "automatic", "reference"} <= {row["name"] for row in rows}
