"""The Relume panel, in the sidebar of the 3D view and in the render properties."""

import bpy
from bpy.types import Panel

from ..scene import light_groups, render_settings
from ..store.properties import AUTO, PREFILTERED
from . import left_out, mixer_panels, preferences, remarks_panel, report_panel
from .translation import said
from .wrapping import words

__all__ = ["CLASSES", "register", "unregister"]


class _Relume:
    bl_label = "Relume"

    def draw_header_preset(self, context) -> None:
        self.layout.emboss = "NONE"
        self.layout.popover(panel=preferences.PresetsPanel.bl_idname, icon="PRESET", text="")

    def draw(self, context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = context.scene.relume
        if settings.is_set_up:
            _draw_mixer(layout, settings)
        else:
            _draw_introduction(layout, settings)


def _draw_introduction(layout, settings) -> None:
    words(layout, "Render the whole spectrum, choose the light afterwards.")
    _draw_choice(layout, settings)
    layout.prop(settings, "grouping")
    if settings.grouping == "LIGHT":
        words(layout, said("More than {number} lights: by collection", number=light_groups.MOST))
    row = layout.row()
    row.scale_y = 1.6
    row.operator("relume.set_up", icon="LIGHT_AREA")


def _draw_mixer(layout, settings) -> None:
    model, plan = settings.model(), settings.plan
    if render_settings.is_suspended(settings.id_data):
        column = layout.column(align=True)
        column.label(text="Spectral passes wait for Cycles", icon="PAUSE")
        column.operator("relume.use_cycles", icon="LOOP_BACK")
    else:
        name = said(model.label)
        text = said("F12 renders 1 pass ({model})", model=name)
        if model.passes > 1:
            text = said("F12 renders {passes} passes ({model})", passes=model.passes, model=name)
        words(layout, text, icon="RENDER_STILL")
    if plan.get("changed"):
        words(layout, plan["changed"][:1].upper() + plan["changed"][1:])
    if plan.get("reason"):
        words(layout, plan["reason"])
    if plan.get("request") != settings.request:
        row = layout.row()
        row.scale_y = 1.4
        row.operator("relume.set_up", text="Apply New Channels", icon="FILE_REFRESH")
    mixer_panels.draw(layout, settings)
    layout.separator()
    _draw_choice(layout, settings)
    layout.operator("relume.remove", icon="TRASH")


def _draw_choice(layout, settings) -> None:
    layout.prop(settings, "channels")
    if settings.channels == AUTO:
        layout.prop(settings, "tolerance")
        layout.prop(settings, "switching")
    elif settings.channels == PREFILTERED:
        layout.prop(settings, "dominant_group", icon="LIGHT")
        layout.prop(settings, "rendering_space")
    layout.prop(settings, "split_samples")
    if settings.is_set_up and settings.model().passes > 1:
        layout.prop(settings, "denoise_passes" if settings.id_data.cycles.use_denoising else "reduce_color_noise")


class SidebarPanel(_Relume, Panel):
    bl_idname = "VIEW3D_PT_relume"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Relume"


class ImagePanel(_Relume, Panel):
    bl_idname = "IMAGE_PT_relume"
    bl_space_type = "IMAGE_EDITOR"
    bl_region_type = "UI"
    bl_category = "Relume"


class RenderPanel(_Relume, Panel):
    bl_idname = "RENDER_PT_relume"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    bl_order = -1
    bl_options = {"DEFAULT_CLOSED"}


CLASSES = (
    *mixer_panels.CLASSES,
    SidebarPanel,
    ImagePanel,
    RenderPanel,
    *left_out.CLASSES,
    *report_panel.CLASSES,
    *remarks_panel.CLASSES,
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    report_panel.end()
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
