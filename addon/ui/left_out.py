"""What a set-up leaves out of a scene, what keeping it would cost, and the panel that says so.

It is worked out when it is first looked at, and again after a new set-up; nothing of it is kept in the file.
"""

import bpy

from ...core.picture import plan
from ..host import inventory
from ..scene import content, view_layers
from .panel_places import in_both_places
from .wrapping import words

__all__ = ["CLASSES", "work_out"]

_known = {}  # what a set-up depends on: its list of LeftOut, None while that is being worked out
_NO_OTHERS = {"use_pass_combined", "use_pass_cryptomatte_accurate"}
_WAIT = 0.01  # seconds: Blender draws first


def work_out(scene) -> list[plan.LeftOut]:
    """What the set-up of a scene does without: finer models, other render passes, materials that it does not show."""
    model, groups = scene.relume.model(), len(scene.relume.lit)
    part = scene.render.resolution_percentage / 100
    pixels = int(scene.render.resolution_x * part) * int(scene.render.resolution_y * part)
    found = plan.left_out(model, content.content_of(scene), pixels, groups)
    others = _other_passes(scene)
    if others and model.passes > 1:
        megabytes = (model.passes - 1) * others * pixels * 4 * 4 / 1e6
        what = f"{others} other render pass{'es' if others > 1 else ''}, in all view layers but the first"
        found.append(plan.LeftOut(what, f"{megabytes:.0f} MB, and they would all be the same"))
    unseen = len([m for m in bpy.data.materials if m.users]) - len(inventory.take(scene).materials)
    if unseen > 0:
        what = f"{unseen} material{'s' if unseen > 1 else ''} that this scene does not show"
        found.append(plan.LeftOut(what, "a node for each colour, and the time to put it in"))
    return found


def _other_passes(scene) -> int:
    """How many passes besides the picture the artist asked for in the first of the rendered view layers."""
    layers = next(iter(view_layers.pass_layers(scene).values()))
    names = {name for name in layers[0].bl_rna.properties.keys() if name.startswith("use_pass_")}
    return sum(getattr(layers[0], name) is True for name in names - _NO_OTHERS)


def _key(scene) -> tuple:
    settings, render = scene.relume, scene.render
    size = (render.resolution_x, render.resolution_y, render.resolution_percentage)
    return scene.session_uid, scene.name, *settings.plan.values(), len(settings.light_groups), *size


def _soon(key: tuple, name: str) -> None:
    """Work it out once Blender has drawn: a panel may not compute anything."""

    def work() -> None:
        scene = bpy.data.scenes.get(name)
        _known.clear()
        if scene is not None and scene.relume.is_set_up:
            _known[key] = work_out(scene)
        for window in bpy.context.window_manager.windows:
            for area in window.screen.areas:
                area.tag_redraw()

    bpy.app.timers.register(work, first_interval=_WAIT)


class _LeftOut:
    bl_label = "Left Out"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 100

    @classmethod
    def poll(cls, context) -> bool:
        return context.scene.relume.is_set_up and bool(context.scene.relume.plan.get("reason"))

    def draw(self, context) -> None:
        key = _key(context.scene)
        if key not in _known:
            _known[key] = None
            _soon(key, context.scene.name)
        if _known[key] is None:
            self.layout.label(text="Looking at the scene …")
            return
        words(self.layout, "This scene does without, and what keeping it would cost:")
        for row in _known[key]:
            box = self.layout.box().column(align=True)
            words(box, row.what[:1].upper() + row.what[1:], boxed=True)
            cost = box.column(align=True)
            cost.active = False
            words(cost, row.cost, boxed=True)


CLASSES = in_both_places(_LeftOut, "left_out")
