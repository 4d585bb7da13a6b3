"""A full dump of the file as it is without Relume, and how two sessions' dumps differ."""

import re

import bpy
from dump import differences, dump

from relume.addon.host import animation

__all__ = ["plain", "unlike"]

# What is not compared, and why
_LEFT_OUT = [
    (r"^/scenes/[^/]+/relume/", "the mixer: what the artist chose there is kept on purpose, for the next set-up"),
    (r"^/images/Render Result", "Blender makes it when something renders or composites, and keeps it"),
    (r"^/node_groups/[^/]+/.*(location|location_absolute|width|dimensions)\b", "where a node lies in the editor"),
    (r"^/libraries/[^/]+/(filepath|name|parent)", "sessions save into folders of their own"),
    (r"^/particles/.*/force_field_\d/seed", "Blender draws it anew for each copy"),
    (r"/point_cache/.*(info|is_outdated)\b", "what Blender has computed of particles in this session"),
    (r"^/scenes/[^/]+/cycles/custom/[^/:]+: (missing|added)", "whether a default was chosen or is one: values count"),
    (r"^/actions/.*/groups/", "Blender names a group of curves after the node that was keyed"),
]
_WITHOUT = re.compile("|".join(pattern for pattern, _ in _LEFT_OUT))


def plain() -> dict:
    """The full dump of the file that is open. What is animated counts for nothing: it is set to 0."""
    for block in bpy.data.user_map():
        _still(block)
        if getattr(block, "node_tree", None) is not None:
            _still(block.node_tree)
    return dump()


def _still(block) -> None:
    """Set what is animated to 0: when Blender last worked it out depends on what was shown in the session."""
    data = getattr(block, "animation_data", None)
    for curve in [*data.drivers, *animation.keyed(block, "")] if data and block.library is None else ():
        owner, _, name = curve.data_path.rpartition(".")
        try:
            struct = block.path_resolve(owner) if owner else block
            value = getattr(struct, name)
        except (ValueError, AttributeError):
            continue  # it acts on nothing
        if isinstance(value, (int, float)):
            setattr(struct, name, type(value)(0))
        elif hasattr(value, "__len__") and not isinstance(value, str):
            value[curve.array_index] = 0.0


def unlike(without: dict, removed: dict) -> list[str]:
    """Where the file from which Relume was removed differs from the one that never had it."""
    return [line for line in differences(without, removed) if not _WITHOUT.search(line)]
