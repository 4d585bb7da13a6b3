"""The Blender side of Relume. It holds no arithmetic: every number comes from `core`.

One direction: properties → nodes → the set-up of a scene (spectra, lights, passes, compositing) → operators → panels
and commands.
"""

__all__ = ["register", "unregister"]


def _modules():
    from . import (
        commands,
        handlers,
        icons,
        material_panel,
        operators,
        palette,
        palette_assign,
        palette_entries,
        palette_operators,
        palette_panel,
        panels,
        properties,
        remarks,
    )

    palettes = (palette, palette_operators, palette_entries, palette_assign, palette_panel)
    return properties, icons, operators, panels, *palettes, remarks, material_panel, handlers, commands


def register():
    for module in _modules():
        module.register()


def unregister():
    for module in reversed(_modules()):
        module.unregister()
