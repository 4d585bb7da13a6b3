"""Pictures of illuminants as Blender's icons. They are drawn by `core.drawing` and kept while Blender runs."""

import bpy
import bpy.utils.previews
import numpy as np

from ...core.picture import drawing
from ...core.picture import scatter as scatter_plot

__all__ = ["curves", "dot", "paint", "patch", "register", "scatter", "swatch_and_curve", "unregister"]


_previews = None


def swatch_and_curve(curve: np.ndarray, swatch: np.ndarray) -> int:
    """The icon of an illuminant, of its curve (81,) and swatch (3,): a small picture, and a large plot of the curve.

    0 in a Blender without a window.
    """
    if _previews is None or len(curve) == 0:
        return 0
    key = f"{tuple(round(value, 3) for value in curve)} {tuple(round(value, 3) for value in swatch)}"
    if key not in _previews:
        preview = _previews.new(key)
        small, large = drawing.icon(curve, swatch), drawing.plot(curve)
        preview.icon_size = small.shape[1::-1]
        preview.icon_pixels_float.foreach_set(small.ravel())
        preview.image_size = large.shape[1::-1]
        preview.image_pixels_float.foreach_set(large.ravel())
    return _previews[key].icon_id


def patch(wanted, full, model) -> int:
    """The icon of a patch of the palette, of three sRGB colours (3,). 0 in a Blender without a window."""
    key = "patch " + " ".join(f"{value:.3f}" for color in (wanted, full, model) for value in color)
    return _picture(key, lambda: drawing.patch(wanted, full, model))


def paint(reflectance) -> int:
    """The icon of the colour that a reflectance, a Spectrum, has in daylight. 0 in a Blender without a window."""
    if _previews is None or bpy.app.background:
        return 0
    color = drawing.paint(reflectance)
    return patch(color, color, color)


def dot(level: str) -> int:
    """The icon of a level of `core.expectation`. 0 in a Blender without a window."""
    return _picture(f"dot {level}", lambda: drawing.dot(level))


def curves(lines) -> int:
    """The icon of curves, (values (81,), sRGB (3,)) each. 0 in a Blender without a window."""
    key = "curves " + " ".join(f"{value:.3g}" for values, color in lines for value in (*values, *color))
    return _picture(key, lambda: drawing.lines(lines)) if lines else 0


def scatter(points, marked: str) -> int:
    """The icon of error against run time, of `core.picture.scatter.Point`. 0 in a Blender without a window."""
    key = "scatter " + " ".join(f"{value:.3g}" for point in points for value in point[1:])
    return _picture(key, lambda: scatter_plot.picture(points, marked))


def _picture(key: str, draw) -> int:
    if _previews is None:
        return 0
    if key not in _previews:
        preview, picture = _previews.new(key), draw()
        preview.icon_size = preview.image_size = picture.shape[1::-1]
        preview.icon_pixels_float.foreach_set(picture.ravel())
        preview.image_pixels_float.foreach_set(picture.ravel())
    return _previews[key].icon_id


def register():
    global _previews
    _previews = bpy.utils.previews.new()


def unregister() -> None:
    global _previews
    bpy.utils.previews.remove(_previews)
    _previews = None
