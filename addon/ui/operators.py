"""What the panel's buttons do."""

from bpy.types import Operator
from bpy.utils import register_classes_factory

from ..scene import setup
from . import dial, files, inspector, mixer_operators, web
from .mixer_operators import NeedsSetUp, reporting

__all__ = ["CLASSES", "register", "unregister"]


class SetUpSpectralRender(Operator):
    """Make this scene spectral: F12 then renders coefficient passes, and the light can be chosen afterwards"""

    bl_idname = "relume.set_up"
    bl_label = "Set Up Spectral Render"
    bl_options = {"REGISTER", "UNDO"}

    @reporting
    def execute(self, context) -> None:
        setup.set_up(context.scene)


class RemoveSpectralRender(NeedsSetUp, Operator):
    """Give the scene back as it was before Relume set it up. Assigned spectra stay"""

    bl_idname = "relume.remove"
    bl_label = "Remove"

    @reporting
    def execute(self, context) -> None:
        setup.remove(context.scene)


CLASSES = (
    SetUpSpectralRender,
    RemoveSpectralRender,
    *mixer_operators.CLASSES,
    *dial.CLASSES,
    *inspector.CLASSES,
    *files.CLASSES,
    *web.CLASSES,
)


register, unregister = register_classes_factory(CLASSES)
