"""Pixels of the picture in the Image Editor: the spectrum under the cursor, and a spot that becomes white."""

import json
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from bpy.types import Area, Operator

from ...core.errors import RelumeError
from ...core.picture import coefficients, inspection
from ...core.picture.coefficients import CoefficientImageError
from ..scene import surfaces, view_layers
from ..store import mixes
from . import overlay, palette_assign
from .mixer_operators import NeedsSetUp

__all__ = ["CLASSES", "Picking", "Surfaces", "coefficients_of", "saved_render", "seen_by"]

_SURFACE = (1.0, 0.75, 0.2, 1.0)  # colour of the curve of what the surface reflects


def coefficients_of(context) -> dict[str, np.ndarray]:
    """{light group: (height, width, p)} of what an Image Editor of this context shows. Raises CoefficientImageError."""
    if context.scene.relume.exr:
        from ..scene import exr

        return exr.read_current(context.scene).groups
    with saved_render(context) as path:
        return _groups_in(path, context.scene)


def _groups_in(path: Path, scene) -> dict[str, np.ndarray]:
    layers = [layer.name for layer in next(iter(view_layers.pass_layers(scene).values()))]
    groups = [row.name for row in scene.relume.lit]
    return coefficients.read_render(path, scene.relume.model(), layers, groups)[0]


@dataclass(frozen=True)
class Surfaces:
    """What each pixel sees first. surface: (height, width, p) coefficients. materials: {name: (height, width) part}."""

    surface: np.ndarray
    materials: dict[str, np.ndarray]

    def at(self, x: int, y: int) -> tuple[str, list[float]]:
        """The material that has most of a pixel, "" for none, and the coefficients there."""
        parts = {name: float(part[y, x]) for name, part in self.materials.items()}
        name = max(parts, key=parts.__getitem__, default="")
        return (name if parts.get(name, 0.0) > 0.0 else ""), self.surface[y, x].tolist()


def seen_by(context) -> tuple[dict[str, np.ndarray], Surfaces | None]:
    """What `coefficients_of` returns, and the Surfaces of the same render, None where it carried none."""
    if context.scene.relume.exr:
        return coefficients_of(context), None
    with saved_render(context) as path:
        groups = _groups_in(path, context.scene)
        try:
            found = Surfaces(surfaces.read(path, context.scene), surfaces.read_materials(path, context.scene))
        except CoefficientImageError:
            found = None
        return groups, found


@contextmanager
def saved_render(context) -> Iterator[Path]:
    """The render that the Image Editor of this context shows, as a temporary file.

    Blender gives no other way to its passes. Raises CoefficientImageError.
    """
    settings = context.scene.render.image_settings
    wanted = {"media_type": "MULTI_LAYER_IMAGE", "file_format": "OPEN_EXR_MULTILAYER", "color_depth": "32"}
    before = {name: getattr(settings, name) for name in wanted}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "render.exr"
        try:
            for name, value in wanted.items():
                setattr(settings, name, value)
            bpy.ops.image.save_as(filepath=str(path), copy=True, check_existing=False)
        except RuntimeError as error:
            raise CoefficientImageError(f"nothing has been rendered yet ({str(error).strip()})") from error
        finally:
            for name, value in before.items():
                setattr(settings, name, value)
        yield path


def picture_editor(context) -> Area | None:
    """An Image Editor of this window that shows a render."""
    for area in context.screen.areas if context.screen else ():
        image = area.spaces.active.image if area.type == "IMAGE_EDITOR" else None
        if image is not None and image.type == "RENDER_RESULT":
            return area
    return None


class Picking(NeedsSetUp):
    """A modal operator in the Image Editor that knows the coefficients under the cursor."""

    bl_options = {"REGISTER", "UNDO", "BLOCKING"}

    @classmethod
    def poll(cls, context) -> bool:
        if not super().poll(context):
            return False
        if picture_editor(context) is None:
            cls.poll_message_set("no Image Editor in this window shows a render")
            return False
        return True

    def invoke(self, context, event) -> set[str]:
        self.area = picture_editor(context)
        self.region = next(region for region in self.area.regions if region.type == "WINDOW")
        try:
            with context.temp_override(area=self.area, region=self.region):
                self.images, self.surfaces = seen_by(context)
            self.begin(context)
        except (RelumeError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        context.window_manager.modal_handler_add(self)
        context.window.cursor_modal_set("EYEDROPPER")
        return {"RUNNING_MODAL"}

    def begin(self, context) -> None:
        """What there is to do before the first event."""

    def pixel(self, event) -> list[list[float]] | None:
        """(groups, p) coefficients under the cursor, None beside the picture."""
        place = self.place(event)
        return place and [image[place[1], place[0]].tolist() for image in self.images.values()]

    def place(self, event) -> tuple[int, int] | None:
        """Column and row of the pixel under the cursor, None beside the picture."""
        u, v = self.region.view2d.region_to_view(event.mouse_x - self.region.x, event.mouse_y - self.region.y)
        height, width, _ = next(iter(self.images.values())).shape
        x, y = int(u * width // 1), int((1.0 - v) * height // 1)
        return (x, y) if 0 <= x < width and 0 <= y < height else None

    def end(self, context, result: set[str]) -> set[str]:
        context.window.cursor_modal_restore()
        self.area.tag_redraw()
        return result


class PickWhite(Picking, Operator):
    """Click a spot of the picture: it becomes white, whatever the light is changed to"""

    bl_idname = "relume.pick_white"
    bl_label = "Pick White"

    def modal(self, context, event) -> set[str]:
        if event.type in {"ESC", "RIGHTMOUSE"}:
            return self.end(context, {"CANCELLED"})
        if event.type == "LEFTMOUSE" and event.value == "PRESS":
            found = self.pixel(event)
            if found is None:
                return self.end(context, {"CANCELLED"})
            settings = context.scene.relume
            settings.white_pixel = json.dumps(dict(zip(self.images, found, strict=True)))
            settings.white_source = "PIXEL"
            settings.white_balance = settings.white_balance or 1.0
            return self.end(context, {"FINISHED"})
        return {"RUNNING_MODAL"}


class InspectPixels(Picking, Operator):
    """Show the spectrum under the cursor. Click a second spot to compare with; Esc ends"""

    bl_idname = "relume.inspect"
    bl_label = "Inspect Pixels"
    bl_options = {"REGISTER", "BLOCKING"}

    def begin(self, context) -> None:
        self.shown = self.pinned = self.reflected = None
        self.words = []
        settings = context.scene.relume
        self.model, self.mix = settings.model(), mixes.of(settings)
        self.space = type(self.area.spaces.active)
        self.handle = self.space.draw_handler_add(self._draw, (), "WINDOW", "POST_PIXEL")
        context.workspace.status_text_set("Spectrum under the cursor: click to compare with a spot, Esc to end")

    def modal(self, context, event) -> set[str]:
        if event.type in {"ESC", "RIGHTMOUSE"}:
            self.space.draw_handler_remove(self.handle, "WINDOW")
            context.workspace.status_text_set(None)
            return self.end(context, {"FINISHED"})
        if event.type in {"MOUSEMOVE", "LEFTMOUSE"}:
            found = self.pixel(event)
            self.shown = found and inspection.inspect(self.model, self.mix, found)
            self.material, self.reflected = self._surface(event)
            if event.type == "LEFTMOUSE" and event.value == "PRESS":
                self.pinned = self.shown
            self.words = self._words()
            self.area.tag_redraw()
        return {"RUNNING_MODAL"}

    def _surface(self, event) -> tuple:
        """Name of the material under the cursor and its spectrum (81,), None where the render carries no surfaces."""
        place = self.place(event)
        if self.surfaces is None or place is None:
            return "", None
        name, carried = self.surfaces.at(*place)
        if not any(carried):
            return name, None
        material = bpy.data.materials.get(name)
        known = (
            palette_assign.reflectance_of(material) if material and palette_assign.takes_spectrum(material) else None
        )
        return name, inspection.reflectance(self.model, carried, known)

    def _words(self) -> list[str]:
        if self.shown is None:
            return ["beside the picture"]
        words = ["XYZ  " + "  ".join(f"{value:.4f}" for value in self.shown.xyz)]
        if self.material:
            words.append(f"{self.material}: " + inspection.range_of(self.reflected))
        if self.pinned is not None:
            apart = inspection.difference(self.model, self.mix, self.shown, self.pinned)
            words.append(f"ΔE2000 to the clicked spot  {apart:.2f}")
        return words

    def _draw(self) -> None:
        if bpy.context.region != self.region or self.shown is None:
            return

        scale = bpy.context.preferences.system.ui_scale
        left, bottom, width, height = 20 * scale, 20 * scale, 300 * scale, 110 * scale
        overlay.rectangle(left - 8 * scale, bottom - 8 * scale, width + 16 * scale, height + 78 * scale)
        overlay.spectrum(self.shown.spectrum, left, bottom + 16 * scale, width, height)
        if self.pinned is not None:
            overlay.line(self.pinned.spectrum, left, bottom + 16 * scale, width, height)
        if self.reflected is not None:
            # Of what the surface reflects, 1 is the top
            overlay.line(np.clip(self.reflected, 0.0, 1.0), left, bottom + 16 * scale, width, height, _SURFACE)
        overlay.text("380 nm", left, bottom, scale)
        overlay.text("780 nm", left + width - 44 * scale, bottom, scale)
        for number, words in enumerate(reversed(self.words)):
            overlay.text(words, left, bottom + height + (22 + 16 * number) * scale, scale)


CLASSES = (PickWhite, InspectPixels)
