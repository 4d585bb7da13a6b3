"""What animates a scene: drivers, the slot of its action and its NLA strips, and nothing of other scenes."""

import bpy
import numpy as np
import pytest
from test_mixer import sockets

from relume.addon.host import animation
from relume.addon.scene import baking, setup, view_layers
from relume.core.model import bases


@pytest.fixture
def ready(room):
    setup.set_up(room, bases.fitted(3))
    room.frame_start, room.frame_end = 1, 3
    return room


def share_action(scene, path: str, value: float):
    """Let another scene have a slot of its own in the action of a scene, which moves a property that has no curve
    in the scene's own slot."""
    other = bpy.data.scenes.new("other")
    action = scene.animation_data_create().action or bpy.data.actions.new("shared")
    if scene.animation_data.action is None:
        scene.animation_data.action = action
        scene.animation_data.action_slot = action.slots.new("SCENE", scene.name)
    slot = action.slots.new("SCENE", other.name)
    other.animation_data_create().action, other.animation_data.action_slot = action, slot
    layer = action.layers[0] if action.layers else action.layers.new("layer")
    strip = layer.strips[0] if layer.strips else layer.strips.new(type="KEYFRAME")
    curve = strip.channelbag(slot, ensure=True).fcurves.new(path)
    curve.keyframe_points.insert(1, value)
    return other


def test_the_mix_of_another_scene_that_shares_the_action_is_not_baked(ready):
    ready.relume.light_groups["fluorescent"].keyframe_insert("stops", frame=1)
    share_action(ready, "relume.light_groups[0].stops", 4.0)
    shown = sockets(ready)
    baking.bake(ready)
    tree = next(iter(baking._trees(ready)))
    bag = tree.animation_data.action.layers[0].strips[0].channelbag(tree.animation_data.action_slot)
    baked = np.array([curve.evaluate(2) for curve in bag.fcurves]).reshape(shown.shape)
    assert np.allclose(baked, shown, rtol=1e-5, atol=1e-7)
    baking.forget(ready)
    assert [row.stops for row in ready.relume.light_groups] == [0.0, 0.0]


def test_a_scene_whose_action_moves_another_is_not_animated(ready):
    other = share_action(ready, "relume.light_groups[0].stops", 4.0)
    assert not baking.is_animated(ready) and baking.is_animated(other)


def test_a_seed_that_another_scene_animates_is_free(room):
    other = share_action(room, "cycles.seed", 7)
    assert animation.is_animated(other, "cycles.seed") and not animation.is_animated(room, "cycles.seed")
    setup.set_up(room, bases.fitted(6))
    assert [layer["relume_cycles_sample_offset"] for layer in view_layers.pass_layers(room)["ViewLayer"]][0] == 0


def strip_on(scene, path: str, value: float):
    """Animate a property by an NLA strip alone."""
    owner, _, name = path.rpartition(".")
    target = scene.path_resolve(owner)
    setattr(target, name, value)
    target.keyframe_insert(name, frame=1)
    data = scene.animation_data
    action, slot = data.action, data.action_slot
    data.action = None
    strip = data.nla_tracks.new().strips.new("strip", 1, action)
    strip.action_slot = slot


@pytest.mark.parametrize("path", ["seed", "sample_offset"])
def test_a_seed_that_nla_strips_animate_stays_the_artists(room, path):
    strip_on(room, f"cycles.{path}", 5)
    assert animation.is_animated(room, f"cycles.{path}")
    setup.set_up(room, bases.fitted(6))
    assert not any(curve.data_path == f"cycles.{path}" for curve in room.animation_data.drivers)
    setup.remove(room)
    assert room.animation_data.nla_tracks[0].strips[0].action


def test_a_mix_that_nla_strips_animate_is_baked_as_blender_evaluates_it(ready):
    whole = sockets(ready)
    strip_on(ready, "relume.light_groups[0].stops", -1.0)
    assert baking.is_animated(ready)
    assert baking.bake(ready) == 3
    tree = next(iter(baking._trees(ready)))
    bag = tree.animation_data.action.layers[0].strips[0].channelbag(tree.animation_data.action_slot)
    baked = np.array([curve.evaluate(2) for curve in bag.fcurves]).reshape(whole.shape)
    assert np.allclose(baked[0], 0.5 * whole[0], rtol=1e-4) and np.allclose(baked[1], whole[1], rtol=1e-4)
    baking.forget(ready)


def test_strips_that_move_nothing_of_the_mixer_do_not_bake(ready):
    strip_on(ready, "cycles.seed", 5)
    assert not baking.is_animated(ready)


def test_curves_of_a_row_that_is_gone_do_not_stop_baking(ready):
    row = ready.relume.light_groups.add()
    row.keyframe_insert("stops", frame=1)
    ready.relume.light_groups["tungsten"].keyframe_insert("stops", frame=1)
    ready.relume.light_groups.remove(2)
    assert baking.bake(ready) == 3
    baking.forget(ready)
