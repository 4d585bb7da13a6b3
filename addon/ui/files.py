"""Operators on files: a coefficient EXR to be relit, and the sidecar of a scene's renders."""

import re
from pathlib import Path

import bpy
from bpy.props import StringProperty
from bpy.types import Operator

from ...core.errors import RelumeError
from ...core.picture import description
from ..scene import describe, exr
from .mixer_operators import NeedsSetUp, reporting

__all__ = ["CLASSES"]


class RelightExr(Operator):
    """Open a coefficient EXR that Relume rendered, or a sequence of them, in a scene of its own and choose its light"""

    bl_idname = "relume.relight_exr"
    bl_label = "Relight from EXR"
    bl_options = {"REGISTER", "UNDO"}

    filepath: StringProperty(subtype="FILE_PATH", options={"SKIP_SAVE"})
    filter_glob: StringProperty(default="*.exr", options={"HIDDEN"})

    def invoke(self, context, event) -> set[str]:
        if self.filepath:  # dropped
            return self.execute(context)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context) -> set[str]:
        settings = context.scene.relume
        try:
            path = Path(bpy.path.abspath(self.filepath))
            if settings.exr:
                exr.point_at(context.scene, path)
            else:
                context.window.scene = exr.new_scene(path)
        except RelumeError as error:
            settings.problem = re.sub(r"\s+", " ", str(error))
            self.report({"ERROR"}, settings.problem)
            return {"CANCELLED"}
        return {"FINISHED"}


class WriteSidecar(NeedsSetUp, Operator):
    """Write what relighting needs to know of this scene, to be put beside what other Blenders render of it. Only a mix
    with measured spectra, or too many light groups for a note of 511 characters, needs it"""

    bl_idname = "relume.write_sidecar"
    bl_label = "Write Sidecar"

    filepath: StringProperty(subtype="FILE_PATH")
    filter_glob: StringProperty(default=f"*{description.SUFFIX}", options={"HIDDEN"})

    def invoke(self, context, event) -> set[str]:
        self.filepath = f"{bpy.path.display_name_from_filepath(bpy.data.filepath) or 'untitled'}{description.SUFFIX}"
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    @reporting
    def execute(self, context) -> None:
        description.write(bpy.path.abspath(self.filepath), describe.description_of(context.scene))
        self.report({"INFO"}, f"wrote {self.filepath}")


CLASSES = (RelightExr, WriteSidecar)
