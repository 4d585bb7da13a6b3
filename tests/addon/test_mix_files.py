"""Mixes and illuminants put back, copied, saved as files and loaded: by the mixer's buttons and by `relume relight`."""

import json

import bpy
import numpy as np
import pytest
from test_web import write

from relume.addon.cli import commands
from relume.addon.scene import exr, light_groups, setup
from relume.addon.store import mix_file, mixer
from relume.core.model import bases
from relume.core.picture import coefficients


@pytest.fixture
def ready(room):
    """The room, set up with few channels; returns its scene."""
    setup.set_up(room, bases.fitted(3))
    return room


@pytest.fixture
def measured(tmp_path):
    path = tmp_path / "lamp.csv"
    path.write_text("nm,power\n400,1\n700,2\n")
    return path


def change(scene, measured):
    """Choose something in every row, and a white."""
    tungsten, fluorescent = scene.relume.light_groups
    tungsten.path, tungsten.source, tungsten.stops = str(measured), "FILE", -1.5
    tungsten.tint = (1.0, 0.5, 0.25)
    fluorescent.source = "BLEND"
    fluorescent.blend[1].weight = 0.5
    scene.relume.white_balance, scene.relume.observer = 0.5, "CIE 1964 10°"


def test_reset_has_a_row_or_all_begin_anew(startup, measured):
    bpy.data.lights["Light"].use_temperature, bpy.data.lights["Light"].temperature = True, 3200.0
    light_groups.regroup(startup, "LIGHT")
    setup.set_up(startup, bases.fitted(3))
    began = mixer.choices(startup.relume)
    assert [row.illuminant for row in startup.relume.light_groups] == ["Planckian 3200 K", "D65"]
    first, second = (row.name for row in startup.relume.light_groups)
    ready = startup
    change(ready, measured)
    changed = mixer.choices(ready.relume)
    assert bpy.ops.relume.reset_mix(group=first) == {"FINISHED"}
    now = mixer.choices(ready.relume)
    assert now["light_groups"][first] == began["light_groups"][first]
    assert now["light_groups"][second] == changed["light_groups"][second] and now["balance"] == changed["balance"]
    assert bpy.ops.relume.reset_mix() == {"FINISHED"}
    assert mixer.choices(ready.relume) == began


def test_reset_of_an_exr_is_what_it_was_rendered_with(relume, tmp_path):
    scene = exr.new_scene(write(tmp_path / "shot.exr", ("key", "fill"), gains={"key": 4.0, "fill": 1.0}))
    try:
        with bpy.context.temp_override(scene=scene):
            began = mixer.choices(scene.relume)
            for row in scene.relume.light_groups:
                row.source, row.illuminant, row.stops = "LIBRARY", "A", -3.0
            assert bpy.ops.relume.reset_mix() == {"FINISHED"}
            assert mixer.choices(scene.relume) == began and scene.relume.light_groups["key"].stops == 2.0
    finally:
        bpy.data.scenes.remove(scene)


def test_an_illuminant_is_pasted_into_another_row_and_keeps_the_gain(ready, measured):
    change(ready, measured)
    for source, target in ((0, 1), (1, 0)):
        source, target = ready.relume.light_groups[source], ready.relume.light_groups[target]
        target.stops = 2.0
        text = mix_file.illuminant_text(source)
        assert bpy.ops.relume.paste_illuminant(group=target.name, words=text) == {"FINISHED"}
        assert mix_file.illuminant_text(target) == text and target.stops == 2.0
        assert np.array_equal(target.spectrum().values, source.spectrum().values)
    assert bpy.ops.relume.paste_illuminant(group=target.name, words="fl2\n") == {"FINISHED"}
    assert (target.source, target.illuminant) == ("LIBRARY", "FL2")
    for words in ("nothing", "{", "{}", mix_file.mix_text(ready.relume), text.replace('"source": "', '"source": "x')):
        with pytest.raises(RuntimeError):
            bpy.ops.relume.paste_illuminant(group=target.name, words=words)
    assert target.illuminant == "FL2"


def test_a_saved_mix_comes_back(ready, measured, tmp_path):
    path = tmp_path / "evening.json"
    change(ready, measured)
    changed = mixer.choices(ready.relume)
    assert bpy.ops.relume.save_mix(filepath=str(path)) == {"FINISHED"}
    measured.unlink()
    bpy.ops.relume.reset_mix()
    assert bpy.ops.relume.load_mix(filepath=str(path)) == {"FINISHED"}
    assert mixer.choices(ready.relume) == changed and ready.relume.problem == ""
    words = tmp_path / "words.txt"
    words.write_text(f"--light '{ready.relume.light_groups[0].name}=Mercury*2' --white 0.25")
    assert bpy.ops.relume.load_mix(filepath=str(words)) == {"FINISHED"}
    assert ready.relume.light_groups[0].illuminant == "Mercury" and ready.relume.white_balance == 0.25


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda kept: kept.update(version=99), "newer Relume"),
        (lambda kept: kept.update(relume="illuminant"), "not a mix"),
        (lambda kept: kept.pop("version"), "has no version"),
        (lambda kept: kept.pop("balance"), "damaged"),
        (lambda kept: kept.update(balance=[]), "no objects"),
        (lambda kept: kept["light_groups"].update(key=3), "light group 'key': is no object"),
        (lambda kept: kept["light_groups"].update(key={"stops": "much"}), "stops cannot be 'much'"),
        (lambda kept: kept["light_groups"].update(key={"stops": float("nan")}), "stops cannot be nan"),
        (lambda kept: kept["light_groups"].update(key={"source": "SUN"}), "source cannot be 'SUN'"),
        (lambda kept: kept["light_groups"].update(key={"mute": 1}), "mute cannot be 1"),
        (lambda kept: kept["light_groups"].update(key={"blend": [["A"]]}), "the blend is no list"),
    ],
)
def test_a_file_that_is_no_mix_is_refused_in_a_sentence(ready, tmp_path, change, words):
    path, before = tmp_path / "bad.json", mixer.choices(ready.relume)
    kept = json.loads(mix_file.mix_text(ready.relume))
    change(kept)
    path.write_text(json.dumps(kept))
    with pytest.raises(RuntimeError, match=words):
        bpy.ops.relume.load_mix(filepath=str(path))
    assert mixer.choices(ready.relume) == before


def test_select_lights_selects_those_of_the_group(ready):
    for row in ready.relume.light_groups:
        assert bpy.ops.relume.select_lights(group=row.name) == {"FINISHED"}
        assert {thing.lightgroup for thing in bpy.context.selected_objects} == {row.name}
    bpy.context.selected_objects[0].hide_set(True)
    for thing in ready.objects:
        thing.hide_set(thing.lightgroup == row.name)
    with pytest.raises(RuntimeError, match="can be seen"):
        bpy.ops.relume.select_lights(group=row.name)


def test_relight_takes_a_saved_mix(relume, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    scene = exr.new_scene(write(tmp_path / "shot.exr", ("key", "fill")))
    try:
        key, fill = scene.relume.light_groups
        key.source, key.illuminant, key.stops = "LIBRARY", "Mercury", 1.0
        fill.source, fill.temperature, fill.solo = "PLANCKIAN", 2900.0, True
        scene.relume.white_balance = 0.5
        mix_file.write(tmp_path / "mix.json", scene.relume)
    finally:
        bpy.data.scenes.remove(scene)
    plain = ["--light", "key=Mercury*0", "fill=Planckian 2900 K*1", "--white", "0.5"]
    for name, said in (("mix", ["--mix", "mix.json"]), ("plain", plain)):
        assert commands.execute(["relight", "shot.exr", *said, "--out", f"{name}.exr"]) == 0
    pixels = coefficients.read_rgb(tmp_path / "plain.exr")
    np.testing.assert_allclose(coefficients.read_rgb(tmp_path / "mix.exr"), pixels, rtol=1e-6, atol=1e-7)
    said = ["--mix", "mix.json", "--light", "fill=A"]
    assert commands.execute(["relight", "shot.exr", *said, "--out", "other.exr"]) == 0
    assert not np.allclose(coefficients.read_rgb(tmp_path / "other.exr"), pixels), "what is said beside it counts"
    (tmp_path / "bad.json").write_text("{}")
    for name, words in (("bad.json", "not a mix"), ("none.json", "cannot be read")):
        assert commands.execute(["relight", "shot.exr", "--mix", name, "--out", "bad.exr"]) == 2
        assert words in capsys.readouterr().err


def test_every_named_illuminant_says_its_code(relume):
    from relume.core.spectra import library, names

    known = [name for family in library.illuminants().values() for name in family]
    assert set(names._NAMES) | set(names._WORDS) <= set(known), "every name is one of the library's"
    shown = [names.named(name) for name in known]
    assert len(set(shown)) == len(known), "no two have one name"
    for family in ("Daylight", "Fluorescent", "LED", "Discharge"):
        assert all(names.named(name) != name for name in library.illuminants()[family]), family
