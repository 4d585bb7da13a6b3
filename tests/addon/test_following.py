"""A scene that is set up follows its artist, and stays as it is while nobody edits it."""

import bpy

from relume.addon.scene import setup
from relume.core.model import bases


def test_following_changes_nothing_where_nothing_is_to_follow(startup):
    """Not even for Blender, which would build its dependencies anew and have everything looked at again, for ever."""
    setup.set_up(startup, bases.fitted(9))
    bpy.context.view_layer.update()
    updated = []

    def note(scene, depsgraph):
        updated.extend(update.id.name for update in depsgraph.updates)

    bpy.app.handlers.depsgraph_update_post.append(note)
    try:
        setup.update(startup)
        bpy.context.view_layer.update()
    finally:
        bpy.app.handlers.depsgraph_update_post.remove(note)
    assert updated == []
