"""What a Blender without Relume renders of a scene that is set up can be relit: exactly, or with a reason why not."""

import json
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import OpenImageIO as oiio
import pytest
from test_render import close, composite

from relume.addon.cli import commands
from relume.addon.scene import describe, exr, follower, render, setup
from relume.core.colour import differences
from relume.core.errors import CoefficientImageError
from relume.core.picture import coefficients, description, noise, note, recombination
from relume.core.spectra import library

NAME = "Küche, 2 'a'"  # of a light group

# What the artist, or the farm, chooses: file -> statements about the scene `s`
VARIANTS = {
    "parts": "",
    "interleaved": "i.use_exr_interleave = True",
    "half": "i.color_depth = '16'; i.use_exr_interleave = True",
    "more": "s.view_layers['ViewLayer'].use = True; layer.use_pass_cryptomatte_object = layer.use_pass_z = True",
    "border": "r.use_border = True; r.border_min_x = r.border_min_y = 0.25; r.border_max_x = r.border_max_y = 0.75",
    "crop": "r.use_crop_to_border = True",
    "small": "r.use_border = r.use_crop_to_border = False; r.resolution_percentage = 5",
    "few": "s.view_layers['ViewLayer 2'].use = False",
}


def stock(blend: Path, folder: Path, variants: dict[str, str]) -> dict[str, Path]:
    """Render a .blend with a Blender that has no Relume, in each variant after the one before."""
    lines = [
        "import bpy",
        f"bpy.ops.wm.open_mainfile(filepath={str(blend)!r})",
        "assert not hasattr(bpy.types.Scene, 'relume')",
        "s = bpy.context.scene; r = s.render; i = r.image_settings; layer = s.view_layers.get('ViewLayer 1')",
        "i.media_type = 'MULTI_LAYER_IMAGE'; i.file_format = 'OPEN_EXR_MULTILAYER'; i.color_depth = '32'",
    ]
    for name, statements in variants.items():
        lines += ["i.use_exr_interleave = False; i.color_depth = '32'", statements]
        lines += [f"r.filepath = {str(folder / name)!r}", "bpy.ops.render.render(write_still=True)"]
    subprocess.run([sys.executable, "-c", "\n".join(lines)], check=True, capture_output=True, cwd=folder)
    return {name: folder / f"{name}.exr" for name in variants}


def opened_room(model=None):
    from relume.assets import make_room

    bpy.ops.wm.open_mainfile(filepath=str(make_room.PATH))
    scene = bpy.context.scene
    scene.render.resolution_percentage, scene.cycles.samples, scene.relume.channels = 10, 6, "9"
    scene.render.stamp_note_text = "shot 7, Ä"
    for thing in scene.objects:
        if thing.lightgroup == "tungsten":
            thing.lightgroup = NAME
        elif thing.lightgroup:
            thing.lightgroup = ""
    setup.set_up(scene, model)
    scene.relume.light_groups[NAME].source = "BLEND"
    scene.relume.light_groups[NAME].blend[0].illuminant = "LED-B1"
    scene.relume.light_groups[NAME].blend[1].weight = 0.3
    scene.relume.light_groups[NAME].stops = 0.7
    scene.relume.light_groups[coefficients.EVERYTHING_ELSE].illuminant = "FL11"
    scene.relume.white_balance, scene.relume.observer = 0.6, "CIE 1964 10°"
    scene.view_settings.exposure = 0.5
    return scene


def lit(path: Path, scene=None) -> np.ndarray:
    image = coefficients.read(path, scene)
    return coefficients.recombine(list(image.groups.values()), image.matrices())


@pytest.fixture(scope="module")
def farm(relume, tmp_path_factory):
    """A folder with room.blend, own.exr as `relume render` writes it, and a stock EXR for each variant."""
    folder = tmp_path_factory.mktemp("farm")
    scene = opened_room()
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "room.blend"))
    image = render.render(scene, folder).image
    coefficients.write(folder / "own.exr", image, coefficients.recombine(list(image.groups.values()), image.matrices()))
    stock(folder / "room.blend", folder, VARIANTS)
    return folder


@pytest.fixture
def empty_file():
    bpy.ops.wm.read_factory_settings()


@pytest.mark.parametrize("name", ["parts", "interleaved", "more"])
def test_a_stock_render_is_bit_equal_to_a_render_of_relume(farm, tmp_path, name):
    own, found = coefficients.read(farm / "own.exr"), coefficients.read(farm / f"{name}.exr")
    assert list(found.groups) == [NAME, coefficients.EVERYTHING_ELSE] == list(own.groups)
    for group in own.groups:
        np.testing.assert_array_equal(found.groups[group], own.groups[group])
    assert found.view == own.view and found.space == own.space
    pictures = []
    for source in (farm / "own.exr", farm / f"{name}.exr"):
        out = tmp_path / source.name
        assert commands.execute(["relight", str(source), "--light", f"{NAME}=HP1*0.5", "--out", str(out)]) == 0
        pictures.append(coefficients.read_rgb(out))
    np.testing.assert_array_equal(*pictures)
    np.testing.assert_array_equal(lit(farm / f"{name}.exr"), lit(farm / "own.exr"))


def test_half_floats_cost_less_than_can_be_seen(farm):
    image, half = (coefficients.read(farm / f"{name}.exr") for name in ("own", "half"))
    assert not np.array_equal(image.groups[NAME], half.groups[NAME]), "else this is not half float"
    lights = image.mix().lights
    white = recombination.mixed_white(image.model, image.mix())
    difference = differences.picture_delta_E(
        coefficients.to_xyz(half, lights), coefficients.to_xyz(image, lights), white
    )
    assert np.median(difference) < 0.1


def test_a_border_is_dark_around_and_a_crop_is_a_smaller_picture(farm, monkeypatch):
    monkeypatch.setattr(noise, "estimated", lambda groups, guides: groups)  # of pixels around, which a crop has not
    border, crop = (coefficients.read(farm / f"{name}.exr") for name in ("border", "crop"))
    assert border.size == coefficients.read(farm / "own.exr").size and crop.size == (24, 18)
    assert border.alpha[:8].max() == 0.0 and border.alpha[10:26, 13:35].min() > 0.0
    np.testing.assert_array_equal(border.groups[NAME][9:27, 12:36], crop.groups[NAME])


@pytest.mark.parametrize("name", ["own", "parts", "interleaved", "half", "more", "crop"])
def test_the_compositor_shows_what_relume_relight_writes(farm, tmp_path, empty_file, name):
    path = farm / f"{name}.exr"
    scene = exr.new_scene(path)
    scene.render.engine, scene.render.compositor_precision = "CYCLES", "FULL"
    assert close(composite(scene, tmp_path / "as_lit.exr"), lit(path), 1e-5)
    scene.relume.light_groups[NAME].source = "LIBRARY"
    scene.relume.light_groups[NAME].illuminant = "HP1"
    image = coefficients.read(path)
    lights = dict(zip(image.groups, scene.relume.lights(), strict=True))
    assert close(composite(scene, tmp_path / "relit.exr"), render.picture(image, lights), 1e-5)
    np.testing.assert_array_equal(exr.read_current(scene).groups[NAME], image.groups[NAME])


def test_a_scene_is_pointed_at_another_stock_render_and_refuses_what_is_other(farm, tmp_path, empty_file):
    scene = exr.new_scene(farm / "parts.exr")
    images, before = len(bpy.data.images), scene.compositing_node_group.nodes["Image"].image
    exr.point_at(scene, farm / "crop.exr")
    assert len(bpy.data.images) == images and before is not scene.compositing_node_group.nodes["Image"].image
    scene.render.engine, scene.render.compositor_precision = "CYCLES", "FULL"
    assert close(composite(scene, tmp_path / "crop.exr"), lit(farm / "crop.exr"), 1e-5)
    for other, words in (("own", "other view layers"), ("few", "'ViewLayer 2.Combined_Küche, 2 'a'' is missing")):
        with pytest.raises(CoefficientImageError, match=f"{other}.exr: .*{words}".replace("'", ".")):
            exr.point_at(scene, farm / f"{other}.exr")
        assert scene.relume.exr == str(farm / "crop.exr") and len(bpy.data.images) == images


def test_a_sequence_of_stock_renders(farm, tmp_path, empty_file, capsys):
    for frame, name in enumerate(("parts", "interleaved"), 1):
        (tmp_path / f"shot.{frame:04d}.exr").write_bytes((farm / f"{name}.exr").read_bytes())
    command = ["relight", str(tmp_path / "shot.####.exr"), "--out", str(tmp_path / "lit.####.exr")]
    assert commands.execute(command) == 0
    np.testing.assert_array_equal(coefficients.read_rgb(tmp_path / "lit.0002.exr"), lit(farm / "own.exr"))
    scene = exr.new_scene(tmp_path / "shot.####.exr")
    assert (scene.frame_start, scene.frame_end) == (1, 2)
    (tmp_path / "shot.0003.exr").write_bytes((farm / "small.exr").read_bytes())
    scenes = len(bpy.data.scenes)
    with pytest.raises(CoefficientImageError, match=r"shot.0003.exr: .* size than shot.0001.exr: 24 × 18"):
        exr.new_scene(tmp_path / "shot.####.exr")
    assert len(bpy.data.scenes) == scenes
    assert commands.execute(command) == 1
    assert "shot.0003.exr: " in capsys.readouterr().err


def rewritten(source: Path, out: Path, change=None, note_text=None) -> Path:
    """Write an EXR again, one part per part; change(spec, pixels) of each part gives what it becomes, None drops it."""
    reader, kept, part = oiio.ImageInput.open(str(source)), [], 0
    while reader.seek_subimage(part, 0):
        spec, pixels = reader.spec(), reader.read_image(part, 0, 0, reader.spec().nchannels, "float")
        if note_text is not None and part == 0:
            spec.attribute("Note", note_text)
        each = (spec, pixels) if change is None else change(spec, pixels)
        kept += [] if each is None else [each]
        part += 1
    writer = oiio.ImageOutput.create(str(out))
    assert writer.open(str(out), tuple(spec for spec, _ in kept)), writer.geterror()
    for index, (spec, pixels) in enumerate(kept):
        assert not index or writer.open(str(out), spec, "AppendSubimage")
        assert writer.write_image(np.ascontiguousarray(pixels)), writer.geterror()
    assert writer.close()
    return out


def test_what_is_missing_or_cropped_is_named(farm, tmp_path):
    with pytest.raises(CoefficientImageError, match=r"few.exr: pass .ViewLayer 2.Combined_.* is missing; render all"):
        coefficients.read(farm / "few.exr")

    def cropped(spec, pixels):
        if spec.channelnames[0].startswith("ViewLayer 3.Combined_"):
            spec.x, spec.width = 4, spec.width - 4
            return spec, pixels[:, 4:]
        return spec, pixels

    path = rewritten(farm / "parts.exr", tmp_path / "cropped.exr", cropped)
    for read in (coefficients.read, coefficients.describe, exr.new_scene):
        with pytest.raises(CoefficientImageError, match=r"cropped.exr: .* .ViewLayer 3.* is cropped to 44 × 36 at 4"):
            read(path)


def test_a_render_without_a_note_says_what_to_do_and_takes_the_scene(farm, tmp_path, capsys):
    path = rewritten(farm / "parts.exr", tmp_path / "bare.exr", note_text="the artist's own")
    command = ["relight", str(path), "--out", str(tmp_path / "x.exr")]
    assert commands.execute(command) == 1
    assert "bare.exr: no Relume header and no Relume note; give the scene (room.blend) with --scene" in (
        capsys.readouterr().err
    )
    assert commands.execute([*command, "--scene", str(farm / "room.blend")]) == 0
    np.testing.assert_array_equal(coefficients.read_rgb(tmp_path / "x.exr"), lit(farm / "own.exr"))
    web = ["web", str(path), "--lamps", "A", "--size", "16", "--out", str(tmp_path / "x.html")]
    assert commands.execute(web) == 1 and not (tmp_path / "x.html").exists()
    assert commands.execute([*web, "--scene", str(farm / "room.blend")]) == 0
    assert commands.execute(["describe", str(farm / "room.blend"), "--out", str(tmp_path / "relume.json")]) == 0
    assert commands.execute(command) == 1, "who knows whose that is"
    (tmp_path / "relume.json").rename(tmp_path / "bare.relume.json")
    assert exr.new_scene(path).relume.light_groups[0].name == NAME
    assert commands.execute(command) == 0
    np.testing.assert_array_equal(coefficients.read_rgb(tmp_path / "x.exr"), lit(farm / "own.exr"))


def test_a_scene_of_the_first_version_still_works(farm, tmp_path):
    bpy.ops.wm.open_mainfile(filepath=str(farm / "room.blend"))
    scene = bpy.context.scene
    scene.render.stamp_note_text, scene.render.use_stamp_note = "the artist's own", True
    del scene["relume_note_off"]
    description_before = describe.description_of(scene)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "later.blend"))
    assert note.read(scene.render.stamp_note_text).model[:2] == ("fitted", 9)
    assert note.mix_of(note.read(scene.render.stamp_note_text)) == description_before.mix
    setup.remove(scene)
    assert scene.render.stamp_note_text == "the artist's own" and scene.render.use_stamp_note


def test_the_artists_note_stays_and_comes_back(tmp_path):
    scene = opened_room()
    for own in ("shot 7, Ä", "", "ends with blanks  ", "x" * 500):
        scene.render.stamp_note_text = own
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
        assert scene.render.stamp_note_text.startswith(own) and scene.render.use_stamp_note == (len(own) < 500)
        assert len(scene.render.stamp_note_text.encode()) <= 511
        assert ("relume1" in scene.render.stamp_note_text) == (len(own) < 500)
        assert note.without(scene.render.stamp_note_text) == own
    scene.render.stamp_note_text = "shot 7, Ä"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    scene.render.use_stamp = True  # burnt into the picture, where ours must not stand
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    assert scene.render.stamp_note_text == "shot 7, Ä" and not scene.render.use_stamp_note
    scene.render.use_stamp = False
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    setup.remove(scene)
    assert scene.render.stamp_note_text == "shot 7, Ä" and not scene.render.use_stamp_note
    assert not [key for key in scene.keys() if key.startswith("relume_")]


def test_what_does_not_fit_comes_from_a_sidecar_of_this_very_scene(tmp_path, capsys):
    scene = opened_room()
    lamp = tmp_path / "lamp.csv"
    lamp.write_text("nm,power\n" + "".join(f"{nm},{1 + (nm % 70)}\n" for nm in range(380, 781, 5)))
    scene.relume.light_groups[NAME].source = "FILE"
    scene.relume.light_groups[NAME].path = str(lamp)
    blend = tmp_path / "room.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    image = render.render(scene, tmp_path).image
    true = coefficients.recombine(list(image.groups.values()), image.matrices())
    path = stock(blend, tmp_path, {"room_0001": ""})["room_0001"]
    out = tmp_path / "x.exr"
    command = ["relight", str(path), "--out", str(out)]
    assert commands.execute(command) == 1
    assert "room_0001.exr: needs the mix, which does not fit into the note; write a sidecar" in capsys.readouterr().err
    assert commands.execute([*command, "--scene", str(blend)]) == 0
    np.testing.assert_array_equal(coefficients.read_rgb(out), true)
    out.unlink()
    sidecar = tmp_path / "room.relume.json"
    assert commands.execute(["describe", str(blend), "--out", str(sidecar)]) == 0
    assert commands.execute(command) == 0
    np.testing.assert_array_equal(coefficients.read_rgb(out), true)
    np.testing.assert_array_equal(lit(path), true)
    # An older mix, then another scene
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    scene = bpy.context.scene
    scene.relume.light_groups[NAME].stops = 0.1
    description.write(sidecar, describe.description_of(scene))
    with pytest.raises(CoefficientImageError, match="room.relume.json beside it is another scene's or of an older mix"):
        coefficients.read(path)
    sidecar.write_text(json.dumps(json.loads(sidecar.read_text()) | {"space": "mud"}))
    with pytest.raises(CoefficientImageError, match="room.relume.json: space: expected one of Linear Rec.709"):
        coefficients.read(path)


def test_a_model_of_the_scene_comes_from_a_sidecar_or_the_scene(tmp_path):
    own = [library.reflectance(f"ColorChecker: {name}") for name in ("red", "green", "blue")]
    from relume.core.model import bases

    scene = opened_room(bases.scene(6, own, [library.illuminant("LED-B1")]))
    blend = tmp_path / "room.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    image = render.render(scene, tmp_path).image
    path = stock(blend, tmp_path, {"room": ""})["room"]
    described = describe.description_of(scene)
    with pytest.raises(CoefficientImageError, match="needs the scene's own model of 6 channels; write a sidecar"):
        coefficients.read(path)
    description.write(tmp_path / "relume.json", described)
    found = coefficients.read(path)
    for group in image.groups:
        np.testing.assert_array_equal(found.groups[group], image.groups[group])
    np.testing.assert_allclose(found.matrices(), image.matrices(), rtol=0, atol=1e-12)
    other = describe.description_of(opened_room())
    with pytest.raises(CoefficientImageError, match="room.exr: was rendered from another scene"):
        coefficients.read(path, other)


def test_of_several_view_layers_one_is_taken_and_the_others_are_named(tmp_path, capsys):
    scene = opened_room()
    setup.remove(scene)
    scene.view_layers.new("Left. Ä")
    apart = bpy.data.collections.new("apart")
    scene.collection.children.link(apart)
    for ball in [thing for thing in scene.objects if thing.type == "MESH"][-1:]:
        apart.objects.link(ball)
        for collection in [c for c in ball.users_collection if c != apart]:
            collection.objects.unlink(ball)
    scene.view_layers["Left. Ä"].layer_collection.children["apart"].exclude = True
    setup.set_up(scene)
    blend = tmp_path / "two.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    path = stock(blend, tmp_path, {"two": ""})["two"]
    command = ["relight", str(path), "--out", str(tmp_path / "x.exr")]
    assert commands.execute(command) == 0
    assert "took view layer 'ViewLayer'; --layer takes 'Left. Ä'" in capsys.readouterr().err
    first = coefficients.read_rgb(tmp_path / "x.exr")
    assert commands.execute([*command, "--layer", "Left. Ä"]) == 0
    assert not np.array_equal(coefficients.read_rgb(tmp_path / "x.exr"), first)
    assert commands.execute([*command, "--layer", "Right"]) == 1
    assert "two.exr: no view layer 'Right'; there are ViewLayer, Left. Ä" in capsys.readouterr().err
    web = ["web", str(path), "--lamps", "A", "--size", "16", "--out"]
    for name, layer in (("first", []), ("left", ["--layer", "Left. Ä"])):
        assert commands.execute([*web, str(tmp_path / f"{name}.html"), *layer]) == 0
    assert (tmp_path / "first.html").read_bytes() != (tmp_path / "left.html").read_bytes()
    assert commands.execute([*web, str(tmp_path / "right.html"), "--layer", "Right"]) == 1
    assert "two.exr: no view layer 'Right'" in capsys.readouterr().err and not (tmp_path / "right.html").exists()


def test_renamed_passes_and_an_animated_mix(tmp_path, capsys):
    scene = opened_room()
    scene.view_layers["ViewLayer 2"].name = "renamed"
    row = scene.relume.light_groups[NAME]
    for frame, stops in ((1, 0.0), (10, 3.0)):
        row.stops = stops
        row.keyframe_insert("stops", frame=frame)
    scene.frame_set(4)
    blend = tmp_path / "moving.blend"
    with follower.held():  # it would give the pass back its name
        bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    found = note.read(scene.render.stamp_note_text)
    assert found.animated and found.layers == [["ViewLayer", "ViewLayer 1", "renamed", "ViewLayer 3"]]
    assert found.lights[0].gain == pytest.approx(2.0**row.stops) and 0.5 < row.stops < 1.5
    path = stock(blend, tmp_path, {"moving": ""})["moving"]
    assert commands.execute(["relight", str(path), "--out", str(tmp_path / "x.exr")]) == 0
    assert "the mix is animated" in capsys.readouterr().err
