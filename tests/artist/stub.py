"""Stands in for the follower until there is one: everything is set up afresh whenever a scene is to be right.

Data-blocks that come or go without an undo step crash Blender 5.2 at the next undo: what the step left unchanged is not
read again, and goes on pointing to them. So undo reads the whole file here.
"""

import bpy

from relume.addon.scene import setup


def _read_everything(*_) -> None:
    bpy.context.preferences.view.show_developer_ui = True  # the setting does nothing without
    bpy.context.preferences.experimental.use_undo_legacy = True


bpy.app.handlers.undo_pre.append(bpy.app.handlers.persistent(_read_everything))
bpy.app.handlers.redo_pre.append(bpy.app.handlers.persistent(_read_everything))


def follow() -> None:
    """Wait for the next check."""


def settle(scene) -> None:
    setup.set_up_afresh(scene)
