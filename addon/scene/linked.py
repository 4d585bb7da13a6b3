"""Linked data and library overrides, whose node trees Blender keeps from changes: made local where an artist asks."""

import bpy

from ..graph import nodes, sockets
from ..host import inventory
from . import setup

__all__ = ["make_local"]

# Users before what they use, for Blender copies what something linked uses too; meshes, lamps and worlds in between
_ORDER = {bpy.types.Collection: 0, bpy.types.Object: 1, bpy.types.Material: 3, bpy.types.NodeTree: 4}
_BETWEEN = 2


def make_local(scene) -> list[str]:
    """Make local what keeps materials, lamps, worlds and node groups of a scene from being spectral, and what shows
    them; returns the names of the former. What cannot be found stays linked. The libraries stay as they are."""
    names = {}
    for _ in range(len(_ORDER)):  # where a copy was made, something linked used it still
        found = inventory.take(scene)
        foreign = _untouchable(found)
        if not foreign:
            break
        names |= dict.fromkeys(block.name for block in foreign)
        for block in sorted(_foreign_users(found, foreign), key=_rank):
            block.make_local()
    if scene.relume.is_set_up and names:
        setup.update(scene)
    return list(names)


def _untouchable(found: inventory.Inventory) -> list:
    """What shades a scene and cannot be changed, but for what was set up in its own file."""
    owners = [*found.materials, *found.lights, *([found.world] if found.world else [])]
    trees = [(owner, owner.node_tree) for owner in owners]
    trees += [(block, block) for block in found.blocks if isinstance(block, bpy.types.ShaderNodeTree)]
    return [
        o for o, tree in trees if _is_foreign(o) and not (tree and (nodes.ROLE in tree or sockets.is_converted(tree)))
    ]


def _is_foreign(block) -> bool:
    return inventory.is_foreign(block) and not block.is_missing


def _foreign_users(found: inventory.Inventory, blocks: list) -> list:
    """Blocks that are not the file's own, with all such that use them, directly or not, in the order of the scene."""
    users, waiting = bpy.data.user_map(), list(blocks)
    reached = set(waiting)
    while waiting:
        for user in users.get(waiting.pop(), ()):
            if user not in reached and _is_foreign(user) and not isinstance(user, bpy.types.Scene):
                reached.add(user)
                waiting.append(user)
    return [block for block in found.blocks if block in reached]


def _rank(block) -> int:
    return next((rank for kind, rank in _ORDER.items() if isinstance(block, kind)), _BETWEEN)
