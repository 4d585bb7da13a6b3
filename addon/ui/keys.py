"""Keys of the light dial and of A/B: they are the user's to change, in Relume's preferences or in Blender's keymap."""

import bpy

__all__ = ["draw", "register", "unregister"]

_EDITORS = {"3D View": "VIEW_3D", "Image": "IMAGE_EDITOR"}  # keymaps, and where they hold
_KEYS = {"relume.light_dial": "D", "relume.compare": "C"}  # with Shift and Alt, which Blender leaves free there
_made = []


def draw(layout, context) -> None:
    """The keys, as Blender lets its own be changed."""
    import rna_keymap_ui

    users = context.window_manager.keyconfigs.user
    for name in _EDITORS:
        keymap = users.keymaps.get(name)
        layout.label(text=name, text_ctxt="WindowManager")
        for item in keymap.keymap_items if keymap else ():
            if item.idname in _KEYS:
                rna_keymap_ui.draw_kmi([], users, keymap, item, layout, 0)


def register() -> None:
    own = bpy.context.window_manager.keyconfigs.addon
    if own is None:  # without a window
        return
    for name, space in _EDITORS.items():
        keymap = own.keymaps.new(name=name, space_type=space)
        for operator, key in _KEYS.items():
            _made.append((keymap, keymap.keymap_items.new(operator, key, "PRESS", shift=True, alt=True)))


def unregister() -> None:
    for keymap, item in _made:
        keymap.keymap_items.remove(item)
    _made.clear()
