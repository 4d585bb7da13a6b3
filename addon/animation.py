"""Animated and driven values: what is animated in a data-block, and moving the animation of one value to another.

A driver between two inputs of one tree would do as well, but to Blender every tree that reads itself is a circle.
"""

__all__ = ["is_shared", "move", "paths"]

_PREFIX = "node_tree."


def paths(tree, owner) -> frozenset[str]:
    """Data paths, seen from `tree`, of what is animated or driven in it, by itself or through its owner."""
    found = {curve.data_path for curve in _curves(tree)}
    if owner != tree:
        through = (curve.data_path for curve in _curves(owner))
        found |= {path.removeprefix(_PREFIX) for path in through if path.startswith(_PREFIX)}
    return frozenset(found)


def _actions(block):
    """(action, slot) of everything that animates a data-block but its drivers."""
    data = block.animation_data
    if data is None:
        return
    if data.action:
        yield data.action, data.action_slot
    for track in data.nla_tracks:
        for strip in track.strips:
            if strip.action:
                yield strip.action, strip.action_slot


def _curves_of(action, slot):
    for layer in action.layers:
        for strip in layer.strips:
            bag = strip.channelbag(slot) if slot else None
            if bag:
                yield from bag.fcurves


def _curves(block):
    if block.animation_data:
        yield from block.animation_data.drivers
    for action, slot in _actions(block):
        yield from _curves_of(action, slot)


def is_shared(block, path: str) -> bool:
    """Whether the animation of a property is that of other data-blocks too, and so cannot be moved for this one."""
    for action, slot in _actions(block):
        if slot and len(slot.users()) > 1 and any(curve.data_path == path for curve in _curves_of(action, slot)):
            return True
    return False


def move(block, before: str, after: str) -> bool:
    """Let what animates or drives the path `before` of a data-block act on `after`; whether anything does."""
    moved = [curve for curve in _curves(block) if curve.data_path == before]
    for curve in moved:
        curve.data_path = after
    return bool(moved)
