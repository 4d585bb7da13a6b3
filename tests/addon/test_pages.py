"""What docs/ten_minutes.md and docs/sunset.md tell an artist to do, step by step."""

import re
from pathlib import Path

import bpy
import numpy as np

from relume.addon.cli import commands
from relume.addon.graph import places
from relume.addon.ui import material_panel, translation
from relume.assets import make_room, still_life
from relume.core.picture import exr

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "sunset.md").read_text(encoding="utf-8")


def keyframes():
    """(frame, window's temperature, window's EV, candle's EV) of each row of the page's table."""
    rows = re.findall(r"^\| (\d+) \| (\d+) \| (\S+) \| (\S+) \| .* \|$", PAGE, re.MULTILINE)
    return [tuple(float(cell.replace("−", "-")) for cell in row) for row in rows]


def test_ten_minutes():
    page = (DOCS / "ten_minutes.md").read_text(encoding="utf-8")
    bpy.ops.wm.open_mainfile(filepath=str(make_room.PATH), load_ui=False)
    scene = bpy.context.scene
    assert bpy.ops.relume.set_up() == {"FINISHED"}
    assert scene.relume.model().passes == 2 and "renders two passes" in page
    row = scene.relume.light_groups["tungsten"]
    row.illuminant = "Sodium (low pressure)"
    assert translation.illuminant(row.label).startswith("Street lamp, sodium") and not scene.relume.problem
    scene.relume.white_balance = 1.0
    assert not scene.relume.problem, "with the fluorescent tube there is white to balance"

    material = bpy.data.materials["green plastic"]
    node, socket = re.search(r"the one of \*(.*): (.*)\*, type", page).groups()
    shown, chosen = re.search(r"Click \*(.*)\*, the one .* choose \*(.*)\*, and", page).groups()
    here = (node, material.node_tree.nodes[node].inputs[socket].identifier, places.REFLECTANCE)
    assert here in places.of(material) and places.chosen_at(material.node_tree.nodes[node], *here[1:]) == shown
    material_panel.assign_from_library(material, material.node_tree.nodes[node], *here[1:], chosen)
    assert places.chosen_at(material.node_tree.nodes[node], *here[1:]) == chosen


def test_animate_a_sunset(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    bpy.ops.wm.open_mainfile(filepath=str(still_life.PATH), load_ui=False)
    scene = bpy.context.scene
    scene.render.resolution_percentage, scene.cycles.samples = 2, 4
    assert bpy.ops.relume.set_up() == {"FINISHED"}
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "evening.blend"))
    (command,) = re.findall(r"^    relume (.*)$", PAGE, re.MULTILINE)
    assert commands.execute(command.split()) == 0

    bpy.ops.wm.read_factory_settings()
    assert bpy.ops.relume.relight_exr(filepath=str(tmp_path / "evening.exr")) == {"FINISHED"}
    scene = bpy.context.scene
    window, candle = (scene.relume.light_groups[name] for name in ("window", "candle"))
    assert all(scene.relume.light_groups[name].mute for name in ("bulb", "tube")), "the eye is closed"
    window.source = candle.source = "PLANCKIAN"
    candle.temperature = 1900
    table = keyframes()
    assert [row[0] for row in table] == [1, 60, 90, 120]
    for frame, temperature, window_stops, candle_stops in table:
        window.temperature, window.stops, candle.stops = temperature, window_stops, candle_stops
        for row, name in ((window, "temperature"), (window, "stops"), (candle, "stops")):
            row.keyframe_insert(name, frame=frame)

    scene.frame_end, scene.frame_step = 120, 59  # frames 1, 60 and 119
    scene.render.filepath = str(tmp_path / "out/evening_")
    bpy.ops.render.render(animation=True, scene=scene.name)
    noon, low_sun, night = (exr.read_rgb(path) for path in sorted((tmp_path / "out").glob("*.png")))
    left, right = np.s_[:, :10], np.s_[:, -10:]
    assert low_sun[left].mean(axis=(0, 1))[2] < 0.7 * noon[left].mean(axis=(0, 1))[2], "the window turns red"
    assert night[right].mean() / night[left].mean() > 1.5 * noon[right].mean() / noon[left].mean(), "the candle is left"
