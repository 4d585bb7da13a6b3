"""Mixes and illuminants that are put back, copied, pasted, saved and loaded; and the lights of a row."""

import argparse
from dataclasses import replace
from pathlib import Path

import bpy
from bpy.props import StringProperty
from bpy.types import Operator

from ...core.errors import RelumeError, UsageError
from ...core.spectra import library
from ..cli import arguments, jobs
from ..scene import mix_edits, render
from ..store import mix_file, mixer
from .mixer_operators import NeedsSetUp, reporting

__all__ = ["CLASSES"]


class ResetMix(NeedsSetUp, Operator):
    """Put the mixer, or this light group alone, back to how it begins: daylight, or the black body that its lamps are,
    with no gain; of an EXR, what it was rendered with"""

    bl_idname = "relume.reset_mix"
    bl_label = "Reset Mix"

    group: StringProperty(options={"HIDDEN", "SKIP_SAVE"})

    @reporting
    def execute(self, context) -> None:
        mix_edits.reset(context.scene, [self.group] if self.group else None)


class _OfRow(NeedsSetUp):
    """An operator on a row of the mixer: the one that is named, else the active one."""

    group: StringProperty(options={"HIDDEN", "SKIP_SAVE"})

    def row(self, context):
        settings = context.scene.relume
        if self.group:
            return settings.light_groups[self.group]
        return settings.light_groups[min(settings.active_light_group, len(settings.light_groups) - 1)]


class CopyIlluminant(_OfRow, Operator):
    """Copy what shines in this light group, to paste it into another, in this scene or another Blender"""

    bl_idname = "relume.copy_illuminant"
    bl_label = "Copy Illuminant"
    bl_options = {"REGISTER"}

    def execute(self, context) -> set[str]:
        context.window_manager.clipboard = mix_file.illuminant_text(self.row(context))
        return {"FINISHED"}


class PasteIlluminant(_OfRow, Operator):
    """Have this light group show the illuminant that was copied, or the one of which the name was copied"""

    bl_idname = "relume.paste_illuminant"
    bl_label = "Paste Illuminant"

    words: StringProperty(description="An illuminant; empty: what was copied", options={"HIDDEN", "SKIP_SAVE"})

    @reporting
    def execute(self, context) -> None:
        words = self.words or context.window_manager.clipboard
        if mix_file.is_json(words):
            shines = mix_file.illuminant_from(words)
        else:
            shines = {"source": "LIBRARY", "illuminant": _illuminant_of(words)}
        mix_edits.paste(self.row(context), shines)


def _illuminant_of(words: str) -> str:
    try:
        return library.illuminant(words.strip()).name
    except RelumeError as error:
        raise UsageError(f"what was copied is no illuminant: {words.strip()[:40]!r}") from error


class SelectLights(_OfRow, Operator):
    """Select the lamps and shining objects of this light group"""

    bl_idname = "relume.select_lights"
    bl_label = "Select Lights"

    @reporting
    def execute(self, context) -> None:
        if context.mode != "OBJECT":
            raise UsageError("lights are selected in object mode")
        names = mix_edits.select(context, self.row(context).name)
        self.report({"INFO"}, f"selected {', '.join(names)}")


class CopyMix(NeedsSetUp, Operator):
    """Copy the whole mix, to paste it into another scene or Blender"""

    bl_idname = "relume.copy_mix"
    bl_label = "Copy Mix"
    bl_options = {"REGISTER"}

    def execute(self, context) -> set[str]:
        context.window_manager.clipboard = mix_file.mix_text(context.scene.relume)
        return {"FINISHED"}


class PasteMix(NeedsSetUp, Operator):
    """Take over a mix that was copied, in Blender or from a web page, by light groups of the same name"""

    bl_idname = "relume.paste_mix"
    bl_label = "Paste Mix"

    words: StringProperty(description="A mix; empty: what was copied", options={"HIDDEN", "SKIP_SAVE"})

    @reporting
    def execute(self, context) -> None:
        try:
            _take_over(self, context, self.words or context.window_manager.clipboard)
        except argparse.ArgumentTypeError:
            raise UsageError("what was copied is not a mix: expected --light 'GROUP=ILLUMINANT*GAIN' …") from None


class SaveMix(NeedsSetUp, Operator):
    """Write the mix as a JSON file, for other scenes and for `relume relight --mix`. Measured spectra are in it"""

    bl_idname = "relume.save_mix"
    bl_label = "Save Mix"
    bl_options = {"REGISTER"}

    filepath: StringProperty(subtype="FILE_PATH", options={"SKIP_SAVE"})
    filter_glob: StringProperty(default="*.json", options={"HIDDEN"})
    check_existing: bpy.props.BoolProperty(default=True, options={"HIDDEN"})

    def invoke(self, context, event) -> set[str]:
        self.filepath = f"{bpy.path.clean_name(context.scene.name)} mix.json"
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    @reporting
    def execute(self, context) -> None:
        path = Path(bpy.path.abspath(self.filepath)).with_suffix(".json")
        mix_file.write(path, context.scene.relume)
        self.report({"INFO"}, f"wrote {path}")


class LoadMix(NeedsSetUp, Operator):
    """Take over a mix from a file: that of Save Mix, or the words that a web page's Copy Mix gave"""

    bl_idname = "relume.load_mix"
    bl_label = "Load Mix"

    filepath: StringProperty(subtype="FILE_PATH", options={"SKIP_SAVE"})
    filter_glob: StringProperty(default="*.json;*.txt", options={"HIDDEN"})

    def invoke(self, context, event) -> set[str]:
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    @reporting
    def execute(self, context) -> None:
        path = Path(bpy.path.abspath(self.filepath))
        text = mix_file.read(path)
        try:
            _take_over(self, context, text)
        except (argparse.ArgumentTypeError, RelumeError) as error:
            raise UsageError(f"{path}: {error}") from error


def _take_over(operator, context, text: str) -> None:
    """Have the mixer say what a text does, JSON or words. Raises RelumeError, ArgumentTypeError."""
    settings = context.scene.relume
    if not mix_file.is_json(text):
        _take_over_words(context, arguments.mix(text))
    elif missing := mixer.apply(settings, mix_file.mix_from(text)):
        operator.report({"WARNING"}, f"the mixer has no light group {', '.join(missing)}: the rest is applied")


def _take_over_words(context, said: argparse.Namespace) -> None:
    settings = context.scene.relume
    image = render.described(context.scene)
    lights = jobs.lights_of(replace(image, groups=dict.fromkeys(image.illuminants)), said.light)
    with mixer.quiet():
        for words in said.light:
            group, _, what = words.rpartition("=")
            row = settings.light_groups[group]
            parts = arguments.blend(what.partition("*")[0])
            if parts:
                row.blend.clear()
                for name, weight in parts:
                    part = row.blend.add()
                    part.illuminant, part.weight = name, weight
                row.source = "BLEND"
            else:
                row.source, row.illuminant = "LIBRARY", lights[group].illuminant.name
            row.solo, row.gain = False, lights[group].gain
        if said.white is not None:
            settings.white_balance = said.white
    mixer.mix_changed(settings, context)


CLASSES = (
    ResetMix,
    CopyIlluminant,
    PasteIlluminant,
    SelectLights,
    CopyMix,
    PasteMix,
    SaveMix,
    LoadMix,
)
