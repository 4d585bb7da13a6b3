"""What the README and the pages of docs/ tell people to type, run as it is printed there, from a fresh clone."""

import os
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
PAGES = "\n".join(path.read_text(encoding="utf-8") for path in sorted((ROOT / "docs").glob("*.md"), reverse=True))


def _printed(beginning: str, text: str = README) -> list[str]:
    """The lines of a text's blocks of commands that begin so, each once, without what is said of them."""
    lines = re.findall(rf"^    ({re.escape(beginning)}.*)$", text, re.MULTILINE)
    return list(dict.fromkeys(line.partition("  #")[0].strip() for line in lines))


@pytest.fixture
def clone(tmp_path):
    folder = tmp_path / "relume"
    done = subprocess.run(["git", "clone", "--quiet", str(ROOT), str(folder)], capture_output=True, text=True)
    if done.returncode:
        pytest.skip(f"not a git checkout: {done.stderr.strip()}")
    return folder


def _typed(line: str, folder: Path, **environment) -> str:
    done = subprocess.run(
        line,
        shell=True,
        cwd=folder,
        env=os.environ | environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, (line, done.stdout, done.stderr)
    return done.stdout


def _make_coarse(blend: Path):
    """Give a scene few samples: what commands print and write is tested here, not what they render."""
    import bpy

    bpy.ops.wm.open_mainfile(filepath=str(blend))
    bpy.context.scene.cycles.samples = 6
    bpy.ops.wm.save_mainfile()


def test_commands(relume, clone, tmp_path):
    """In this environment, with the clone in the place of the installed Relume; its room has few samples."""
    if not (ROOT / ".venv").exists():
        pytest.skip("`make` has made no environment here")
    (clone / ".venv").symlink_to((ROOT / ".venv").resolve())
    (tmp_path / "path").mkdir()
    (tmp_path / "path/relume").symlink_to(clone)
    _make_coarse(clone / "assets/room.blend")
    for name, content in re.findall(
        r"^```{code-block} text\n:caption: (\S+)\n(.*?)^```", PAGES, re.MULTILINE | re.DOTALL
    ):
        (clone / name).write_text(content)
    lines = _printed(".venv/bin/relume ", f"{README}\n{PAGES}")
    scripts = [line for line in _printed(".venv/bin/python ", PAGES) if " -m " not in line and " tools/" not in line]
    assert len(lines) >= 3 and len(scripts) >= 2
    for line in [*lines, *scripts]:
        for made in _typed(line, clone, PYTHONPATH=str(tmp_path / "path")).splitlines():
            assert line in scripts or (clone / made).is_file(), (line, made)
    assert (clone / "out/colours.csv").is_file()


def test_options(capsys):
    """Each option of the README's synopsis is one of the command's, and the other way round."""
    pytest.importorskip("bpy", reason="commands need bpy")
    from relume.addon.cli import commands

    synopses = dict(re.findall(r"^    relume (\w+)((?:.*\n)(?:     +.*\n)*)", README, re.MULTILINE))
    assert {"render", "relight"} <= set(synopses)
    for name, text in synopses.items():
        assert commands.execute([name, "--help"]) == 0
        known = set(re.findall(r"--[a-z]+", capsys.readouterr().out)) - {"--help"}
        assert set(re.findall(r"--[a-z]+", text)) == known, name


@pytest.mark.torture
def test_make_demo(clone):
    """On a machine that has nothing of Relume yet."""
    pictures = _typed("make demo", clone)
    assert "out/demo/room_sodium.png" in pictures
    assert (clone / "out/demo/room_sodium.png").is_file()
