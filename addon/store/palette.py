"""Palettes in a .blend: designs of lights and reflectances, as the artist sees and changes them.

A scene keeps any number of them. The names of properties are stored in files: do not rename them.
"""

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    StringProperty,
)
from bpy.types import PropertyGroup

from .palette_parts import (
    CLASSES as PARTS,
)
from .palette_parts import (
    KINDS,
    PaletteCell,
    PaletteConstancy,
    PaletteDifference,
    PaletteEntry,
    PaletteFree,
    changed,
    demands_on,
    quiet,
)

__all__ = [
    "CLASSES",
    "FAMILIES",
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
MODELS = [
    ("0", "None", "Full spectra only"),
    ("3", "3 channels", "As a render with 3 channels sees it"),
    ("6", "6 channels", "As a render with 6 channels sees it"),
    ("7", "7 channels", "As many as in the paper"),
    ("9", "9 channels", "As a render with 9 channels sees it"),
    ("12", "12 channels", "As a render with 12 channels sees it"),
]


FAMILIES = [
    ("fitted", "Fitted", "Relume's own, which renders use"),
    ("sharpened", "Sharpened", "That of the paper"),
    ("block", "Block", "Equal bands"),
]
SHOWN = [
    ("COLOUR", "Colour", "Patches have the colours themselves, whatever the view"),
    ("VIEW", "View", "Patches look as in the render: through the scene's exposure, look and view transform"),
]


class PaletteDesign(PropertyGroup):
    """A matrix of lights and reflectances."""

    name: StringProperty(name="Palette", description="Name of this palette")
    version: IntProperty(default=VERSION)
    lights: CollectionProperty(type=PaletteEntry)
    reflectances: CollectionProperty(type=PaletteEntry)
    cells: CollectionProperty(type=PaletteCell)
    differences: CollectionProperty(type=PaletteDifference)
    constancies: CollectionProperty(type=PaletteConstancy)
    free_colours: CollectionProperty(type=PaletteFree)
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
    family: EnumProperty(name="Kind", description="How the model was made", items=FAMILIES, update=changed)
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
    shown: EnumProperty(name="Patches", description="How the patches are drawn", items=SHOWN, update=changed)
    view: StringProperty(options={"HIDDEN"})
    remarks: StringProperty(options={"HIDDEN"})
    trial: StringProperty(options={"HIDDEN"})


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


CLASSES = (*PARTS, PaletteDesign)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.relume_palettes = CollectionProperty(type=PaletteDesign)
    bpy.types.Scene.relume_palette_active = IntProperty(name="Palette", description="The palette that the editor shows")


def unregister():
    del bpy.types.Scene.relume_palettes, bpy.types.Scene.relume_palette_active
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
