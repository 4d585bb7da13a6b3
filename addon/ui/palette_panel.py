"""The palette editor: the matrix of lights and reflectances, in the sidebar of the Image Editor and of the 3D view."""

from bpy.types import Menu, Panel
from bpy.utils import register_classes_factory

from ..store import palette, palette_tables
from . import icons, palette_demands, palette_trial
from .translation import said
from .wrapping import words

__all__ = ["CLASSES", "register", "unregister"]

_SHOWN = 6  # columns that fit; the others are reached by selecting them


class AddMenu(Menu):
    bl_idname = "RELUME_MT_palette_add"
    bl_label = "Add to Palette"

    def draw(self, context):
        for kind, label in (("LIGHT", "Light"), ("REFLECTANCE", "Reflectance")):
            self.layout.label(text=label)
            self.layout.operator_context = "INVOKE_DEFAULT"
            self.layout.operator("relume.palette_add_designed", text="Designed", icon="MODIFIER").kind = kind
            self.layout.operator("relume.palette_add_named", text="From Library…", icon="VIEWZOOM").kind = kind
            self.layout.operator("relume.palette_add_file", text="From File…", icon="FILEBROWSER").kind = kind
            if kind == "LIGHT":
                self.layout.operator("relume.palette_add_planckian", text="Black Body…", icon="LIGHT_SUN")
            else:
                self.layout.operator("relume.palette_add_materials", text="Materials of Selected", icon="MATERIAL")
            self.layout.separator()


class _Palette:
    bl_label = "Palette"
    bl_category = "Relume"
    bl_region_type = "UI"

    def draw(self, context):
        layout, scene = self.layout, context.scene
        line = layout.row()
        line.template_list(
            "UI_UL_list", "relume_palettes", scene, "relume_palettes", scene, "relume_palette_active", rows=2, maxrows=4
        )
        column = line.column(align=True)
        column.operator_menu_enum("relume.palette_new", "example", text="", icon="ADD")
        column.operator("relume.palette_remove", text="", icon="REMOVE")
        column.operator("relume.palette_open", text="", icon="FILEBROWSER")
        design = palette.active(scene)
        if design is None:
            words(layout, "A palette finds lights and materials that make the colours you want, together.")
            return
        _draw_matrix(layout, design)
        _draw_selected(layout, design)
        row = layout.row()
        row.scale_y = 1.5
        row.operator("relume.palette_create", icon="SHADERFX")
        for sentence in design.remarks.splitlines():
            words(layout, sentence)
        _draw_curves(layout, design)
        palette_demands.draw_demands(layout, design)
        palette_demands.draw_criteria(layout, design)
        _draw_assign(layout, design)
        palette_trial.draw(layout, context, design)
        for sentence in design.trial.splitlines():
            words(layout, sentence)


def _draw_matrix(layout, design):
    palette_tables.show_view(design)
    first = max(0, min(design.column - _SHOWN + 1, len(design.lights) - _SHOWN))
    columns = range(first, min(first + _SHOWN, len(design.lights)))
    # Patches as large as the usual width of a sidebar lets them be
    patch = min(3.2, 8.0 / max(len(columns), 1))
    box = layout.box().column(align=True)
    corner, head = _line(box)
    corner.menu("RELUME_MT_palette_add", text="", icon="ADD")
    for index in columns:
        column = head.column(align=True)
        light, color = design.lights[index], design.lights[index].swatch
        column.operator("relume.palette_select", text=light.name, depress=index == design.column).column = index
        column.template_icon(icons.patch(color, color, color), scale=1.0)
    for index, reflectance in enumerate(design.reflectances):
        # Names of materials are long: each has the whole width
        box.separator(factor=0.5)
        name = box.row(align=True)
        name.operator("relume.palette_select", text=reflectance.name, depress=index == design.row).row = index
        name.prop(reflectance, "designed", text="", icon=_sign(reflectance), toggle=True)
        side, line = _line(box)
        color = reflectance.swatch
        side.template_icon(icons.patch(color, color, color), scale=min(patch, 1.8))
        for column_index in columns:
            cell = palette.cell_at(design, index, column_index)
            column = line.column(align=True)
            column.template_icon(icons.patch(cell.wanted, cell.full, cell.model), scale=patch)
            chosen = column.operator(
                "relume.palette_select",
                text=_cell_label(cell),
                depress=(index, column_index) == (design.row, design.column),
            )
            chosen.row, chosen.column = index, column_index
    box.separator(factor=0.5)
    box.row(align=True).prop(design, "shown", expand=True)


def _line(box):
    """A line of the matrix: its side, and the place for its patches."""
    line = box.split(factor=0.18, align=True)
    return line.column(align=True), line.row(align=True)


def _sign(entry) -> str:
    return "MODIFIER" if entry.designed else "LOCKED"


def _cell_label(cell) -> str:
    if cell.use == "FREE":
        return cell.free
    if cell.use == "TARGET":
        return f"ΔE {cell.error:.1f}" if cell.error >= 0 else "wanted"
    return "–"


def _draw_selected(layout, design):
    if not (design.lights and design.reflectances):
        words(layout, "Add a light and a reflectance: colours are wanted where they meet.")
        return
    light, reflectance = design.lights[design.column], design.reflectances[design.row]
    cell = palette.cell_at(design, design.row, design.column)
    box = layout.box().column()
    box.use_property_split = False
    box.label(text=said("{reflectance} under {light}", reflectance=reflectance.name, light=light.name), icon="COLOR")
    line = box.row(align=True)
    line.prop(cell, "use", expand=True)
    if cell.use == "TARGET":
        line = box.row(align=True)
        line.prop(cell, "target", text="")
        line.prop(cell, "weight")
    elif cell.use == "FREE":
        line = box.row(align=True)
        line.prop(cell, "free", expand=True)
        palette_demands.draw_free(box, design, cell.free)
    line = box.row(align=True)
    line.operator("relume.palette_fit", text="Fit Colour").everywhere = False
    line.operator("relume.palette_fit", text="Fit All").everywhere = True
    line.operator("relume.palette_black", text="", icon="GHOST_ENABLED")
    for kind, entry in (("LIGHT", light), ("REFLECTANCE", reflectance)):
        line = box.row(align=True)
        line.prop(entry, "name", text="", icon="LIGHT" if kind == "LIGHT" else "MATERIAL")
        line.prop(entry, "designed", text="", icon=_sign(entry), toggle=True)
        line.operator("relume.palette_normalise", text="", icon="FULLSCREEN_EXIT").kind = kind
        line.operator("relume.palette_take_out", text="", icon="X").kind = kind
        if kind == "LIGHT" and not entry.designed:
            box.prop(entry, "luminance")
    line = box.row(align=True)
    line.prop(reflectance, "material", text="")
    line.operator("relume.palette_pick_material", text="", icon="EYEDROPPER")
    for kind, entry in (("LIGHT", light), ("REFLECTANCE", reflectance)):
        if entry.designed:
            palette_demands.draw_limits(layout, entry, kind)


def _draw_curves(layout, design):
    pairs = ((design.lights, design.column, True), (design.reflectances, design.row, False))
    chosen = [(entries[index], is_light) for entries, index, is_light in pairs if entries and entries[index].spectrum]
    lines = [(_drawn(entry.spectrum, is_light), entry.swatch) for entry, is_light in chosen]
    if icon := icons.curves(lines):
        layout.label(text=" and ".join(entry.name for entry, _ in chosen), icon="FCURVE")
        layout.template_icon(icon, scale=8.0)


def _drawn(text: str, is_light: bool) -> list:
    from ...core.picture import drawing
    from ..store.shining import stored_spectrum

    spectrum = stored_spectrum(text)
    return (drawing.curve(spectrum) if is_light else spectrum.sampled()).tolist()


def _draw_assign(layout, design):
    column = layout.column(align=True)
    column.operator("relume.palette_assign", icon="MATERIAL")
    column.operator("relume.palette_assign_lights", icon="LIGHT")


class ViewPanel(_Palette, Panel):
    bl_idname = "VIEW3D_PT_relume_palette"
    bl_space_type = "VIEW_3D"
    bl_options = {"DEFAULT_CLOSED"}


class ImagePanel(_Palette, Panel):
    bl_idname = "IMAGE_PT_relume_palette"
    bl_space_type = "IMAGE_EDITOR"
    bl_options = {"DEFAULT_CLOSED"}


CLASSES = (AddMenu, ViewPanel, ImagePanel)

register, unregister = register_classes_factory(CLASSES)
