"""`blender -b SCENE.blend -c relume`: the command in the real application."""

import json

import numpy as np
import OpenImageIO as oiio

SCENE = "assets/room.blend"


def test_render_writes_coefficients_and_pictures(blender_app, tmp_path):
    blender_app.check(
        *("-b", SCENE, "-c", "relume", "render"),
        *("--channels", "6", "--samples", "2", "--illuminant", "D65", "A", "--out", tmp_path),
    )
    assert {path.name for path in tmp_path.iterdir()} == {"room.exr", "room_D65.png", "room_A.png", "summary.json"}
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert (summary["channels"], summary["passes"]) == (6, 2)
    daylight, tungsten = (_mean(tmp_path / f"room_{name}.png") for name in ("D65", "A"))
    assert tungsten[0] / tungsten[2] > 1.5 * daylight[0] / daylight[2], "unadapted, tungsten is the redder light"


def test_what_is_printed_is_the_commands_own(blender_app, tmp_path):
    """Blender's own lines, of starting and of opening the file, come before; none while the command runs."""
    done = blender_app.run(
        "-b",
        SCENE,
        "-c",
        "relume",
        "render",
        "--channels",
        "3",
        "--samples",
        "1",
        "--out",
        tmp_path,
        "--frame",
        "-2--1",
    )
    assert done.returncode == 0
    assert not [word for word in ("Saved:", "Fra:", "Info:") if word in done.stdout]
    written = [line for line in done.stdout.splitlines() if line.startswith(str(tmp_path))]
    assert len(written) == 5 and written[-1] == str(tmp_path / "summary.json")


def test_a_failure_is_one_line_and_status_1(blender_app, tmp_path):
    done = blender_app.run("-b", SCENE, "-c", "relume", "render", "--illuminant", "D66", "--out", tmp_path)
    assert done.returncode == 1
    (line,) = [line for line in done.stdout.splitlines() if line.startswith("relume: ")]
    assert "D66" in line and "D65" in line
    assert "Traceback" not in done.stdout
    assert not list(tmp_path.iterdir())


def test_wrong_usage_is_status_2(blender_app):
    assert blender_app.run("-b", SCENE, "-c", "relume", "rendr").returncode == 2


def test_what_blender_renders_without_the_extension_is_relit_bit_for_bit(blender_app, tmp_path):
    saved = tmp_path / "shot.blend"
    blender_app.python(
        f"""
        import bpy
        scene = bpy.context.scene
        assert hasattr(scene, "relume")
        scene.cycles.samples, scene.relume.channels = 6, "6"
        scene.render.resolution_percentage = 10
        scene.render.image_settings.media_type = "MULTI_LAYER_IMAGE"
        scene.render.image_settings.color_depth = "32"
        assert bpy.ops.relume.set_up() == {{"FINISHED"}}
        scene.relume.light_groups["tungsten"].illuminant = "HP1"
        bpy.ops.wm.save_as_mainfile(filepath={str(saved)!r})
        """,
        SCENE,
    )
    stock = ("--factory-startup", "-b", saved, "-o", tmp_path / "farm_####", "-F", "OPEN_EXR_MULTILAYER", "-f", 3)
    assert "relume" not in blender_app.check(*stock, "--python-expr", "import bpy; print(dir(bpy.types.Scene))").lower()
    blender_app.check("-b", saved, "-c", "relume", "render", "--frame", 3, "--out", tmp_path)
    for name in ("farm_0003", "shot_0003"):
        source, out = tmp_path / f"{name}.exr", tmp_path / f"{name}_lit.exr"
        blender_app.check("-b", "-c", "relume", "relight", source, "--light", "fluorescent=D50*0.5", "--out", out)
    farm, own = (oiio.ImageBuf(str(tmp_path / f"{name}_0003_lit.exr")).get_pixels() for name in ("farm", "shot"))
    assert own.max() > 0.1
    np.testing.assert_array_equal(farm, own)


def _mean(picture):
    return oiio.ImageBufAlgo.computePixelStats(oiio.ImageBuf(str(picture))).avg[:3]
