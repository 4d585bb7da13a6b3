"""Denoising: guided, and pass by pass; the picture once where that is chosen. Without: noise of colour taken out."""

import json
from dataclasses import replace

import bpy
import numpy as np
import pytest

from relume.addon.cli import commands
from relume.addon.graph import nodes
from relume.addon.host import denoising
from relume.addon.scene import follower, kept, render, setup, view_layers
from relume.addon.store import remarks
from relume.core.colour import differences
from relume.core.model import bases, upsample
from relume.core.picture import coefficients, recombination
from relume.core.picture.mix import Mix

pytestmark = pytest.mark.skipif(not denoising.available(), reason="this Blender has no denoiser")


@pytest.fixture
def noisy(room):
    """The room, with the denoiser on."""
    room.relume.split_samples, room.cycles.use_denoising = True, True
    room.cycles.samples = 48
    return room


def composited(scene, path):
    """F12 of a scene, (height, width, 3)."""
    output = scene.render.image_settings
    output.media_type, output.file_format, output.color_depth = "IMAGE", "OPEN_EXR", "32"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    return coefficients.read_rgb(path)


def denoisers(scene):
    return list(denoisers_in(scene.compositing_node_group))


def denoisers_in(tree):
    for node in tree.nodes:
        if node.type == "DENOISE":
            yield node
        elif node.type == "GROUP":
            yield from denoisers_in(node.node_tree)


def noise_nodes(scene):
    return [node for node in scene.compositing_node_group.nodes if nodes.role(node) == "noise"]


def test_the_picture_is_denoised_once_with_the_guides_of_the_first_pass_where_that_is_chosen(noisy):
    noisy.relume.denoise_passes = noisy.relume.reduce_color_noise = False
    setup.set_up(noisy)
    (node,) = denoisers(noisy)
    layers = view_layers.pass_layers(noisy)["ViewLayer"]
    for guide in ("Albedo", "Normal"):
        assert node.inputs[guide].links[0].from_node.layer == layers[0].name
    assert [layer.cycles.denoising_store_passes for layer in layers] == [True, False, False]
    setup.remove(noisy)
    assert not noisy.view_layers[0].cycles.denoising_store_passes


def sampled(rendered):
    return replace(rendered.image, groups=rendered.sampled)


def test_every_pass_by_itself_in_the_compositor_is_what_the_command_makes(noisy, tmp_path):
    noisy.relume.denoise_passes = False
    setup.set_up(noisy)
    once = composited(noisy, tmp_path / "once.exr")
    noisy.relume.denoise_passes = True
    assert len(denoisers(noisy)) == (3 + 1) * 2, "every light group of every pass, and of all"
    apart = composited(noisy, tmp_path / "apart.exr")
    rendered = render.render(noisy, tmp_path, guides=denoising.guides_of(noisy))
    lights = {row.name: row.light() for row in noisy.relume.light_groups}
    by_command = render.picture(denoising.denoised_image(sampled(rendered), rendered.guides), lights)
    assert np.abs(apart - by_command).max() <= 1e-3 * by_command.max() < np.abs(apart - once).max()
    noisy.relume.light_groups["tungsten"].name = "left"
    noisy.relume.light_groups["left"].illuminant = "Sodium (low pressure)"
    assert not np.allclose(composited(noisy, tmp_path / "sodium.exr"), apart, atol=1e-2)
    setup.remove(noisy)
    assert noisy.compositing_node_group is None and len(noisy.view_layers) == 1


@pytest.mark.parametrize("elsewhere", [False, True])
def test_what_is_not_denoised_has_the_same_brightness_in_every_pass_in_the_compositor_too(noisy, tmp_path, elsewhere):
    noisy.cycles.use_denoising = False
    if elsewhere:
        next(thing for thing in noisy.objects if thing.type == "LIGHT").lightgroup = ""
    setup.set_up(noisy, bases.fitted(9))
    assert not denoisers(noisy)
    rendered = render.render(noisy, tmp_path)
    assert rendered.guides == () and (coefficients.EVERYTHING_ELSE in rendered.image.groups) == elsewhere
    lights = dict(zip(rendered.image.groups, noisy.relume.lights(), strict=True))
    by_command = render.picture(rendered.image, lights)
    estimated = composited(noisy, tmp_path / "estimated.exr")
    np.testing.assert_allclose(estimated, by_command, rtol=1e-3, atol=1e-3)
    noisy.relume.reduce_color_noise = False
    assert not noise_nodes(noisy)
    plain = composited(noisy, tmp_path / "plain.exr")
    np.testing.assert_allclose(plain, render.picture(sampled(rendered), lights), rtol=1e-3, atol=1e-3)
    assert np.abs(plain - estimated).max() > 0.1
    setup.remove(noisy)
    assert not [tree for tree in bpy.data.node_groups if tree.get(nodes.ROLE) == "noise" and tree.users]


def test_another_light_shows_what_was_kept_as_a_render_denoises_it(noisy, tmp_path):
    noisy.cycles.samples = 9
    setup.set_up(noisy)
    first = composited(noisy, tmp_path / "first.exr")
    assert kept.KEPT not in {key for node in noisy.compositing_node_group.nodes for key in node.keys()}, "no window"
    bpy.data.images.new("Relume Denoised", 1, 1)[nodes.ROLE] = "denoised"  # as it is ready in a window
    composited(noisy, tmp_path / "kept.exr")
    kept.put(noisy)
    tree = noisy.compositing_node_group
    (reader,) = [node for node in tree.nodes if node.type == "IMAGE"]
    assert len([socket for socket in reader.outputs if socket.is_linked]) == 3 * 2
    assert not [socket for node in noise_nodes(noisy) for socket in node.outputs if socket.is_linked]
    noisy.cycles.samples = 1  # of which nothing is to be seen
    with follower.held():
        assert np.abs(composited(noisy, tmp_path / "read.exr") - first).max() <= 1e-5 * first.max()
        noisy.relume.light_groups["tungsten"].illuminant = "Sodium (low pressure)"
        sodium = composited(noisy, tmp_path / "sodium.exr")
    noisy.cycles.samples = 9
    rendered = composited(noisy, tmp_path / "rendered.exr")
    assert np.abs(sodium - rendered).max() <= 1e-5 * rendered.max() and not np.allclose(sodium, first, atol=1e-2)
    assert not [node for node in tree.nodes if node.type == "OUTPUT_FILE" and not node.get(kept.KEPT)]
    setup.remove(noisy)
    assert not [image for image in bpy.data.images if image.get(nodes.ROLE)]


def test_the_compositor_follows_the_artists_choice_of_guides(noisy):
    noisy.cycles.denoising_input_passes, noisy.cycles.denoising_prefilter = "RGB", "FAST"
    setup.set_up(noisy)
    for node in denoisers(noisy):
        assert not node.inputs["Albedo"].is_linked and not node.inputs["Normal"].is_linked
        assert node.inputs["Prefilter"].default_value == "Fast"


def test_each_pass_by_itself_leaves_the_least_error(noisy, tmp_path):
    noisy.relume.denoise_passes = noisy.relume.reduce_color_noise = False
    setup.set_up(noisy, bases.fitted(9))
    rendered = render.render(noisy, tmp_path, guides=denoising.guides_of(noisy))
    assert len(rendered.guides) == 3 and set(rendered.guides[0]) == {"Albedo", "Normal"}
    assert not view_layers.pass_layers(noisy)["ViewLayer"][2].cycles.denoising_store_passes, "put back"
    noisy.cycles.samples = 1500
    setup.set_up(noisy, bases.fitted(9))
    long_run = render.render(noisy, tmp_path)
    assert long_run.guides == ()
    lights = {row.name: row.light() for row in noisy.relume.light_groups}
    truth, noise = (render.picture(each.image, lights) for each in (long_run, rendered))
    apart = render.picture(denoising.denoised_image(rendered.image, rendered.guides), lights)
    together = denoising.denoised(noise, rendered.guides[0])

    def error(picture):
        to_xyz = upsample.rgb_to_xyz()
        white = recombination.mixed_white(bases.bands(), Mix(lights))
        return differences.picture_delta_E(picture @ to_xyz.T, truth @ to_xyz.T, white).mean()

    assert error(apart) < error(together) < 0.6 * error(noise)


def test_part_empty_passes_and_negative_coefficients_stay_what_they_are():
    height, width = 24, 32
    values = np.tile(np.array([0.4, 0.8, -0.2, 0.6]), (height, width, 1)).astype(np.float32)
    image = coefficients.CoefficientImage(bases.fitted(4), {"a": values}, {}, np.ones((height, width)))
    clean = denoising.denoised_image(image, [{}, {}]).groups["a"]
    assert clean.shape == values.shape
    # A plain picture is none to the denoiser: it dapples it by a few per cent
    assert np.allclose(np.median(clean, axis=(0, 1)), values[0, 0], atol=0.05)


def test_the_commands_coefficients_are_not_denoised_but_without_noise_of_colour_where_that_is_chosen(noisy, tmp_path):
    blend = tmp_path / "little.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    render_it = ["render", str(blend), "--samples", "6", "--illuminant", "D65", "A", "--out"]
    assert commands.execute([*render_it, str(tmp_path / "clean")]) == 0
    noisy = bpy.context.scene
    setup.remove(noisy)
    noisy.cycles.use_denoising = False
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    assert commands.execute([*render_it, str(tmp_path / "noisy")]) == 0
    bpy.context.scene.relume.reduce_color_noise = False
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    assert commands.execute([*render_it, str(tmp_path / "sampled")]) == 0
    ways = {name: tmp_path / name for name in ("clean", "noisy", "sampled")}
    kept = {name: coefficients.read(folder / "little.exr").groups["tungsten"] for name, folder in ways.items()}
    np.testing.assert_allclose(kept["clean"], kept["noisy"], rtol=1e-5, atol=1e-6)
    ratios = kept["noisy"] / np.maximum(kept["sampled"], 1e-6)
    assert np.ptp(ratios[..., :3], axis=-1).max() < 1e-3 < ratios.std(), "a pass is scaled as a whole"
    said = {name: json.loads((folder / "summary.json").read_text())["frames"][0] for name, folder in ways.items()}
    assert [each["reduced_color_noise"] for each in said.values()] == [True, True, False]
    shown = [(tmp_path / name / "little_A.png").read_bytes() for name in ("clean", "noisy")]
    assert shown[0] != shown[1]
    assert json.loads((tmp_path / "clean/summary.json").read_text())["passes"] == 3


def test_a_blender_without_denoiser_says_so(noisy, monkeypatch):
    monkeypatch.setattr(denoising, "available", lambda: False)
    setup.set_up(noisy)
    assert any("no denoiser" in remark.why for remark in remarks.of(noisy))
