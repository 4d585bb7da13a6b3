"""`relume report`: error against run time, resumable, with the planner's choice among the rows."""

import json
import shutil
import subprocess
import sys
import types

import bpy
import numpy as np
import pytest

from relume.addon.cli import background, commands
from relume.addon.scene import setup
from relume.addon.ui import left_out
from relume.core.picture import coefficients

ARGUMENTS = ("--channels", "6", "--models", "rgb", "fitted", "--samples", "4", "--percent", "6")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The folder of the one report that every test gets a copy of."""
    return tmp_path_factory.mktemp("report")


@pytest.fixture
def reported(room, made, tmp_path):
    """A report of a small room, whole: the words that made it, and its folder."""
    scene = made / "little.blend"
    if not scene.exists():
        bpy.ops.wm.save_as_mainfile(filepath=str(scene))
        assert commands.execute(["report", str(scene), *ARGUMENTS, "--out", str(made / "out")]) == 0
    shutil.copytree(made, tmp_path, dirs_exist_ok=True)
    return ["report", str(tmp_path / "little.blend"), *ARGUMENTS, "--out", str(tmp_path / "out")], tmp_path / "out"


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
    text = (folder / "report.md").read_text()
    assert "](error_over_time.svg)" in text and "9 channels" not in (folder / "error_over_time.svg").read_text()
    for name in ("delta_e.png", "side_by_side.png"):
        assert f"]({name})" in text
        picture = coefficients.read_rgb(folder / name)
        assert (np.ptp(picture, axis=2) > 0.1).any(), f"{name} has no colour"


def test_a_stopped_report_goes_on_where_it_was(reported, capfd):
    arguments, folder = reported
    before = rows_of(folder)
    next((folder / "renders").glob("6_channels-*.json")).unlink()
    capfd.readouterr()
    assert commands.execute(arguments) == 0
    printed = capfd.readouterr().err
    assert "6 channels" in printed and "RGB" not in printed
    after = rows_of(folder)
    assert after["RGB"] == before["RGB"]
    assert after["6 channels"]["model"] == before["6 channels"]["model"]


def test_what_is_damaged_is_named_and_made_again(reported, capfd):
    arguments, folder = reported
    before = rows_of(folder)
    image = next((folder / "renders").glob("RGB-*.exr"))
    row = next((folder / "renders").glob("RGB-*.json"))
    whole = image.read_bytes()
    for data in (whole[: len(whole) // 2], whole[:100], b""):
        image.write_bytes(data)
        row.write_bytes(row.read_bytes()[:40])
        (folder / "renders" / ".relume-00000000-00000000.lock").touch()
        capfd.readouterr()
        assert commands.execute(arguments) == 0
        printed = [line for line in capfd.readouterr().err.splitlines() if line.startswith("relume: ")]
        assert f"{image}: damaged, and made again" in printed[0] and f"{row}: damaged, and made again" in printed[1]
        assert printed[2:] == ["relume: 3 passes to render"]
        assert image.read_bytes() == whole
    assert rows_of(folder)["RGB"]["model"] == before["RGB"]["model"]
    assert not [path for path in folder.rglob(".*") if "00000000" not in path.name]


def test_a_killed_report_leaves_nothing_that_a_rerun_does_not_mend(reported, tmp_path):
    arguments, folder = reported
    expected = {path.name: path.read_bytes() for path in folder.rglob("*.exr")}
    other = tmp_path / "other"
    command = "from relume.__main__ import main; main()"
    for passes in (1, 3, 8):
        process = subprocess.Popen(
            [sys.executable, "-c", command, *arguments[:-1], str(other)], stderr=subprocess.PIPE, text=True
        )
        for line in process.stderr:
            passes -= "pass" in line
            if not passes:
                break
        process.kill()
        process.wait()
        process.stderr.close()
    assert commands.execute([*arguments[:-1], str(other)]) == 0
    assert {path.name: path.read_bytes() for path in other.rglob("*.exr")} == expected
    found, whole = rows_of(other), rows_of(folder)
    assert found.keys() == whole.keys()
    for name in whole:  # BLAS does not promise the same last bit twice
        assert found[name]["model"] == pytest.approx(whole[name]["model"], rel=1e-9, abs=1e-12)
    assert not list(other.rglob(".*"))


def test_a_changed_scene_is_rendered_anew(reported, capfd):
    arguments, folder = reported
    bpy.ops.wm.open_mainfile(filepath=arguments[1])
    bpy.context.scene.camera.location.x += 0.1
    bpy.ops.wm.save_mainfile()
    capfd.readouterr()
    assert commands.execute(arguments) == 0
    assert "RGB" in capfd.readouterr().err


def test_without_matplotlib_there_are_plain_pictures(reported, monkeypatch, capfd):
    arguments, folder = reported
    monkeypatch.setitem(sys.modules, "matplotlib", types.ModuleType("matplotlib"))  # what colour-science leaves there
    capfd.readouterr()
    assert commands.execute(arguments) == 0
    assert "relume: 0 passes to render" in capfd.readouterr().err
    text = (folder / "report.md").read_text()
    assert all(f"]({name}.png)" in text for name in ("RGB", "automatic", "reference"))
    rgb, automatic, reference = (coefficients.read_rgb(folder / f"{n}.png") for n in ("RGB", "automatic", "reference"))
    assert np.abs(automatic - reference).mean() < np.abs(rgb - reference).mean() / 2
    assert "](error_over_time.svg)" in text and "renders nothing again" in text


def test_the_button_needs_a_saved_file(startup):
    with pytest.raises(RuntimeError, match="save the file first"):
        bpy.ops.relume.report()


def test_the_button_makes_a_report_beside_blender(room, tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "little.blend"))
    room.relume.channels = "3"
    assert bpy.ops.relume.report(percent=4, samples=3, folder=str(tmp_path / "out")) == {"FINISHED"}
    report = background.current()
    assert report.is_running and not bpy.ops.relume.report.poll()
    assert room.relume.channels == "3", "what the artist goes on with stays"
    report.wait(300)
    assert report.words == "done", report.words
    assert report.part == 1.0
    assert {"RGB", "9 channels", "automatic", "reference"} <= {row["name"] for row in report.rows}
    assert (tmp_path / "out/report.md").is_file()


def test_a_report_that_fails_says_why(room, tmp_path):
    (tmp_path / "out").write_text("a file in the way")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "little.blend"))
    bpy.ops.relume.report(percent=4, samples=3, folder=str(tmp_path / "out"))
    report = background.current()
    report.wait(60)
    assert "out: cannot write there" in report.words and not report.rows


def test_a_report_can_be_stopped(room, tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "little.blend"))
    bpy.ops.relume.report(percent=100, folder=str(tmp_path / "out"))
    bpy.ops.relume.stop_report()
    report = background.current()
    report.wait(60)
    assert not report.is_running and report.words.startswith("stopped")
    assert not (tmp_path / "out/report.md").exists()


def test_what_was_left_out_and_what_it_would_cost(room):
    room.relume.channels = "auto"
    room.view_layers[0].use_pass_z = room.view_layers[0].use_pass_normal = True
    bpy.data.materials.new("unseen").use_fake_user = True
    setup.set_up(room)
    passes = room.relume.model().passes
    costs = {row.what: row.cost for row in left_out.work_out(room)}
    finer = next(iter(costs))
    assert int(finer.split()[0]) == 3 * (passes + 1), "the next model has a pass more"
    assert costs[finer].startswith("1 more pass and") and "ΔE 0." in costs[finer]
    assert f"{12 - passes} more passes" in costs["the reference, 36 bands"]
    assert "MB" in costs["2 other render passes, in all view layers but the first"]
    assert "1 material that this scene does not show" in costs
