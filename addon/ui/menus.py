"""Relume in Blender's own menus: Render, File > Import and Export, and the right-click menus of materials and lights.

F3 finds what stands in a menu: *Render > Relume* therefore has every command that needs no place of its own.
"""

import bpy
from bpy.types import Menu

from ..graph import places
from . import material_panel, spectrum_files

__all__ = ["CLASSES", "register", "unregister"]

# "" separates; each is drawn as its operator is called
_COMMANDS = (
    *("relume.set_up", "relume.use_cycles", "relume.make_local", "relume.remove", ""),
    *("relume.remove_empty_groups", "relume.select_lights", "relume.write_to_lights", ""),
    *("relume.copy_mix", "relume.paste_mix", "relume.save_mix", "relume.load_mix", "relume.reset_mix"),
    *("relume.copy_illuminant", "relume.paste_illuminant", ""),
    *("relume.take_snapshot", "relume.apply_snapshot", "relume.compare", ""),
    *("relume.pick_white", "relume.inspect", ""),
    *("relume.relight_exr", "relume.write_sidecar", "relume.share_as_web_page", "relume.report", ""),
    *("relume.import_spectrum", "relume.export_spectrum", ""),
    *(
        "relume.carry_surfaces",
        "relume.new_transfer",
        "relume.palette_create",
        "relume.palette_assign",
        "relume.palette_assign_lights",
    ),
)


class CommandsMenu(Menu):
    bl_idname = "RELUME_MT_commands"
    bl_label = "Relume"

    def draw(self, context) -> None:
        layout = self.layout
        layout.operator_context = "INVOKE_DEFAULT"
        for name in _COMMANDS:
            if name:
                layout.operator(name)
            else:
                layout.separator()
        layout.separator()
        thing = context.object
        if thing is not None and thing.active_material is not None:
            _draw_material(layout, thing.active_material)
        layout.menu("RELUME_MT_illuminants")
        layout.operator_menu_enum("relume.regroup", "way", text="New Light Groups")


class IlluminantsMenu(Menu):
    bl_idname = "RELUME_MT_illuminants"
    bl_label = "Illuminant of Light Group"

    def draw(self, context) -> None:
        self.layout.operator_context = "INVOKE_DEFAULT"
        for index, row in enumerate(context.scene.relume.light_groups):
            _choose(self.layout, index, row.name)


def _choose(layout, index: int, text: str) -> None:
    chosen = layout.operator("relume.choose_illuminant", text=text, translate=False)
    chosen.group, chosen.part = index, -1


def _draw_material(layout, material) -> None:
    """The commands of a material's colour, where it takes a spectrum."""
    place = material_panel.first_place(material) if material.node_tree else None
    if place is not None:
        node, identifier, takes = place
        _draw_place(layout, node, identifier, takes)


def _draw_place(layout, node, identifier: str, takes: str) -> None:
    layout.operator_context = "INVOKE_DEFAULT"
    buttons = [
        layout.operator("relume.assign_spectrum", text="Measured Spectrum from Library"),
        layout.operator("relume.assign_spectrum_file", text="Measured Spectrum from File"),
    ]
    if places.chosen_at(node, identifier, takes):
        buttons.append(layout.operator("relume.clear_spectrum"))
    for button in buttons:
        button.node, button.socket, button.takes = node.name, identifier, takes


def _material_menu(self, context) -> None:
    material = material_panel.active_material(context)
    if material is not None:
        self.layout.separator()
        _draw_material(self.layout, material)


def _object_menu(self, context) -> None:
    """For a lamp, its illuminant; for what has a material, its spectrum."""
    thing, layout = context.object, self.layout
    if thing is None:
        return
    row = spectrum_files.row_of(context.scene, thing) if thing.type == "LIGHT" else None
    if row is not None:
        layout.separator()
        layout.operator_context = "INVOKE_DEFAULT"
        _choose(layout, context.scene.relume.light_groups.find(row.name), bpy.app.translations.pgettext("Illuminant"))
        measured = layout.operator("relume.import_spectrum", text="Illuminant from File")
        measured.use, measured.group = spectrum_files.LIGHT, row.name
    elif thing.type != "LIGHT" and thing.active_material is not None:
        layout.separator()
        _draw_material(layout, thing.active_material)


def _button_menu(self, context) -> None:
    """On a colour of a material: the spectrum of just that socket."""
    socket = getattr(context, "button_pointer", None)
    material = material_panel.active_material(context)
    if not isinstance(socket, bpy.types.NodeSocket) or material is None or socket.id_data != material.node_tree:
        return
    for node, identifier, takes in places.of(material):
        if node == socket.node.name and identifier in ("", socket.identifier):
            self.layout.separator()
            _draw_place(self.layout, socket.node, identifier, takes)
            return


def _render_menu(self, context) -> None:
    self.layout.separator()
    self.layout.menu("RELUME_MT_commands", icon="LIGHT_AREA")


def _import_menu(self, context) -> None:
    self.layout.operator("relume.import_spectrum", text="Spectrum (.csv, .spd, .spdx, .cgats)")
    self.layout.operator("relume.load_mix", text="Relume Mix (.json)")
    self.layout.operator("relume.relight_exr", text="Spectral Coefficients, to Relight (.exr)")


def _export_menu(self, context) -> None:
    self.layout.operator("relume.export_spectrum", text="Spectrum (.csv)")
    self.layout.operator("relume.save_mix", text="Relume Mix (.json)")
    self.layout.operator("relume.write_sidecar", text="Relume Sidecar (.json)")


CLASSES = (CommandsMenu, IlluminantsMenu)
_PLACES = (
    ("TOPBAR_MT_render", _render_menu),
    ("TOPBAR_MT_file_import", _import_menu),
    ("TOPBAR_MT_file_export", _export_menu),
    ("MATERIAL_MT_context_menu", _material_menu),
    ("VIEW3D_MT_object_context_menu", _object_menu),
    ("UI_MT_button_context_menu", _button_menu),
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    for menu, draw in _PLACES:
        getattr(bpy.types, menu).append(draw)


def unregister() -> None:
    for menu, draw in _PLACES:
        getattr(bpy.types, menu).remove(draw)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
