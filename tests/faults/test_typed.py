"""Every command as people type it: in a shell, from the scene's own folder, with bare names and awkward ones."""

import json
import shlex
import shutil

import pytest

from relume.core.picture import coefficients

from . import outcome

pytest.importorskip("bpy", reason="commands need bpy")

RENDER = "relume render room.blend --samples 3 --channels 3"
# Every start costs seconds: in `make test` what is awkward stands in one name, in `make torture` also by itself
NAMES = ["room.blend", "-dash.blend", 'it\'s "so", a=b, 100%, #1, v2.Räume {x} $HOME.blend']
ALONE = ["my room.blend", "it's.blend", 'say "so".blend', "Räume.blend", "a=b.blend"]
ALONE += ["100%.blend", "#1.blend", "room.final.v2.blend", "{x}.blend", "$HOME.blend"]
OUT = ["", "--out 'two words'", "--out ~/home"]
OUT_TOO = ["--out .", "--out ./", "--out sub", "--out ../room-out", '--out "it\'s"']


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


def _rarely(cases) -> list:
    """The cases, in `make torture` only."""
    return [pytest.param(case, marks=pytest.mark.torture) for case in cases]


@pytest.mark.parametrize("out", [*OUT, *_rarely(OUT_TOO)])
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


@pytest.mark.parametrize("name", [*NAMES, *_rarely(ALONE)])
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


CANNOT = [
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
]
IN_A_SHELL = (
    "relume",
    "relume rendr room.blend",
    "relume render 'room.blend\n'",
    "relume relight empty.exr --out x.png",
)


@pytest.fixture
def refused(scene, settle):
    """A function: what a line prints that has to be refused, and to change nothing; `typed` runs it in a folder."""
    (scene / "room.png").write_text("no scene at all")
    (scene / "empty.exr").write_bytes(b"")

    def of(line, typed) -> str:
        before = outcome.files_of(scene)
        ended = typed(line, scene)
        assert outcome.of_command(ended) == outcome.SAID or line == "relume", ended
        assert outcome.files_of(scene) == before
        settle(outcome.SAID)
        return ended.err

    return of


@pytest.mark.parametrize(("line", "words"), CANNOT)
def test_what_cannot_be_done_is_said_in_a_line(relume, refused, line, words, monkeypatch, capfd):
    """In this process, where it costs no start."""
    from relume.addon.cli import commands

    def typed(line, folder) -> outcome.Ended:
        monkeypatch.chdir(folder)
        capfd.readouterr()
        return outcome.Ended(commands.execute(shlex.split(line)[1:]), *capfd.readouterr())

    assert words in refused(line, typed)


@pytest.mark.parametrize("line", [*IN_A_SHELL, *_rarely(line for line, _ in CANNOT if line not in IN_A_SHELL)])
def test_what_cannot_be_done_is_said_in_a_shell(refused, line):
    assert dict(CANNOT)[line] in refused(line, outcome.typed)


def test_a_command_prints_nothing_of_blender(scene, settle):
    ended = _done(f"{RENDER} --illuminant D65", scene)
    assert ended.out.split() == ["room.exr", "room_D65.png", "summary.json"]
    for words in ("Saved:", "Read blend", "Fra:", "Blender quit", "Info:"):
        assert words not in ended.out + ended.err
    settle(outcome.RIGHT)
