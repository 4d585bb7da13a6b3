"""Denoising a finished picture with Blender's own denoiser, through a compositor of its own."""

import tempfile
from pathlib import Path

import bpy
import numpy as np

from ..core import coefficients

__all__ = ["available", "denoised"]


def available() -> bool:
    """Whether this Blender was built with OpenImageDenoise."""
    import _cycles

    return _cycles.with_openimagedenoise


def denoised(rgb: np.ndarray) -> np.ndarray:
    """(height, width, 3) linear picture without its noise. Blender's current scene is left alone."""
    height, width, _ = rgb.shape
    image = bpy.data.images.new("Relume noisy", width, height, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"  # values go through unchanged
    image.pixels.foreach_set(coefficients.bottom_up_rgba(rgb, np.ones((height, width))))
    tree = bpy.data.node_groups.new("Relume denoise", "CompositorNodeTree")
    tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    source, denoise, output = (
        tree.nodes.new(kind) for kind in ("CompositorNodeImage", "CompositorNodeDenoise", "NodeGroupOutput")
    )
    source.image = image
    tree.links.new(source.outputs["Image"], denoise.inputs["Image"])
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
        bpy.data.images.remove(image)
