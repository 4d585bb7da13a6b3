"""Relume in Blender's preferences, and presets of set-ups."""

import logging
from pathlib import Path

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel
from bpy.props import EnumProperty, FloatProperty, StringProperty
from bpy.types import AddonPreferences, Menu, Operator, Panel

from ..host.console import LOG
from ..store import preferred, properties
from . import keys

__all__ = ["CLASSES", "register", "unregister"]

_FOLDER = "relume/set_up"  # of Blender's presets
_SHIPPED = str(Path(__file__).parent)  # has them in `presets`
_LEVELS = [
    ("WARNING", "Problems", "What went wrong"),
    ("INFO", "Changes", "Also what Relume changed in a scene that is set up"),
    ("DEBUG", "Everything", "Also where each error came from"),
]


def _log(self, context) -> None:
    """Say on standard error what the level asks for."""
    LOG.setLevel(self.log_level)
    if self.log_level != "WARNING" and not LOG.handlers:
        handler = logging.StreamHandler()
        handler.setFormatter(logging.Formatter("%(name)s %(levelname)s %(message)s"))
        LOG.addHandler(handler)


class RelumePreferences(AddonPreferences):
    bl_idname = preferred.PACKAGE

    channels: EnumProperty(
        name="Channels",
        description="How finely the spectrum is split in scenes that do not say otherwise",
        items=properties.CHANNELS,
        default=properties.AUTO,
    )
    tolerance: FloatProperty(
        name="Tolerance",
        description="Colour difference (CIEDE2000) to the full spectrum in scenes that do not say otherwise",
        default=1.0,
        min=0.02,
        soft_max=5.0,
    )
    lamp_folder: StringProperty(
        name="Lamps",
        description="A folder of measured lamps: its files stand in the search of illuminants",
        subtype="DIR_PATH",
    )
    paint_folder: StringProperty(
        name="Surfaces",
        description="A folder of measured reflectances: its files stand in the search of spectra of materials",
        subtype="DIR_PATH",
    )
    favourites: StringProperty(options={"HIDDEN"})  # names of illuminants, a line each
    log_level: EnumProperty(
        name="Log", description="What Relume says on the terminal", items=_LEVELS, default="WARNING", update=_log
    )

    def draw(self, context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "channels")
        row = layout.row()
        row.active = self.channels == properties.AUTO
        row.prop(self, "tolerance")
        column = layout.column()
        column.label(text="Library Folders")
        column.prop(self, "lamp_folder")
        column.prop(self, "paint_folder")
        layout.prop(self, "log_level")
        column = layout.column()
        column.label(text="Keys")
        keys.draw(column, context)


class PresetsMenu(Menu):
    bl_idname = "RELUME_MT_presets"
    bl_label = "Set-Up Presets"
    preset_subdir = _FOLDER
    preset_operator = "script.execute_preset"
    draw = Menu.draw_preset


class AddPreset(AddPresetBase, Operator):
    """Keep these choices under a name, for other scenes and files, or remove a name"""

    bl_idname = "relume.preset_add"
    bl_label = "Add Set-Up Preset"
    preset_menu = "RELUME_MT_presets"
    preset_subdir = _FOLDER
    preset_defines = ("settings = bpy.context.scene.relume",)
    preset_values = tuple(
        f"settings.{name}" for name in ("channels", "tolerance", "switching", "grouping", "split_samples")
    )


class PresetsPanel(PresetPanel, Panel):
    bl_idname = "RELUME_PT_presets"
    bl_label = "Set-Up Presets"
    preset_subdir = _FOLDER
    preset_operator = "script.execute_preset"
    preset_add_operator = "relume.preset_add"


CLASSES = (RelumePreferences, PresetsMenu, AddPreset, PresetsPanel)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.utils.register_preset_path(_SHIPPED)
    own = preferred.of()
    if own is not None:
        _log(own, bpy.context)


def unregister() -> None:
    bpy.utils.unregister_preset_path(_SHIPPED)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
