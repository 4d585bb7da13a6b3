"""What a user prefers for every file. It is kept in Blender's preferences: nothing in a .blend depends on it."""

import bpy

__all__ = ["PACKAGE", "channels", "of", "tolerance"]

PACKAGE = __package__.rsplit(".", 2)[0]  # the extension's own name, which Blender gives it


def of():
    """Relume's preferences; None without a window, so that a farm renders what the file says, and where it is no
    extension."""
    found = None if bpy.app.background else bpy.context.preferences.addons.get(PACKAGE)
    return found and found.preferences


def channels(self, current: int, is_set: bool) -> int:
    """The number of a scene's choice of channels, where it has made none the preferred one."""
    preferences = None if is_set else of()
    if preferences is None:
        return current
    return preferences.bl_rna.properties["channels"].enum_items[preferences.channels].value


def tolerance(self, current: float, is_set: bool) -> float:
    """A scene's tolerance, where none has been chosen the preferred one."""
    preferences = None if is_set else of()
    return current if preferences is None else preferences.tolerance
