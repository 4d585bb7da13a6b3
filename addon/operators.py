"""What the panel's buttons do."""

from functools import cache

import bpy
from bpy.props import EnumProperty, IntProperty
from bpy.types import Operator

__all__ = [
    "CLASSES",
    "ChooseIlluminant",
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


@cache  # Blender keeps no reference to the strings
def _illuminants():
    from ..core import library

    return [(name, name, family) for family, names in library.illuminants().items() for name in names]


class ChooseIlluminant(Operator):
    """Choose the spectrum of the lamps in this light group. The picture follows without rendering"""

    # An operator, because Blender's own search field leaves no undo step
    bl_idname = "relume.choose_illuminant"
    bl_label = "Illuminant"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}
    bl_property = "illuminant"

    illuminant: EnumProperty(name="Illuminant", items=lambda self, context: _illuminants())
    group: IntProperty(options={"HIDDEN"})

    def invoke(self, context, event):
        context.window_manager.invoke_search_popup(self)
        return {"INTERFACE"}

    def execute(self, context):
        context.scene.relume.light_groups[self.group].illuminant = self.illuminant
        return {"FINISHED"}


CLASSES = (SetUpSpectralRender, RemoveSpectralRender, ChooseIlluminant)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
