"""`relume web` as it is typed, and Share as Web Page."""

import json
import re
from dataclasses import replace

import bpy
import numpy as np
import pytest

from relume.addon.cli import commands
from relume.addon.scene import exr
from relume.core.model import bases
from relume.core.picture import coefficients
from relume.core.picture.coefficient_image import CoefficientImage
from relume.core.spectra import library

FEW = ("--lamps", "D65", "A")


def write(path, groups=("key",), **changes):
    model = bases.fitted(3)
    rng = np.random.default_rng(0)
    image = CoefficientImage(
        model,
        {name: rng.uniform(0, 1, (24, 32, 3)).astype(np.float32) for name in groups},
        {name: library.illuminant("FL2") for name in groups},
        np.ones((24, 32), np.float32),
    )
    coefficients.write(path, replace(image, **changes), next(iter(image.groups.values())))
    return path


def data(path):
    text = path.read_text(encoding="utf-8")
    return json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', text)[1])


@pytest.fixture
def here(relume, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_file_a_sequence_and_a_folder(here, capfd):
    (here / "shots").mkdir()
    for frame in (7, 8, 9):
        write(here / "shots" / f"shot.{frame:04d}.exr")
    write(here / "shots" / "other.exr", ("key", "fill"))
    (here / "shots" / "broken.exr").write_bytes(b"no picture")
    assert commands.execute(["web", "shots/other.exr", *FEW, "--title", "Two lights", "--out", "one.html"]) == 0
    assert commands.execute(["web", "shots/shot.####.exr", *FEW, "--out", "out/frames.html"]) == 0
    assert commands.execute(["web", "shots", *FEW, "--size", "16", "--bare", "--out", "all.html"]) == 0
    one, frames, every = data(here / "one.html"), data(here / "out" / "frames.html"), data(here / "all.html")
    assert one["title"] == "Two lights" and [g["name"] for g in one["pictures"][0]["groups"]] == ["key", "fill"]
    assert [lamp["name"] for lamp in one["lamps"]] == ["D65", "A", "FL2"], "what it was rendered with is there too"
    assert [frame["number"] for frame in frames["pictures"][0]["frames"]] == [7, 8, 9]
    assert frames["pictures"][0]["name"] == "shot"
    assert [each["name"] for each in every["pictures"]] == ["other", "shot.0007", "shot.0008", "shot.0009"]
    assert every["bare"] and every["pictures"][0]["size"] == [16, 12]
    assert "broken.exr" in capfd.readouterr().err


@pytest.mark.parametrize(
    "words, status, said",
    [
        (["none.exr", "--out", "a.html"], 1, "none.exr: no such file"),
        (["here.exr", "--out", "a.png"], 1, "ends in .html"),
        (["here.exr", "--lamps", "Sodiu", "--out", "a.html"], 1, "Sodiu"),
        (["empty", "--out", "a.html"], 1, "no coefficient images"),
        (["gone.####.exr", "--out", "a.html"], 1, "gone.####.exr"),
        (["plain.exr", "--out", "a.html"], 1, "plain.exr"),
        (["here.exr", "--quality", "0", "--out", "a.html"], 2, "0.1 to 20"),
        (["here.exr", "--quality", "nan", "--out", "a.html"], 2, "0.1 to 20"),
        (["here.exr", "--size", "-3", "--out", "a.html"], 2, "--size"),
        (["here.exr", "--size", "9" * 5000, "--out", "a.html"], 2, "8192"),
        (["here.exr"], 2, "--out"),
        (["here.exr", "--out", "here.exr/a.html"], 1, "here.exr"),
    ],
)
def test_what_cannot_be_is_one_line_and_leaves_nothing(here, capfd, words, status, said):
    write(here / "here.exr")
    (here / "empty").mkdir()
    (here / "plain.exr").write_bytes(b"nothing")
    before = sorted(here.rglob("*"))
    assert commands.execute(["web", *words]) == status
    lines = [line for line in capfd.readouterr().err.splitlines() if line.startswith("relume")]
    assert said in lines[-1] and "Traceback" not in lines[-1] and (status == 2 or len(lines) == 1)
    assert sorted(here.rglob("*")) == before


def test_a_view_that_is_not_plain_becomes_a_table(here):
    agx = {"view_transform": "AgX", "look": "None", "exposure": 0.5, "gamma": 1.0, "display_device": "sRGB"}
    write(here / "agx.exr", view=agx)
    assert commands.execute(["web", "agx.exr", *FEW, "--out", "agx.html"]) == 0
    (lut,) = data(here / "agx.html")["luts"]
    assert lut["values"][1:] == [lut["size"]] * 3 + [3]
    assert data(here / "agx.html")["pictures"][0]["view"] == {"exposure": 0.5, "gamma": 1.0, "lut": 0}


def test_share_as_web_page_writes_what_is_relit(here):
    scene = exr.new_scene(write(here / "shot.exr", ("key", "fill")))
    scene.relume.light_groups["fill"].source = "LIBRARY"
    scene.relume.light_groups["fill"].illuminant = "Mercury"
    scene.relume.light_groups["fill"].stops = 1.0
    try:
        with bpy.context.temp_override(scene=scene):
            assert bpy.ops.relume.share_as_web_page(filepath=str(here / "page.html"), size=16) == {"FINISHED"}
            with pytest.raises(RuntimeError, match="nowhere"):
                bpy.ops.relume.share_as_web_page(filepath=str(here / "nowhere" / "page.html"), size=16)
    finally:
        bpy.data.scenes.remove(scene)
    shared = data(here / "page.html")
    groups = shared["pictures"][0]["groups"]
    assert [shared["lamps"][each["lamp"]]["name"] for each in groups] == ["FL2", "Mercury"]
    assert groups[1]["gain"] == pytest.approx(2.0) and shared["pictures"][0]["size"] == [16, 12]


def test_a_mix_that_was_copied_is_pasted(here):
    scene = exr.new_scene(write(here / "shot.exr", ("key", "fill = 2")))
    try:
        with bpy.context.temp_override(scene=scene):
            words = "--light 'key=Planckian 2900 K*0' 'fill = 2=Sodium (low pressure)*2' --white 0.5"
            assert bpy.ops.relume.paste_mix(words=words) == {"FINISHED"}
            key, fill = scene.relume.light_groups
            assert (key.illuminant, key.mute) == ("Planckian 2900 K", True)
            assert (fill.illuminant, fill.stops, fill.mute) == ("Sodium (low pressure)", pytest.approx(1.0), False)
            assert scene.relume.white_balance == pytest.approx(0.5)
            parts = '[["D65",0.25],["A",0.75]]'
            assert bpy.ops.relume.paste_mix(words=f"--light 'key={parts}*2'") == {"FINISHED"}
            assert (key.source, key.stops, key.mute) == ("BLEND", pytest.approx(1.0), False)
            assert [(part.illuminant, part.weight) for part in key.blend] == [("D65", 0.25), ("A", 0.75)]
            assert bpy.ops.relume.paste_mix(words="--light 'key=Planckian 2900 K*0'") == {"FINISHED"}
            for words in (" ", "hello", "--light 'rim=D65*1'", "--light 'key=D66*1'", "--light 'key", "--help"):
                with pytest.raises(RuntimeError):
                    bpy.ops.relume.paste_mix(words=words)
            assert key.illuminant == "Planckian 2900 K"
    finally:
        bpy.data.scenes.remove(scene)


def test_a_mix_that_was_copied_relights(here, capsys):
    write(here / "shot.exr", ("key", "fill = 2"))
    words = "--light 'key=Planckian 2900 K*0.5' 'fill = 2=Sodium (low pressure)*2' --white 0.5"
    plain = ["--light", "key=Planckian 2900 K*0.5", "fill = 2=Sodium (low pressure)*2", "--white", "0.5"]
    for name, said in (("mix", ["--mix", words]), ("plain", plain)):
        assert commands.execute(["relight", "shot.exr", *said, "--out", f"{name}.exr"]) == 0
    pixels = coefficients.read_rgb(here / "plain.exr")
    np.testing.assert_array_equal(coefficients.read_rgb(here / "mix.exr"), pixels)
    assert commands.execute(["relight", "shot.exr", "--mix", words, "--light", "key=A", "--out", "other.exr"]) == 0
    assert not np.array_equal(coefficients.read_rgb(here / "other.exr"), pixels), "what is said beside it counts"
    dial = '[["D65", 0.25], ["A", 0.75]]'
    assert commands.execute(["relight", "shot.exr", "--light", f"key={dial}*2", "--out", "dial.exr"]) == 0
    rows = [["key=D65*0.5", "fill = 2=FL2*0"], ["key=A*1.5", "fill = 2=FL2*0"], ["fill = 2=FL2*1", "key=A*0"]]
    for number, row in enumerate(rows):
        assert commands.execute(["relight", "shot.exr", "--light", *row, "--out", f"part{number}.exr"]) == 0
    blended = coefficients.read_rgb(here / "dial.exr")
    parts = sum(coefficients.read_rgb(here / f"part{number}.exr") for number in range(3))
    # Matrices of three channels are fitted for each illuminant by itself
    np.testing.assert_allclose(blended, parts, rtol=0.02, atol=0.05)
    for bad in ("[", "[]", "[1]", '[["D65", 2]]', '[["D65", NaN]]', '[["D65", "x"]]', "[[1, 1]]", "[" * 5000):
        assert commands.execute(["relight", "shot.exr", "--light", f"key={bad}", "--out", "bad.exr"]) == 1
        assert "expected a blend" in capsys.readouterr().err
    for words in ("", "hello", "--out x.png", "--light 'key=A", "--help", "--white 2", "--mix '--white 1'"):
        assert commands.execute(["relight", "shot.exr", "--mix", words, "--out", "bad.exr"]) == 2
        assert "argument --mix: " in capsys.readouterr().err
    assert commands.execute(["relight", "shot.exr", "--mix", "--light rim=A", "--out", "bad.exr"]) == 1
    assert "no light group 'rim'" in capsys.readouterr().err and not (here / "bad.exr").exists()
