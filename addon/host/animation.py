"""Animated and driven values: which there are, and moving the animation of one value to another.

The one place that knows what animates a data-block: its drivers, the slot of its action, and the strips of its NLA
tracks, each with a slot of its own. Two data-blocks may share an action and not a curve.

A driver between two inputs of one tree would do as well as moving, but to Blender every tree that reads itself is a
circle.
"""

import re
from collections import Counter
from collections.abc import Collection

import bpy

__all__ = [
    "acts_on",
    "broken",
    "carry",
    "count_again",
    "has_any",
    "has_strips",
    "is_animated",
    "is_driven",
    "is_shared",
    "keyed",
    "move",
    "paths",
    "renumber",
    "shared",
]

_PREFIX = "node_tree."


def paths(tree, owner) -> frozenset[str]:
    """Data paths, seen from `tree`, of what is animated or driven in it, by itself or through its owner."""
    found = {curve.data_path for curve in _curves(tree)}
    if owner != tree:
        through = (curve.data_path for curve in _curves(owner))
        found |= {path.removeprefix(_PREFIX) for path in through if path.startswith(_PREFIX)}
    return frozenset(found)


def has_any(block) -> bool:
    """Whether anything is there that animates a data-block."""
    data = block.animation_data
    return data is not None and bool(data.action or data.drivers or data.nla_tracks)


def is_animated(block, path: str) -> bool:
    """Whether a property of a data-block is animated or driven."""
    return any(curve.data_path == path for curve in _curves(block))


def acts_on(block, beginning: str) -> bool:
    """Whether anything in a data-block whose path begins so is animated or driven."""
    return any(curve.data_path.startswith(beginning) for curve in _curves(block))


def broken(block) -> list[str]:
    """Data paths of the drivers of a data-block that could not be worked out when Blender tried last."""
    data = getattr(block, "animation_data", None)
    return sorted({c.data_path for c in data.drivers if not c.driver.is_valid}) if data else []


def is_driven(block, beginning: str) -> bool:
    """Whether anything in a data-block whose path begins so is driven."""
    data = block.animation_data
    return data is not None and any(curve.data_path.startswith(beginning) for curve in data.drivers)


def has_strips(block) -> bool:
    """Whether NLA strips animate a data-block: then only Blender's own evaluation knows its values."""
    data = block.animation_data
    return data is not None and any(track.strips for track in data.nla_tracks)


def keyed(block, beginning: str) -> list:
    """The curves of a data-block's own action, in its slot, whose paths begin so."""
    data = block.animation_data
    if data is None or data.action is None:
        return []
    return [c for c in _curves_of(data.action, data.action_slot) if c.data_path.startswith(beginning)]


def _strips(strips):
    for strip in strips:
        yield strip
        yield from _strips(strip.strips)  # of a meta strip


def _actions(block):
    """(action, slot) of everything that animates a data-block but its drivers."""
    data = block.animation_data
    if data is None:
        return
    if data.action:
        yield data.action, data.action_slot
    for track in data.nla_tracks:
        for strip in _strips(track.strips):
            if strip.action:
                yield strip.action, strip.action_slot


def _bags(action, slot):
    for layer in action.layers:
        for strip in layer.strips:
            bag = strip.channelbag(slot) if slot else None
            if bag:
                yield bag


def _curves_of(action, slot):
    for bag in _bags(action, slot):
        yield from bag.fcurves


def _curves(block):
    if block.animation_data:
        yield from block.animation_data.drivers
    for action, slot in _actions(block):
        yield from _curves_of(action, slot)


def is_shared(block, path: str) -> bool:
    """Whether the animation of a property is that of other data-blocks too, and so cannot be moved for this one."""
    for action, slot in _actions(block):
        if slot and any(curve.data_path == path for curve in _curves_of(action, slot)):
            return _users()[action.session_uid, slot.handle] > 1
    return False


def shared(block) -> tuple:
    """How many data-blocks each of the actions moves that animate a data-block; () where none does."""
    if block.animation_data is None:
        return ()
    return tuple(_users()[action.session_uid, slot.handle] for action, slot in _actions(block) if slot)


_counted = []  # how many data-blocks each slot animates, once it has been asked for


def count_again(animated: Collection | None = None) -> None:
    """Forget how many data-blocks share their animation: edits may have changed it.

    animated: all data-blocks of the file that use an action, where that is known.
    """
    _counted.clear()
    if animated is not None:
        _counted.append(_users_of(animated))


def _users() -> Counter:
    """{(session_uid of an action, handle of its slot): how many data-blocks it animates}.

    Blender's own `ActionSlot.users` may name data-blocks that are gone, and end Blender.
    """
    if not _counted:
        _counted.append(_users_of(set().union(*bpy.data.user_map(key_types={"ACTION"}).values())))
    return _counted[0]


def _users_of(animated: Collection) -> Counter:
    found = Counter()
    for block in (block for block in animated if block.users):  # what nothing uses is gone once the file is saved
        tree = getattr(block, "node_tree", None)
        for owner in (block, tree) if tree is not None and tree.is_embedded_data else (block,):
            found.update({(action.session_uid, slot.handle) for action, slot in _actions(owner) if slot})
    return found


def move(block, before: str, after: str) -> bool:
    """Let what animates or drives the path `before` of a data-block act on `after`; returns whether anything does.

    What acts on `after` already gives way, but for keys: these are joined by the new ones, as if the artist had keyed
    the value where its animation is.
    """
    moved = [curve for curve in _curves(block) if curve.data_path == before]
    if moved and before != after and any(curve.data_path == after for curve in _curves(block)):
        for curves in _own_curves(block):
            _make_way(curves, before, after)
        moved = [curve for curve in _curves(block) if curve.data_path == before]
        if not moved:
            return True
    for curve in moved:
        curve.data_path = after
    return bool(moved)


def _make_way(curves, before: str, after: str) -> None:
    """Join the keys of curves of the path `before` to those of `after`; drivers, and what has no new keys, go."""
    is_new = {curve.array_index for curve in curves if curve.data_path == before}
    for index in [curve.array_index for curve in curves if curve.data_path == after]:
        old = curves.find(after, index=index)
        new = curves.find(before, index=index) if index in is_new else None
        if new is None or not (len(old.keyframe_points) and len(new.keyframe_points)):
            curves.remove(old)
            continue
        for key in new.keyframe_points:
            old.keyframe_points.insert(key.co.x, key.co.y, keyframe_type=key.type).interpolation = key.interpolation
        curves.remove(new)


def _own_curves(block) -> list:
    """The collections of drivers and curves of a data-block that no other shares."""
    if block.animation_data is None:
        return []
    count_again()
    users = _users()
    own = [(a, slot) for a, slot in _actions(block) if slot and users[a.session_uid, slot.handle] == 1]
    own = dict.fromkeys(own)
    return [block.animation_data.drivers, *(bag.fcurves for action, slot in own for bag in _bags(action, slot))]


def carry(source, before: str, target, after: str) -> None:
    """Give the keys of a value of one data-block to a value of another, which nothing animates."""
    size = len(target.path_resolve(after))
    curves = [c for c in keyed(source, before) if c.data_path == before and c.array_index < size]
    if not curves or is_animated(target, after):
        return
    for curve in curves:
        for key in curve.keyframe_points:
            target.keyframe_insert(after, index=curve.array_index, frame=key.co.x)
    for new in keyed(target, after):
        old = next(curve for curve in curves if curve.array_index == new.array_index)
        new.extrapolation = old.extrapolation
        for key, kept in zip(new.keyframe_points, old.keyframe_points, strict=True):
            for name in ("handle_left_type", "handle_right_type", "interpolation", "co", "handle_left", "handle_right"):
                setattr(key, name, getattr(kept, name))
    for own in _own_curves(source):
        for curve in [curve for curve in own if curve.data_path == before]:
            own.remove(curve)


def renumber(block, collection: str, numbers: dict[int, int]) -> None:
    """Let what animates or drives the members of a collection follow them to new places: {old index: new index}.

    What acts on a member that is gone is taken away: it would act on another. What other data-blocks share stays.
    """
    member = re.compile(rf"{re.escape(collection)}\[(\d+)\]")
    for curves in _own_curves(block):
        for curve in list(curves):
            found = member.match(curve.data_path)
            old = int(found[1]) if found else None
            if found and old not in numbers:
                curves.remove(curve)
            elif found and numbers[old] != old:
                curve.data_path = f"{collection}[{numbers[old]}]{curve.data_path[found.end() :]}"
