"""Rendering the coefficient passes of a scene into a coefficient image, and saving pictures."""

import re
import tempfile
from collections.abc import Callable, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

from ..core import coefficients, view
from ..core.coefficients import CoefficientImage
from ..core.errors import RenderError
from . import passes, setup, surfaces

__all__ = ["FORMATS", "RenderError", "Rendered", "picture", "render", "save_picture"]


@dataclass(frozen=True)
class Rendered:
    """A coefficient image, and what it took: render seconds, synchronisation seconds and samples of each pass.

    guides: what the denoiser may look at in each pass, as `denoise.denoised` takes it; empty if it was not asked for.
    surface: (height, width, p) coefficients of what each pixel sees first, where the scene's passes carry them.
    """

    image: CoefficientImage
    times: dict[str, dict[str, float]]
    guides: tuple[dict[str, np.ndarray], ...] = ()
    surface: np.ndarray | None = None


def render(
    scene, folder: Path, progress: Callable[[int, float], None] | None = None, guides: Sequence[str] | None = None
) -> Rendered:
    """Render the current frame of a scene that is set up. `folder` is for Blender's own file, which is deleted.

    progress(pass, part of it done) is called as the render goes. guides: names of what the denoiser is to have of every
    pass, None where nothing is to be denoised. Only the first of the artist's view layers is read. Raises RenderError.
    """
    layers = next(iter(passes.pass_layers(scene).values()))
    names = [layer.name for layer in layers]
    groups = [group.name for group in scene.relume.light_groups]
    with tempfile.TemporaryDirectory(prefix=".relume-", dir=folder) as temporary:
        path = Path(temporary) / "passes.exr"
        with _Progress(progress), _storing_guides(layers if guides else ()):
            _render_to(scene, path)
        try:
            found = () if guides is None else tuple(coefficients.read_guides(path, names, guides))
            channels, alpha = coefficients.read_render(path, scene.relume.model(), names, groups)
            surface = surfaces.read(path, scene) if surfaces.AOV in layers[0].aovs else None
            times = coefficients.read_render_times(path, names)
        except coefficients.CoefficientImageError as error:
            # Blender says nothing when it cannot write the whole of a file
            raise RenderError(f"{folder}: cannot write the render there; is the disk full? ({error})") from error
    for layer in layers:
        times.get(layer.name, {})["samples"] = passes.samples_of(layer, scene)
    settings = scene.relume
    chosen = setup.lighting(scene)
    lights = dict(zip(groups, chosen["lights"], strict=True))
    return Rendered(
        CoefficientImage(
            model=settings.model(),
            groups=channels,
            illuminants={group: light.illuminant for group, light in lights.items()},
            alpha=alpha,
            space=bpy.data.colorspace.working_space,
            white_balance=settings.white_balance,
            white_balance_method=settings.white_balance_method,
            view=_view_of(scene),
            gains={group: light.gain for group, light in lights.items()},
            white=None if chosen["white"] is None else tuple(map(float, chosen["white"])),
            observer=chosen["observer"],
        ),
        times,
        found,
        surface,
    )


@contextmanager
def _storing_guides(layers):
    """While it lasts, these view layers store what the denoiser looks at."""
    before = [layer.cycles.denoising_store_passes for layer in layers]
    for layer in layers:
        layer.cycles.denoising_store_passes = True
    try:
        yield
    finally:
        for layer, stored in zip(layers, before, strict=True):
            layer.cycles.denoising_store_passes = stored


def _render_to(scene, path: Path):
    """Render all view layers into a multilayer EXR, without the compositor, and put the output settings back."""
    output = scene.render.image_settings
    render_settings = {"filepath": str(path), "use_compositing": False, "use_sequencer": False}
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
        bpy.ops.render.render(write_still=True, scene=scene.name)
    except RuntimeError as error:
        raise RenderError(str(error).strip().removeprefix("Error: ")) from error
    finally:
        for target, values in ((scene.render, before), (output, image_before)):
            for name, value in values.items():
                setattr(target, name, value)


class _Progress:
    """While it is entered, tells how far the render is: Cycles says the sample, and begins at one in every pass."""

    _SAMPLE = re.compile(r"Sample (\d+)/(\d+)")

    def __init__(self, tell: Callable[[int, float], None] | None):
        self.tell, self.index, self.sample = tell, 0, 0

    def __call__(self, words, _):
        found = self._SAMPLE.search(words or "")
        if found:
            sample, samples = map(int, found.groups())
            self.index += sample < self.sample
            self.sample = sample
            self.tell(self.index, sample / samples)

    def __enter__(self):
        if self.tell:
            bpy.app.handlers.render_stats.append(self)

    def __exit__(self, *_):
        if self.tell:
            bpy.app.handlers.render_stats.remove(self)


def _view_of(scene) -> dict:
    chosen = scene.view_settings
    return {
        "display_device": scene.display_settings.display_device,
        "view_transform": chosen.view_transform,
        "look": chosen.look,
        "exposure": chosen.exposure,
        "gamma": chosen.gamma,
    }


def picture(image: CoefficientImage, lights: dict[str, view.Light], white_balance: float | None = None):
    """(height, width, 3) linear picture with a light for each group; the image's own white balance if none is given."""
    matrices = view.recombination_matrices(
        image.model,
        [lights[group] for group in image.groups],
        white_balance=image.white_balance if white_balance is None else white_balance,
        method=image.white_balance_method,
        space=image.space,
        white=image.white,
        observer=image.observer,
    )
    return coefficients.recombine(list(image.groups.values()), matrices)


FORMATS = {".png": ("PNG", "16"), ".tif": ("TIFF", "16"), ".tiff": ("TIFF", "16"), ".exr": ("OPEN_EXR", "32")}


def save_picture(path: Path, rgb, image: CoefficientImage):
    """Save a linear picture as Blender would: PNG and TIFF through the scene's view transform, EXR linear.

    The file appears whole or not at all. Raises OSError when it cannot be written, ValueError for another extension.
    """
    if path.suffix.lower() not in FORMATS:
        raise ValueError(f"{path}: a picture's name ends in {', '.join(FORMATS)}")
    file_format, depth = FORMATS[path.suffix.lower()]
    width, height = image.size
    scene = bpy.data.scenes.new("Relume picture")
    buffer = bpy.data.images.new("Relume picture", width, height, alpha=True, float_buffer=True)
    partial = path.with_name(f".{path.stem}.partial{path.suffix}")
    try:
        buffer.colorspace_settings.name = image.space
        buffer.pixels.foreach_set(coefficients.bottom_up_rgba(rgb, image.alpha))
        settings = scene.render.image_settings
        settings.media_type, settings.file_format, settings.color_depth = "IMAGE", file_format, depth
        settings.color_mode = "RGBA" if (image.alpha < 1.0).any() else "RGB"
        shown = dict(image.view)
        if "display_device" in shown:
            scene.display_settings.display_device = shown.pop("display_device")
        for name, value in {"view_transform": "Standard", **shown}.items():
            setattr(scene.view_settings, name, value)
        scene.render.dither_intensity = 0.0
        buffer.save_render(str(partial), scene=scene)
        coefficients.read_rgb(partial)  # Blender says nothing when it cannot write the whole of a file
        partial.replace(path)
    except (RuntimeError, FileNotFoundError, coefficients.CoefficientImageError) as error:
        reason = str(error).strip().removeprefix("Error: ")
        raise OSError(f"{path}: cannot be written; is the disk full? ({reason})") from error
    finally:
        partial.unlink(missing_ok=True)
        bpy.data.images.remove(buffer)
        bpy.data.scenes.remove(scene)
