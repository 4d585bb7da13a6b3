"""Designed reflectances tried on in a render that is there, and rows picked from its picture."""

import bpy
import numpy as np
from bpy.types import Operator
from bpy.utils import register_classes_factory

from ...core.errors import RelumeError
from ...core.picture import coefficients, recombination
from ..scene import surfaces
from ..store import mixes, palette, palette_tables, shining
from . import inspector, palette_entries
from .palette_operators import OfPalette

__all__ = ["CLASSES", "draw", "register", "unregister"]

_IMAGE = "Relume Try-On"
_NONE_CARRIED = "this render carries no surfaces: switch Carry Surfaces on and render again"


class CarrySurfaces(OfPalette, Operator):
    """Let renders carry what each pixel sees first, and which material: for Try On, rows picked from the picture, and
    the surface's spectrum in Inspect Pixels. It takes memory and nearly no time"""

    bl_idname = "relume.carry_surfaces"
    bl_label = "Carry Surfaces"

    @classmethod
    def poll(cls, context):
        if not context.scene.relume.is_set_up:
            cls.poll_message_set("this scene is not set up for spectral rendering")
            return False
        return super().poll(context)

    def execute(self, context):
        scene = context.scene
        wanted = not surfaces.carried(scene)
        without = surfaces.ask(scene, wanted)
        if without:
            self.report({"WARNING"}, f"these materials have no colour to carry: {', '.join(without)}")
        elif wanted:
            self.report({"INFO"}, f"the next render carries surfaces: {surfaces.cost(scene) / 1e6:.0f} MB more")
        return {"FINISHED"}


def _editor(context):
    """The Image Editor with the render, or with what was tried on in it; None if none is open."""
    areas = [area for area in context.screen.areas if area.type == "IMAGE_EDITOR"]
    shown = [area.spaces.active.image for area in areas]
    ours = [area for area, image in zip(areas, shown, strict=True) if image and image.name == _IMAGE]
    return next((a for a, i in zip(areas, shown, strict=True) if i and i.type == "RENDER_RESULT"), (ours or [None])[0])


def _show_render(area) -> bool:
    result = next((image for image in bpy.data.images if image.type == "RENDER_RESULT"), None)
    if result is not None:
        area.spaces.active.image = result
    return result is not None


class TryOn(Operator):
    """Show the render as it would be with this palette's reflectances on their materials, without rendering. Hatched is
    what may be far off; F12 makes it exact"""

    bl_idname = "relume.palette_try_on"
    bl_label = "Try On"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context):
        if palette.active(context.scene) is None or not context.scene.relume.is_set_up:
            cls.poll_message_set("try on needs a palette, and a scene that is set up for spectral rendering")
            return False
        if _editor(context) is None:
            cls.poll_message_set("no Image Editor in this window shows a render")
            return False
        return True

    def execute(self, context):
        try:
            self._try_on(context, palette.active(context.scene))
        except (RelumeError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}

    def _try_on(self, context, design):
        from ...core import palette as core

        scene, area = context.scene, _editor(context)
        rows = [row for row in design.reflectances if row.material is not None and row.spectrum]
        if not rows:
            raise core.PaletteError("no row has both a spectrum and a material: create spectra, and choose materials")
        if not _show_render(area):
            raise core.PaletteError("nothing has been rendered yet")
        region = next(region for region in area.regions if region.type == "WINDOW")
        with context.temp_override(area=area, region=region):
            groups, seen = inspector.seen_by(context)
        if seen is None:
            raise core.PaletteError(_NONE_CARRIED)
        model = scene.relume.model()
        mix = mixes.of(scene.relume, model)
        wanted = [
            core.Worn(
                row.material.name,
                model.coefficients(shining.stored_spectrum(row.spectrum)),
                surfaces.mirrors(row.material),
            )
            for row in rows
        ]
        done = core.trial(model, mix, groups, seen.surface, seen.materials, wanted)
        matrices = recombination.recombination_matrices(model, mix)
        picture = core.hatched(coefficients.recombine(list(done.groups.values()), matrices), done.expected)
        area.spaces.active.image = _shown(picture)
        design.trial = done.words()
        palette_tables.redraw()
        self.report({"INFO"}, done.words().replace("\n", " "))


def _shown(picture: np.ndarray):
    """The image datablock that holds a linear picture (height, width, 3), seen through the scene's view."""
    height, width, _ = picture.shape
    image = bpy.data.images.get(_IMAGE)
    if image is not None and tuple(image.size) != (width, height):
        bpy.data.images.remove(image)
        image = None
    if image is None:
        image = bpy.data.images.new(_IMAGE, width, height, alpha=False, float_buffer=True)
        image.colorspace_settings.name = bpy.data.colorspace.working_space
        image.use_view_as_render = True
    image.pixels.foreach_set(coefficients.bottom_up_rgba(picture, np.ones((height, width), np.float32)))
    image.update()
    return image


class ShowRender(Operator):
    """Show the render again"""

    bl_idname = "relume.palette_show_render"
    bl_label = "Render"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context):
        return bpy.data.images.get(_IMAGE) is not None and _editor(context) is not None

    def execute(self, context):
        return {"FINISHED"} if _show_render(_editor(context)) else {"CANCELLED"}


class PickRow(inspector.Picking, Operator):
    """Click a surface in the picture: its material's row is selected, or added"""

    bl_idname = "relume.palette_pick_row"
    bl_label = "Pick Row"

    @classmethod
    def poll(cls, context):
        if palette.active(context.scene) is None:
            cls.poll_message_set("this scene has no palette: make one")
            return False
        return super().poll(context)

    def begin(self, context):
        if self.surfaces is None:
            raise RelumeError(_NONE_CARRIED)

    def modal(self, context, event):
        if event.type in {"ESC", "RIGHTMOUSE"}:
            return self.end(context, {"CANCELLED"})
        if event.type != "LEFTMOUSE" or event.value != "PRESS":
            return {"RUNNING_MODAL"}
        place = self.place(event)
        name = self.surfaces.at(*place)[0] if place else ""
        material = bpy.data.materials.get(name)
        if material is None:
            self.report({"INFO"}, "no material is seen there")
            return self.end(context, {"CANCELLED"})
        try:
            palette_entries.select_material(palette.active(context.scene), material)
        except RelumeError as error:
            self.report({"ERROR"}, str(error))
            return self.end(context, {"CANCELLED"})
        return self.end(context, {"FINISHED"})


def draw(layout, context, design):
    """Try On, and what it needs."""
    column = layout.column(align=True)
    line = column.row(align=True)
    line.operator("relume.palette_try_on", icon="HIDE_OFF")
    line.operator("relume.palette_show_render", text="", icon="RENDER_RESULT")
    line.operator("relume.palette_pick_row", text="", icon="EYEDROPPER")
    if context.scene.relume.is_set_up:
        carried = surfaces.carried(context.scene)
        column.operator("relume.carry_surfaces", depress=carried, icon="CHECKBOX_HLT" if carried else "CHECKBOX_DEHLT")


CLASSES = (CarrySurfaces, TryOn, ShowRender, PickRow)

register, unregister = register_classes_factory(CLASSES)
