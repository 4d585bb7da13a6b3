"""What is asked of a palette beside colours: differences, constancy, blacks, bounds, nearness; asked for, and drawn."""

import json

from bpy.props import EnumProperty, IntProperty, StringProperty
from bpy.types import Operator
from bpy.utils import register_classes_factory

from ..store import palette, palette_tables
from .palette_operators import OfPalette
from .translation import said

__all__ = ["CLASSES", "draw_criteria", "draw_demands", "draw_free", "draw_limits", "register", "unregister"]


class AddDemand(OfPalette, Operator):
    """Add a demand: two reflectances that match or part, or one that keeps its colour"""

    bl_idname = "relume.palette_add_demand"
    bl_label = "Add Demand"

    what: EnumProperty(items=[("DIFFERENCE", "Difference", ""), ("CONSTANCY", "Constancy", "")], options={"HIDDEN"})
    remove: IntProperty(default=-1, options={"HIDDEN"})

    def execute(self, context):
        design = palette.active(context.scene)
        collection = design.differences if self.what == "DIFFERENCE" else design.constancies
        if self.remove >= 0:
            collection.remove(self.remove)
            return {"FINISHED"}
        names = [entry.name for entry in design.reflectances]
        if self.what == "CONSTANCY":
            collection.add().reflectance = names[design.row] if names else ""
            return {"FINISHED"}
        item = collection.add()
        item.light = design.lights[design.column].name if design.lights else ""
        item.first, item.second = (names + ["", ""])[0], (names + ["", ""])[1]
        return {"FINISHED"}


class LeaveOut(OfPalette, Operator):
    """Whether this constancy holds under this light"""

    bl_idname = "relume.palette_leave_out"
    bl_label = "Leave Out"

    index: IntProperty(options={"HIDDEN"})
    light: StringProperty(options={"HIDDEN"})

    def execute(self, context):
        left_out = palette.active(context.scene).constancies[self.index].left_out
        if (index := left_out.find(self.light)) >= 0:
            left_out.remove(index)
        else:
            left_out.add().name = self.light
        return {"FINISHED"}


class Black(OfPalette, Operator):
    """Want nothing to be seen of this reflectance under this light, though it may be bright under others: a metameric
    black. It is below 0 somewhere, so it gets bounds of its own"""

    bl_idname = "relume.palette_black"
    bl_label = "Invisible Here"

    def execute(self, context):
        design = palette.active(context.scene)
        if not (design.lights and design.reflectances):
            self.report({"ERROR"}, "this palette needs a light and a reflectance")
            return {"CANCELLED"}
        entry = design.reflectances[design.row]
        if design.bounded and not (entry.own_bounds and entry.lower < 0):
            entry.own_bounds, entry.lower, entry.upper = True, -1.0, 1.0
            self.report({"INFO"}, f"{entry.name!r} may now be from -1 to 1: as emission or in AOVs, not on a surface")
        palette.cell_at(design, design.row, design.column).target = (0.0, 0.0, 0.0)
        return {"FINISHED"}


class BoundFree(OfPalette, Operator):
    """Give the free colour of this letter bounds, or take them away"""

    bl_idname = "relume.palette_bound_free"
    bl_label = "Bounds"

    letter: StringProperty(options={"HIDDEN"})

    def execute(self, context):
        free = palette.active(context.scene).free_colours
        if (index := free.find(self.letter)) >= 0:
            free.remove(index)
        else:
            free.add().name = self.letter
        return {"FINISHED"}


_NAMED = []  # Blender keeps no reference to the strings


def _reflectances(self, context):
    from ...core.spectra import library

    if not _NAMED:
        found = [spectrum for label in library.REFLECTANCE_SETS for spectrum in library.reflectances(label)]
        _NAMED.extend((spectrum.name, spectrum.name, spectrum.source) for spectrum in found)
    return _NAMED


class StayNear(OfPalette, Operator):
    """Choose the measured reflectance that the selected one stays near to"""

    bl_idname = "relume.palette_near"
    bl_label = "Stay Near To"
    bl_property = "spectrum"

    way: EnumProperty(
        items=[("LIBRARY", "Library", ""), ("NOW", "As It Is", ""), ("NONE", "Nothing", "")], options={"HIDDEN"}
    )
    spectrum: EnumProperty(name="Spectrum", items=_reflectances)

    def invoke(self, context, event):
        if self.way != "LIBRARY":
            return self.execute(context)
        context.window_manager.invoke_search_popup(self)
        return {"INTERFACE"}

    def execute(self, context):
        from ...core.errors import PaletteError
        from ...core.spectra import library

        def choose(design):
            if not design.reflectances:
                raise PaletteError("this palette has no reflectance")
            entry = design.reflectances[design.row]
            if self.way == "NOW" and not entry.spectrum:
                raise PaletteError(f"{entry.name!r} has no spectrum yet: create spectra")
            if self.way == "LIBRARY":
                near = library.reflectance(self.spectrum)
                entry.near, entry.near_name = json.dumps(near.to_dict()), near.name
            else:
                now = self.way == "NOW"
                entry.near, entry.near_name = (entry.spectrum, f"{entry.name}, as it is") if now else ("", "")
            palette_tables.redraw()

        return self.done(context, choose)


def draw_demands(layout, design):
    """Differences and constancy."""
    header, body = layout.panel("relume_palette_demands", default_closed=not (design.differences or design.constancies))
    header.label(text="Differences and Constancy")
    if body is None:
        return
    for index, one in enumerate(design.differences):
        box = body.box().column(align=True)
        line = box.row(align=True)
        line.prop_search(one, "first", design, "reflectances", text="")
        line.prop_search(one, "second", design, "reflectances", text="")
        _draw_removal(line, "DIFFERENCE", index)
        line = box.row(align=True)
        line.prop(one, "kind", text="")
        line.prop(one, "amount", text="ΔE")
        line = box.row(align=True)
        line.prop_search(one, "light", design, "lights", text="")
        line.prop(one, "weight")
    for index, one in enumerate(design.constancies):
        box = body.box().column(align=True)
        line = box.row(align=True)
        line.prop_search(one, "reflectance", design, "reflectances", text="")
        _draw_removal(line, "CONSTANCY", index)
        line = box.row(align=True)
        line.prop(one, "adapted", toggle=True)
        line.prop(one, "weight")
        grid = box.grid_flow(columns=3, align=True)
        for light in design.lights:
            is_in = one.left_out.find(light.name) < 0
            chosen = grid.operator("relume.palette_leave_out", text=light.name, depress=is_in)
            chosen.index, chosen.light = index, light.name
    line = body.row(align=True)
    line.operator("relume.palette_add_demand", text="Difference", icon="ADD").what = "DIFFERENCE"
    line.operator("relume.palette_add_demand", text="Constancy", icon="ADD").what = "CONSTANCY"


def _draw_removal(line, what: str, index: int):
    removed = line.operator("relume.palette_add_demand", text="", icon="X")
    removed.what, removed.remove = what, index


def draw_free(layout, design, letter: str):
    """The bounds of a free colour."""
    index = design.free_colours.find(letter)
    layout.operator(
        "relume.palette_bound_free", text=said("Bounds of {letter}", letter=letter), depress=index >= 0
    ).letter = letter
    if index >= 0:
        for name in ("lower", "upper"):
            layout.row(align=True).prop(design.free_colours[index], name, text="")


def draw_limits(layout, entry, kind: str):
    """What a light or a reflectance that is designed has to keep to."""
    name = "relume_palette_limits_" + kind.lower()
    header, body = layout.panel(name, default_closed=True)
    header.label(text=said("Limits of {name}", name=entry.name))
    if body is None:
        return
    line = body.row(align=True)
    line.prop(entry, "own_bounds", toggle=True)
    if entry.own_bounds:
        line.prop(entry, "lower", text="")
        line.prop(entry, "upper", text="")
    if kind == "LIGHT":
        return
    line = body.row(align=True)
    line.operator("relume.palette_near", text=entry.near_name or "Near To…", icon="VIEWZOOM").way = "LIBRARY"
    line.operator("relume.palette_near", text="", icon="PINNED").way = "NOW"
    if entry.near:
        line.operator("relume.palette_near", text="", icon="X").way = "NONE"
        body.prop(entry, "near_weight", text="Weight of Nearness")
    body.prop(entry, "span")
    if entry.span != "NONE":
        body.prop(entry, "span_weight", text="Weight of What It Is Made Of")


def draw_criteria(layout, design):
    """What holds for the whole design."""
    header, body = layout.panel("relume_palette_criteria", default_closed=True)
    header.label(text="Criteria")
    if body is None:
        return
    body.use_property_split = True
    for name in ("bounded", "smoothness", "space", "channels"):
        body.prop(design, name)
    if design.channels != "0":
        for name in ("family", "model_error", "use_model"):
            body.prop(design, name)


CLASSES = (AddDemand, LeaveOut, Black, BoundFree, StayNear)

register, unregister = register_classes_factory(CLASSES)
