"""What the palette editor's buttons do."""

import json
from pathlib import Path

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty
from bpy.types import Operator
from bpy.utils import register_classes_factory
from bpy_extras.io_utils import ImportHelper

from ..store import palette, palette_tables

__all__ = ["CLASSES", "OfPalette", "register", "unregister"]

EXAMPLES = Path(__file__).resolve().parents[2] / "assets/palettes"


class OfPalette:
    """Of operators on the palette that the editor shows; one step of undo each."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        if palette.active(context.scene) is None:
            cls.poll_message_set("this scene has no palette: make one")
            return False
        return True

    def done(self, context, do):
        """Do it with the palette; what cannot be done is told, and changes nothing."""
        from ...core.errors import RelumeError

        try:
            do(palette.active(context.scene))
        except RelumeError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


_EXAMPLES = []  # Blender keeps no reference to the strings


def _examples(self=None, context=None):
    if not _EXAMPLES:
        _EXAMPLES.append(("", "Empty", "Daylight, tungsten, and one reflectance to be designed"))
        for path in sorted(EXAMPLES.glob("*.toml")):
            title = next(line for line in path.read_text("utf-8").splitlines() if line.startswith("title"))
            _EXAMPLES.append((path.stem, title.partition("=")[2].strip().strip('"'), "An example"))
    return [(name or "EMPTY", label, words) for name, label, words in _EXAMPLES]


def _add_design(scene, made):
    design = scene.relume_palettes.add()
    palette_tables.fill(design, made)
    taken = [other.name for other in scene.relume_palettes if other != design]
    number, name = 2, design.name or "Palette"
    while design.name in taken or not design.name:
        design.name, number = f"{name} {number}", number + 1
    scene.relume_palette_active = len(scene.relume_palettes) - 1


class NewPalette(Operator):
    """Make a palette, empty or after an example"""

    bl_idname = "relume.palette_new"
    bl_label = "New Palette"
    bl_options = {"REGISTER", "UNDO"}

    example: EnumProperty(name="Example", items=_examples)

    def execute(self, context):
        from ...core import palette as core
        from ...core.model import bases
        from ...core.spectra import library

        if self.example in ("", "EMPTY"):
            lights = tuple(core.Entry(name, library.illuminant(name)) for name in ("D65", "A"))
            made = core.Palette(
                lights,
                (core.Entry("first", designed=True),),
                criteria=core.Criteria(model=bases.fitted(9)),
                title="Palette",
            )
        else:
            made = core.read(EXAMPLES / f"{self.example}.toml")
        _add_design(context.scene, made)
        return {"FINISHED"}


class OpenPalette(Operator, ImportHelper):
    """Read a palette from a TOML file"""

    bl_idname = "relume.palette_open"
    bl_label = "Open Palette"
    bl_options = {"REGISTER", "UNDO"}

    filter_glob: StringProperty(default="*.toml", options={"HIDDEN"})

    def execute(self, context):
        from ...core import palette as core

        try:
            made = core.read(self.filepath)
        except core.PaletteError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        _add_design(context.scene, made)
        return {"FINISHED"}


class RemovePalette(OfPalette, Operator):
    """Remove this palette from the file. What was assigned stays"""

    bl_idname = "relume.palette_remove"
    bl_label = "Remove Palette"

    def execute(self, context):
        scene = context.scene
        scene.relume_palettes.remove(scene.relume_palette_active)
        scene.relume_palette_active = max(0, scene.relume_palette_active - 1)
        return {"FINISHED"}


class Select(OfPalette, Operator):
    """Choose what is shown below: a light, a reflectance, or where they meet"""

    bl_idname = "relume.palette_select"
    bl_label = "Select"
    bl_options = {"INTERNAL"}

    row: IntProperty(default=-1, options={"HIDDEN"})
    column: IntProperty(default=-1, options={"HIDDEN"})

    def execute(self, context):
        design = palette.active(context.scene)
        design.row = self.row if self.row >= 0 else design.row
        design.column = self.column if self.column >= 0 else design.column
        palette_tables.redraw()
        return {"FINISHED"}


class Fit(OfPalette, Operator):
    """Want the colours that are there now"""

    bl_idname = "relume.palette_fit"
    bl_label = "Fit Colour"

    everywhere: BoolProperty(options={"HIDDEN"})

    def execute(self, context):
        from ...core import palette as core

        def fit(design):
            full = core.patches(palette_tables.design_of(design))[0]
            space = bpy.data.colorspace.working_space
            for row in range(len(design.reflectances)):
                for column in range(len(design.lights)):
                    if self.everywhere or (row, column) == (design.row, design.column):
                        palette.cell_at(design, row, column).target = core.scene_from_xyz(full[row, column], space)
            palette_tables.show(design)

        return self.done(context, fit)


class Create(OfPalette, Operator):
    """Find the spectra that are designed"""

    bl_idname = "relume.palette_create"
    bl_label = "Create Spectra"

    def execute(self, context):
        from ...core import palette as core

        def create(design):
            solution = core.create(palette_tables.design_of(design))
            for entries, made in (
                (design.lights, solution.palette.lights),
                (design.reflectances, solution.palette.reflectances),
            ):
                for entry, found in zip(entries, made, strict=True):
                    if entry.designed:
                        entry.spectrum, entry.source = json.dumps(found.spectrum.to_dict()), "Designed"
                        entry["luminance"] = found.luminance
            report = core.report(solution)
            errors = {(cell.reflectance, cell.light): cell.error for cell in report.cells}
            for index, cell in enumerate(design.cells):
                cell.error = errors.get(divmod(index, len(design.lights)), -1.0)
            design.remarks = "\n".join(report.remarks) or "Every demand is met."
            design.trial = ""
            palette_tables.show(design)

        return self.done(context, create)


class Normalise(OfPalette, Operator):
    """Scale the selected light or reflectance"""

    bl_idname = "relume.palette_normalise"
    bl_label = "Normalise"

    kind: EnumProperty(items=palette.KINDS, options={"HIDDEN"})
    way: EnumProperty(
        name="By",
        items=[("LUMINANCE", "Luminance", "A luminance of 1"), ("L2", "L2 Norm", "A sum of squares of 1")],
    )
    scale: FloatProperty(name="Scale", description="What it is then multiplied by", default=1.0, min=0.0)

    def invoke(self, context, event):
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context):
        from ...core import palette as core

        def normalise(design):
            made, index = palette_tables.design_of(design), design.column if self.kind == "LIGHT" else design.row
            entry = palette.entries(design, self.kind)[index]
            found = core.scaled(made, self.kind.lower(), index, self.way, self.scale)
            entry["luminance"] = found.luminance
            entry.spectrum = json.dumps(found.spectrum.to_dict())
            palette_tables.show(design)

        return self.done(context, normalise)


CLASSES = (
    NewPalette,
    OpenPalette,
    RemovePalette,
    Select,
    Fit,
    Create,
    Normalise,
)

register, unregister = register_classes_factory(CLASSES)
