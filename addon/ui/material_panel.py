"""Measured spectra in materials: the panel that lists the spectral sockets, and the operators behind its buttons."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import bpy
from bpy.props import EnumProperty, StringProperty
from bpy.types import Operator, Panel
from bpy.utils import register_classes_factory
from bpy_extras.io_utils import ImportHelper

from ...core.picture import finish
from ...core.spectra import files, library
from ...core.spectra.spectrum import Spectrum, SpectrumError
from ..graph import glass, places, spectra
from . import icons, own_spectra
from .mixer_operators import reporting
from .translation import said
from .wrapping import words

__all__ = [
    "CLASSES",
    "active_material",
    "assign_from_file",
    "assign_from_library",
    "first_place",
    "library_of",
    "register",
    "unregister",
]

_WORDS = {places.REFLECTANCE: "RGB colour", places.METAL: "RGB metal", places.GLASS: "Without dispersion"}
_OWN = {}  # the user's own files, by those that were listed


@cache  # Blender keeps no reference to the strings
def library_of(takes: str) -> list[tuple]:
    if takes == places.METAL:
        return [(name, name, "") for name in library.conductors()]
    if takes == places.GLASS:
        return [(name, name, "") for name in library.glasses()]
    found = [spectrum for label in library.REFLECTANCE_SETS for spectrum in library.reflectances(label)]
    return [(s.name, s.name, s.source, icons.paint(s), number) for number, s in enumerate(found)]


def _offered(self, context) -> list[tuple]:
    """The library, and the files of the user's own folder where colours are looked for."""
    takes = self.takes or places.REFLECTANCE
    found = own_spectra.listed(own_spectra.PAINTS) if takes == places.REFLECTANCE else []
    if not found:
        return library_of(takes)
    if _OWN.get("files") is not found:
        first = len(library_of(takes))
        items = [(path, f"{name}  (own)", path, 0, first + k) for k, (path, name) in enumerate(found)]
        _OWN.update(files=found, items=[*library_of(takes), *items])
    return _OWN["items"]


def assign_from_library(material, node, identifier: str, takes: str, name: str) -> None:
    """Put a spectrum of the library in a place of a material. Raises LibraryError."""
    if takes == places.METAL:
        n, k = library.conductor(name)
        _assign_metal(material, node, n, k)
    elif takes == places.GLASS:
        glass.replace(node, library.glass(name))
    else:
        _assign_reflectance(material, places.socket_of(node, identifier), library.reflectance(name))


def _assign_reflectance(material, socket, spectrum: Spectrum) -> None:
    thing = bpy.context.object
    shows = thing is not None and material.name in thing.material_slots
    way = finish.way_through(thing.dimensions) if shows else None
    spectra.assign(material, socket, spectra.for_socket(socket, spectrum, way))


def _assign_metal(material, node, n: Spectrum, k: Spectrum) -> None:
    tree = spectra.existing({"IOR": n, "Extinction": k}) or spectra.new_conductor(n.name, n, k)
    node.fresnel_type = "PHYSICAL_CONDUCTOR"
    for output in ("IOR", "Extinction"):
        spectra.assign(material, node.inputs[output], tree, output)


class _Place:
    """An operator on one place of the active material."""

    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    node: StringProperty(options={"HIDDEN"})
    socket: StringProperty(options={"HIDDEN"})
    takes: StringProperty(options={"HIDDEN"})

    @classmethod
    def poll(cls, context) -> bool:
        material = active_material(context)
        if material is None or not material.is_editable:
            cls.poll_message_set("no material that can be edited here")
            return False
        return True

    def target(self, context):
        material = active_material(context)
        return material, material.node_tree.nodes[self.node]


def active_material(context):
    return getattr(context, "material", None) or (context.object and context.object.active_material)


class AssignSpectrum(_Place, Operator):
    """Give this part of the material a measured spectrum from the library"""

    bl_idname = "relume.assign_spectrum"
    bl_label = "Spectrum"
    bl_property = "spectrum"

    spectrum: EnumProperty(name="Spectrum", items=_offered)

    def invoke(self, context, event) -> set[str]:
        context.window_manager.invoke_search_popup(self)
        return {"INTERFACE"}

    @reporting
    def execute(self, context) -> None:
        if own_spectra.is_own(self.spectrum):
            said, warning = assign_from_file(*self.target(context), self.socket, self.takes, self.spectrum)
            self.report({"WARNING"} if warning else {"INFO"}, warning or said)
        else:
            assign_from_library(*self.target(context), self.socket, self.takes, self.spectrum)


class AssignSpectrumFile(_Place, Operator, ImportHelper):
    """Give this part of the material a measured spectrum from a file: CSV, SPD, SPDX or CGATS. A metal: n and k"""

    bl_idname = "relume.assign_spectrum_file"
    bl_label = "Spectrum from File"

    filter_glob: StringProperty(
        default="*.csv;*.spd;*.txt;*.dat;*.spdx;*.xml;*.cgats;*.it8;*.cie;*.ti3", options={"HIDDEN"}
    )

    @reporting
    def execute(self, context) -> None:
        said, warning = assign_from_file(*self.target(context), self.socket, self.takes, self.filepath)
        if warning:
            self.report({"WARNING"}, warning)
        self.report({"INFO"}, said)


def assign_from_file(material, node, identifier: str, takes: str, path: str) -> tuple[str, str]:
    """Put the spectrum of a file in a place of a material -> (what was read, a warning or ""). Raises SpectrumError."""
    found, warning = files.read(path, takes if takes == places.REFLECTANCE else "refractive index"), ""
    if takes == places.METAL:
        n, k = _metal_in(found, Path(path))
        _assign_metal(material, node, n, k)
    elif takes == places.GLASS:
        glass.replace(node, found[0])
    else:
        from ...core.palette import beyond

        socket = places.socket_of(node, identifier)
        _assign_reflectance(material, socket, found[0])
        warning = beyond(found[0], spectra.shines(socket))
    used = 2 if takes == places.METAL else 1
    rest = f"; the first {used} of {len(found)} spectra" if len(found) > used else ""
    return f"From {found[0].source}{rest}", warning


def first_place(material):
    """(node, socket identifier, what it takes) of the place that is meant by a material's spectrum, None for none.

    That is its first colour; of a material without one, its first metal or glass.
    """
    found = sorted(places.of(material), key=lambda place: place[2] != places.REFLECTANCE)
    return (material.node_tree.nodes[found[0][0]], *found[0][1:]) if found else None


def _metal_in(columns: list, path: Path) -> tuple[Spectrum, Spectrum]:
    """n and k of a metal from a file's first two spectra. Raises SpectrumError."""
    if len(columns) < 2:
        raise SpectrumError(f"{path}: a metal needs two columns after the wavelengths, n and k")
    n, k = columns[:2]
    return replace(n, name=path.stem), replace(k, name=path.stem, kind="extinction")


class ClearSpectrum(_Place, Operator):
    """Let this part of the material have its RGB colour again"""

    bl_idname = "relume.clear_spectrum"
    bl_label = "Clear Spectrum"

    def execute(self, context) -> set[str]:
        material, node = self.target(context)
        if self.takes == places.GLASS:
            glass.put_back(node)
        elif self.takes == places.METAL:
            for name in ("IOR", "Extinction"):
                spectra.unassign(material, node.inputs[name])
        else:
            spectra.unassign(material, places.socket_of(node, self.socket))
        return {"FINISHED"}


class MaterialPanel(Panel):
    bl_idname = "MATERIAL_PT_relume"
    bl_label = "Relume Spectra"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "material"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context) -> bool:
        return context.material is not None and context.material.node_tree is not None

    def draw(self, context) -> None:
        material, layout = context.material, self.layout
        for name, identifier, takes in places.of(material):
            node = material.node_tree.nodes[name]
            chosen = places.chosen_at(node, identifier, takes)
            column = layout.column(align=True)
            words(column, f"{node.label or name}: {places.socket_of(node, identifier).name}" if identifier else name)
            row = column.row(align=True)
            buttons = [row.operator("relume.assign_spectrum", text=chosen or said(_WORDS[takes]), icon="DOWNARROW_HLT")]
            buttons.append(row.operator("relume.assign_spectrum_file", text="", icon="FILEBROWSER"))
            if chosen:
                buttons.append(row.operator("relume.clear_spectrum", text="", icon="X"))
            for button in buttons:
                button.node, button.socket, button.takes = name, identifier, takes


CLASSES = (AssignSpectrum, AssignSpectrumFile, ClearSpectrum, MaterialPanel)


register, unregister = register_classes_factory(CLASSES)
