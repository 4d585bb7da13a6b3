"""What a scene says about its renders: for `relume describe`, `relume relight --scene`, and the sidecar's button."""

import bpy
from bpy.props import StringProperty
from bpy.types import Operator

from ..core import description
from ..core.description import Description
from ..core.errors import RelumeError, SetupError
from . import baking, note, passes, render
from .mixer_operators import NeedsSetUp

__all__ = ["CLASSES", "description_of", "of_open_file"]


def description_of(scene) -> Description:
    """The description of a scene that is set up, with its mix at the current frame. Raises RelumeError."""
    from ..core.note import mix_of

    layers = passes.pass_layers(scene)
    if not layers:
        raise SetupError(f"scene {scene.name!r} is not set up for spectral rendering")
    image, animated = render.described(scene), baking.is_animated(scene)
    found, _ = note.made(scene, image, animated)
    names = {source: tuple(layer.name for layer in each) for source, each in layers.items()}
    return Description(image, names, mix_of(found), animated)


def of_open_file() -> Description:
    """The description of the current scene, or of the first that is set up. Raises RelumeError."""
    scenes = [bpy.context.scene, *bpy.data.scenes]
    ready = next((scene for scene in scenes if scene.relume.is_set_up and passes.pass_layers(scene)), None)
    if ready is None:
        raise SetupError(f"{bpy.path.basename(bpy.data.filepath)}: no scene is set up for spectral rendering")
    return description_of(ready)


class WriteSidecar(NeedsSetUp, Operator):
    """Write what relighting needs to know of this scene, to be put beside what other Blenders render of it. Only a mix
    with measured spectra, or too many light groups for a note of 511 characters, needs it"""

    bl_idname = "relume.write_sidecar"
    bl_label = "Write Sidecar"

    filepath: StringProperty(subtype="FILE_PATH")
    filter_glob: StringProperty(default=f"*{description.SUFFIX}", options={"HIDDEN"})

    def invoke(self, context, event):
        self.filepath = f"{bpy.path.display_name_from_filepath(bpy.data.filepath) or 'untitled'}{description.SUFFIX}"
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        try:
            description.write(bpy.path.abspath(self.filepath), description_of(context.scene))
        except (OSError, RelumeError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"wrote {self.filepath}")
        return {"FINISHED"}


CLASSES = (WriteSidecar,)
