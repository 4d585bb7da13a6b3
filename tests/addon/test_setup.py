"""Setting up, removing, and the shared state of several scenes."""

import re

import bpy
import numpy as np
import pytest
from dump import differences, dump
from mathutils import Color

from relume.addon.scene import render, render_settings, setup, view_layers
from relume.core.errors import SetupError
from relume.core.model import bases, relight
from relume.core.spectra import library

lamps_without_nodes = pytest.mark.xfail(
    bpy.app.version < (5, 1, 0), reason="Blender 5.0 cannot take back a lamp's node tree: it stays, unused", strict=True
)


@pytest.mark.parametrize("channels", ["3", "9", "reference"])
def test_remove_gives_back_the_room(room, channels):
    room.relume.channels = channels
    before = dump()
    setup.set_up(room)
    assert differences(before, dump()), "setting up must change something, or this test shows nothing"
    setup.remove(room)
    assert differences(before, dump()) == []


@lamps_without_nodes
def test_remove_gives_back_a_scene_with_colours(startup):
    before = dump()
    setup.set_up(startup)
    assert bpy.data.lights["Light"].color == Color((1.0, 1.0, 1.0)), "the lamp's colour stands in its nodes"
    setup.remove(startup)
    assert differences(before, dump()) == []


def test_setting_up_twice_is_setting_up_once(startup):
    setup.set_up(startup)
    once = dump()
    setup.set_up(startup)
    assert differences(once, dump()) == []


def test_undo_after_set_up_leaves_a_scene_that_can_be_removed(room):
    setup.set_up(room)
    assert [layer.name for layer in view_layers.pass_layers(room)["ViewLayer"]] == [f"ViewLayer {k}" for k in (1, 2, 3)]
    assert not room.view_layers["ViewLayer"].use


def test_passes_render_disjoint_parts_of_one_sequence(room, tmp_path):
    room.cycles.samples = 48
    before = dump()["scenes/Room"]["cycles"]
    setup.set_up(room)
    rendered = render.render(room, tmp_path)
    assert sum(times["samples"] for times in rendered.times.values()) == 48
    layers = view_layers.pass_layers(room)["ViewLayer"]
    ends = [0]
    for layer in layers:
        assert layer["relume_cycles_sample_offset"] == ends[-1] and layer.samples == 48
        ends.append(ends[-1] + layer["relume_cycles_sample_subset_length"])
    assert ends[-1] == 48
    setup.remove(room)
    assert differences(before, dump()["scenes/Room"]["cycles"]) == []


def test_cycles_takes_the_samples_of_each_pass(room):
    room.cycles.samples = 48
    setup.set_up(room)
    seen = []
    bpy.app.handlers.render_stats.append(hear := lambda words, _: seen.append(words))
    bpy.ops.render.render(scene=room.name)
    bpy.app.handlers.render_stats.remove(hear)
    counts = [view_layers.samples_of(layer, room) for layer in view_layers.pass_layers(room)["ViewLayer"]]
    taken = [int(found[1]) for words in seen if (found := re.search(r"Sample 0/(\d+)", words or ""))]
    assert taken == counts and len(set(counts)) > 1


@pytest.mark.parametrize("path", ["seed", "sample_offset"])
def test_the_artists_own_driver_stays(room, path):
    room.driver_add(f"cycles.{path}").driver.expression = "7"
    before = dump()
    setup.set_up(room)
    assert room.animation_data.drivers.find(f"cycles.{path}").driver.expression == "7"
    setup.remove(room)
    assert differences(before, dump()) == []


def test_a_subset_that_the_artist_renders_is_dealt_out(room):
    room.cycles.samples, room.cycles.use_sample_subset = 100, True
    room.cycles.sample_offset, room.cycles.sample_subset_length = 70, 50
    before = dump()
    setup.set_up(room)
    layers = view_layers.pass_layers(room)["ViewLayer"]
    assert layers[0]["relume_cycles_sample_offset"] == 70
    assert sum(view_layers.samples_of(layer, room) for layer in layers) == 30
    setup.remove(room)
    assert differences(before, dump()) == []


def test_passes_that_are_not_shared_take_the_scenes_samples_with_seeds_of_their_own(room):
    room.relume.split_samples = False
    setup.set_up(room)
    layers = view_layers.pass_layers(room)["ViewLayer"]
    room.cycles.samples = 11
    assert [view_layers.samples_of(layer, room) for layer in layers] == [11, 11, 11]
    assert [layer["relume_cycles_seed"] for layer in layers] == [0, 1, 2]


def test_changing_channels_rebuilds_the_passes(room):
    setup.set_up(room, bases.fitted(9))
    setup.set_up(room, bases.fitted(12))
    assert len(view_layers.pass_layers(room)["ViewLayer"]) == 4


def test_an_artists_compositing_is_kept_and_fed(room):
    tree = bpy.data.node_groups.new("mine", "CompositorNodeTree")
    tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    render, blur, output = (
        tree.nodes.new(kind) for kind in ("CompositorNodeRLayers", "CompositorNodeBlur", "NodeGroupOutput")
    )
    tree.links.new(render.outputs["Image"], blur.inputs["Image"])
    tree.links.new(blur.outputs["Image"], output.inputs["Image"])
    room.compositing_node_group = tree
    before = dump()
    setup.set_up(room)
    assert blur.inputs["Image"].links[0].from_node.node_tree.name == "Relume Recombination ViewLayer"
    setup.remove(room)
    assert differences(before, dump()) == []


def test_a_scene_without_camera_or_light_is_refused_and_untouched(room):
    camera, room.camera = room.camera, None
    before = dump()
    with pytest.raises(setup.SetupError, match="no camera"):
        setup.set_up(room)
    room.camera = camera
    for light in list(bpy.data.lights):
        bpy.data.lights.remove(light)
    with pytest.raises(setup.SetupError, match="no light"):
        setup.set_up(room)
    assert before.keys() >= dump().keys()
    assert not room.relume.is_set_up


@lamps_without_nodes
def test_a_failure_part_way_gives_the_scene_back(startup, monkeypatch):
    before = dump()

    def fail(*_):
        raise RuntimeError("part-way")

    monkeypatch.setattr("relume.addon.scene.compositing.patch", fail)
    with pytest.raises(RuntimeError, match="part-way"):
        setup.set_up(startup)
    assert differences(before, dump()) == []


def test_two_scenes_share_spectra_and_are_removed_one_by_one(room):
    before = dump()
    other = room.copy()
    other.name = "Other"
    with_both = dump()
    setup.set_up(room)
    setup.set_up(other)
    setup.remove(other)
    group = bpy.data.node_groups["red"]
    assert any(node.type == "GROUP" for node in group.nodes), "the first scene still renders spectra"
    setup.remove(room)
    assert differences(with_both, dump()) == []
    bpy.data.scenes.remove(other)
    assert differences(before, dump()) == []


def test_an_unknown_illuminant_changes_nothing_and_is_told(room):
    setup.set_up(room)
    shown = list(room.view_layers["ViewLayer"]["relume_w0"])
    room.relume.light_groups["tungsten"].illuminant = "FL22"
    assert "FL2" in room.relume.problem
    assert list(room.view_layers["ViewLayer"]["relume_w0"]) == shown
    room.relume.light_groups["tungsten"].illuminant = "FL11"
    assert room.relume.problem == ""
    assert list(room.view_layers["ViewLayer"]["relume_w0"]) != shown


def test_passes_stop_at_more_noise_than_the_picture_may_have(room):
    room.cycles.use_adaptive_sampling, room.cycles.adaptive_threshold = True, 0.01
    before = dump()
    setup.set_up(room)
    assert room.cycles.adaptive_threshold == pytest.approx(0.01 * 3**0.75)
    setup.remove(room)
    assert differences(before, dump()) == []
    room.relume.split_samples = False
    setup.set_up(room)
    assert room.cycles.adaptive_threshold == pytest.approx(0.01), "where each pass takes all samples"


def test_the_engine_changes_when_no_preview_is_rendered(startup, monkeypatch):
    """Blender would stand still for good: see `render_settings`."""
    own = startup.render.engine
    assert own != "CYCLES"
    setup.set_up(startup)
    monkeypatch.setattr(render_settings, "is_previewing", lambda: True)
    setup.remove(startup)
    assert startup.render.engine == "CYCLES" and render_settings.change_engines() > 0
    setup.set_up(startup)
    setup.remove(startup)
    monkeypatch.setattr(render_settings, "is_previewing", lambda: False)
    assert render_settings.change_engines() is None
    assert startup.render.engine == own


@pytest.mark.parametrize("space", ["sharp", "srgb", "xyz"])
def test_one_pass_is_prefiltered_for_the_light_that_the_artist_calls_dominant(room, space):
    room.relume.channels, room.relume.rendering_space = "prefiltered", space
    room.relume.dominant_group = "fluorescent"
    setup.set_up(room)
    settings = room.relume
    light = settings.light_groups["fluorescent"].spectrum()
    expected = bases.prefiltered(light, space)
    assert settings.model().passes == 1
    assert settings.model().to_dict() == expected.to_dict()
    surface = library.reflectance("ColorChecker: red")
    weights = relight.power_weights(light.sampled(), library.observer())
    seen = expected.relight(light) @ settings.model().coefficients(surface)
    np.testing.assert_allclose(seen, surface.sampled() @ weights, rtol=1e-9, atol=1e-12)
    assert settings.plan["request"] == settings.request, "nothing is left to apply"


def test_the_first_light_is_dominant_unless_one_is_called_so(room):
    room.relume.channels = "prefiltered"
    setup.set_up(room)
    first = room.relume.lit[0]
    assert room.relume.model().to_dict() == bases.prefiltered(first.spectrum(), "sharp").to_dict()


def test_another_dominant_light_is_something_to_apply(room):
    room.relume.channels, room.relume.dominant_group = "prefiltered", "tungsten"
    setup.set_up(room)
    room.relume.light_groups["fluorescent"].illuminant = "LED-B3"
    assert room.relume.plan["request"] == room.relume.request, "a light that does not dominate may be any"
    room.relume.light_groups["tungsten"].illuminant = "D65"
    assert room.relume.plan["request"] != room.relume.request
    setup.set_up(room)
    assert room.relume.plan["request"] == room.relume.request
    room.relume.rendering_space = "xyz"
    assert room.relume.plan["request"] != room.relume.request


def test_a_dominant_light_that_is_not_there_is_named(room):
    room.relume.channels, room.relume.dominant_group = "prefiltered", "moon"
    with pytest.raises(SetupError, match="nothing shines in 'moon'.*tungsten, fluorescent"):
        setup.set_up(room)
    assert not room.relume.is_set_up
