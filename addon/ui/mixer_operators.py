"""What the mixer's buttons do."""

import json
from collections.abc import Callable
from functools import wraps
from pathlib import Path

import bpy
from bpy.props import EnumProperty, IntProperty, StringProperty
from bpy.types import Operator

from ...core.errors import RelumeError, SetupError
from ...core.picture import drawing
from ...core.spectra import files, library
from ..scene import comparison, compositing, light_groups, setup
from ..store import mixer, schema
from . import icons, own_spectra, translation

__all__ = ["CLASSES", "NeedsSetUp", "reporting"]


class NeedsSetUp:
    """Operators that need a scene that is set up, and are one step of undo."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context) -> bool:
        if not context.scene.relume.is_set_up:
            cls.poll_message_set("this scene is not set up for spectral rendering")
            return False
        return True


def reporting(work: Callable[..., None]) -> Callable[..., set[str]]:
    """An operator's `execute` of what it does: finished, or cancelled where that raises RelumeError, which is shown."""

    @wraps(work)
    def execute(self, context) -> set[str]:
        try:
            work(self, context)
        except RelumeError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}

    return execute


_ITEMS, _ITEMS_IN = [], {}  # Blender keeps no reference to the strings; the language that they are in


def _illuminants(self=None, context=None):
    """Every named illuminant with its family, icon and number, as a menu wants them."""
    locale = bpy.app.translations.locale
    if _ITEMS_IN.get("locale") != locale:
        _ITEMS_IN["locale"] = locale
        _ITEMS.clear()
        for family, names in library.illuminants().items():
            for name in names:
                spectrum = library.illuminant(name)
                icon = icons.swatch_and_curve(drawing.curve(spectrum).tolist(), drawing.swatch(spectrum).tolist())
                _ITEMS.append((name, translation.illuminant(name), family, icon, len(_ITEMS)))
    return [*_ITEMS, *_own_lamps()] if own_spectra.listed(own_spectra.LAMPS) else _ITEMS


_OWN = {}  # the files, by those that were listed: Blender keeps no reference to the strings


def _own_lamps() -> list[tuple]:
    """The files of the user's own folder of lamps, as `_illuminants` gives its items."""
    found = own_spectra.listed(own_spectra.LAMPS)
    if _OWN.get("files") is not found:
        items = [(path, f"{name}  (own)", path, 0, len(_ITEMS) + k) for k, (path, name) in enumerate(found)]
        _OWN.update(files=found, items=items)
    return _OWN["items"]


class ChooseIlluminant(Operator):
    """Choose the spectrum of the lamps in this light group. The picture follows without rendering"""

    # An operator, because Blender's own search field leaves no undo step
    bl_idname = "relume.choose_illuminant"
    bl_label = "Illuminant"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}
    bl_property = "illuminant"

    illuminant: EnumProperty(name="Illuminant", items=_illuminants)
    group: IntProperty(options={"HIDDEN"})
    part: IntProperty(options={"HIDDEN"}, default=-1)

    def invoke(self, context, event) -> set[str]:
        context.window_manager.invoke_search_popup(self)
        return {"INTERFACE"}

    @reporting
    def execute(self, context) -> None:
        row = context.scene.relume.light_groups[self.group]
        part = row.blend[self.part] if self.part >= 0 else None
        name, measured = self.illuminant, ""
        if own_spectra.is_own(name):  # a file of the user's own folder
            name, measured = Path(name).stem, json.dumps(files.illuminant(name).to_dict())
        with mixer.quiet():
            if part is not None:
                part.illuminant, part.measured = name, measured
            elif measured:
                row.path, row.measured, row.source = self.illuminant, measured, "FILE"
            else:
                row.source, row.illuminant = "LIBRARY", name
        mixer.mix_changed(row, context)


class ChangeBlend(NeedsSetUp, Operator):
    """Add an illuminant to this blend, or take one out"""

    bl_idname = "relume.change_blend"
    bl_label = "Change Blend"

    group: IntProperty(options={"HIDDEN"})
    part: IntProperty(options={"HIDDEN"}, default=-1)

    def execute(self, context) -> set[str]:
        row = context.scene.relume.light_groups[self.group]
        if self.part < 0:
            with mixer.quiet():
                row.blend.add().weight = 0.0
        else:
            row.blend.remove(self.part)
        mixer.mix_changed(row, context)
        return {"FINISHED"}


class Regroup(NeedsSetUp, Operator):
    """Put everything that shines into new light groups. Then render again"""

    bl_idname = "relume.regroup"
    bl_label = "New Light Groups"

    way: EnumProperty(name="Groups", items=light_groups.WAYS)

    @reporting
    def execute(self, context) -> None:
        count = light_groups.regroup(context.scene, self.way)
        self.report({"INFO"}, f"{count} light groups; render again to see them")


class AddLights(NeedsSetUp, Operator):
    """Put the selected lamps and shining objects into this light group. Then render again"""

    bl_idname = "relume.add_lights"
    bl_label = "Add Selected Lights"

    group: StringProperty(options={"HIDDEN"})

    @classmethod
    def poll(cls, context) -> bool:
        if not context.selected_objects:
            cls.poll_message_set("no object is selected")
            return False
        return super().poll(context)

    @reporting
    def execute(self, context) -> None:
        count = light_groups.add(context.scene, self.group, context.selected_objects)
        if not count:
            raise SetupError("nothing that shines is selected")
        self.report({"INFO"}, f"{count} in {self.group}; render again to see it")


class RemoveEmptyGroups(NeedsSetUp, Operator):
    """Remove the light groups in which nothing shines. Until then they cost nothing but their row"""

    bl_idname = "relume.remove_empty_groups"
    bl_label = "Remove Groups without Lights"

    def execute(self, context) -> set[str]:
        names = light_groups.remove_empty(context.scene)
        self.report({"INFO"}, f"removed {', '.join(names)}" if names else "every light group has lights")
        return {"FINISHED"} if names else {"CANCELLED"}


class TakeSnapshot(NeedsSetUp, Operator):
    """Keep this mix in the file, to come back to it or to compare with it"""

    bl_idname = "relume.take_snapshot"
    bl_label = "Take Snapshot"

    def execute(self, context) -> set[str]:
        settings = context.scene.relume
        taken = {snapshot.name for snapshot in settings.snapshots}
        number = next(n for n in range(1, len(taken) + 2) if f"Mix {n}" not in taken)
        snapshot = settings.snapshots.add()
        snapshot.name, snapshot.mix = f"Mix {number}", schema.snapshot_text(mixer.choices(settings))
        settings.active_snapshot = len(settings.snapshots) - 1
        return {"FINISHED"}


class _OfSnapshot(NeedsSetUp):
    @classmethod
    def poll(cls, context) -> bool:
        if not super().poll(context):
            return False
        if not 0 <= context.scene.relume.active_snapshot < len(context.scene.relume.snapshots):
            cls.poll_message_set("there is no snapshot: take one")
            return False
        return True

    @staticmethod
    def chosen(context):
        settings = context.scene.relume
        return settings.snapshots[settings.active_snapshot]


class ForgetSnapshot(_OfSnapshot, Operator):
    """Remove this snapshot from the file"""

    bl_idname = "relume.forget_snapshot"
    bl_label = "Remove Snapshot"

    def execute(self, context) -> set[str]:
        settings = context.scene.relume
        settings.snapshots.remove(settings.active_snapshot)
        settings.active_snapshot = max(0, settings.active_snapshot - 1)
        return {"FINISHED"}


class ApplySnapshot(_OfSnapshot, Operator):
    """Put the mixer back to this snapshot"""

    bl_idname = "relume.apply_snapshot"
    bl_label = "Apply Snapshot"

    @reporting
    def execute(self, context) -> None:
        missing = mixer.apply(context.scene.relume, schema.snapshot(self.chosen(context).mix))
        if missing:
            self.report({"WARNING"}, f"the mixer has no light group {', '.join(missing)}: the rest is applied")


class Compare(_OfSnapshot, Operator):
    """Show this snapshot in the right part of the picture, beside the mixer's"""

    bl_idname = "relume.compare"
    bl_label = "Compare with Snapshot"

    @reporting
    def execute(self, context) -> None:
        scene, settings = context.scene, context.scene.relume
        if settings.comparing:
            comparison.end(scene)
            settings.comparing = ""
            return
        snapshot = self.chosen(context)
        try:
            compositing.compare(scene, setup.matrices_of(scene, schema.snapshot(snapshot.mix)))
        except RelumeError as error:
            raise SetupError(f"{snapshot.name}: {error}") from error
        settings.comparing = snapshot.name


class WriteToLights(NeedsSetUp, Operator):
    """Give the lamps the brightness that the mixer says, and set the mixer's gains to 0. Then render again"""

    bl_idname = "relume.write_to_lights"
    bl_label = "Write to Lights"

    def execute(self, context) -> set[str]:
        kept = light_groups.write_gains(context.scene)
        if kept:
            self.report({"WARNING"}, f"left as they are, for their strength is linked or shared: {', '.join(kept)}")
        else:
            self.report({"INFO"}, "the lamps are as bright as the mixer said; render again")
        return {"FINISHED"}


CLASSES = (
    ChooseIlluminant,
    ChangeBlend,
    Regroup,
    AddLights,
    RemoveEmptyGroups,
    TakeSnapshot,
    ForgetSnapshot,
    ApplySnapshot,
    Compare,
    WriteToLights,
)
