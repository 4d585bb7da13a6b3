"""A folder among the asset libraries of the user's preferences, for as long as an add-on is there.

Blender has no other way to offer assets than its preferences. So an entry that was added leaves them as saved as they
were, and one that Blender saved all the same, with something that the user changed, is found again and not added twice.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import bpy

__all__ = ["IMPORT_METHOD", "offer", "withdraw"]

IMPORT_METHOD = "APPEND"  # what is linked or packed, as Blender would have it, nobody may change


def offer(name: str, folder: Path) -> None:
    """Add the folder under a name, unless the user has it as a library already."""
    if _entries(folder):
        return
    with _unsaved():
        added = bpy.context.preferences.filepaths.asset_libraries.new(name=name, directory=str(folder))
        added.import_method = IMPORT_METHOD


def withdraw(name: str, folder: Path) -> None:
    """Take out the folder, unless the user has it under another name."""
    with _unsaved():
        for entry in [entry for entry in _entries(folder) if entry.name == name]:
            bpy.context.preferences.filepaths.asset_libraries.remove(entry)


def _entries(folder: Path) -> list:
    libraries = bpy.context.preferences.filepaths.asset_libraries
    return [entry for entry in libraries if entry.path and Path(bpy.path.abspath(entry.path)) == folder]


@contextmanager
def _unsaved() -> Iterator[None]:
    """While it is entered, changes of the preferences do not count as such: Blender saves none on our account."""
    preferences = bpy.context.preferences
    was_dirty = preferences.is_dirty
    try:
        yield
    finally:
        preferences.is_dirty = was_dirty
