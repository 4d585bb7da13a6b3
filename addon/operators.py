"""What the panel's buttons do."""

import bpy
from bpy.types import Operator

from . import dial, exr, inspector, mixer_operators

__all__ = [
    "CLASSES",
    "RemoveSpectralRender",
    "SetUpSpectralRender",
    "register",
    "unregister",
]


class SetUpSpectralRender(Operator):
    """Make this scene spectral: F12 then renders coefficient passes, and the light can be chosen afterwards"""

    bl_idname = "relume.set_up"
    bl_label = "Set Up Spectral Render"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        from . import setup

        try:
            setup.set_up(context.scene)
        except setup.SetupError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class RemoveSpectralRender(Operator):
    """Give the scene back as it was before Relume set it up. Assigned spectra stay"""

    bl_idname = "relume.remove"
    bl_label = "Remove"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        if not context.scene.relume.is_set_up:
            cls.poll_message_set("this scene is not set up for spectral rendering")
            return False
        return True

    def execute(self, context):
        from . import setup

        setup.remove(context.scene)
        return {"FINISHED"}


CLASSES = (
    SetUpSpectralRender,
    RemoveSpectralRender,
    *mixer_operators.CLASSES,
    *dial.CLASSES,
    *inspector.CLASSES,
    *exr.CLASSES,
)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
