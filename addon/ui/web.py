"""Share as Web Page. The mix that comes back from one: Paste Mix in `mix_files`."""

from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np
from bpy.props import FloatProperty, IntProperty, StringProperty
from bpy.types import Operator

from ...core.picture.coefficients import CoefficientImage
from ..cli.arguments import QUALITIES, SIZES
from ..cli.web import plain_name, shown
from ..scene import render
from . import inspector
from .mixer_operators import NeedsSetUp, reporting

__all__ = ["CLASSES"]


class ShareAsWebPage(NeedsSetUp, Operator):
    """Write the render that is there as one HTML file, in which anyone can change the light in a browser"""

    bl_idname = "relume.share_as_web_page"
    bl_label = "Share as Web Page"
    bl_options = {"REGISTER"}

    filepath: StringProperty(subtype="FILE_PATH")
    filter_glob: StringProperty(default="*.html", options={"HIDDEN"})
    size: IntProperty(
        name="Size", description="Pixels of the longer side, at most", default=1920, min=SIZES[0], max=SIZES[1]
    )
    quality: FloatProperty(
        name="Colour Difference",
        description="CIEDE2000 that 98 % of the picture keeps to under every lamp. More makes a smaller file",
        default=1.0,
        min=QUALITIES[0],
        max=QUALITIES[1],
    )
    title: StringProperty(name="Title", description="Headline of the page; empty: the name of the file")

    @classmethod
    def poll(cls, context) -> bool:
        if not super().poll(context):
            return False
        if not context.scene.relume.exr and inspector.picture_editor(context) is None:
            cls.poll_message_set("no Image Editor in this window shows a render")
            return False
        return True

    def invoke(self, context, event) -> set[str]:
        name = plain_name(Path(context.scene.relume.exr or bpy.data.filepath or context.scene.name))
        self.filepath = self.filepath or f"{name}.html"
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    @reporting
    def execute(self, context) -> None:
        from ...core.web import page

        path = Path(bpy.path.abspath(self.filepath)).with_suffix(".html")
        window = context.window_manager
        window.progress_begin(0, 1)
        try:
            image = _image(context)
            picture = page.Picture(self.title or path.stem, {1: lambda: image})
            page.write(path, [picture], size=self.size, quality=self.quality, title=self.title, show=shown)
        finally:
            window.progress_end()
        self.report({"INFO"}, f"{path} ({path.stat().st_size / 1e6:.1f} MB)")
        if not bpy.app.background:
            import webbrowser

            webbrowser.open(path.absolute().as_uri())


def _image(context) -> CoefficientImage:
    """The coefficient image that a scene shows now, lit as its mixer says. Raises CoefficientImageError."""
    scene = context.scene
    if scene.relume.exr:
        groups = inspector.coefficients_of(context)
    else:
        area = inspector.picture_editor(context)
        region = next(region for region in area.regions if region.type == "WINDOW")
        with context.temp_override(area=area, region=region):
            groups = inspector.coefficients_of(context)
    shape = next(iter(groups.values())).shape[:2]
    return replace(render.described(scene), groups=groups, alpha=np.ones(shape, np.float32))


CLASSES = (ShareAsWebPage,)
