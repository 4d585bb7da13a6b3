"""Rendering: the compositor, the saved EXR and numpy agree; the file needs no add-on; metamers and metals come out."""

import json
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest

from relume.addon.scene import render, setup
from relume.core.colour import spaces
from relume.core.model import bases
from relume.core.picture import coefficients, recombination
from relume.core.picture.mix import Mix
from relume.core.spectra import library


def read_exr(path: Path, prefix: str = "") -> np.ndarray:
    """(height, width, 3) of the channels R, G, B of an EXR's first part."""
    import OpenImageIO as oiio

    image = oiio.ImageInput.open(str(path))
    names = image.spec().channelnames
    pixels = image.read_image("float")
    image.close()
    return pixels[..., [names.index(prefix + c) for c in "RGB"]]


def composite(scene, path: Path) -> np.ndarray:
    """F12 of a scene through its compositor into a linear EXR; (height, width, 3)."""
    output = scene.render.image_settings
    output.media_type, output.file_format, output.color_depth = "IMAGE", "OPEN_EXR", "32"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True, scene=scene.name)
    return read_exr(path)


def close(a, b, relative: float = 1e-4) -> bool:
    return np.abs(a - b).max() <= relative * np.abs(b).max()


def test_compositor_file_and_numpy_agree(room, tmp_path):
    setup.set_up(room)
    room.relume.light_groups["tungsten"].illuminant = "HP1"
    room.relume.light_groups["fluorescent"].gain = 0.5
    room.relume.white_balance = 0.6
    composited = composite(room, tmp_path / "f12.exr")
    image = render.render(room, tmp_path).image
    lights = {row.name: row.light() for row in room.relume.light_groups}
    coefficients.write(tmp_path / "room.exr", image, render.picture(image, lights))
    relit = render.picture(coefficients.read(tmp_path / "room.exr"), lights)
    white = recombination.mixed_white(image.model, Mix(lights))
    to_rgb = spaces.xyz_to_rgb() @ spaces.adaptation(white, np.linalg.inv(spaces.xyz_to_rgb()).sum(axis=1), 0.6)
    by_hand = np.einsum(
        "ij,jp,hwp->hwi", to_rgb, image.model.relight(library.illuminant("HP1")), image.groups["tungsten"]
    )
    by_hand += 0.5 * np.einsum(
        "ij,jp,hwp->hwi", to_rgb, image.model.relight(library.illuminant("FL2")), image.groups["fluorescent"]
    )
    assert by_hand.max() > 0.1
    assert close(composited, by_hand)
    assert close(relit, by_hand)
    assert close(read_exr(tmp_path / "room.exr"), by_hand)


@pytest.mark.parametrize("channels", [1, 5])
def test_a_last_pass_may_be_part_empty(room, tmp_path, channels):
    model = bases.fitted(channels)
    setup.set_up(room, model)
    composited = composite(room, tmp_path / "f12.exr")
    image = render.render(room, tmp_path).image
    assert all(group.shape[2] == channels for group in image.groups.values())
    lights = {row.name: row.light() for row in room.relume.light_groups}
    assert close(composited, render.picture(image, lights))
    assert composited.mean() > 0.05


def test_the_illuminant_changes_the_composited_picture_without_new_coefficients(room, tmp_path):
    setup.set_up(room)
    before = composite(room, tmp_path / "a.exr")
    for row in room.relume.light_groups:
        row.illuminant = "Sodium (low pressure)"
    after = composite(room, tmp_path / "b.exr")
    assert after[..., 2].mean() < 0.05 * before[..., 2].mean() and after.mean() > 0.05


def test_light_outside_every_group_is_recombined_too(room, tmp_path):
    bpy.data.objects["fluorescent"].lightgroup = ""
    setup.set_up(room)
    assert [row.name for row in room.relume.light_groups] == ["tungsten", coefficients.EVERYTHING_ELSE]
    room.relume.light_groups["tungsten"].gain = 0.0
    composited = composite(room, tmp_path / "f12.exr")
    image = render.render(room, tmp_path).image
    lights = {row.name: row.light() for row in room.relume.light_groups}
    assert close(composited, render.picture(image, lights))
    assert composited.mean() > 0.02


def test_the_saved_file_renders_the_same_without_relume(room, tmp_path):
    setup.set_up(room)
    saved = tmp_path / "saved.blend"
    here = composite(room, tmp_path / "here.exr")
    bpy.ops.wm.save_as_mainfile(filepath=str(saved))
    script = (
        "import bpy, sys\n"
        f"bpy.ops.wm.open_mainfile(filepath={str(saved)!r})\n"
        "assert not hasattr(bpy.types.Scene, 'relume') and 'relume' not in sys.modules\n"
        f"bpy.context.scene.render.filepath = {str(tmp_path / 'elsewhere.exr')!r}\n"
        "bpy.ops.render.render(write_still=True)\n"
    )
    subprocess.run([sys.executable, "-c", script], check=True, capture_output=True, cwd=tmp_path)
    assert np.array_equal(read_exr(tmp_path / "elsewhere.exr"), here)


def test_a_flat_wall_has_the_coefficients_of_its_reflectance(room, tmp_path):
    """A wall under lamps of 1 that sees no other surface: its channels are in proportion to its coefficients."""
    room.cycles.max_bounces = 0
    setup.set_up(room)
    room.relume.same_seed = True
    setup.set_up(room)
    image = render.render(room, tmp_path).image
    left = sum(image.groups.values())[10:26, 0]
    expected = image.model.coefficients(library.reflectance("ColorChecker: red"))
    assert left.mean() > 0.01
    assert np.allclose(left / left[:, -1:], expected / expected[-1], rtol=1e-3)


def test_an_rgb_scene_under_daylight_keeps_its_colours(startup, tmp_path):
    """One bounce, white lamps, D65 on everything: the spectral picture is the RGB picture."""
    bpy.data.lights["Light"].color = (1.0, 1.0, 1.0)
    startup.render.engine = "CYCLES"
    startup.cycles.max_bounces = 0
    startup.cycles.samples = 64
    startup.relume.split_samples = False
    startup.relume.same_seed = True
    plain = composite(startup, tmp_path / "rgb.exr")
    setup.set_up(startup)
    spectral = composite(startup, tmp_path / "spectral.exr")
    assert np.abs(plain[..., 0] - plain[..., 2]).max() > 0.1, "the scene is coloured"
    assert np.abs(spectral - plain).mean() < 0.002 * plain.mean()


def test_gold_reflects_as_its_complex_index_says(tmp_path):
    """A mirror of gold in a white furnace, against Fresnel's equations integrated over the spectrum at 1 nm."""
    model = bases.fitted(9)
    from relume.core.model import fresnel

    n, k = library.conductor("gold")
    fine = np.arange(380.0, 781.0)
    spectrum = fresnel.reflectance(n.sampled(fine), k.sampled(fine), 1.0)
    expected = model.coefficients(np.interp(model.wavelengths, fine, spectrum))
    n_p, k_p = fresnel.conductor_channels(model, n, k)
    assert np.allclose(fresnel.reflectance(n_p, k_p, 1.0), expected, atol=5e-3)


@pytest.mark.parametrize("arguments", [["--channels", "6"], ["--channels", "9", "--frame", "3-4"]])
def test_the_render_command(room, tmp_path, arguments):
    from relume.addon.cli import commands

    scene = tmp_path / "little.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(scene))
    untouched = scene.read_bytes()
    out = tmp_path / "out"
    status = commands.execute(
        ["render", str(scene), "--illuminant", "D65", "tungsten=FL11", "--out", str(out), *arguments]
    )
    assert status == 0
    summary = json.loads((out / "summary.json").read_text())
    assert summary["channels"] == int(arguments[1])
    names = [f"little{f}" for f in (["_0003", "_0004"] if "--frame" in arguments else [""])]
    assert sorted(p.name for p in out.iterdir()) == sorted(
        ["summary.json", *(f"{n}.exr" for n in names), *(f"{n}_D65.png" for n in names)]
    )
    assert summary["frames"][0]["light_groups"] == {"tungsten": "FL11", "fluorescent": "FL2"}
    assert scene.read_bytes() == untouched
    assert (
        commands.execute(
            ["relight", str(out / f"{names[0]}.exr"), "--light", "tungsten=A*2", "--out", str(out / "x.png")]
        )
        == 0
    )
    as_lit, tungsten = (
        coefficients.read_rgb(out / f"{name}.png").mean(axis=(0, 1)) for name in (f"{names[0]}_D65", "x")
    )
    assert tungsten[0] / tungsten[2] > 1.1 * as_lit[0] / as_lit[2], "one lamp is redder than daylight"


@pytest.mark.parametrize(
    ("arguments", "status", "words"),
    [
        (["render"], 2, "SCENE.blend"),
        (["render", "no.blend"], 1, "no.blend: no such file"),
        (["render", "text.blend"], 1, "text.blend: not a file that Blender can open"),
        (["render", "little.blend", "--illuminant", "Sodum"], 1, "nearest: Sodium"),
        (["render", "little.blend", "--illuminant", "moon=A"], 1, "no light group 'moon'"),
        (["render", "little.blend", "--out", "/proc/nowhere"], 1, "/proc/nowhere: cannot write there"),
        (["render", "little.blend", "--samples", "0"], 2, "0 is not 1 or more"),
        (["relight", "no.exr", "--out", "x.png"], 1, "no.exr: no such file"),
        (["relight", "text.blend", "--out", "x.png"], 1, "text.blend"),
        (["relight", "no.exr", "--out", "x.jpg"], 1, "x.jpg: a picture's name ends in .png"),
        (["relight", "no.exr", "--white", "2", "--out", "x.png"], 2, "none, full or a number from 0 to 1"),
    ],
)
def test_bad_input_is_one_line(room, tmp_path, monkeypatch, capfd, arguments, status, words):
    from relume.addon.cli import commands

    monkeypatch.chdir(tmp_path)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "little.blend"))
    (tmp_path / "text.blend").write_text("not a blend")
    before = sorted(tmp_path.iterdir())
    capfd.readouterr()
    assert commands.execute(arguments) == status
    said = [line for line in capfd.readouterr().err.splitlines() if line.startswith("relume")]
    assert words in said[-1]
    assert status == 2 or len(said) == 1
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no limit on the size of a file")
def test_a_disk_that_fills_up_leaves_no_partial_files(room, tmp_path):
    scene, out = tmp_path / "little.blend", tmp_path / "out"
    out.mkdir()
    bpy.ops.wm.save_as_mainfile(filepath=str(scene))
    script = (
        "import resource\n"
        "from relume.__main__ import main\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))\n"
        f"main(['render', {str(scene)!r}, '--out', {str(out)!r}])\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 1
    assert "disk full" in done.stderr.splitlines()[-1]
    assert list(out.iterdir()) == []
