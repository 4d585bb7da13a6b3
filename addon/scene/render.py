"""Rendering the coefficient passes of a scene into a coefficient image, and saving pictures."""

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import bpy
import numpy as np

from ...core import results
from ...core.errors import CoefficientImageError, RenderError, ResultError, UsageError
from ...core.picture import coefficients, noise, recombination
from ...core.picture.coefficients import CoefficientImage
from ...core.picture.mix import Light
from ..host import console
from ..host.blend_file import first_line
from . import follower, setup, surfaces, view_layers

__all__ = ["FORMATS", "RenderError", "Rendered", "check_view", "described", "picture", "render", "save_picture"]


@dataclass(frozen=True)
class Rendered:
    """A coefficient image, and what it took: render seconds, synchronisation seconds and samples of each pass.

    sampled: its light groups as they were sampled, where the scene wants noise of colour taken out of the image.
    guides: what the denoiser may look at in each pass, as `denoise.denoised` takes it; empty if it was not asked for.
    surface: (height, width, p) coefficients of what each pixel sees first, where the scene's passes carry them, and
    materials: {name: (height, width)}, the part of each pixel that is that material.
    """

    image: CoefficientImage
    times: dict[str, dict[str, float]]
    sampled: Mapping[str, np.ndarray]
    guides: tuple[dict[str, np.ndarray], ...] = ()
    surface: np.ndarray | None = None
    materials: dict[str, np.ndarray] | None = None


def render(
    scene, folder: Path, progress: Callable[[int, float], None] | None = None, guides: Sequence[str] | None = None
) -> Rendered:
    """Render the current frame of a scene that is set up. `folder` is for Blender's own file, which is deleted.

    progress(pass, part of it done) is called as the render goes. guides: names of what the denoiser is to have of every
    pass, None where nothing is to be denoised. Only the first of the artist's view layers is read. Raises RenderError.
    """
    if scene.render.use_multiview:
        raise RenderError(f"scene {scene.name!r} renders several views (stereoscopy): switch that off, one is kept")
    follower.settle(scene)
    if not view_layers.pass_layers(scene):
        raise RenderError(f"scene {scene.name!r} is rendered with {scene.render.engine}: spectral passes need Cycles")
    layers = next(iter(view_layers.pass_layers(scene).values()))
    names = [layer.name for layer in layers]
    groups = [row.name for row in scene.relume.lit]
    is_estimated = scene.relume.shares_brightness
    said = described(scene)  # and what is wrong with it, before it takes long
    with results.scratch(folder) as temporary:
        path = temporary.absolute() / "passes.exr"
        wanted = list(dict.fromkeys([*(guides or ()), *(("Albedo", "Normal") if is_estimated else ())]))
        with follower.held(), _Progress(progress), _storing_guides(layers if wanted else ()):
            _render_to(scene, path)
        try:
            seen_by = coefficients.read_guides(path, names, wanted) if wanted else [{} for _ in names]
            channels, alpha = coefficients.read_render(path, scene.relume.model(), names, groups)
            carried = surfaces.carried(scene)
            seen = (surfaces.read(path, scene), surfaces.read_materials(path, scene)) if carried else (None, None)
            times = coefficients.read_render_times(path, names)
        except CoefficientImageError as error:
            # Blender says nothing when it cannot write the whole of a file
            reason = str(error).replace(str(path), path.name)
            raise RenderError(f"{folder}: cannot write the render there; is the disk full? ({reason})") from error
    for layer in layers:
        times.get(layer.name, {})["samples"] = view_layers.samples_of(layer, scene)
    found = () if guides is None else tuple({name: each[name] for name in guides} for each in seen_by)
    estimated = noise.estimated(channels, seen_by) if is_estimated else channels
    return Rendered(replace(said, groups=estimated, alpha=alpha), times, channels, found, *seen)


def described(scene) -> CoefficientImage:
    """What a scene that is set up says about its renders, at its current frame: without groups and pixels.

    Raises RelumeError where the mix cannot be shown.
    """
    chosen = setup.lighting(scene)
    return CoefficientImage(
        model=scene.relume.model(),
        groups={},
        illuminants={group: light.illuminant for group, light in chosen.lights.items()},
        alpha=np.empty((0, 0), np.float32),
        space=chosen.space,
        white_balance=chosen.white_balance,
        white_balance_method=chosen.method,
        view=_view_of(scene),
        gains={group: light.gain for group, light in chosen.lights.items()},
        white=chosen.white,
        observer=chosen.observer,
    )


@contextmanager
def _storing_guides(layers) -> Iterator[None]:
    """While it lasts, these view layers store what the denoiser looks at."""
    before = [layer.cycles.denoising_store_passes for layer in layers]
    for layer in layers:
        layer.cycles.denoising_store_passes = True
    try:
        yield
    finally:
        for layer, stored in zip(layers, before, strict=True):
            layer.cycles.denoising_store_passes = stored


def _render_to(scene, path: Path) -> None:
    """Render all view layers into a multilayer EXR, without the compositor, and put the output settings back."""
    output = scene.render.image_settings
    # In braces Blender's output path names what it fills in
    filepath = str(path).replace("{", "{{").replace("}", "}}")
    render_settings = {"filepath": filepath, "use_compositing": False, "use_sequencer": False}
    render_settings |= {"use_file_extension": False, "use_single_layer": False}
    image_settings = {"media_type": "MULTI_LAYER_IMAGE", "file_format": "OPEN_EXR_MULTILAYER"}
    image_settings |= {"color_depth": "32", "exr_codec": "NONE"}
    before = {name: getattr(scene.render, name) for name in render_settings}
    image_before = {name: getattr(output, name) for name in image_settings}
    if not image_before["exr_codec"]:  # an old file may name a codec that is no more, which nobody could put back
        del image_settings["exr_codec"], image_before["exr_codec"]
    try:
        for target, values in ((scene.render, render_settings), (output, image_settings)):
            for name, value in values.items():
                setattr(target, name, value)
        with console.reports():
            bpy.ops.render.render(write_still=True, scene=scene.name)
    except RuntimeError as error:
        raise RenderError(first_line(error)) from error
    finally:
        for target, values in ((scene.render, before), (output, image_before)):
            for name, value in values.items():
                setattr(target, name, value)


class _Progress:
    """While it is entered, reports how far the render is: Cycles says the sample, and begins at one in every pass."""

    _SAMPLE = re.compile(r"Sample (\d+)/(\d+)")

    def __init__(self, report: Callable[[int, float], None] | None) -> None:
        self.report, self.index, self.sample = report, 0, 0

    def __call__(self, words, _) -> None:
        found = self._SAMPLE.search(words or "")
        if found:
            sample, samples = map(int, found.groups())
            self.index += sample < self.sample
            self.sample = sample
            self.report(self.index, sample / samples)

    def __enter__(self) -> None:
        if self.report:
            bpy.app.handlers.render_stats.append(self)

    def __exit__(self, *_) -> None:
        if self.report:
            bpy.app.handlers.render_stats.remove(self)


def _view_of(scene) -> dict:
    chosen = scene.view_settings
    for name in ("exposure", "gamma"):
        if not math.isfinite(getattr(chosen, name)):
            raise RenderError(f"scene {scene.name!r}: the {name} of its view is {getattr(chosen, name)}, not a number")
    return {
        "display_device": scene.display_settings.display_device,
        "view_transform": chosen.view_transform,
        "look": chosen.look,
        "exposure": chosen.exposure,
        "gamma": chosen.gamma,
    }


def picture(image: CoefficientImage, lights: dict[str, Light], white_balance: float | None = None) -> np.ndarray:
    """(height, width, 3) linear picture with a light for each group; the image's own white balance if none is given."""
    matrices = recombination.recombination_matrices(image.model, image.mix(lights, white_balance))
    return coefficients.recombine(list(image.groups.values()), matrices)


def _show(scene, chosen: Mapping[str, object]) -> None:
    """Have a scene show pictures as `CoefficientImage.view` says. Raises CoefficientImageError."""
    for name, value in {"display_device": "sRGB", "view_transform": "Standard", **chosen}.items():
        try:
            setattr(scene.display_settings if name == "display_device" else scene.view_settings, name, value)
        except TypeError:
            raise CoefficientImageError(
                f"view, {name}: this Blender has no {value!r}; write .exr, which is linear, or start it with the OCIO "
                "configuration of the render"
            ) from None


def check_view(path: Path, image: CoefficientImage) -> None:
    """Raise CoefficientImageError that names the EXR where this Blender cannot show its picture as it was rendered."""
    scene = bpy.data.scenes.new("Relume view")
    try:
        _show(scene, image.view)
    except CoefficientImageError as error:
        raise CoefficientImageError(f"{path}: {error}") from None
    finally:
        bpy.data.scenes.remove(scene)


FORMATS = {".png": ("PNG", "16"), ".tif": ("TIFF", "16"), ".tiff": ("TIFF", "16"), ".exr": ("OPEN_EXR", "32")}


def save_picture(path: Path, rgb: np.ndarray, image: CoefficientImage) -> None:
    """Save a linear picture as Blender would: PNG and TIFF through the scene's view transform, EXR linear.

    The file appears whole or not at all. Raises ResultError when it cannot be written, UsageError for another
    extension, RenderError for a view that this Blender does not have.
    """
    if path.suffix.lower() not in FORMATS:
        raise UsageError(f"{path}: a picture's name ends in {', '.join(FORMATS)}")
    file_format, depth = FORMATS[path.suffix.lower()]
    width, height = image.size
    scene = bpy.data.scenes.new("Relume picture")
    buffer = bpy.data.images.new("Relume picture", width, height, alpha=True, float_buffer=True)
    try:
        buffer.colorspace_settings.name = image.space
        buffer.pixels.foreach_set(coefficients.bottom_up_rgba(rgb, image.alpha))
        settings = scene.render.image_settings
        settings.media_type, settings.file_format, settings.color_depth = "IMAGE", file_format, depth
        settings.color_mode = "RGBA" if (image.alpha < 1.0).any() else "RGB"
        if file_format != "OPEN_EXR":  # which is linear
            _show(scene, image.view)
        scene.render.dither_intensity = 0.0
        with results.replacing(path) as partial:
            try:
                buffer.save_render(str(partial), scene=scene)
                coefficients.read_rgb(partial)  # Blender says nothing when it cannot write the whole of a file
            except (RuntimeError, FileNotFoundError, CoefficientImageError) as error:
                reason = first_line(error).replace(str(partial), path.name)
                raise ResultError(f"{path}: cannot be written; is the disk full? ({reason})") from error
    finally:
        bpy.data.images.remove(buffer)
        bpy.data.scenes.remove(scene)
