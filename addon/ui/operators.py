"""What the panel's buttons do."""

import time
from contextlib import closing

from bpy.types import Operator
from bpy.utils import register_classes_factory

from ...core.errors import RelumeError
from ..host import interruption
from ..scene import light_groups, linked, render_settings, setup
from ..store import preferred
from . import dial, files, illuminants, inspector, mix_files, mixer_operators, web
from .mixer_operators import NeedsSetUp, reporting

__all__ = ["CLASSES", "register", "unregister"]

_SLICE = 0.1  # seconds of setting up between two looks at the keyboard
_running = set()  # operators that are at work in a window


def is_at_work() -> bool:
    """Whether a scene is being set up, while the window goes on."""
    return bool(_running)


class SetUpSpectralRender(Operator):
    """Make this scene spectral: F12 then renders coefficient passes, and the light can be chosen afterwards"""

    bl_idname = "relume.set_up"
    bl_label = "Set Up Spectral Render"
    bl_options = {"REGISTER", "UNDO"}

    def invoke(self, context, event) -> set[str]:
        """Work a slice at a time, so that the window says what is done and Esc stops it."""
        self._begin(context)
        done = self._work_on(context)
        if done == {"RUNNING_MODAL"}:
            self.timer = context.window_manager.event_timer_add(0.02, window=context.window)
            context.window_manager.modal_handler_add(self)
            _running.add(self.bl_idname)
            context.window.cursor_modal_set("WAIT")
        return done

    def execute(self, context) -> set[str]:
        self._begin(context)
        with interruption.held_back() as let_through, closing(self.steps):
            while (done := self._work_on(context)) == {"RUNNING_MODAL"}:
                let_through()
        return done

    def modal(self, context, event) -> set[str]:
        done = {"CANCELLED"}
        try:
            if event.type == "ESC":
                self.steps.close()
                self.report({"WARNING"}, "Set-up stopped: the scene is as it was")
            else:
                done = self._work_on(context) if event.type == "TIMER" else {"RUNNING_MODAL"}
        finally:
            context.workspace.status_text_set(f"Relume: {self.doing} …  Esc stops it")
            if done != {"RUNNING_MODAL"}:
                _running.clear()
                context.window_manager.event_timer_remove(self.timer)
                context.workspace.status_text_set(None)
                context.window.cursor_modal_restore()
        return done

    def cancel(self, context) -> None:
        """Blender ends an operator so when a file is opened or its window closes."""
        _running.clear()
        self.steps.close()

    def _begin(self, context) -> None:
        scene = context.scene
        for name in ("channels", "tolerance"):  # what is preferred, which another user's Blender need not know
            if preferred.of() is not None and not scene.relume.is_property_set(name):
                setattr(scene.relume, name, getattr(scene.relume, name))
        self.engine, is_new = scene.render.engine, not scene.relume.is_set_up
        self.steps = light_groups.setting_up(scene, scene.relume.grouping if is_new else "KEEP")

    def _work_on(self, context) -> set[str]:
        """Set up for a while."""
        until = time.monotonic() + _SLICE
        try:
            while time.monotonic() < until:
                self.doing = next(self.steps)
        except StopIteration as end:
            self.report({"INFO"}, _said(context.scene, self.engine, end.value))
            return {"FINISHED"}
        except RelumeError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"RUNNING_MODAL"}


def _said(scene, engine: str, why: str) -> str:
    """What setting up changed, in one line. engine: which it was. why: why lights are grouped otherwise than chosen."""
    passes, names = scene.relume.model().passes, [row.name for row in scene.relume.lit]
    groups = f"{len(names)} light groups ({', '.join(names[:4])}{' …' if len(names) > 4 else ''})"
    parts = [
        f"{passes} passes" if passes > 1 else "1 pass",
        (groups if len(names) > 1 else f"1 light group ({names[0]})") + (f" {why}" if why else ""),
    ]
    if engine != "CYCLES":
        known = scene.render.bl_rna.properties["engine"].enum_items
        parts.append(f"engine {known[engine].name if engine in known else engine} → Cycles")
    return f"Set up: {', '.join(parts)}"


class UseCycles(NeedsSetUp, Operator):
    """Let Cycles render this scene again: the spectral passes come back"""

    bl_idname = "relume.use_cycles"
    bl_label = "Back to Cycles"

    def execute(self, context) -> set[str]:
        render_settings.use_cycles(context.scene)
        return {"FINISHED"}


class RemoveSpectralRender(NeedsSetUp, Operator):
    """Give the scene back as it was before Relume set it up. Assigned spectra stay"""

    bl_idname = "relume.remove"
    bl_label = "Remove"

    @reporting
    def execute(self, context) -> None:
        setup.remove(context.scene)


class MakeLocal(NeedsSetUp, Operator):
    """Copy linked materials, lamps and worlds, with what shows them, into this file: they become spectral"""

    bl_idname = "relume.make_local"
    bl_label = "Make Local"

    @reporting
    def execute(self, context) -> None:
        names = linked.make_local(context.scene)
        self.report({"INFO"}, f"Made local: {', '.join(names)}" if names else "Nothing linked is left to make local")


CLASSES = (
    SetUpSpectralRender,
    UseCycles,
    MakeLocal,
    RemoveSpectralRender,
    *mixer_operators.CLASSES,
    *illuminants.CLASSES,
    *mix_files.CLASSES,
    *dial.CLASSES,
    *inspector.CLASSES,
    *files.CLASSES,
    *web.CLASSES,
)


register, unregister = register_classes_factory(CLASSES)
