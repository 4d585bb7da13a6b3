"""The Blender side of Relume. It holds no arithmetic: every number comes from `core`.

One direction: `host` (what Blender is like) → `store` (what is kept) → `graph` (node trees) → `scene` (what a scene
carries) → `cli` and `ui`. `handlers` wires what changes in the store to the scene.
"""

__all__ = ["register", "unregister"]


def _modules():
    from . import handlers
    from .cli import commands
    from .store import palette, properties
    from .ui import (
        assets,
        expected,
        icons,
        keys,
        light_panel,
        manual,
        material_panel,
        menus,
        operators,
        palette_assign,
        palette_demands,
        palette_entries,
        palette_operators,
        palette_panel,
        palette_trial,
        panels,
        preferences,
        spectrum_files,
        transfer_panel,
        translation,
    )

    palettes = (
        palette,
        palette_operators,
        palette_demands,
        palette_entries,
        palette_assign,
        palette_trial,
        palette_panel,
    )
    return (
        translation,
        properties,
        preferences,
        icons,
        expected,
        operators,
        keys,
        panels,
        *palettes,
        material_panel,
        transfer_panel,
        light_panel,
        spectrum_files,
        menus,
        manual,
        assets,
        handlers,
        commands,
    )


def register() -> None:
    for module in _modules():
        module.register()


def unregister() -> None:
    for module in reversed(_modules()):
        module.unregister()
