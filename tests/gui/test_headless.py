"""`blender -b SCENE.blend -c relume`: the command in the real application."""

import json

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


def _mean(picture):
    return oiio.ImageBufAlgo.computePixelStats(oiio.ImageBuf(str(picture))).avg[:3]
