"""Palettes in a .blend: designs of lights and reflectances, as the artist sees and changes them.

A scene keeps any number of them. The names of properties are stored in files: do not rename them.
"""

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)
from bpy.types import PropertyGroup

__all__ = [
    "CLASSES",
    "KINDS",
    "MODELS",
    "active",
    "cell_at",
    "changed",
    "demands_on",
    "entries",
    "quiet",
    "register",
    "reshape",
    "unregister",
]

VERSION = 1
KINDS = [("LIGHT", "Light", ""), ("REFLECTANCE", "Reflectance", "")]
FREE = [
    (letter, letter, f"Free colour {letter}: cells with it have one colour, whichever that is") for letter in "ABCDEF"
]
MODELS = [
    ("0", "None", "Full spectra only"),
    ("3", "3 channels", "As a render with 3 channels sees it"),
    ("6", "6 channels", "As a render with 6 channels sees it"),
    ("9", "9 channels", "As a render with 9 channels sees it"),
    ("12", "12 channels", "As a render with 12 channels sees it"),
]
_busy = False


def changed(self, context):
    """Update of what a design's colours depend on."""
    if not _busy and context is not None and (design := _owner(self)) is not None:
        from . import palette_tables

        palette_tables.show(design)


def _target_chosen(self, context):
    """A colour that was picked is one that is wanted."""
    if not _busy:
        self["use"] = 1
        changed(self, context)


def _renamed(self, context):
    """Demands name their lights and reflectances: they follow."""
    before, self.was = self.was, self.name
    design = _owner(self)
    if not before or design is None or before == self.name:
        return
    for one, field in demands_on(design, "LIGHT" if ".lights[" in self.path_from_id() else "REFLECTANCE", before):
        setattr(one, field, self.name)
    changed(self, context)


def demands_on(design, kind: str, name: str) -> list:
    """(demand, property) of all that names a light or a reflectance."""
    places = [(one, field) for one in design.differences for field in ("light", "first", "second")]
    places += [(one, "reflectance") for one in design.constancies]
    fields = ("light",) if kind == "LIGHT" else ("first", "second", "reflectance")
    return [(one, field) for one, field in places if field in fields and getattr(one, field) == name]


def _owner(part):
    """The design that holds a light, a reflectance or a cell."""
    for design in part.id_data.relume_palettes:
        if design == part or part.path_from_id().startswith(design.path_from_id() + "."):
            return design
    return None


class PaletteEntry(PropertyGroup):
    """A light or a reflectance of a design."""

    name: StringProperty(name="Name", description="Name of this light or reflectance", update=_renamed)
    was: StringProperty(options={"HIDDEN"})
    spectrum: StringProperty(options={"HIDDEN"})
    source: StringProperty(name="From", description="Where the spectrum comes from")
    designed: BoolProperty(
        name="Designed",
        description="Whether Create Spectra finds this spectrum; otherwise it stays as it is",
        update=changed,
    )
    luminance: FloatProperty(
        name="Luminance", description="How bright a white is in this light", default=1.0, min=0.0, update=changed
    )
    material: PointerProperty(
        type=bpy.types.Material, name="Material", description="The material that Assign gives this reflectance to"
    )
    swatch: FloatVectorProperty(subtype="COLOR_GAMMA", size=3, default=(0.5, 0.5, 0.5))


class PaletteCell(PropertyGroup):
    """What a reflectance is to look like under a light."""

    use: EnumProperty(
        name="Demand",
        description="What is asked of this colour",
        items=[
            ("NONE", "Unused", "Whatever comes of it"),
            ("TARGET", "Colour", "The colour that is chosen"),
            ("FREE", "Free Colour", "A colour shared with others, whichever it is"),
        ],
        update=changed,
    )
    target: FloatVectorProperty(
        name="Wanted",
        description="The colour that is wanted here. The eyedropper of the colour picker takes it from a render",
        subtype="COLOR",
        size=3,
        default=(0.2, 0.2, 0.2),
        min=0.0,
        soft_max=1.0,
        update=_target_chosen,
    )
    weight: FloatProperty(
        name="Weight", description="How much this colour counts among the demands", default=1.0, min=0.0, soft_max=10.0
    )
    free: EnumProperty(name="Free Colour", description="Cells with the same letter have one colour", items=FREE)
    error: FloatProperty(default=-1.0)
    wanted: FloatVectorProperty(subtype="COLOR_GAMMA", size=3)
    full: FloatVectorProperty(subtype="COLOR_GAMMA", size=3)
    model: FloatVectorProperty(subtype="COLOR_GAMMA", size=3)


class PaletteDifference(PropertyGroup):
    """Two reflectances that are to look alike or different under a light."""

    light: StringProperty(name="Light", description="The light that both are seen under")
    first: StringProperty(name="One", description="A reflectance")
    second: StringProperty(name="Other", description="Another reflectance")
    kind: EnumProperty(
        name="Apart",
        items=[("LEAST", "At Least", "They are to be told apart"), ("MOST", "At Most", "They are to match")],
        default="LEAST",
    )
    amount: FloatProperty(
        name="ΔE2000", description="1 is just noticeable, 10 plain to see", default=10.0, min=0.0, soft_max=50.0
    )
    weight: FloatProperty(name="Weight", default=1.0, min=0.0)


class PaletteConstancy(PropertyGroup):
    """A reflectance that is to look the same under every light of the design."""

    reflectance: StringProperty(name="Reflectance", description="The reflectance that keeps its colour")
    adapted: BoolProperty(
        name="Adapted",
        description="As an eye, or a picture with white balance, that adapts to each light",
        default=True,
    )
    weight: FloatProperty(name="Weight", default=1.0, min=0.0)


class PaletteDesign(PropertyGroup):
    """A matrix of lights and reflectances."""

    name: StringProperty(name="Palette", description="Name of this palette")
    version: IntProperty(default=VERSION)
    lights: CollectionProperty(type=PaletteEntry)
    reflectances: CollectionProperty(type=PaletteEntry)
    cells: CollectionProperty(type=PaletteCell)
    differences: CollectionProperty(type=PaletteDifference)
    constancies: CollectionProperty(type=PaletteConstancy)
    row: IntProperty(options={"HIDDEN"})
    column: IntProperty(options={"HIDDEN"})
    bounded: BoolProperty(
        name="Bounds",
        description="Keep reflectances in 0 to 1 and lights at 0 or more. Off: more can be had, which nothing real has",
        default=True,
    )
    smoothness: FloatProperty(
        name="Smoothness", description="How much smooth curves count", default=0.001, min=0.0, soft_max=1.0, precision=4
    )
    channels: EnumProperty(
        name="Model",
        description="The render whose colours are compared with full spectra",
        items=MODELS,
        update=changed,
    )
    model_error: FloatProperty(
        name="Model Error", description="How much the difference of both counts", default=0.1, min=0.0, soft_max=10.0
    )
    use_model: BoolProperty(name="Fit Model", description="Fit the colours of the model and not those of full spectra")
    space: EnumProperty(
        name="Compare",
        description="How colours are compared",
        items=[
            ("perceptual", "As Seen", "By CIEDE2000"),
            ("rgb", "RGB", "By linear RGB, as in the paper"),
            ("xyz", "XYZ", "By XYZ"),
        ],
    )
    remarks: StringProperty(options={"HIDDEN"})


def active(scene):
    """The design that the editor shows; None if there is none."""
    index = scene.relume_palette_active
    return scene.relume_palettes[index] if 0 <= index < len(scene.relume_palettes) else None


def entries(design, kind: str):
    """The lights or the reflectances of a design."""
    return design.lights if kind == "LIGHT" else design.reflectances


def cell_at(design, row: int, column: int):
    """The cell of a reflectance and a light."""
    return design.cells[row * len(design.lights) + column]


def reshape(design, rows: list, columns: list, width: int):
    """Give the matrix cells of other rows and columns: old indices, None for new ones; `width` columns it had."""
    names = ("use", "weight", "free")
    kept = [({name: getattr(cell, name) for name in names}, tuple(cell.target)) for cell in design.cells]
    with quiet():
        design.cells.clear()
        for row in rows:
            for column in columns:
                cell = design.cells.add()
                if row is not None and column is not None:
                    values, target = kept[row * width + column]
                    cell.target = target
                    for name, value in values.items():
                        setattr(cell, name, value)
        design.row = min(design.row, max(len(rows) - 1, 0))
        design.column = min(design.column, max(len(columns) - 1, 0))


class quiet:
    """While it is entered, changed properties draw nothing anew."""

    def __enter__(self):
        global _busy
        _busy = True

    def __exit__(self, *_):
        global _busy
        _busy = False


CLASSES = (PaletteEntry, PaletteCell, PaletteDifference, PaletteConstancy, PaletteDesign)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.relume_palettes = CollectionProperty(type=PaletteDesign)
    bpy.types.Scene.relume_palette_active = IntProperty(name="Palette", description="The palette that the editor shows")


def unregister():
    del bpy.types.Scene.relume_palettes, bpy.types.Scene.relume_palette_active
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
