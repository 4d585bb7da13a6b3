"""The Blender side of Relume. It holds no arithmetic: every number comes from `core`.

One direction: properties → nodes → the set-up of a scene (spectra, lights, passes, compositing) → operators → panels
and commands.
"""

__all__ = ["register", "unregister"]


def _modules():
    from . import commands, handlers, icons, material_panel, operators, panels, properties, remarks

    return properties, icons, operators, panels, remarks, material_panel, handlers, commands


def register():
    for module in _modules():
        module.register()


def unregister():
    for module in reversed(_modules()):
        module.unregister()
