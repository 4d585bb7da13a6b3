"""Commands as they are typed: from the scene's own folder, again after a kill, two at once; numbers out of range."""

import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import time

import bpy
import numpy as np
import pytest

from relume.addon.cli import commands
from relume.addon.host import console
from relume.addon.scene import render, setup
from relume.core import results
from relume.core.picture import coefficients, expectation
from relume.core.spectra import files, library
from relume.core.spectra.spectrum import WAVELENGTHS, Spectrum

CHEAP = ("--channels", "3")
COMMAND = (sys.executable, "-m", "relume")


@pytest.fixture
def typed(room, tmp_path, monkeypatch):
    """A small room in the folder in which one stands."""
    room.cycles.samples = 2
    room.cycles.use_denoising = False
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "little.blend"))
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def home(typed, monkeypatch):
    (typed / "home").mkdir()
    monkeypatch.setenv("HOME", str(typed / "home"))
    return typed


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The folder of the one render that every test gets a copy of."""
    return tmp_path_factory.mktemp("rendered")


@pytest.fixture
def rendered(typed, made, monkeypatch):
    """The same folder, with the small room rendered in it."""
    if not any(made.iterdir()):
        shutil.copy2(typed / "little.blend", made)
        with monkeypatch.context() as there:
            there.chdir(made)
            assert commands.execute(["render", "little.blend", *CHEAP]) == 0
    shutil.copytree(made, typed, dirs_exist_ok=True)
    return typed


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def said(capfd) -> list[str]:
    """What was said, but for what every picture is expected to be."""
    lines = capfd.readouterr().err.splitlines()
    return [line for line in lines if line.startswith("relume") and " expected, " not in line]


def digests(folder) -> dict[str, str]:
    """Of what is the same in every run; summary.json holds how long it took."""
    found = {path.name: path for path in folder.iterdir() if path.is_file() and path.name != "summary.json"}
    return {name: hashlib.sha256(path.read_bytes()).hexdigest() for name, path in found.items()}


FRAME = ["little.exr", "little_A+FL2.png", "summary.json"]


@pytest.mark.parametrize(
    ("out", "folder"),
    [
        ([], "."),
        (["--out", "."], "."),
        (["--out", "./x"], "x"),
        (["--out", "a/b/c/"], "a/b/c"),
        (["--out=~/x"], "home/x"),
        (["--out", "//x"], "x"),
        (["--out", "mit Ümlaut \"und\" 'so'"], "mit Ümlaut \"und\" 'so'"),
        (["--out", "{braces} #1"], "{braces} #1"),
        (["--out=-x"], "-x"),
    ],
)
def test_folders_as_people_type_them(home, capfd, out, folder):
    assert commands.execute(["render", "little.blend", *CHEAP, *out]) == 0
    assert set(names(home / folder)) - {"little.blend", "home"} == set(FRAME)
    assert coefficients.read(home / folder / "little.exr").size == (48, 36)
    printed = capfd.readouterr().out.splitlines()
    assert [os.path.basename(line) for line in printed] == FRAME, "nothing but what was written"
    assert all(os.path.exists(line) for line in printed)


@pytest.mark.parametrize("name", ["./-x.blend", "mit Ümlaut \"und\" 'so'.blend", "~/x.blend", "{b} #1.blend"])
def test_scenes_as_people_type_them(home, name):
    path = home / name.replace("~", "home")
    (home / "little.blend").rename(path)
    assert commands.execute(["render", name, *CHEAP]) == 0
    assert (home / f"{path.stem}.exr").is_file()


def test_a_leading_dash_after_two(typed):
    (typed / "little.blend").rename(typed / "-x.blend")
    assert commands.execute(["render", *CHEAP, "--", "-x.blend"]) == 0
    assert (typed / "-x.exr").is_file()


@pytest.mark.parametrize("out", ["evening.png", "./evening.png", "~/evening.png", "new/evening.exr", "a b/ü.tif"])
def test_pictures_as_people_type_them(home, rendered, out):
    assert commands.execute(["relight", "little.exr", "--light", "tungsten=D65*2", f"--out={out}"]) == 0
    path = rendered / out.replace("~", "home")
    assert coefficients.read_rgb(path).shape == (36, 48, 3)
    assert names(path.parent)[0][0] != "."


def test_light_of_a_file_of_spectra(home, rendered, capsys):
    lamps = {"warm": library.illuminant("A").sampled(), "cool": library.illuminant("FL2").sampled()}
    files.write("lamps.csv", [Spectrum(WAVELENGTHS, power, name, "illuminant") for name, power in lamps.items()])
    for light, out in (("tungsten=FL2*0.5", "named.exr"), ("tungsten=lamps.csv#cool*0.5", "filed.exr")):
        assert commands.execute(["relight", "little.exr", "--light", light, "--out", out]) == 0
    named, filed = (coefficients.read_rgb(rendered / name) for name in ("named.exr", "filed.exr"))
    np.testing.assert_allclose(filed, named, rtol=1e-4, atol=1e-6)
    assert commands.execute(["relight", "little.exr", "--light", "tungsten=lamps.csv#blue", "--out", "x.png"]) == 1
    assert "lamps.csv has no column 'blue'; it has warm, cool" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "status", "words"),
    [
        (["render", "little.blend", "--out", "{blend_name}"], 2, "{blend_name} is filled in by Blender only"),
        (["render", "little.blend", "--out", "evening.png"], 1, "evening.png: expected a folder"),
        (["render", "little.blend", "--out", "little.blend"], 1, "little.blend: cannot write there (it is a file"),
        (["render", "."], 1, ".: is a folder; expected a .blend file"),
        (["render", "/dev/null"], 1, "/dev/null: is a device or a pipe"),
        (["render", "\udcff.blend"], 2, "names in UTF-8"),
        (["render", "little.blend", "--frame", "1-1000000000000"], 2, "1000000000000 is more than 1048574"),
        (["render", "little.blend", "--frame", "-1048575"], 2, "-1048575 is not -1048574 or more"),
        (["render", "little.blend", "--frame", "5-3"], 2, "the last frame comes before the first"),
        (["render", "little.blend", "--frame", "1_0"], 2, "is not a frame or frames"),
        (["render", "little.blend", "--frame", "9" * 5000], 2, "is more than 1048574"),
        (["render", "little.blend", "--samples", "1_0"], 2, "is not a whole number from 1 to 16777216"),
        (["render", "little.blend", "--samples", "16777217"], 2, "is more than 16777216"),
        (["render", "little.blend", "--illuminant", "D65", "D65", "d65"], 1, "d65"),
        (["report", "little.blend", "--percent", "0"], 2, "0 is not 1 or more"),
        (["report", "little.blend", "--channels", "82"], 2, "82 is more than 81"),
        (["report", "little.blend", "--frame", "99999999"], 2, "99999999 is more than 1048574"),
        *(
            (
                ["relight", "little.exr", "--light", f"tungsten=A*{gain}", "--out", "x.png"],
                1,
                "a number from 0 to 1000000",
            )
            for gain in ("nan", "inf", "1e300", "-1", "1_0", "", "٣")
        ),
        (["relight", "little.exr", "--white", "nan", "--out", "x.png"], 2, "a number from 0 to 1"),
        (["relight", "little.exr", "--out", "//x.png"], 1, "none is open here"),
        (["relight", "little.exr", "--out", "little.exr"], 1, "little.exr: holds coefficients to be relit"),
        (["relight", "little.exr", "--out", "sub/../little.exr"], 1, "holds coefficients to be relit"),
        (["relight", "little.exr", "--out", "soft.exr"], 1, "soft.exr: holds coefficients to be relit"),
        (["relight", "little.exr", "--out", "hard.exr"], 1, "hard.exr: holds coefficients to be relit"),
        (["relight", "soft.exr", "--out", "little.exr"], 1, "little.exr: holds coefficients to be relit"),
        (["relight", "little.exr", "--out", "folder.png"], 1, "folder.png: is a folder"),
        (["relight", "little.exr", "--out", "little.blend/x.png"], 1, "little.blend: cannot write there"),
    ],
)
def test_what_cannot_be_is_one_line(rendered, capfd, arguments, status, words):
    (rendered / "soft.exr").symlink_to("little.exr")
    os.link(rendered / "little.exr", rendered / "hard.exr")
    (rendered / "folder.png").mkdir()
    (rendered / "sub").mkdir()
    bpy.ops.wm.read_factory_settings()
    before, listed = digests(rendered), names(rendered)
    capfd.readouterr()
    assert commands.execute(arguments) == status
    printed = said(capfd)
    assert words in printed[-1]
    assert status == 2 or len(printed) == 1
    assert (digests(rendered), names(rendered)) == (before, listed)


@pytest.mark.parametrize("frames", ["-2", "-2--1", "-1-0"])
def test_negative_frames(typed, frames):
    assert commands.execute(["render", "little.blend", *CHEAP, "--frame", frames]) == 0
    found = [each["frame"] for each in json.loads((typed / "summary.json").read_text())["frames"]]
    assert found == {"-2": [-2], "-2--1": [-2, -1], "-1-0": [-1, 0]}[frames]


@pytest.mark.parametrize("raised", [KeyboardInterrupt, OSError(28, "No space left on device"), ZeroDivisionError])
@pytest.mark.parametrize("where", ["render.render", "render.save_picture", "coefficients.write", "results.write_text"])
def test_a_failure_leaves_the_older_frame(rendered, monkeypatch, capfd, raised, where):
    before = digests(rendered) | {"summary.json": (rendered / "summary.json").read_bytes()}
    module, name = where.split(".")

    def fail(*_, **__):
        raise raised

    monkeypatch.setattr({"render": render, "coefficients": coefficients, "results": results}[module], name, fail)
    capfd.readouterr()
    assert commands.execute(["render", "little.blend", *CHEAP]) == (130 if raised is KeyboardInterrupt else 1)
    assert len(said(capfd)) == 1
    assert names(rendered) == ["little.blend", *FRAME]
    assert digests(rendered) | {"summary.json": (rendered / "summary.json").read_bytes()} == before


def test_frames_of_several_runs_are_noted_together(typed):
    for frames in ("3", "1-2", "2"):
        assert commands.execute(["render", "little.blend", *CHEAP, "--frame", frames]) == 0
    frames = json.loads((typed / "summary.json").read_text())["frames"]
    assert [each["frame"] for each in frames] == [1, 2, 3]


def test_a_summary_of_something_else_is_not_overwritten(typed, capfd):
    (typed / "summary.json").write_text('{"mine": 1}')
    capfd.readouterr()
    assert commands.execute(["render", "little.blend", *CHEAP]) == 1
    assert "summary.json: not a summary that Relume wrote" in said(capfd)[-1]
    assert names(typed) == ["little.blend", "summary.json"]


def test_resume_keeps_what_is_whole(typed, capfd):
    arguments = ["render", "little.blend", *CHEAP, "--frame", "1-3", "--resume"]
    assert commands.execute(arguments) == 0
    times = {name: (typed / name).stat().st_mtime_ns for name in names(typed)}
    data = (typed / "little_0002.exr").read_bytes()
    (typed / "little_0002.exr").write_bytes(data[: len(data) // 2])
    (typed / "little_0003_A+FL2.png").unlink()
    capfd.readouterr()
    assert commands.execute(arguments) == 0
    printed = capfd.readouterr().err
    assert "little_0001.exr: kept" in printed and "little_0002.exr: the file is damaged" in printed
    assert (typed / "little_0002.exr").read_bytes() == data, "rendered again, to the same bytes"
    changed = {name for name in names(typed) if (typed / name).stat().st_mtime_ns != times[name]}
    assert changed == {f"little_000{n}{end}" for n in "23" for end in (".exr", "_A+FL2.png")} | {"summary.json"}
    os.utime(typed / "little.blend")
    assert commands.execute([*arguments[:-2], "2", "--resume"]) == 0
    assert (typed / "little_0002.exr").stat().st_mtime_ns > times["little_0002.exr"], "the scene is newer"


def test_a_frame_that_another_process_renders_is_skipped_or_waited_for(typed, capfd):
    frame = typed / "little_0001.exr"
    with results.claim(frame):
        assert commands.execute(["render", "little.blend", *CHEAP, "--frame", "1-2", "--resume"]) == 0
        assert "little_0001.exr: another process renders this frame; skipped" in capfd.readouterr().err
        assert not frame.exists() and (typed / "little_0002.exr").exists()
        waiting = subprocess.Popen(
            [*COMMAND, "render", "little.blend", *CHEAP, "--frame", "1"], stderr=subprocess.PIPE, text=True
        )
        assert "another process renders this frame; waiting" in waiting.stderr.readline()
        assert not frame.exists()
    assert waiting.wait() == 0 and frame.exists()
    waiting.stderr.close()


def test_two_processes_share_the_frames(typed):
    arguments = [*COMMAND, "render", "little.blend", *CHEAP, "--frame", "1-6", "--resume"]
    running = [subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    printed = [process.communicate()[0].splitlines() for process in running]
    assert [process.returncode for process in running] == [0, 0]
    written = [line for each in printed for line in each if line.endswith(".exr")]
    assert sorted(written) == [f"little_000{n}.exr" for n in range(1, 7)], "each frame once"
    assert [each["frame"] for each in json.loads((typed / "summary.json").read_text())["frames"]] == [1, 2, 3, 4, 5, 6]
    assert not [name for name in names(typed) if name.startswith(".")]


@pytest.mark.parametrize("wait", [0.0, 0.4, 1.0])
def test_a_kill_leaves_nothing_that_a_rerun_does_not_mend(rendered, wait):
    expected = digests(rendered)
    process = subprocess.Popen([*COMMAND, "render", "little.blend", *CHEAP], stderr=subprocess.PIPE)
    process.stderr.readline()  # the first pass has begun
    time.sleep(wait)
    process.kill()
    process.wait()
    process.stderr.close()
    assert digests(rendered).items() >= expected.items(), "what was there is whole"
    assert commands.execute(["render", "little.blend", *CHEAP]) == 0
    assert digests(rendered) == expected
    assert names(rendered) == ["little.blend", *FRAME]


@pytest.mark.skipif(sys.platform == "win32", reason="Windows ends a process without asking it")
@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_ends_a_render_at_once(typed, number, status):
    arguments = [*COMMAND, "render", "little.blend", "--samples", "100000", "--out", "new"]
    process = subprocess.Popen(
        arguments,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    assert "pass 1" in process.stderr.readline()
    process.send_signal(number)
    assert process.wait(30) == status
    assert process.stderr.read() == "relume: stopped\n"
    process.stderr.close()
    assert names(typed) == ["little.blend"]


def test_a_file_that_opens_with_a_warning_is_rendered(typed, capfd):
    """A library that is missing."""
    bpy.ops.wm.read_factory_settings()
    bpy.ops.wm.save_as_mainfile(filepath=str(typed / "library.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(typed / "little.blend"))
    bpy.ops.wm.link(directory=str(typed / "library.blend/Object/"), filename="Cube")
    bpy.ops.wm.save_mainfile()
    (typed / "library.blend").unlink()
    capfd.readouterr()
    assert commands.execute(["render", "little.blend", *CHEAP]) == 0
    (line,) = said(capfd)
    assert line.startswith("relume: little.blend: ") and "library.blend" in line


def test_a_driver_that_does_not_work_is_named(typed, capfd):
    floor = bpy.data.objects["floor"]
    floor.driver_add("location", 0).driver.expression = "1 / 0 + nope("
    bpy.ops.wm.save_mainfile()
    capfd.readouterr()
    assert commands.execute(["render", "little.blend", *CHEAP]) == 0
    printed = capfd.readouterr()
    line, _ = [line for line in printed.err.splitlines() if line.startswith("relume")]  # the other: what is expected
    assert "location of floor" in line
    assert "Traceback" not in printed.err and "PyDriver" not in printed.err and "PyDriver" not in printed.out


def test_an_exposure_that_is_no_number_is_refused(typed, capfd):
    bpy.context.scene.view_settings.exposure = float("nan")
    bpy.ops.wm.save_mainfile()
    capfd.readouterr()
    assert commands.execute(["render", "little.blend", *CHEAP]) == 1
    assert "the exposure of its view is nan" in said(capfd)[-1]
    assert names(typed) == ["little.blend", "little.blend1"]


def test_what_nobody_foresaw_is_a_sentence_and_its_traceback_is_logged(typed, monkeypatch, capfd):
    def fail(*_):
        raise KeyError("shape")

    monkeypatch.setattr(setup, "set_up", fail)
    capfd.readouterr()
    assert commands.execute(["render", "little.blend", *CHEAP]) == 1
    printed = capfd.readouterr().err
    assert "unexpected KeyError" in printed and "Traceback" not in printed
    monkeypatch.setenv("RELUME_LOG", "debug")
    assert commands.execute(["render", "little.blend", *CHEAP]) == 1
    assert "Traceback" in capfd.readouterr().err
    console.LOG.handlers.clear()


def test_events_are_json_lines(typed, monkeypatch, capfd):
    monkeypatch.setenv("RELUME_EVENTS", "json")
    capfd.readouterr()
    assert commands.execute(["render", "little.blend", "--channels", "6"]) == 0
    printed = [json.loads(line) for line in capfd.readouterr().out.splitlines()]
    assert [each["event"] for each in printed] == ["pass", "pass", "wrote", "wrote", "expected", "wrote"]
    assert [(each["number"], each["passes"]) for each in printed[:2]] == [(1, 2), (2, 2)]
    assert commands.execute(["render", "no.blend"]) == 1
    printed = json.loads(capfd.readouterr().out)
    assert printed == {"event": "failed", "words": "no.blend: no such file"}


def test_every_picture_comes_with_the_error_that_is_expected(rendered, capfd):
    """In summary.json, in the EXR, in a line; and what would help where anybody sees it."""
    (frame,) = json.loads((rendered / "summary.json").read_text())["frames"]
    own = frame["expected"]["A+FL2"]
    shown = coefficients.describe(rendered / "little.exr")
    found = expectation.expected(shown.model, shown.shows, shown.mix())
    assert own["p98"] == pytest.approx(found.p98, rel=1e-3)
    assert own["level"] == found.level
    capfd.readouterr()
    group = next(iter(shown.groups))
    relit = ["relight", "little.exr", "--light", f"{group}=532 nm", "--out", "relit.png"]
    assert commands.execute(relit) == 0
    (line,) = [line for line in capfd.readouterr().err.splitlines() if " expected, " in line]
    assert "channels: " in line
    worse = float(line.split(" expected, ")[1].split()[0])
    assert worse > max(expectation.YELLOW, own["p98"])


def test_a_full_standard_output_is_one_line(rendered):
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [*COMMAND, "relight", "little.exr", "--out", "x.png"], stdout=full, stderr=subprocess.PIPE, text=True
        )
    assert done.returncode == 1
    assert done.stderr == "relume: standard output cannot be written (No space left on device)\n"
    assert (rendered / "x.png").is_file()


def test_two_files_of_one_frame_are_refused(rendered, capfd):
    for name in ("shot.01.exr", "shot.001.exr"):
        (rendered / name).write_bytes((rendered / "little.exr").read_bytes())
    before = names(rendered)
    capfd.readouterr()
    assert commands.execute(["relight", "shot.##.exr", "--out", "x.##.png"]) == 1
    assert "are both frame 1" in said(capfd)[-1]
    assert names(rendered) == before


def test_the_demo_prints_the_errors_of_each_lighting(capsys):
    from relume.addon.cli import demo

    takes = [demo._Take(None, seconds) for seconds in (1.0, 2.0, 12.0)]
    demo._print_table(*takes, {"sodium": (np.full((2, 2), 30.0), np.full((2, 2), 0.25))})
    lines = capsys.readouterr().out.splitlines()
    assert ["sodium", "30.00", "30.00", "0.25", "0.25"] in [line.split() for line in lines]
