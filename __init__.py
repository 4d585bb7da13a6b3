"""Relume: spectral rendering in Blender's Cycles, and the light chosen after the render."""


def register():
    from . import addon

    addon.register()


def unregister():
    from . import addon

    addon.unregister()
