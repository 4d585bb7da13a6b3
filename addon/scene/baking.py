"""Animated mixes as Blender's own keyframes.

Blender composites a frame of an animation before it looks at what a handler changed, and a render farm has no Relume.
So while a scene is rendered or saved, its recombination carries a keyframe of every number at every frame, in an action
that is taken away afterwards.
"""

import re
from collections.abc import Iterator

import bpy

from ..graph import node_groups
from ..host import animation
from ..store import mixer
from . import compositing, setup

__all__ = ["bake", "forget", "is_animated", "is_baked"]

_BAKED = "relume_baked"  # on the action of a recombination group
_MIXER = "relume."  # how the paths of the mixer's properties begin
_PATH = re.compile(r"relume\.(light_groups\[(?P<row>\d+)\]\.)?(blend\[(?P<part>\d+)\]\.)?(?P<name>\w+)")


def _trees(scene) -> set:
    return {node.node_tree for node in compositing.recombinations(scene)}


def _action(tree):
    action = tree.animation_data.action if tree.animation_data else None
    return action if action and _BAKED in action else None


def is_baked(scene) -> bool:
    """Whether the scene's recombination carries keyframes that `bake` made."""
    return any(_action(tree) for tree in _trees(scene))


def _needs_evaluation(scene) -> bool:
    """Whether the mixer is driven, or animated by strips: only Blender's own evaluation knows its values then."""
    return animation.is_driven(scene, _MIXER) or animation.has_strips(scene)


def is_animated(scene) -> bool:
    """Whether anything in the mixer is keyframed or driven."""
    return animation.acts_on(scene, _MIXER)


def bake(scene) -> int:
    """Keyframe the recombination at every frame of the scene as the mixer is animated; returns how many frames."""
    forget(scene)
    frames = list(range(scene.frame_start, scene.frame_end + 1))
    rows = {tree: [] for tree in _trees(scene)}
    at = _by_evaluation if _needs_evaluation(scene) else _by_curves
    for _ in at(scene, frames):
        for tree, values in rows.items():
            values.append([tuple(socket.default_value) for socket in node_groups.matrix_sockets(tree)])
    for tree, values in rows.items():
        _write(tree, frames, values)
    return len(frames)


def _by_evaluation(scene, frames: list[int]) -> Iterator[None]:
    before = scene.frame_current
    try:
        for frame in frames:
            scene.frame_set(frame)
            yield
    finally:
        scene.frame_set(before)


def _by_curves(scene, frames: list[int]) -> Iterator[None]:
    """The mixer as its curves say at each frame, without the rest of the scene: it may take seconds to evaluate."""
    settings, curves = scene.relume, animation.keyed(scene, _MIXER)
    for frame in frames:
        said = mixer.choices(settings)
        for curve in curves:
            _say(settings, said, curve.data_path, curve.evaluate(frame))
        setup.follow(scene, said)
        yield
    setup.follow(scene, mixer.choices(settings))


def _say(settings, said: dict, path: str, value: float) -> None:
    """Put the value of a curve into what the mixer says; a path that leads nowhere there says nothing."""
    found = _PATH.fullmatch(path)
    if not found:
        return
    row, part, name = found["row"], found["part"], found["name"]
    owner, place = settings, said["balance"]
    if row:
        if int(row) >= len(settings.light_groups):
            return
        owner = settings.light_groups[int(row)]
        place = said["light_groups"][owner.name]
    if part:
        if name == "weight" and int(part) < len(place["blend"]):
            place["blend"][int(part)][1] = value
    elif name in place:
        kind = owner.bl_rna.properties[name]
        place[name] = kind.enum_items[int(value)].identifier if kind.type == "ENUM" else type(place[name])(value)


def _write(tree, frames: list[int], values: list[list[tuple]]) -> None:
    """One curve for each component of each matrix column, of values by frame, socket and component."""
    action = bpy.data.actions.new(f"{tree.name} mix")
    action[_BAKED] = True
    slot = action.slots.new("NODETREE", tree.name)
    data = tree.animation_data_create()
    data.action, data.action_slot = action, slot
    bag = action.layers.new("Mix").strips.new(type="KEYFRAME").channelbag(slot, ensure=True)
    linear = bpy.types.Keyframe.bl_rna.properties["interpolation"].enum_items["LINEAR"].value
    for index, socket in enumerate(node_groups.matrix_sockets(tree)):
        for component in range(3):
            curve = bag.fcurves.new(socket.path_from_id("default_value"), index=component)
            points = curve.keyframe_points
            points.add(len(frames))
            column = [value[index][component] for value in values]
            points.foreach_set("co", [number for point in zip(frames, column, strict=True) for number in point])
            points.foreach_set("interpolation", [linear] * len(frames))
            curve.update()


def forget(scene) -> None:
    """Take away the keyframes that `bake` made."""
    for tree in _trees(scene):
        action = _action(tree)
        if action:
            tree.animation_data_clear()
            bpy.data.actions.remove(action)
