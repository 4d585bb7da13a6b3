"""How far a picture of Relume's is from the render that Blender makes by itself."""

from pathlib import Path

import bpy
import numpy as np

from relume.core.colour import differences
from relume.core.model import upsample
from relume.core.picture import coefficients

WHITE = upsample.rgb_to_xyz().sum(axis=1)


def rgb_render(scene, folder: Path) -> np.ndarray:
    """(height, width, 3) linear picture of the layers that are rendered, without compositing."""
    path = folder / "plain.exr"
    output = scene.render.image_settings
    before = scene.render.filepath, output.media_type, output.file_format, output.color_depth
    compositing, scene.render.use_compositing = scene.render.use_compositing, False
    output.media_type, output.file_format, output.color_depth = "IMAGE", "OPEN_EXR", "32"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True, scene=scene.name)
    scene.render.filepath, output.media_type, output.file_format, output.color_depth = before
    scene.render.use_compositing = compositing
    return coefficients.read_rgb(path)


def delta_E(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """ΔE2000 of two linear Rec.709 pictures, as bright as they are against a white of the picture's mean times five."""
    scale = 0.2 / max(b.mean(), 1e-6)
    to_xyz = upsample.rgb_to_xyz()
    return differences.picture_delta_E(a * scale @ to_xyz.T, b * scale @ to_xyz.T, WHITE)
