"""The parts of a palette in a .blend: lights, reflectances, cells, and what is asked of them.

The names of properties are stored in files: do not rename them.
"""

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    PointerProperty,
    StringProperty,
)
from bpy.types import PropertyGroup

__all__ = [
    "CLASSES",
    "KINDS",
    "PaletteCell",
    "PaletteConstancy",
    "PaletteDifference",
    "PaletteEntry",
    "PaletteFree",
    "changed",
    "demands_on",
    "quiet",
]

KINDS = [("LIGHT", "Light", ""), ("REFLECTANCE", "Reflectance", "")]
FREE = [
    (letter, letter, f"Free colour {letter}: cells with it have one colour, whichever that is") for letter in "ABCDEF"
]
SPANS = [
    ("NONE", "Anything", "No set of measured reflectances"),
    ("ces", "99 of All Kinds", "What the 99 colour evaluation samples (CES) of TM-30 are made of"),
    ("colorchecker", "ColorChecker", "What the 24 patches of the ColorChecker are made of"),
    ("tcs", "14 Test Colours", "What the test colours of the colour rendering index are made of"),
    ("cqs", "15 Vivid Colours", "What the samples of the colour quality scale are made of"),
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
    places += [(left_out, "name") for one in design.constancies for left_out in one.left_out]
    fields = ("light", "name") if kind == "LIGHT" else ("first", "second", "reflectance")
    return [(one, field) for one, field in places if field in fields and getattr(one, field) == name]


def _owner(part):
    """The design that holds a light, a reflectance or a cell."""
    for design in part.id_data.relume_palettes:
        if design == part or part.path_from_id().startswith(design.path_from_id() + "."):
            return design
    return None


class PaletteName(PropertyGroup):
    """The name of a light."""

    name: StringProperty()


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
    own_bounds: BoolProperty(
        name="Own Bounds", description="Keep this spectrum within bounds of its own, whatever holds for the others"
    )
    lower: FloatProperty(name="Lowest", description="Lowest value that this spectrum may have", default=0.0)
    upper: FloatProperty(name="Highest", description="Highest value that this spectrum may have", default=1.0)
    near: StringProperty(options={"HIDDEN"})
    near_name: StringProperty(name="Near To", description="The measured spectrum that this one stays near to")
    near_weight: FloatProperty(
        name="Weight", description="How much nearness counts", default=0.01, min=0.0, soft_max=1.0, precision=3
    )
    span: EnumProperty(
        name="Made As", description="Measured reflectances whose components this one is to be made of", items=SPANS
    )
    span_weight: FloatProperty(
        name="Weight",
        description="How much it counts that it is made as they are",
        default=0.01,
        min=0.0,
        soft_max=1.0,
        precision=3,
    )


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


class PaletteFree(PropertyGroup):
    """Bounds of the free colour of a letter."""

    name: StringProperty()
    lower: FloatVectorProperty(name="Lowest", description="Lowest red, green and blue, linear Rec.709", size=3)
    upper: FloatVectorProperty(
        name="Highest", description="Highest red, green and blue, linear Rec.709", size=3, default=(1.0, 1.0, 1.0)
    )


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
    """A reflectance that is to look the same under every light of the design but those left out."""

    left_out: CollectionProperty(type=PaletteName)

    reflectance: StringProperty(name="Reflectance", description="The reflectance that keeps its colour")
    adapted: BoolProperty(
        name="Adapted",
        description="As an eye, or a picture with white balance, that adapts to each light",
        default=True,
    )
    weight: FloatProperty(name="Weight", default=1.0, min=0.0)


class quiet:
    """While it is entered, changed properties draw nothing anew."""

    def __enter__(self):
        global _busy
        _busy = True

    def __exit__(self, *_):
        global _busy
        _busy = False


CLASSES = (PaletteName, PaletteEntry, PaletteCell, PaletteFree, PaletteDifference, PaletteConstancy)
