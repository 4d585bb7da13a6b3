"""Drawing over a region of the window: discs, rectangles, curves and words, in pixels."""

from collections.abc import Sequence

import numpy as np

from ...core.picture import drawing

__all__ = ["disc", "line", "rectangle", "spectrum", "text"]

_DARK = (0.12, 0.12, 0.12, 0.85)
_WHITE = (1.0, 1.0, 1.0, 1.0)


def _draw(kind: str, places: Sequence, colour: tuple[float, ...], indices: Sequence | None = None) -> None:
    import gpu
    from gpu_extras.batch import batch_for_shader

    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    batch = batch_for_shader(shader, kind, {"pos": places}, indices=indices)
    gpu.state.blend_set("ALPHA")
    shader.uniform_float("color", colour)
    batch.draw(shader)
    gpu.state.blend_set("NONE")


def disc(centre: tuple[float, float], radius: float, colour: tuple[float, ...]) -> None:
    """A filled disc."""
    places = drawing.circle(48) * radius + centre
    _draw("TRIS", places.tolist(), colour, [(0, i, i + 1) for i in range(1, 47)])


def rectangle(left: float, bottom: float, width: float, height: float, colour: tuple[float, ...] = _DARK) -> None:
    """A filled rectangle, dark unless a colour is given."""
    right, top = left + width, bottom + height
    places = [(left, bottom), (right, bottom), (right, top), (left, top)]
    _draw("TRIS", places, colour, [(0, 1, 2), (0, 2, 3)])


def spectrum(values: Sequence[float], left: float, bottom: float, width: float, height: float) -> None:
    """The area under a curve of 81 values, in the colours of its light."""
    import gpu
    from gpu_extras.batch import batch_for_shader

    places, colours = drawing.ribbon(values)
    places = places * np.array([width, height]) + np.array([left, bottom])
    shader = gpu.shader.from_builtin("SMOOTH_COLOR")
    batch = batch_for_shader(shader, "TRI_STRIP", {"pos": places.tolist(), "color": colours.tolist()})
    batch.draw(shader)


def line(values: Sequence[float], left: float, bottom: float, width: float, height: float, colour=_WHITE) -> None:
    """A curve of 81 values, white unless a colour is given."""
    places, _ = drawing.ribbon(values)
    _draw("LINE_STRIP", (places[1::2] * np.array([width, height]) + np.array([left, bottom])).tolist(), colour)


def text(words: str, x: float, y: float, scale: float, centred: bool = False) -> None:
    """Words in white, from `x` or around it."""
    import blf

    blf.size(0, 11 * scale)
    blf.color(0, *_WHITE)
    width, _ = blf.dimensions(0, words)
    blf.position(0, x - width / 2 if centred else x, y, 0)
    blf.draw(0, words)
