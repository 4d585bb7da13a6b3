"""The mixer: groups, gains, illuminants, white balance, animation, snapshots, EXRs relit in the compositor."""

import json
import subprocess
import sys

import bpy
import numpy as np
import pytest
from dump import differences, dump
from test_render import close, composite, read_exr

from relume.addon.graph import node_groups
from relume.addon.scene import baking, compositing, exr, light_groups, render, setup
from relume.addon.store import mixer
from relume.core.model import bases
from relume.core.picture import coefficients, mixing, recombination, sequences
from relume.core.picture.mix import Light, Mix
from relume.core.spectra import files, library


@pytest.fixture
def ready(room):
    """The room, set up with few channels; returns its scene."""
    setup.set_up(room, bases.fitted(6))
    return room


def sockets(scene) -> np.ndarray:
    """(groups, p, 3) numbers in the recombination."""
    tree = compositing.recombinations(scene)[0].node_tree
    values = np.array([socket.default_value for socket in node_groups.matrix_sockets(tree)])
    return values.reshape(len(scene.relume.light_groups), -1, 3)


def expected(scene, lights, **options) -> np.ndarray:
    mix = Mix(dict(enumerate(lights)), **options)
    return recombination.recombination_matrices(scene.relume.model(), mix).transpose(0, 2, 1)


def test_stops_solo_and_mute_reach_the_sockets(ready):
    tungsten, fluorescent = ready.relume.light_groups
    whole = sockets(ready)
    tungsten.stops = -2.0
    assert np.allclose(sockets(ready), whole * np.array([0.25, 1.0])[:, None, None], rtol=1e-5)
    tungsten.solo = True
    assert np.allclose(sockets(ready), whole * np.array([0.25, 0.0])[:, None, None], rtol=1e-5)
    tungsten.mute = True
    assert not sockets(ready).any()
    tungsten.solo = tungsten.mute = False
    fluorescent.mute = True
    assert np.allclose(sockets(ready), whole * np.array([0.25, 0.0])[:, None, None], rtol=1e-5)


def test_every_kind_of_illuminant_reaches_the_sockets(ready, tmp_path):
    row, other = ready.relume.light_groups
    lamp = tmp_path / "lamp.csv"
    lamp.write_text("nm,power\n" + "\n".join(f"{w},{w - 300}" for w in range(380, 785, 5)))
    row.temperature, row.cct = 3400, 7500
    row.path = str(lamp)
    row.source = "BLEND"
    assert [part.illuminant for part in row.blend] == ["A", "D65"], "a blend starts with what shone, and daylight"
    row.blend[1].weight = 3.0
    ramp = np.linspace(80, 480, 81)
    spectra = {
        "LIBRARY": library.illuminant("A"),
        "PLANCKIAN": library.illuminant("Planckian 3400 K"),
        "DAYLIGHT": library.illuminant("D 7500 K"),
        "FILE": library.Spectrum(np.arange(380.0, 785.0, 5.0), ramp, kind="illuminant"),
        "BLEND": mixing.blend(((library.illuminant("A"), 1.0), (library.illuminant("D65"), 3.0))),
    }
    for source, spectrum in spectra.items():
        row.source = source
        assert ready.relume.problem == ""
        assert np.allclose(sockets(ready), expected(ready, [Light(spectrum), other.light()]), atol=1e-5), source
    lamp.unlink()
    row.source = "FILE"
    assert ready.relume.problem == "", "the spectrum of a file is kept in the scene"


def test_a_gel_colours_the_light_of_its_group_alone_and_is_part_of_the_mix(ready):
    row, other = ready.relume.light_groups
    row.tint = (1.0, 0.3, 0.1)
    behind = Light(mixing.tinted(library.illuminant("A"), tuple(row.tint)))
    assert np.allclose(sockets(ready), expected(ready, [behind, other.light()]), atol=1e-5)
    assert bpy.ops.relume.take_snapshot() == {"FINISHED"}
    bpy.ops.relume.copy_illuminant(group="tungsten")
    bpy.ops.relume.reset_mix(group="tungsten")
    assert not row.is_tinted and np.allclose(sockets(ready), expected(ready, ready.relume.lights()), atol=1e-5)
    assert bpy.ops.relume.apply_snapshot() == {"FINISHED"}
    assert np.allclose(sockets(ready), expected(ready, [behind, other.light()]), atol=1e-5)
    row.tint = (0.0, 0.0, 0.0)
    assert "lets no light through" in ready.relume.problem
    row.tint = (1.0, 1.0, 1.0)
    assert ready.relume.problem == ""
    assert light_groups.regroup(ready, "ILLUMINANT") == 2


def test_a_gel_takes_keyframes(ready):
    row = ready.relume.light_groups[0]
    for frame, colour in ((1, (1.0, 1.0, 1.0)), (10, (1.0, 0.2, 0.1))):
        row.tint = colour
        row.keyframe_insert("tint", frame=frame)
    ready.frame_set(1)
    plain = sockets(ready)
    ready.frame_set(10)
    assert np.abs(sockets(ready)[0] - plain[0]).max() > 0.05 and np.allclose(sockets(ready)[1], plain[1])


def test_rows_stay_where_they_are_moved_and_keep_their_light_and_their_keys(ready, tmp_path):
    before = composite(ready, tmp_path / "a.exr")
    row = ready.relume.light_groups["tungsten"]
    for frame, stops in ((1, 0.0), (10, -2.0)):
        row.stops = stops
        row.keyframe_insert("stops", frame=frame)
    ready.frame_set(1)
    assert bpy.ops.relume.move_group(group="tungsten", down=True) == {"FINISHED"}
    rows = ready.relume.light_groups
    assert [row.name for row in rows] == ["fluorescent", "tungsten"]
    assert np.allclose(sockets(ready), expected(ready, ready.relume.lights()), atol=1e-5)
    assert close(composite(ready, tmp_path / "b.exr"), before)
    ready.frame_set(10)
    assert (rows["tungsten"].stops, rows["fluorescent"].stops) == (-2.0, 0.0), "keys follow the row"
    assert bpy.ops.relume.set_up() == {"FINISHED"}
    assert [row.name for row in ready.relume.light_groups] == ["fluorescent", "tungsten"]
    bpy.ops.relume.move_group(group="tungsten", down=True)
    assert [row.name for row in ready.relume.light_groups] == ["fluorescent", "tungsten"], "there is nothing below"
    lamp = bpy.data.objects.new("third", bpy.data.lights.new("third", "POINT"))
    ready.collection.objects.link(lamp)
    ready.view_layers[0].lightgroups.add(name="third")
    lamp.lightgroup = "third"
    setup.update(ready)
    assert [row.name for row in ready.relume.light_groups] == ["fluorescent", "tungsten", "third"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("nm,power\n400,1\n500,-2\n600,1\n", "the power at 500 nm is negative"),
        ("nm,power\n400,1\n500,\n600,1\n", "line 3: '' is not a number"),
        ("nm,power\n800,1\n900,1\n", "no power between 380 and 780 nm"),
        ("nm,a,b\n400,1,1\n500,1,1\n", "holds 2 spectra"),
        ("400,0,5\n500,0,6\n", "may be 2 spectra, or numbers with decimal commas"),
        ("4OO,0.5\n500,0.6\n", "line 1: '4OO' is not a number"),
    ],
)
def test_a_file_that_is_no_illuminant_changes_nothing_and_is_named(ready, tmp_path, text, words):
    row = ready.relume.light_groups[0]
    good, bad = tmp_path / "good.csv", tmp_path / "bad.csv"
    good.write_text("nm,power\n400,1\n700,2\n")
    bad.write_text(text)
    row.path, row.source = str(good), "FILE"
    before = sockets(ready)
    row.path = str(bad)
    assert words in ready.relume.problem and "bad.csv" in ready.relume.problem
    assert np.array_equal(sockets(ready), before)
    assert row.origin == row.label == "good.csv"


def test_how_a_file_was_read_is_shown(ready, tmp_path):
    row, path = ready.relume.light_groups[0], tmp_path / "lamp.csv"
    assert row.origin == ready.relume.observer_origin == ""
    path.write_text("wavelength in µm;power\n0,40;-0,01\n0,70;2,5\n", encoding="latin-1")
    row.path, row.source = str(path), "FILE"
    assert ready.relume.problem == ""
    assert row.origin == "lamp.csv, wavelengths read as µm, noise below 0 read as 0"
    path.write_text("nm\tr\tg\tb\n400\t0.1\t0.2\t0.3\n700\t0.3\t0.2\t0.1\n", encoding="utf-16")
    ready.relume.observer_path, ready.relume.observer = str(path), "FILE"
    assert ready.relume.problem == "" and ready.relume.observer_origin == "lamp.csv"
    path.write_text("nm\tr\tg\n400\t0.1\t0.2\n700\t0.3\t0.2\n")
    before = sockets(ready)
    ready.relume.observer_path = str(path)
    assert "an observer or camera has three" in ready.relume.problem
    assert np.array_equal(sockets(ready), before)


def test_a_snapshot_holds_what_its_files_held(ready, tmp_path, monkeypatch):
    """No file is read to apply it: there may be none any more."""
    row, settings, path = ready.relume.light_groups[0], ready.relume, tmp_path / "three.csv"
    path.write_text("nm\tr\tg\tb\n400\t0.1\t0.2\t0.3\n700\t0.3\t0.2\t0.1\n")
    settings.observer_path, settings.observer = str(path), "FILE"
    (tmp_path / "lamp.csv").write_text("nm,power\n400,1\n700,2\n")
    row.path, row.source = str(tmp_path / "lamp.csv"), "FILE"
    bpy.ops.relume.take_snapshot()
    before = sockets(ready)
    row.path, row.source, settings.observer_path, settings.observer = "", "LIBRARY", "", "CIE 1931 2°"
    assert not np.array_equal(sockets(ready), before)
    read = []
    monkeypatch.setattr(files, "illuminant", lambda path: read.append(path) or library.illuminant("A"))
    monkeypatch.setattr(files, "observer", lambda path: read.append(path) or [])
    assert bpy.ops.relume.apply_snapshot() == {"FINISHED"}
    assert not read
    assert settings.problem == "" and np.array_equal(sockets(ready), before)


def test_white_balance_to_a_group_to_a_pixel_and_in_part(ready):
    settings = ready.relume
    settings.white_balance = 1.0
    settings.white_source, settings.white_group = "GROUP", "tungsten"
    white = sockets(ready)[0].sum(axis=0)  # of a perfect white under the tungsten lamp
    assert np.ptp(white) < 1e-4 * white.mean()
    grey = {name: [0.3] * 6 for name in ("tungsten", "fluorescent")}
    red = {name: [0.1, 0.1, 0.1, 0.2, 0.4, 0.5] for name in grey}
    for spot in (grey, red):
        settings.white_pixel, settings.white_source = json.dumps(spot), "PIXEL"
        seen = np.einsum("gpj,gp->j", sockets(ready), np.array(list(spot.values())))
        assert np.ptp(seen) < 1e-3 * seen.mean()
    settings.light_groups[0].illuminant = "FL11"
    seen = np.einsum("gpj,gp->j", sockets(ready), np.array(list(red.values())))
    assert np.ptp(seen) < 1e-3 * seen.mean(), "a picked spot stays white when the light changes"
    settings.white_source, settings.white_group = "GROUP", "moon"
    assert "no light group 'moon'" in settings.problem


def test_the_white_of_a_group_starts_with_the_first_one(ready):
    ready.relume.white_balance, ready.relume.white_source = 1.0, "GROUP"
    assert ready.relume.white_group == "tungsten" and ready.relume.problem == ""


@pytest.mark.parametrize("observer", ["CIE 1964 10°", "Nikon 5100 (NPL)"])
def test_white_in_daylight_is_white_to_every_observer(ready, observer):
    for row in ready.relume.light_groups:
        row.illuminant = "D65"
    plain = sockets(ready)
    ready.relume.observer = observer
    white = sockets(ready).sum(axis=1)
    assert np.allclose(white, 1.0, atol=2e-3)
    assert np.abs(sockets(ready) - plain).max() > 1e-3


def test_renaming_a_group_keeps_its_members_and_its_picture(ready, tmp_path):
    before = composite(ready, tmp_path / "a.exr")
    ready.relume.light_groups["tungsten"].name = "warm.lamp"
    assert [row.name for row in ready.relume.light_groups] == ["warm_lamp", "fluorescent"]
    assert bpy.data.objects["tungsten"].lightgroup == "warm_lamp"
    assert close(composite(ready, tmp_path / "b.exr"), before)
    ready.relume.light_groups["warm_lamp"].name = "fluorescent"
    assert [row.name for row in ready.relume.light_groups] == ["fluorescent 2", "fluorescent"], "no two share a name"


def test_groups_by_light_and_by_collection(ready):
    tungsten = ready.relume.light_groups["tungsten"]
    tungsten.stops, tungsten.illuminant = 1.5, "HP1"
    assert light_groups.regroup(ready, "COLLECTION") == 1
    assert light_groups.regroup(ready, "LIGHT") == 2
    assert {row.name for row in ready.relume.light_groups} == {"tungsten", "fluorescent"}
    assert all((row.illuminant, row.stops) == ("HP1", 1.5) for row in ready.relume.light_groups)
    assert light_groups.regroup(ready, "ILLUMINANT") == 1, "what shines alike shares a group"
    assert np.allclose(sockets(ready), expected(ready, ready.relume.lights()), atol=1e-5)


def test_a_group_without_lights_is_offered_for_removal(ready):
    assert light_groups.empty(ready) == []
    assert light_groups.add(ready, "fluorescent", [bpy.data.objects["tungsten"]]) == 1
    assert [row.name for row in ready.relume.light_groups] == ["fluorescent"]
    ready.relume.light_groups[0].stops = 1.0
    bpy.data.objects["tungsten"].lightgroup = bpy.data.objects["fluorescent"].lightgroup = "new"
    assert light_groups.empty(ready) == ["fluorescent"]
    assert light_groups.remove_empty(ready) == ["fluorescent"]
    assert [row.name for row in ready.relume.light_groups] == ["new"]


def animate(scene):
    """Tungsten fades from daylight to sodium within ten frames, fluorescent dims."""
    row = scene.relume.light_groups["tungsten"]
    row.source = "BLEND"
    row.blend[0].illuminant, row.blend[1].illuminant = "D65", "Sodium (low pressure)"
    for frame, weights in ((1, (1.0, 0.0)), (10, (0.0, 1.0))):
        for part, weight in zip(row.blend, weights, strict=True):
            part.weight = weight
            part.keyframe_insert("weight", frame=frame)
    other = scene.relume.light_groups["fluorescent"]
    for frame, stops in ((1, 0.0), (10, -3.0)):
        other.stops = stops
        other.keyframe_insert("stops", frame=frame)


def test_the_compositor_follows_an_animated_mix(ready, tmp_path):
    animate(ready)
    pictures = {}
    for frame in (1, 10):
        ready.frame_set(frame)
        assert np.allclose(sockets(ready), expected(ready, ready.relume.lights()), atol=1e-5)
        pictures[frame] = composite(ready, tmp_path / f"{frame}.exr")
    ready.frame_set(5)
    ready.frame_start, ready.frame_end, ready.frame_step = 1, 10, 9
    ready.render.filepath = str(tmp_path / "anim_")
    bpy.ops.render.render(animation=True)
    for frame, picture in pictures.items():
        assert close(read_exr(tmp_path / f"anim_{frame:04d}.exr"), picture), frame


def test_the_compositor_follows_a_driver(ready):
    ready["dimmer"] = 0.0
    driver = ready.driver_add("relume.light_groups[0].stops").driver
    driver.variables.new().name = "d"
    driver.variables["d"].type = "SINGLE_PROP"
    target = driver.variables["d"].targets[0]
    target.id_type, target.id, target.data_path = "SCENE", ready, '["dimmer"]'
    driver.expression = "d"
    bpy.context.view_layer.update()
    whole = sockets(ready)
    ready["dimmer"] = -1.0
    ready.update_tag()
    bpy.context.view_layer.update()
    assert np.allclose(sockets(ready)[0], 0.5 * whole[0], rtol=1e-4)
    assert np.allclose(sockets(ready)[1], whole[1], rtol=1e-4)


def test_a_saved_animated_mix_renders_the_same_without_relume(ready, tmp_path):
    animate(ready)
    ready.frame_start, ready.frame_end = 1, 10
    ready.frame_set(7)
    here = composite(ready, tmp_path / "here.exr")
    ready.frame_set(1)
    saved = tmp_path / "saved.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(saved))
    assert not baking.is_baked(ready), "the keyframes are in the file, not in the session"
    script = (
        "import bpy, sys\n"
        f"bpy.ops.wm.open_mainfile(filepath={str(saved)!r})\n"
        "assert not hasattr(bpy.types.Scene, 'relume')\n"
        f"bpy.context.scene.render.filepath = {str(tmp_path / 'elsewhere.exr')!r}\n"
        "bpy.context.scene.frame_set(7)\n"
        "bpy.ops.render.render(write_still=True)\n"
    )
    subprocess.run([sys.executable, "-c", script], check=True, capture_output=True, cwd=tmp_path)
    assert close(read_exr(tmp_path / "elsewhere.exr"), here)


def test_snapshots_keep_a_mix_and_are_compared_by_a_wipe(ready, tmp_path):
    settings = ready.relume
    before = composite(ready, tmp_path / "a.exr")
    assert bpy.ops.relume.take_snapshot() == {"FINISHED"}
    settings.light_groups["tungsten"].source = "PLANCKIAN"
    settings.light_groups["fluorescent"].stops = -2.0
    settings.white_balance = 0.7
    after = composite(ready, tmp_path / "b.exr")
    assert not close(before, after)
    settings.wipe = 0.25
    assert bpy.ops.relume.compare() == {"FINISHED"}
    both = composite(ready, tmp_path / "c.exr")
    edge = both.shape[1] // 4
    assert close(both[:, : edge - 1], after[:, : edge - 1]) and close(both[:, edge + 1 :], before[:, edge + 1 :])
    assert bpy.ops.relume.compare() == {"FINISHED"}
    assert close(composite(ready, tmp_path / "d.exr"), after)
    assert bpy.ops.relume.apply_snapshot() == {"FINISHED"}
    assert close(composite(ready, tmp_path / "e.exr"), before)


def test_removing_while_comparing_gives_the_room_back(room):
    before = dump()
    setup.set_up(room, bases.fitted(6))
    bpy.ops.relume.take_snapshot()
    bpy.ops.relume.compare()
    setup.remove(room)
    room.relume.snapshots.clear()
    for name in ("snapshots", "active_snapshot"):
        room.relume.property_unset(name)
    assert differences(before, dump()) == []


def test_write_to_lights_makes_the_mix_the_lighting(ready, tmp_path):
    ready.relume.light_groups["tungsten"].stops = -1.0
    mixed = composite(ready, tmp_path / "a.exr")
    assert light_groups.write_gains(ready) == []
    assert ready.relume.light_groups["tungsten"].stops == 0.0
    lit = composite(ready, tmp_path / "b.exr")
    assert abs(lit.mean() / mixed.mean() - 1.0) < 0.05


def test_relighting_an_exr_in_the_compositor(ready, tmp_path):
    image = render.render(ready, tmp_path).image
    lights = dict(zip(image.groups, ready.relume.lights(), strict=True))
    path = tmp_path / "shot.exr"
    coefficients.write(path, image, render.picture(image, lights))
    scene = exr.new_scene(path)
    assert close(composite(scene, tmp_path / "same.exr"), render.picture(image, lights), 1e-3)
    scene.relume.light_groups["tungsten"].source = "LIBRARY"
    scene.relume.light_groups["tungsten"].illuminant = "HP1"
    lights["tungsten"] = Light(library.illuminant("HP1"))
    assert close(composite(scene, tmp_path / "other.exr"), render.picture(image, lights), 1e-3)


def test_an_exr_of_other_groups_is_refused_and_nothing_changes(ready, tmp_path):
    image = render.render(ready, tmp_path).image
    picture = next(iter(image.groups.values()))[..., :3]
    path, other = tmp_path / "a.exr", tmp_path / "b.exr"
    coefficients.write(path, image, picture)
    renamed = coefficients.replace(
        image,
        groups={"moon": image.groups["tungsten"]},
        illuminants={"moon": image.illuminants["tungsten"]},
        gains={},
    )
    coefficients.write(other, renamed, picture)
    scene = exr.new_scene(path)
    before = mixer.choices(scene.relume)
    with pytest.raises(coefficients.CoefficientImageError, match="has the light groups moon, the mixer has tungsten"):
        exr.point_at(scene, other)
    assert mixer.choices(scene.relume) == before and scene.relume.exr == str(path)
    count = len(bpy.data.scenes)
    (tmp_path / "s.0001.exr").write_bytes(path.read_bytes())
    (tmp_path / "s.0003.exr").write_bytes(path.read_bytes())
    with pytest.raises(sequences.SequenceError, match="frames are missing: 2"):
        exr.new_scene(tmp_path / "s.####.exr")
    assert len(bpy.data.scenes) == count


def test_the_relight_command_takes_sequences_and_goes_on_where_it_was_stopped(ready, tmp_path, capfd):
    from relume.addon.cli import commands

    image = render.render(ready, tmp_path).image
    picture = render.picture(image, dict(zip(image.groups, ready.relume.lights(), strict=True)))
    for frame in (1, 2, 3):
        coefficients.write(tmp_path / f"shot.{frame:04d}.exr", image, picture)
    command = ["relight", str(tmp_path / "shot.####.exr"), "--light", "tungsten=HP1", "--out"]
    assert commands.execute([*command, str(tmp_path / "lit.####.png")]) == 0
    pictures = [tmp_path / f"lit.{frame:04d}.png" for frame in (1, 2, 3)]
    assert all(path.is_file() for path in pictures) and "relit 3 of 3" in capfd.readouterr().err
    pictures[1].unlink()
    before = [path.stat().st_mtime_ns for path in (pictures[0], pictures[2])]
    assert commands.execute([*command, str(tmp_path / "lit.####.png"), "--resume"]) == 0
    assert pictures[1].is_file() and before == [path.stat().st_mtime_ns for path in (pictures[0], pictures[2])]
    (tmp_path / "shot.0002.exr").unlink()
    capfd.readouterr()
    assert commands.execute([*command, str(tmp_path / "other.####.png")]) == 1
    assert "frames are missing: 2" in capfd.readouterr().err
    assert not list(tmp_path.glob("other.*")), "nothing is written of a sequence with holes"
    assert commands.execute([*command, str(tmp_path / "other.png")]) == 1
    assert "expected #### for the frame number" in capfd.readouterr().err
