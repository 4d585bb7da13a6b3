"""`relume report`: error against run time, resumable, with the planner's choice among the rows."""

import json

import bpy
import pytest

from relume.addon import commands

ARGUMENTS = ("--channels", "6", "--models", "rgb", "fitted", "--samples", "4", "--percent", "6")


@pytest.fixture
def reported(room, tmp_path):
    scene = tmp_path / "little.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(scene))
    arguments = ["report", str(scene), *ARGUMENTS, "--out", str(tmp_path / "out")]
    assert commands.execute(arguments) == 0
    return arguments, tmp_path / "out"


def rows_of(folder):
    return {row["name"]: row for row in json.loads((folder / "report.json").read_text())["rows"]}


def test_more_channels_err_less_and_take_more_passes(reported):
    _, folder = reported
    rows = rows_of(folder)
    assert set(rows) == {"RGB", "6 channels", "automatic", "reference"}
    assert rows["RGB"]["model"]["p98"] > 2 * rows["6 channels"]["model"]["p98"] > 0
    assert rows["reference"]["model"]["max"] == 0
    assert [rows[name]["passes"] for name in ("RGB", "6 channels", "reference")] == [1, 2, 12]
    assert all(row["noise"] > 0 and row["seconds"] > 0 for row in rows.values())
    for name in ("report.md", "error_over_time.png", "delta_e.png", "side_by_side.png"):
        assert (folder / name).stat().st_size > 500


def test_a_stopped_report_goes_on_where_it_was(reported, capfd):
    arguments, folder = reported
    before = rows_of(folder)
    next((folder / "renders").glob("6_channels-*.json")).unlink()
    capfd.readouterr()
    assert commands.execute(arguments) == 0
    told = capfd.readouterr().err
    assert "6 channels" in told and "RGB" not in told
    after = rows_of(folder)
    assert after["RGB"] == before["RGB"]
    assert after["6 channels"]["model"] == before["6 channels"]["model"]


def test_a_changed_scene_is_rendered_anew(reported, capfd):
    arguments, folder = reported
    bpy.ops.wm.open_mainfile(filepath=arguments[1])
    bpy.context.scene.camera.location.x += 0.1
    bpy.ops.wm.save_mainfile()
    capfd.readouterr()
    assert commands.execute(arguments) == 0
    assert "RGB" in capfd.readouterr().err
