"""Every command as people type it: in a shell, from the scene's own folder, with bare names and awkward ones."""

import json
import shlex
import shutil

import pytest

from relume.core.picture import coefficients

from . import outcome

pytest.importorskip("bpy", reason="commands need bpy")

RENDER = "relume render room.blend --samples 3 --channels 3"
NAMES = ["room.blend", "my room.blend", "it's.blend", 'say "so".blend', "Räume.blend", "-dash.blend", "a=b.blend"]
NAMES += ["100%.blend", "#1.blend", "room.final.v2.blend", "{x}.blend", "$HOME.blend"]


@pytest.fixture
def scene(little, tmp_path):
    """A folder with little.blend in it as room.blend."""
    shutil.copy(little, tmp_path / "room.blend")
    return tmp_path


def _done(line, folder, **environment):
    """What a line that has to succeed printed."""
    ended = outcome.typed(line, folder, **environment)
    assert ended.status == 0, (line, ended)
    assert "Traceback" not in ended.err, (line, ended)
    return ended


@pytest.mark.parametrize(
    "out",
    ["", "--out .", "--out ./", "--out sub", "--out 'two words'", "--out ../room-out", "--out ~/home", '--out "it\'s"'],
)
def test_render_says_what_it_wrote_and_wrote_it(scene, out, settle, monkeypatch):
    monkeypatch.setenv("HOME", str(scene))
    (scene / "stand here").mkdir()
    (scene / "room.blend").rename(scene / "stand here/room.blend")
    ended = _done(f"{RENDER} {out}", scene / "stand here")
    made = [scene / "stand here" / line.replace("~", str(scene)) for line in ended.out.splitlines()]
    assert sorted(path.suffix for path in made) == [".exr", ".json", ".png"], ended
    assert all(path.is_file() for path in made), ended
    outcome.files_of(scene)
    settle(outcome.RIGHT)


def test_relight_into_the_folder_where_one_stands(scene, settle):
    _done(RENDER, scene)
    picture = (scene / "room_A+FL2.png").read_bytes()
    ended = _done("relume relight room.exr --light tungsten=LED-B1 fluorescent=D50*0.5 --out evening.png", scene)
    assert ended.out == "evening.png\n"
    assert coefficients.read_rgb(scene / "evening.png").shape == (12, 16, 3)
    _done("relume relight ./room.exr --out ./evening.png --white full", scene)
    _done("relume relight room.exr --out 'room_A+FL2.png'", scene)
    assert (scene / "room_A+FL2.png").read_bytes() == picture, "relit as it was lit, it is the same picture"
    settle(outcome.RIGHT, 4)


@pytest.mark.parametrize("name", NAMES)
def test_scenes_of_any_name(scene, name, settle):
    (scene / "room.blend").rename(scene / name)
    typed = shlex.quote(f"./{name}" if name.startswith("-") else name)
    ended = _done(f"relume render {typed} --samples 3 --channels 3", scene)
    (exr,) = [line for line in ended.out.splitlines() if line.endswith(".exr")]
    typed = shlex.quote(f"./{exr}" if exr.startswith("-") else exr)
    _done(f"relume relight {typed} --light tungsten=D50 --out relit.png", scene)
    assert (scene / "relit.png").is_file()
    outcome.files_of(scene)
    settle(outcome.RIGHT)


def test_frames_and_their_sequence(scene, settle):
    ended = _done(f"{RENDER} --frame 1-3 --illuminant D65", scene)
    assert [line for line in ended.out.splitlines() if line.endswith(".exr")] == [
        f"room_{n:04d}.exr" for n in (1, 2, 3)
    ]
    ended = _done("relume relight 'room_####.exr' --light tungsten=D50 --out 'relit_##.png'", scene)
    assert ended.out.split() == ["relit_01.png", "relit_02.png", "relit_03.png"]
    summary = json.loads((scene / "summary.json").read_text(encoding="utf-8"))
    assert [frame["frame"] for frame in summary["frames"]] == [1, 2, 3]
    settle(outcome.RIGHT, 2)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("relume", "usage"),
        ("relume rendr room.blend", "invalid choice"),
        ("relume render", "SCENE.blend"),
        ("relume render nothing.blend", "nothing.blend: no such file"),
        ("relume render .", "folder"),
        ("relume render room.png", "room.png"),
        ("relume render -dash.blend", "-dash.blend"),
        ("relume render 'room.blend\n'", "no such file"),
        ("relume relight nothing.exr --out x.png", "nothing.exr: no such file"),
        ("relume relight room.blend --out x.png", "room.blend"),
        ("relume relight . --out x.png", "folder"),
        ("relume relight empty.exr --out x.png", "empty.exr"),
        ("relume relight 'frame_####.exr' --out 'x_####.png'", "frame_####.exr"),
        ("relume relight 'a##b##.exr' --out 'x_####.png'", "#"),
        ("relume report nothing.blend", "nothing.blend: no such file"),
        ("relume report room.blend --channels 0", "0"),
        ("relume report room.blend --models best", "best"),
        ("relume tables --nonsense", "--nonsense"),
    ],
)
def test_what_cannot_be_done_is_said_in_a_line(scene, line, words, settle):
    (scene / "room.png").write_text("no scene at all")
    (scene / "empty.exr").write_bytes(b"")
    before = outcome.files_of(scene)
    ended = outcome.typed(line, scene)
    assert outcome.of_command(ended) == outcome.SAID or line == "relume", ended
    assert words in ended.err, ended
    assert outcome.files_of(scene) == before
    settle(outcome.SAID)


def test_a_command_prints_nothing_of_blender(scene, settle):
    ended = _done(f"{RENDER} --illuminant D65", scene)
    assert ended.out.split() == ["room.exr", "room_D65.png", "summary.json"]
    for words in ("Saved:", "Read blend", "Fra:", "Blender quit", "Info:"):
        assert words not in ended.out + ended.err
    settle(outcome.RIGHT)
