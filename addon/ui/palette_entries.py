"""Lights and reflectances added to a palette and taken out of it."""

import json

from bpy.props import EnumProperty, FloatProperty, StringProperty
from bpy.types import Operator
from bpy.utils import register_classes_factory
from bpy_extras.io_utils import ImportHelper

from ..store import palette, palette_tables
from .palette_operators import OfPalette

__all__ = ["CLASSES", "register", "select_material", "unregister"]


def _add_entry(design, kind: str, name: str, spectrum=None):
    """A new row or column at the end, and selected."""
    rows, columns = len(design.reflectances), len(design.lights)
    entries = palette.entries(design, kind)
    taken, base, number = [entry.name for entry in entries], name, 2
    while name in taken:
        name, number = f"{base} {number}", number + 1
    entry = entries.add()
    entry.name, entry.source = name, spectrum.name if spectrum else "Designed"
    if spectrum is None:
        entry["designed"] = True
    else:
        entry.spectrum = json.dumps(spectrum.to_dict())
    more = [None]
    palette.reshape(
        design,
        list(range(rows)) + more * (kind != "LIGHT"),
        list(range(columns)) + more * (kind == "LIGHT"),
        columns,
    )
    if kind == "LIGHT":
        design.column = columns
    else:
        design.row = rows
    palette_tables.show(design)
    return entry


def select_material(design, material):
    """Select the row of a material, and add it if there is none. Raises PaletteError for one without a colour."""
    from ...core.errors import PaletteError
    from . import palette_assign

    for index, row in enumerate(design.reflectances):
        if row.material == material:
            design.row = index
            palette_tables.redraw()
            return
    if not palette_assign.takes_spectrum(material):
        raise PaletteError(f"material {material.name!r} has no colour that takes a spectrum")
    entry = _add_entry(design, "REFLECTANCE", material.name, palette_assign.reflectance_of(material))
    entry.material = material


class AddDesigned(OfPalette, Operator):
    """Add a spectrum that Create Spectra is to find"""

    bl_idname = "relume.palette_add_designed"
    bl_label = "Add Designed"

    kind: EnumProperty(items=palette.KINDS, options={"HIDDEN"})

    def execute(self, context):
        name = "lamp" if self.kind == "LIGHT" else "paint"
        return self.done(context, lambda design: _add_entry(design, self.kind, name))


_NAMED = {"LIGHT": [], "REFLECTANCE": []}


def _named(self, context):
    from ...core.spectra import library

    items = _NAMED[self.kind]
    if not items and self.kind == "LIGHT":
        for family, names in library.illuminants().items():
            items += [(name, f"{name}  ({family})", family) for name in names]
    elif not items:
        found = [spectrum for label in library.REFLECTANCE_SETS for spectrum in library.reflectances(label)]
        items += [(spectrum.name, spectrum.name, spectrum.source) for spectrum in found]
    return items


class AddNamed(OfPalette, Operator):
    """Add a measured spectrum from the library"""

    bl_idname = "relume.palette_add_named"
    bl_label = "Add from Library"
    bl_property = "spectrum"

    kind: EnumProperty(items=palette.KINDS, options={"HIDDEN"})
    spectrum: EnumProperty(name="Spectrum", items=_named)

    def invoke(self, context, event):
        context.window_manager.invoke_search_popup(self)
        return {"INTERFACE"}

    def execute(self, context):
        from ...core.spectra import library

        def add(design):
            found = library.illuminant if self.kind == "LIGHT" else library.reflectance
            _add_entry(design, self.kind, self.spectrum, found(self.spectrum))

        return self.done(context, add)


class AddPlanckian(OfPalette, Operator):
    """Add the light of a glowing body of a temperature"""

    bl_idname = "relume.palette_add_planckian"
    bl_label = "Add Black Body"

    kelvin: FloatProperty(
        name="Temperature", default=2856.0, min=500.0, max=100000.0, subtype="TEMPERATURE", precision=0
    )

    def invoke(self, context, event):
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context):
        from ...core.spectra import library

        name = f"Planckian {self.kelvin:.0f} K"
        return self.done(context, lambda design: _add_entry(design, "LIGHT", name, library.illuminant(name)))


class AddFile(OfPalette, Operator, ImportHelper):
    """Add a measured spectrum from a file: CSV, SPD, SPDX or CGATS"""

    bl_idname = "relume.palette_add_file"
    bl_label = "Add from File"

    kind: EnumProperty(items=palette.KINDS, options={"HIDDEN"})
    filter_glob: StringProperty(default="*.csv;*.spd;*.txt;*.dat;*.spdx;*.xml;*.cgats;*.it8;*.cie", options={"HIDDEN"})

    def execute(self, context):
        from ...core import palette as core
        from ...core.spectra import files

        def add(design):
            read = files.illuminant if self.kind == "LIGHT" else lambda path: files.read(path)[0]
            spectrum = read(self.filepath)
            # Told before anything changes: too few samples, no power where the eye sees
            entry = core.Entry(spectrum.name, spectrum)
            core.Palette((entry,) if self.kind == "LIGHT" else (), () if self.kind == "LIGHT" else (entry,))
            _add_entry(design, self.kind, spectrum.name, spectrum)

        return self.done(context, add)


class AddMaterials(OfPalette, Operator):
    """Add the materials of the selected objects as rows, with the spectrum or colour that they have"""

    bl_idname = "relume.palette_add_materials"
    bl_label = "Add Materials"

    def execute(self, context):
        from . import palette_assign

        materials = palette_assign.materials_of(context.selected_objects or context.scene.objects)
        if not materials:
            self.report({"ERROR"}, "no object here has a material with a colour")
            return {"CANCELLED"}

        def add(design):
            for material in materials:
                select_material(design, material)

        return self.done(context, add)


class TakeOut(OfPalette, Operator):
    """Take the selected light or reflectance out of this palette"""

    bl_idname = "relume.palette_take_out"
    bl_label = "Take Out"

    kind: EnumProperty(items=palette.KINDS, options={"HIDDEN"})

    def execute(self, context):
        from ...core.errors import PaletteError

        def take(design):
            rows, columns = list(range(len(design.reflectances))), list(range(len(design.lights)))
            width, entries = len(columns), palette.entries(design, self.kind)
            if not entries:
                raise PaletteError("there is nothing to take out")
            index = design.column if self.kind == "LIGHT" else design.row
            (columns if self.kind == "LIGHT" else rows).pop(index)
            gone = {one.path_from_id() for one, _ in palette.demands_on(design, self.kind, entries[index].name)}
            for demands in (design.differences, design.constancies):
                for number in reversed(range(len(demands))):
                    if demands[number].path_from_id() in gone:
                        demands.remove(number)
            entries.remove(index)
            palette.reshape(design, rows, columns, width)
            palette_tables.show(design)

        return self.done(context, take)


CLASSES = (AddDesigned, AddNamed, AddPlanckian, AddFile, AddMaterials, TakeOut)

register, unregister = register_classes_factory(CLASSES)
