"""What the mixer's buttons do."""

from collections.abc import Callable
from functools import wraps

from bpy.props import BoolProperty, EnumProperty, IntProperty, StringProperty
from bpy.types import Operator

from ...core.errors import RelumeError, SetupError
from ..scene import comparison, compositing, light_groups, mix_edits, setup
from ..store import mixer, schema

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


class MoveGroup(NeedsSetUp, Operator):
    """Move this light group up or down in the mixer"""

    bl_idname = "relume.move_group"
    bl_label = "Move Light Group"

    group: StringProperty(options={"HIDDEN", "SKIP_SAVE"})
    down: BoolProperty(name="Down", options={"SKIP_SAVE"})

    @reporting
    def execute(self, context) -> None:
        mix_edits.move(context.scene, self.group, 1 if self.down else -1)


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
        _take_snapshot(context.scene.relume)
        return {"FINISHED"}


def _take_snapshot(settings):
    taken = {snapshot.name for snapshot in settings.snapshots}
    number = next(n for n in range(1, len(taken) + 2) if f"Mix {n}" not in taken)
    snapshot = settings.snapshots.add()
    snapshot.name, snapshot.mix = f"Mix {number}", schema.snapshot_text(mixer.choices(settings))
    settings.active_snapshot = len(settings.snapshots) - 1
    return snapshot


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


class Compare(NeedsSetUp, Operator):
    """Show this snapshot in the right part of the picture, beside the mixer's. Where there is none, one is taken"""

    bl_idname = "relume.compare"
    bl_label = "Compare with Snapshot"

    @reporting
    def execute(self, context) -> None:
        scene, settings = context.scene, context.scene.relume
        if settings.comparing:
            comparison.end(scene)
            settings.comparing = ""
            return
        chosen = settings.active_snapshot
        kept = settings.snapshots
        snapshot = kept[chosen] if 0 <= chosen < len(kept) else _take_snapshot(settings)
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
    ChangeBlend,
    MoveGroup,
    Regroup,
    AddLights,
    RemoveEmptyGroups,
    TakeSnapshot,
    ForgetSnapshot,
    ApplySnapshot,
    Compare,
    WriteToLights,
)
