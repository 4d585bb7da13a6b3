"""What the panel's buttons do."""

from bpy.types import Operator
from bpy.utils import register_classes_factory

from ..scene import light_groups, render_settings, setup
from . import dial, files, inspector, mixer_operators, web
from .mixer_operators import NeedsSetUp, reporting

__all__ = ["CLASSES", "register", "unregister"]


class SetUpSpectralRender(Operator):
    """Make this scene spectral: F12 then renders coefficient passes, and the light can be chosen afterwards"""

    bl_idname = "relume.set_up"
    bl_label = "Set Up Spectral Render"
    bl_options = {"REGISTER", "UNDO"}

    @reporting
    def execute(self, context) -> None:
        scene = context.scene
        engine, is_new = scene.render.engine, not scene.relume.is_set_up
        why = light_groups.set_up(scene, scene.relume.grouping if is_new else "KEEP")
        self.report({"INFO"}, _said(scene, engine, why))


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


CLASSES = (
    SetUpSpectralRender,
    UseCycles,
    RemoveSpectralRender,
    *mixer_operators.CLASSES,
    *dial.CLASSES,
    *inspector.CLASSES,
    *files.CLASSES,
    *web.CLASSES,
)


register, unregister = register_classes_factory(CLASSES)
