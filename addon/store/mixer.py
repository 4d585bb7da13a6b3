"""The mixer's rows: what shines in each light group, how strongly, and the mixes that the artist keeps.

The names of properties are stored in files and in animations: do not rename them.
"""

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, FloatProperty, FloatVectorProperty, StringProperty
from bpy.types import PropertyGroup

from ...core.errors import RelumeError
from ...core.picture import mixing
from ...core.picture.mix import Light
from ...core.spectra import files
from ...core.spectra.spectrum import Spectrum
from . import changes, shining

__all__ = [
    "CLASSES",
    "CURVE",
    "LightGroup",
    "Snapshot",
    "apply",
    "choice",
    "choices",
    "default",
    "filled",
    "is_quiet",
    "is_touched",
    "mix_changed",
    "quiet",
    "reading",
]

CURVE = "relume_curve"  # on a row: 81 values of its spectrum, the highest 1

SOURCES = [
    ("LIBRARY", "Named", "An illuminant of the CIE, a measured lamp, or a spectral line such as 589 nm"),
    ("PLANCKIAN", "Black Body", "A glowing body of a temperature: candles, tungsten lamps"),
    ("DAYLIGHT", "Daylight", "Daylight of a correlated colour temperature, after the CIE"),
    ("FILE", "File", "A measurement from a file: CSV, text in columns, TM-27 or CGATS"),
    ("BLEND", "Blend", "Several illuminants by weight, as on the light dial"),
]
# What a row says about its light, and what the scene says about all of them: all that a snapshot keeps
_ROW = ("source", "illuminant", "temperature", "cct", "path", "measured", "tint", "stops", "solo", "mute")
BALANCE = (
    *("white_balance", "white_balance_method", "white_source", "white_group", "white_pixel"),
    *("observer", "observer_path", "observer_measured"),
)

_quiet = 0


@contextmanager
def quiet() -> Iterator[None]:
    """While it is entered, changed properties do not change the picture."""
    global _quiet
    _quiet += 1
    try:
        yield
    finally:
        _quiet -= 1


def is_quiet() -> bool:
    """Whether the mixer is being written: what it says now is not to be shown yet."""
    return _quiet > 0


def mix_changed(self, context) -> None:
    """Update of every property that the picture depends on."""
    if not _quiet:
        changes.tell(changes.MIX, self.id_data)


def reading(read: Callable[[str], dict | list], path: str, kept: str) -> Callable:
    """Update of the property `path`: what is read of that file becomes `kept`, as JSON.

    A file that cannot be used leaves that as it is, and the panel says why.
    """

    def chosen(self, context) -> None:
        if _quiet or not getattr(self, path):
            return
        try:
            self[kept] = json.dumps(read(bpy.path.abspath(getattr(self, path))))
        except RelumeError as error:
            self.id_data.relume.problem = str(error)
        else:
            mix_changed(self, context)

    return chosen


def _source_chosen(self, context) -> None:
    """A blend starts with what shone before, and daylight."""
    if self.source == "BLEND" and not self.blend and not _quiet:
        with quiet():
            for name, weight in ((self.illuminant, 1.0), ("A" if self.illuminant == "D65" else "D65", 0.0)):
                part = self.blend.add()
                part.illuminant, part.weight = name, weight
    mix_changed(self, context)


def _renamed(self, new: str, current: str, is_set: bool) -> str:
    """Give the light group itself the new name; it comes back as Blender can use it."""
    given = changes.tell(changes.LIGHT_GROUP_RENAMED, self.id_data, current, new) if current else None
    return new if given is None else given


class BlendPart(PropertyGroup):
    """One illuminant of a blend."""

    illuminant: StringProperty(
        name="Illuminant", description="An illuminant of the blend", default="D65", update=mix_changed
    )
    measured: StringProperty(options={"HIDDEN"})  # its own spectrum, as JSON, where the library does not have it
    weight: FloatProperty(
        name="Weight",
        description="This illuminant's part in the brightness of the light group",
        default=1.0,
        min=0.0,
        soft_max=1.0,
        subtype="FACTOR",
        update=mix_changed,
    )

    def spectrum(self):
        """What shines, as a Spectrum. Raises LibraryError, SpectrumError."""
        return shining.part_spectrum(self.illuminant, self.measured)


class LightGroup(PropertyGroup):
    """One row of the mixer: a light group and what shines in it."""

    name: StringProperty(
        name="Light Group",
        description="Name of the light group. Its lamps stay in it when it is renamed",
        set_transform=_renamed,
    )
    source: EnumProperty(
        name="Kind",
        description="Where the spectrum of this light group comes from",
        items=SOURCES,
        default="LIBRARY",
        update=_source_chosen,
    )
    illuminant: StringProperty(
        name="Illuminant",
        description="The spectrum of the lamps in this light group. Changing it changes the picture without rendering",
        default="D65",
        update=mix_changed,
    )
    temperature: FloatProperty(
        name="Temperature",
        description="Temperature of the black body in kelvin: a candle 1900, a tungsten lamp 2850, a halogen lamp 3200",
        default=2856.0,
        min=500.0,
        max=100000.0,
        soft_min=1000.0,
        soft_max=12000.0,
        step=1000,
        precision=0,
        subtype="TEMPERATURE",
        update=mix_changed,
    )
    cct: FloatProperty(
        name="Daylight",
        description="Correlated colour temperature of the daylight in kelvin: noon 5500, overcast 6500, blue sky 12000",
        default=6500.0,
        min=4000.0,
        max=25000.0,
        soft_max=15000.0,
        step=1000,
        precision=0,
        subtype="TEMPERATURE",
        update=mix_changed,
    )
    path: StringProperty(
        name="File",
        description="A file with wavelengths in nm and power. The spectrum is kept in the scene",
        subtype="FILE_PATH",
        options={"ANIMATABLE", "PATH_SUPPORTS_BLEND_RELATIVE"},
        update=reading(lambda path: files.illuminant(path).to_dict(), "path", "measured"),
    )
    measured: StringProperty(name="Spectrum of the File", options={"HIDDEN"})
    blend: CollectionProperty(type=BlendPart)
    tint: FloatVectorProperty(
        name="Gel",
        description="The colour of a gel before the lamps of this light group. Like every change of the illuminant, it "
        "changes the colour of the light, not the exposure",
        subtype="COLOR_GAMMA",
        size=3,
        default=(1.0, 1.0, 1.0),
        min=0.0,
        max=1.0,
        update=mix_changed,
    )
    stops: FloatProperty(
        name="Gain",
        description="Brightness of this light group in stops: 1 is twice what was rendered, -1 half",
        default=0.0,
        soft_min=-6.0,
        soft_max=6.0,
        step=10,
        precision=1,
        update=mix_changed,
    )
    solo: BoolProperty(
        name="Solo", description="Show only this light group and others that are solo", update=mix_changed
    )
    mute: BoolProperty(name="Mute", description="Switch this light group off", update=mix_changed)
    is_lit: BoolProperty(
        name="Lit", description="Whether anything shone in this light group at set-up", default=True, options={"HIDDEN"}
    )
    position: bpy.props.IntProperty(default=-1, options={"HIDDEN"})  # where the artist moved it, -1 for nowhere
    is_open: BoolProperty(name="Details", description="Show the spectrum and the settings of this light group")
    swatch: FloatVectorProperty(
        name="Colour of a White in This Light", subtype="COLOR_GAMMA", size=3, default=(1, 1, 1)
    )

    @property
    def gain(self) -> float:
        """Brightness as a multiple of what was rendered, 0 where the group is mute; solo does not count."""
        return 0.0 if self.mute else mixing.gain(self.stops)

    @gain.setter
    def gain(self, value: float) -> None:
        with quiet():
            self.mute = value == 0.0
            if value != 0.0:
                self.stops = mixing.stops(value)
        mix_changed(self, bpy.context)

    @property
    def origin(self) -> str:
        """The file that was read, and what was read otherwise than it stands there; "" if none was."""
        try:
            return shining.stored_spectrum(self.measured).source
        except RelumeError:
            return ""

    @property
    def is_tinted(self) -> bool:
        """Whether there is a gel before the lamps."""
        return min(self.tint) < 1.0

    @property
    def label(self) -> str:
        """What shines, in a few words, but for the gel before it."""
        if self.source == "PLANCKIAN":
            return f"Black body {self.temperature:.0f} K"
        if self.source == "DAYLIGHT":
            return f"Daylight {self.cct:.0f} K"
        if self.source == "FILE":
            name, origin = bpy.path.basename(self.path), self.origin
            # A file that was refused is not what shines; what was designed has no file
            return origin if origin and origin != "designed" and not origin.startswith(name) else name or "No file yet"
        if self.source == "BLEND":
            return f"Blend of {len(self.blend)}"
        return self.illuminant

    def spectrum(self) -> Spectrum:
        """What shines, as a Spectrum. Raises LibraryError, SpectrumError."""
        return shining.spectrum_of(choice(self))

    def light(self) -> Light:
        """The `core.mix.Light` of this row alone. Raises as `spectrum` does."""
        return Light(self.spectrum(), self.gain)


class Snapshot(PropertyGroup):
    """A mix that the artist keeps under a name."""

    name: StringProperty(name="Snapshot", description="Name of this mix")
    mix: StringProperty(options={"HIDDEN"})


def is_touched(row) -> bool:
    """Whether the artist chose anything in a row."""
    return any(row.is_property_set(name) for name in (*_ROW, "blend"))


def choice(row) -> dict:
    """All that a row of the mixer says, as a snapshot keeps it."""
    blend = [[part.illuminant, part.weight, *([part.measured] if part.measured else [])] for part in row.blend]
    return {name: _plain(getattr(row, name)) for name in _ROW} | {"blend": blend}


def _plain(value):
    """A property's value as JSON has it."""
    return value if isinstance(value, str) or not hasattr(value, "__len__") else list(value)


def default(known):
    """The default of a property, as JSON has it."""
    return list(known.default_array) if getattr(known, "is_array", False) else known.default


def choices(settings) -> dict:
    """All that the mixer says, as a snapshot keeps it."""
    balance = {name: getattr(settings, name) for name in BALANCE}
    return {"light_groups": {row.name: choice(row) for row in settings.light_groups}, "balance": balance}


def filled(struct, kept: dict) -> dict:
    """What was kept of a row of the mixer, or of the scene's settings, with the default of whatever it lacks."""
    names, blend = (_ROW, {"blend": kept.get("blend", [])}) if isinstance(struct, LightGroup) else (BALANCE, {})
    return {name: kept.get(name, default(struct.bl_rna.properties[name])) for name in names} | blend


def apply(settings, chosen: dict) -> list[str]:
    """Put back what `choices` kept; returns the names of light groups that the mixer no longer has.

    A property that is newer than the mix gets its default.
    """
    missing = []
    with quiet():
        for group, kept in chosen["light_groups"].items():
            if group not in settings.light_groups:
                missing.append(group)
                continue
            row = settings.light_groups[group]
            values = filled(row, kept)
            _set(row, {name: values[name] for name in _ROW})
            if choice(row)["blend"] != values["blend"]:
                row.blend.clear()
                for illuminant, weight, *measured in values["blend"]:
                    part = row.blend.add()
                    part.illuminant, part.weight = illuminant, weight
                    part.measured = measured[0] if measured else ""
        if chosen["balance"]:
            _set(settings, filled(settings, chosen["balance"]))
    mix_changed(settings, bpy.context)
    return missing


def _set(struct, values: dict) -> None:
    """Set what differs: what the artist never touched stays so."""
    for name, value in values.items():
        if _plain(getattr(struct, name)) != value:
            setattr(struct, name, value)


CLASSES = (BlendPart, LightGroup, Snapshot)
