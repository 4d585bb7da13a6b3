"""What windows show: when they are drawn, and colours through the exposure, look and view transform of a scene."""

import tempfile
from pathlib import Path

import bpy
import numpy as np

from ...core.picture import coefficients

__all__ = ["displayed", "redraw", "update", "view_of"]

_VIEW = ("view_transform", "look", "exposure", "gamma", "use_curve_mapping", "use_white_balance")
_WARMTH = ("white_balance_temperature", "white_balance_tint")


def view_of(scene) -> str:
    """What a scene's view is, in words that differ where the view differs; of its curves only that there are some."""
    view = scene.view_settings
    said = [scene.display_settings.display_device, *(getattr(view, name) for name in (*_VIEW, *_WARMTH))]
    return " ".join(map(str, said))


def displayed(scene, rgb: np.ndarray) -> np.ndarray:
    """(..., 3) as displayed, 0..1, of linear colours (..., 3) of the working space.

    Blender tells nobody what its views do: it saves a picture of these colours, which is read again.
    """
    rgb = np.asarray(rgb, dtype=np.float32)
    flat = rgb.reshape(1, -1, 3)
    output = scene.render.image_settings
    wanted = {"media_type": "IMAGE", "file_format": "PNG", "color_mode": "RGB", "color_depth": "16"}
    wanted |= {"color_management": "FOLLOW_SCENE"}
    before = {name: getattr(output, name) for name in wanted}
    dither = scene.render.dither_intensity
    image = bpy.data.images.new("Relume colours", flat.shape[1], 1, alpha=True, float_buffer=True)
    try:
        image.colorspace_settings.name = bpy.data.colorspace.working_space
        image.pixels.foreach_set(coefficients.bottom_up_rgba(flat, np.ones(flat.shape[:2])))
        for name, value in wanted.items():
            setattr(output, name, value)
        scene.render.dither_intensity = 0.0
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "colours.png"
            image.save_render(str(path), scene=scene)
            return coefficients.read_rgb(path)[0].reshape(rgb.shape)
    finally:
        for name, value in before.items():
            setattr(output, name, value)
        scene.render.dither_intensity = dither
        bpy.data.images.remove(image)


def redraw() -> None:
    """Have all windows show what has changed: Blender does not always see that a panel would say something else."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            area.tag_redraw()


def update() -> None:
    """Have Blender evaluate what was changed in the scenes of all windows, and tell its handlers, at once."""
    for window in bpy.context.window_manager.windows:
        window.view_layer.update()
