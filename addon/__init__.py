"""The Blender side of Relume. It holds no arithmetic: every number comes from `core`.

One direction: properties → nodes → the set-up of a scene (spectra, lights, passes, compositing) → operators → panels
and commands.
"""

__all__ = ["register", "unregister"]


def _modules():
    from . import handlers
    from .cli import commands
    from .store import properties, remarks
    from .ui import icons, material_panel, operators, panels

    return properties, icons, operators, panels, remarks, material_panel, handlers, commands


def register():
    for module in _modules():
        module.register()


def unregister():
    for module in reversed(_modules()):
        module.unregister()
