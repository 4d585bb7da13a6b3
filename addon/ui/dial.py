"""The light dial: the illuminants of a blend on a disc in the window, and a handle that weighs them.

[BMD] S. Bergner, T. Moller, M. S. Drew, "A spectral engine for visualization", SFU-CMPT-TR2004-06.
"""

from collections.abc import Sequence

import bpy
from bpy.props import IntProperty
from bpy.types import Operator

from ...core.picture import drawing, mixing
from ..store import mixer
from . import overlay
from .mixer_operators import NeedsSetUp

__all__ = ["CLASSES"]

_RADIUS = 90  # pixels at an interface scale of 1
_MARGIN = 60


class LightDial(NeedsSetUp, Operator):
    """Weigh the illuminants of this blend by a handle on a disc in the picture. Enter keeps, Esc takes back"""

    bl_idname = "relume.light_dial"
    bl_label = "Light Dial"
    bl_options = {"REGISTER", "UNDO", "BLOCKING"}

    group: IntProperty(
        default=-1, options={"HIDDEN", "SKIP_SAVE"}
    )  # -1: the active one, else the first that is a blend

    def _row(self, context):
        return context.scene.relume.light_groups[self.group]

    def invoke(self, context, event) -> set[str]:
        if self.group < 0:
            self.group = _blend_in(context.scene.relume)
        row = self._row(context) if self.group >= 0 else None
        if row is None or len(row.blend) < 2:
            self.report({"ERROR"}, "the light dial needs two illuminants or more in the blend")
            return {"CANCELLED"}
        area = _picture_area(context)
        if area is None:
            self.report({"ERROR"}, "the light dial needs an Image Editor or a 3D view in this window")
            return {"CANCELLED"}
        self.area, self.region = area, next(r for r in area.regions if r.type == "WINDOW")
        self.before = [part.weight for part in row.blend]
        self.dragging = False
        self.colours = [tuple(drawing.swatch(part.spectrum()).tolist()) for part in row.blend]
        self.names = [part.illuminant for part in row.blend]
        space = type(area.spaces.active)
        self.handle = space.draw_handler_add(self._draw, (context.scene,), "WINDOW", "POST_PIXEL")
        self.space = space
        context.window_manager.modal_handler_add(self)
        context.workspace.status_text_set("Light dial: drag the handle, Enter to keep, Esc to cancel")
        area.tag_redraw()
        return {"RUNNING_MODAL"}

    def modal(self, context, event) -> set[str]:
        self.area.tag_redraw()
        if event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
            self._set(context, self.before)
            return self._end(context, {"CANCELLED"})
        if event.type in {"RET", "NUMPAD_ENTER"} and event.value == "PRESS":
            return self._end(context, {"FINISHED"})
        if event.type == "LEFTMOUSE":
            self.dragging = event.value == "PRESS"
            if self.dragging and not self._near(event):
                return self._end(context, {"FINISHED"})
        if self.dragging and event.type in {"MOUSEMOVE", "LEFTMOUSE"}:
            self._set(context, mixing.weights(self._on_disc(event), len(self.before)).tolist())
        return {"RUNNING_MODAL"}

    def _set(self, context, weights: Sequence[float]) -> None:
        row = self._row(context)
        with mixer.quiet():
            for part, weight in zip(row.blend, weights, strict=True):
                part.weight = weight
        mixer.mix_changed(row, context)

    def _end(self, context, result: set[str]) -> set[str]:
        self.space.draw_handler_remove(self.handle, "WINDOW")
        context.workspace.status_text_set(None)
        self.area.tag_redraw()
        return result

    def _geometry(self):
        scale = bpy.context.preferences.system.ui_scale
        radius = _RADIUS * scale
        return (radius + _MARGIN * scale, radius + _MARGIN * scale), radius, scale

    def _on_disc(self, event) -> tuple[float, float]:
        (x, y), radius, _ = self._geometry()
        return (event.mouse_x - self.region.x - x) / radius, (event.mouse_y - self.region.y - y) / radius

    def _near(self, event) -> bool:
        x, y = self._on_disc(event)
        return max(abs(x), abs(y)) < 1.4

    def _draw(self, scene) -> None:
        if bpy.context.region != self.region:
            return
        weights = [part.weight for part in scene.relume.light_groups[self.group].blend]
        (x, y), radius, scale = self._geometry()
        overlay.disc((x, y), radius * 1.25, (0.12, 0.12, 0.12, 0.8))
        overlay.disc((x, y), radius, (0.24, 0.24, 0.24, 0.9))
        anchors = [(x + radius * a, y + radius * b) for a, b in mixing.anchors(len(weights)).tolist()]
        for place, colour, name in zip(anchors, self.colours, self.names, strict=True):
            overlay.disc(place, 9 * scale, (*colour, 1.0))
            above = 12 if place[1] >= y - 1 else -22
            overlay.text(name, place[0], place[1] + above * scale, scale, centred=True)
        a, b = mixing.handle(weights).tolist()
        overlay.disc((x + radius * a, y + radius * b), 8 * scale, (0.0, 0.0, 0.0, 1.0))
        overlay.disc((x + radius * a, y + radius * b), 6 * scale, (1.0, 1.0, 1.0, 1.0))


def _blend_in(settings) -> int:
    """The number of the light group that the dial is meant for, where none was named; -1 for none."""
    rows, active = settings.light_groups, settings.active_light_group
    blends = [number for number, row in enumerate(rows) if row.source == "BLEND"]
    return active if active in blends else next(iter(blends), -1)


def _picture_area(context):
    """Where the picture is seen: an Image Editor, else a 3D view."""
    areas = {area.type: area for area in context.screen.areas}
    return areas.get("IMAGE_EDITOR") or areas.get("VIEW_3D")


CLASSES = (LightDial,)
