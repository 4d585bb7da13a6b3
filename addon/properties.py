"""What an artist chooses, kept in the scene: channels, the mixer of light groups, white balance."""

import json
from functools import lru_cache

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, FloatProperty, IntProperty, StringProperty
from bpy.types import PropertyGroup

__all__ = [
    "AUTO",
    "CHANNELS",
    "CLASSES",
    "SWITCHING",
    "LightGroup",
    "SceneSettings",
    "model_for",
    "register",
    "unregister",
]

MODEL = "relume_model"  # the factor model of a scene that is set up, as JSON
PLAN = "relume_plan"  # what was asked for, and why this model was chosen
REFERENCE_BANDS = 36

AUTO = "auto"

CHANNELS = [
    (AUTO, "Automatic", "As few passes as this scene needs to stay within the tolerance"),
    ("3", "3 channels, 1 pass", "As fast as an RGB render; exact enough for one light that stays"),
    ("6", "6 channels, 2 passes", "Differences seen side by side"),
    ("9", "9 channels, 3 passes", "Nobody can see the difference to the full spectrum"),
    ("12", "12 channels, 4 passes", "For lamps with strong lines"),
    ("15", "15 channels, 5 passes", "For measurements"),
    ("reference", "Reference, 12 passes", "Every band of 11 nm on its own: slow, to compare with"),
]


SWITCHING = [
    ("LIT", "Not at All", "The illuminants that are chosen now, in any mixture"),
    ("COMMON", "To Common Lamps", "Daylight, tungsten, fluorescent, LED and street lamps"),
    ("ANY", "To Any Lamp", "Every CIE illuminant"),
]


def model_for(channels: str):
    """The factor model that an entry of `CHANNELS` stands for."""
    from ..core import bases

    return bases.named("bands", REFERENCE_BANDS) if channels == "reference" else bases.named("fitted", int(channels))


@lru_cache(maxsize=8)
def _model_from(text: str):
    from ..core.factor_model import FactorModel

    return FactorModel.from_dict(json.loads(text))


def _mix_changed(self, context):
    from . import setup

    setup.relight(self.id_data)


class LightGroup(PropertyGroup):
    """One row of the mixer: a light group and what shines in it."""

    name: StringProperty(name="Light Group")
    illuminant: StringProperty(
        name="Illuminant",
        description="The spectrum of the lamps in this light group. Changing it changes the picture without rendering",
        default="D65",
        update=_mix_changed,
    )
    gain: FloatProperty(
        name="Gain",
        description="Brightness of this light group, as a multiple of what was rendered",
        default=1.0,
        min=0.0,
        soft_max=4.0,
        update=_mix_changed,
    )

    def light(self):
        """The `core.view.Light` of this row. Raises `LibraryError` for a name that no illuminant has."""
        from ..core import library, view

        return view.Light(library.illuminant(self.illuminant), self.gain)


class SceneSettings(PropertyGroup):
    channels: EnumProperty(
        name="Channels",
        description="How finely the spectrum is split. Three channels are one render pass",
        items=CHANNELS,
        default=AUTO,
    )
    tolerance: FloatProperty(
        name="Tolerance",
        description="Colour difference (CIEDE2000) to the full spectrum that 98 % of the picture keeps to. 1 is just "
        "noticeable",
        default=1.0,
        min=0.02,
        soft_max=5.0,
    )
    switching: EnumProperty(
        name="Switch Light",
        description="Which illuminants the picture has to be exact for",
        items=SWITCHING,
        default="COMMON",
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
    light_groups: CollectionProperty(type=LightGroup)
    active_light_group: IntProperty()
    white_balance: FloatProperty(
        name="White Balance",
        description="How far the picture adapts to its light. 0: tungsten stays orange, 1: white is white",
        default=0.0,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        update=_mix_changed,
    )
    white_balance_method: EnumProperty(
        name="Method",
        description="The space in which white balance scales its channels",
        items=[("bradford", "Bradford", "As in ICC profiles"), ("sharp", "Sharp", "Sharpened sensors, less skew")],
        default="bradford",
        update=_mix_changed,
    )
    problem: StringProperty(options={"SKIP_SAVE"})

    @property
    def is_set_up(self) -> bool:
        """Whether the scene carries the spectral set-up."""
        return MODEL in self.id_data

    @property
    def request(self) -> str:
        """What is asked for now: the choices that decide the model."""
        chosen = (self.channels, f"{self.tolerance:g}", self.switching) if self.channels == AUTO else (self.channels,)
        return " ".join(chosen)

    @property
    def plan(self) -> dict:
        """For a scene that is set up: the `request` that it answers and, if Relume chose, the `reason`."""
        return dict(self.id_data.get(PLAN, {}))

    def model(self):
        """The factor model that this scene was set up with."""
        return _model_from(self.id_data[MODEL])

    def lights(self) -> list:
        """A `core.view.Light` for each row of the mixer."""
        return [group.light() for group in self.light_groups]


CLASSES = (LightGroup, SceneSettings)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.relume = bpy.props.PointerProperty(type=SceneSettings)


def unregister():
    del bpy.types.Scene.relume
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
