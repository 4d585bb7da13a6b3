"""Denoising with Blender's own denoiser, through a compositor of its own."""

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np

from ...core.picture import coefficients, noise
from ...core.picture.coefficients import CoefficientImage

__all__ = ["available", "denoised", "denoised_image", "guides_of", "prefilter_of"]


def available() -> bool:
    """Whether this Blender was built with OpenImageDenoise."""
    import _cycles

    return _cycles.with_openimagedenoise


def guides_of(scene) -> list[str]:
    """Which of "Albedo" and "Normal" the artist lets Cycles' denoiser look at."""
    return {"RGB": [], "RGB_ALBEDO": ["Albedo"]}.get(scene.cycles.denoising_input_passes, ["Albedo", "Normal"])


def prefilter_of(scene) -> str:
    """The artist's choice of how the guides are cleaned, as the compositor's node calls it."""
    return scene.cycles.denoising_prefilter.title()


def denoised_image(image: CoefficientImage, guides: Sequence[Mapping], prefilter: str = "Accurate") -> CoefficientImage:
    """A coefficient image, as it was sampled, without its noise; guides: for each pass as `denoised` takes them."""
    groups = noise.denoised(image.model, image.groups, guides, lambda rgb, seen: denoised(rgb, seen, prefilter))
    return replace(image, groups=groups)


def denoised(rgb: np.ndarray, guides: Mapping | None = None, prefilter: str = "Accurate") -> np.ndarray:
    """(height, width, 3) linear picture without its noise. Blender's current scene is left alone.

    guides: "Albedo" and "Normal" of what the camera sees, (height, width, 3) with noise; they keep edges and textures.
    """
    height, width, _ = rgb.shape
    tree = bpy.data.node_groups.new("Relume denoise", "CompositorNodeTree")
    tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    denoise, output = (tree.nodes.new(kind) for kind in ("CompositorNodeDenoise", "NodeGroupOutput"))
    denoise.inputs["Prefilter"].default_value = prefilter
    images = [_feed(tree, denoise.inputs[name], values) for name, values in {"Image": rgb, **(guides or {})}.items()]
    tree.links.new(denoise.outputs["Image"], output.inputs["Image"])
    scene = bpy.data.scenes.new("Relume denoise")
    scene.compositing_node_group = tree
    settings, output_settings = scene.render, scene.render.image_settings
    settings.resolution_x, settings.resolution_y, settings.resolution_percentage = width, height, 100
    settings.engine, settings.compositor_device, settings.compositor_precision = "CYCLES", "CPU", "FULL"
    output_settings.media_type, output_settings.file_format, output_settings.color_depth = "IMAGE", "OPEN_EXR", "32"
    try:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "denoised.exr"
            settings.filepath = str(path)
            bpy.ops.render.render(write_still=True, scene=scene.name)
            return coefficients.read_rgb(path)
    finally:
        bpy.data.scenes.remove(scene)
        bpy.data.node_groups.remove(tree)
        bpy.data.batch_remove(images)


def _feed(tree, socket, values: np.ndarray):
    """An image of (height, width, 3) values that feeds a socket of a compositor."""
    height, width, _ = values.shape
    image = bpy.data.images.new("Relume noisy", width, height, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"  # values go through unchanged
    image.pixels.foreach_set(coefficients.bottom_up_rgba(values, np.ones((height, width))))
    source = tree.nodes.new("CompositorNodeImage")
    source.image = image
    tree.links.new(source.outputs["Image"], socket)
    return image
