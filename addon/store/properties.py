"""What an artist chooses, kept in the scene: channels, the mixer of light groups, white balance."""

import json
import zlib
from functools import lru_cache

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, FloatProperty, IntProperty, StringProperty
from bpy.types import PropertyGroup

from ...core.errors import RelumeError
from ...core.model import bases
from ...core.model.factor_model import FactorModel
from ...core.spectra import files
from . import changes, mixes, preferred
from .mixer import CLASSES as MIXER_CLASSES
from .mixer import LightGroup, Snapshot, is_quiet, mix_changed, quiet, reading
from .mixes import FILE

__all__ = ["AUTO", "CHANNELS", "CLASSES", "PREFILTERED", "LightGroup", "model_for", "register", "unregister"]

MODEL = "relume_model"  # the factor model of a scene that is set up, as JSON
PLAN = "relume_plan"  # what was asked for, and why this model was chosen
STOCK = "relume_stock"  # on a scene that shows an EXR which Blender wrote: its description, as JSON
FIRST = "relume_first"  # on a scene that shows an EXR: the mix that it was rendered with, as a snapshot keeps it
REFERENCE_BANDS = 36
EXACT_BANDS = 81

AUTO = "auto"
EXACT = "exact"
PREFILTERED = "prefiltered"

# With the number that a file keeps of each
CHANNELS = [
    (AUTO, "Automatic", "As few passes as this scene needs to stay within the tolerance", 0),
    ("3", "3 channels, 1 pass", "As fast as an RGB render; exact enough for one light that stays", 1),
    (PREFILTERED, "One Pass, Prefiltered", "Exact where one lamp shines directly; others act as RGB colours", 7),
    ("6", "6 channels, 2 passes", "Differences seen side by side", 2),
    ("9", "9 channels, 3 passes", "Nobody can see the difference to the full spectrum", 3),
    ("12", "12 channels, 4 passes", "For lamps with strong lines", 4),
    ("15", "15 channels, 5 passes", "For measurements", 5),
    ("18", "18 channels, 6 passes", "For gels and coloured LEDs", 8),
    ("24", "24 channels, 8 passes", "For gels, coloured LEDs and saturated paints", 9),
    ("reference", "Reference, 12 passes", "36 samples of the spectrum: slow, to compare with", 6),
    (EXACT, "Exact, 27 passes", "All 81 samples of the spectrum, 5 nm apart: very slow, to be sure", 10),
]

# In what one prefiltered pass multiplies colours, as `core.model.bases.SPACES` has them
RENDERING_SPACES = [
    ("sharp", "Sharp", "Sharpened primaries: mostly the nearest, also where light bounces"),
    ("srgb", "sRGB", "The primaries of a display, as in an RGB render"),
    ("xyz", "XYZ", "The tristimulus values themselves; no coefficient is ever negative"),
]


SWITCHING = [
    ("LIT", "Not at All", "The illuminants that are chosen now, in any mixture"),
    ("COMMON", "To Common Lamps", "Daylight, tungsten, fluorescent, LED and street lamps"),
    ("ANY", "To Any Lamp", "Every CIE illuminant"),
]


GROUPING = [
    ("KEEP", "Leave as They Are", "What shines stays in the light groups that it is in"),
    ("LIGHT", "One per Light", "Every lamp, every shining object and the world gets a light group of its own"),
    ("COLLECTION", "One per Collection", "What shines in the same collection shares a light group"),
]


# The standard observers and the cameras that `core.library` knows
OBSERVERS = [
    ("CIE 1931 2°", "CIE 1931, 2°", "The standard observer of colorimetry: small things"),
    ("CIE 1964 10°", "CIE 1964, 10°", "The supplementary observer: large surfaces"),
    ("CIE 2015 2°", "CIE 2015, 2°", "From the cone fundamentals of 2006"),
    ("CIE 2015 10°", "CIE 2015, 10°", "From the cone fundamentals of 2006, for large surfaces"),
    ("Nikon 5100 (NPL)", "Camera: Nikon D5100", "Sensitivities measured at NPL"),
    ("Sigma SDMerill (NPL)", "Camera: Sigma SD1 Merrill", "Sensitivities measured at NPL"),
    (FILE, "From a File", "Three sensitivities in columns"),
]


def model_for(channels: str) -> FactorModel:
    """The factor model that an entry of `CHANNELS` stands for."""
    bands = {"reference": REFERENCE_BANDS, EXACT: EXACT_BANDS}
    return bases.named("bands", bands[channels]) if channels in bands else bases.named("fitted", int(channels))


@lru_cache(maxsize=8)
def _model_from(text: str) -> FactorModel:
    return FactorModel.from_dict(json.loads(text))


def _observer(path: str) -> list[dict]:
    return [spectrum.to_dict() for spectrum in files.observer(path)]


def _groups(self, _context, typed: str) -> list[str]:
    """The light groups to choose from: the mixer's, and those that the scene's view layers have."""
    layers = self.id_data.view_layers
    names = [*(row.name for row in self.lit), *(group.name for layer in layers for group in layer.lightgroups)]
    return [name for name in dict.fromkeys(names) if typed.casefold() in name.casefold()]


def _wiped(self, context) -> None:
    changes.tell(changes.WIPE, self.id_data, self.wipe)


def _denoising_chosen(self, _) -> None:
    if self.shades:
        changes.tell(changes.PASSES, self.id_data)


def _white_chosen(self, context) -> None:
    """The white of a group starts with the first one."""
    if self.white_source == "GROUP" and not self.white_group and self.lit and not is_quiet():
        with quiet():
            self.white_group = self.lit[0].name
    mix_changed(self, context)


class SceneSettings(PropertyGroup):
    channels: EnumProperty(
        name="Channels",
        description="How finely the spectrum is split. Three channels are one render pass",
        items=CHANNELS,
        default=AUTO,
        get_transform=preferred.channels,
    )
    tolerance: FloatProperty(
        name="Tolerance",
        description="Colour difference (CIEDE2000) to the full spectrum that 98 % of the picture keeps to. 1 is just "
        "noticeable",
        default=1.0,
        min=0.02,
        soft_max=5.0,
        get_transform=preferred.tolerance,
    )
    dominant_group: StringProperty(
        name="Dominant Light",
        description="The light group whose light materials are prefiltered for: its direct light is exact. Empty: the "
        "first one",
        search=_groups,
    )
    rendering_space: EnumProperty(
        name="Multiply In",
        description="The primaries in which the pass multiplies colours",
        items=RENDERING_SPACES,
        default="sharp",
    )
    switching: EnumProperty(
        name="Switch Light",
        description="Which illuminants the picture has to be exact for",
        items=SWITCHING,
        default="COMMON",
    )
    grouping: EnumProperty(
        name="Light Groups",
        description="The groups whose light can be chosen apart, without a new render",
        items=GROUPING,
    )
    split_samples: BoolProperty(
        name="Share Samples",
        description="Deal the scene's samples out among the passes, so that a spectral render takes about as long as "
        "an RGB one. Off: every pass takes all samples, with less noise",
        default=True,
    )
    same_seed: BoolProperty(
        name="Same Noise in Every Pass",
        description="Use one seed for all passes. Noise is then coloured less but stronger; for comparisons",
        default=False,
    )
    denoise_passes: BoolProperty(
        name="Denoise Every Pass",
        description="Denoise every light group of every pass by itself, once for each render, and not the picture, "
        "again at each change of light: nearer to the true colours",
        default=True,
        update=_denoising_chosen,
    )
    reduce_color_noise: BoolProperty(
        name="Reduce Color Noise",
        description="Take out of what is not denoised the noise of hue that several passes have and an RGB render has "
        "not: each pass gets the brightness of all of them. Off: coefficients as they were sampled",
        default=True,
        update=_denoising_chosen,
    )
    light_groups: CollectionProperty(type=LightGroup)
    active_light_group: IntProperty()
    white_balance: FloatProperty(
        name="White Balance",
        description="How far the picture adapts to its light. 0: tungsten stays orange, 1: white is white",
        default=0.0,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        update=mix_changed,
    )
    white_balance_method: EnumProperty(
        name="Method",
        description="The space in which white balance scales its channels",
        items=[("bradford", "Bradford", "As in ICC profiles"), ("sharp", "Sharp", "Sharpened sensors, less skew")],
        default="bradford",
        update=mix_changed,
    )
    white_source: EnumProperty(
        name="White Is",
        description="What becomes white as far as the white balance says",
        items=[
            ("MIX", "All Light", "A white surface in the light of all groups together"),
            ("GROUP", "A Light Group", "A white surface in the light of one group"),
            ("PIXEL", "A Picked Pixel", "The spot that was picked in the picture, in whatever light"),
        ],
        default="MIX",
        update=_white_chosen,
    )
    white_group: StringProperty(
        name="Group", description="The light group whose light becomes white", update=mix_changed
    )
    white_pixel: StringProperty(options={"HIDDEN"})
    observer: EnumProperty(
        name="Observer",
        description="Whose eye, or which camera, sees the spectra",
        items=OBSERVERS,
        default=OBSERVERS[0][0],
        update=mix_changed,
    )
    observer_path: StringProperty(
        name="File",
        description="A file with wavelengths in nm and three sensitivities, in columns. They are kept in the scene",
        subtype="FILE_PATH",
        options={"ANIMATABLE", "PATH_SUPPORTS_BLEND_RELATIVE"},
        update=reading(_observer, "observer_path", "observer_measured"),
    )
    observer_measured: StringProperty(options={"HIDDEN"})
    snapshots: CollectionProperty(type=Snapshot)
    active_snapshot: IntProperty(name="Snapshot", description="A mix that is kept in this file")
    comparing: StringProperty(options={"HIDDEN"})
    wipe: FloatProperty(
        name="Wipe",
        description="Where the mixer's picture ends and the snapshot's begins, from the left",
        default=0.5,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        update=_wiped,
    )
    exr: StringProperty(options={"HIDDEN"})
    problem: StringProperty(options={"SKIP_SAVE"})

    @property
    def is_set_up(self) -> bool:
        """Whether the scene carries the spectral set-up."""
        return MODEL in self.id_data

    @property
    def denoises_passes(self) -> bool:
        """Whether the passes are denoised one by one before they are recombined."""
        return self.denoise_passes and self.id_data.cycles.use_denoising

    @property
    def shares_brightness(self) -> bool:
        """Whether passes that are not denoised are brought to one brightness."""
        return self.reduce_color_noise and not self.same_seed and self.model().passes > 1

    @property
    def request(self) -> str:
        """What is asked for now: the choices that decide the model."""
        if self.channels == AUTO:
            return f"{self.channels} {self.tolerance:g} {self.switching}"
        if self.channels == PREFILTERED:
            return f"{self.channels} {self.rendering_space} {self._dominant()}"
        return self.channels

    def _dominant(self) -> str:
        """The dominant light group and a checksum of its light: for another light the pass is no longer exact."""
        row = next((row for row in self.lit if row.name == self.dominant_group or not self.dominant_group), None)
        try:
            return f"{row.name} {zlib.crc32(row.spectrum().values.tobytes()):08x}" if row else self.dominant_group
        except RelumeError:
            return self.dominant_group

    @property
    def plan(self) -> dict:
        """For a scene that is set up: the `request` that it answers and, if Relume chose, the `reason`."""
        return dict(self.id_data.get(PLAN, {}))

    def model(self) -> FactorModel:
        """The factor model that this scene was set up with."""
        return _model_from(self.id_data[MODEL])

    @property
    def lit(self) -> list:
        """The rows of the mixer in which something shone at set-up: those that are rendered, in order."""
        return [row for row in self.light_groups if row.is_lit]

    @property
    def shades(self) -> bool:
        """Whether the shaders of the scene carry the set-up: that of an EXR that is relit has none."""
        return self.is_set_up and not self.exr

    def lights(self) -> list:
        """A `core` Light for each row of `lit`, with its gain after solo and mute."""
        return list(mixes.of(self).lights.values())

    @property
    def observer_origin(self) -> str:
        """The file of an observer that was read, and what was read otherwise than it stands there; "" if none was."""
        try:
            return mixes.stored_observer(self.observer_measured)[0].source
        except RelumeError:
            return ""


CLASSES = (*MIXER_CLASSES, SceneSettings)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.relume = bpy.props.PointerProperty(type=SceneSettings)


def unregister() -> None:
    del bpy.types.Scene.relume
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
