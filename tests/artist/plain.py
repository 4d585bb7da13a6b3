"""A full dump of the file as it is without Relume, and how two sessions' dumps differ."""

import re

from dump import differences, dump

__all__ = ["plain", "unlike"]

# What is not compared, and why
_LEFT_OUT = [
    (r"^/scenes/[^/]+/relume/", "the mixer: what the artist chose there is kept on purpose, for the next set-up"),
    (r"^/images/Render Result", "Blender makes it when something renders or composites, and keeps it"),
    (r"^/node_groups/[^/]+/.*(location|location_absolute|width|dimensions)\b", "where a node lies in the editor"),
    (r"^/libraries/[^/]+/(filepath|name|parent)", "sessions save into folders of their own"),
    (r"^/actions/.*/groups/", "Blender names a group of curves after the node that was keyed"),
]
_WITHOUT = re.compile("|".join(pattern for pattern, _ in _LEFT_OUT))


def plain() -> dict:
    """The full dump of the file that is open."""
    return dump()


def unlike(without: dict, removed: dict) -> list[str]:
    """Where the file from which Relume was removed differs from the one that never had it."""
    return [line for line in differences(without, removed) if not _WITHOUT.search(line)]
