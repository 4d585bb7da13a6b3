"""The light dial as a moving picture: lightings of one render mixed while a handle goes from one to the next.

[BMD] S. Bergner, T. Moller, M. S. Drew, "A spectral engine for visualization", SFU-CMPT-TR2004-06, section 5.1.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..core.colour import spaces
from ..core.picture import mixing
from ..core.spectra.arrays import Array

if TYPE_CHECKING:
    from PIL.Image import Image as Picture

__all__ = ["animate", "path"]

STEPS, REST = 14, 6  # frames from one light to the next, and at each
MILLISECONDS = 80
RADIUS = 46  # pixels of the dial
CORNER = (184, 150)  # pixels that it may take
DARK, FACE, WHITE = (31, 31, 31), (61, 61, 61), (255, 255, 255)


def path(count: int) -> Array:
    """Where the handle stands in each frame, from light to light and back to the first -> (frames, 2) on the disc."""
    corners = mixing.anchors(count)
    frames: list[Array] = []
    for here, there in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        frames += [here] * REST
        frames += [here + (there - here) * (1 - np.cos(np.pi * step / STEPS)) / 2 for step in range(1, STEPS)]
    return np.array(frames)


def animate(to: Path, lightings: Sequence[tuple[str, Array]], colours: Sequence[Array]) -> None:
    """Write an animated WebP of lightings (name, XYZ (height, width, 3)); colours: sRGB (3,) of their lights, 0..1.

    What is linear in the light is added, as the compositor adds it: no frame is rendered. Raises ImportError without
    Pillow.
    """
    from PIL import Image

    seen = np.stack([xyz @ spaces.xyz_to_rgb().T for _, xyz in lightings])
    names, frames = [name for name, _ in lightings], []
    for place in path(len(lightings)):
        rgb = np.tensordot(mixing.weights(place, len(lightings)), seen, axes=1)
        encoded = np.round(255 * spaces.srgb_encoded(np.clip(rgb, 0, 1))).astype(np.uint8)
        picture = Image.fromarray(encoded).resize(
            (2 * encoded.shape[1], 2 * encoded.shape[0]), Image.Resampling.LANCZOS
        )
        frames.append(_with_dial(picture, place, names, colours))
    frames[0].save(to, save_all=True, append_images=frames[1:], duration=MILLISECONDS, loop=0, quality=80)


def _with_dial(picture: "Picture", place: Array, names: Sequence[str], colours: Sequence[Array]) -> "Picture":
    """A picture with the dial in its lower right corner, as in the paper; the handle at `place` of the unit disc."""
    from PIL import Image, ImageDraw, ImageFont

    fine = 4  # drawn larger and made smaller: Pillow's own circles have steps
    corner = (picture.width - CORNER[0], picture.height - CORNER[1])
    part = picture.crop((*corner, picture.width, picture.height))
    large = part.resize((fine * part.width, fine * part.height))
    draw, centre = ImageDraw.Draw(large), np.array(CORNER) / 2

    def disc(at: Array, radius: float, colour: tuple[int, ...]) -> None:
        draw.ellipse([*(fine * (at - radius)), *(fine * (at + radius))], fill=colour)

    disc(centre, RADIUS * 1.15, DARK)
    disc(centre, RADIUS, FACE)
    font = ImageFont.load_default(fine * 12)
    for anchor, name, colour in zip(mixing.anchors(len(names)) * (1, -1), names, colours, strict=True):
        at = centre + RADIUS * anchor
        disc(at, 6, tuple(int(round(255 * float(part))) for part in colour))
        away = (0, -13 if anchor[1] < 0.5 else 15)
        draw.text(tuple(fine * (at + away)), name, WHITE, font, anchor="mm", stroke_width=fine, stroke_fill=DARK)
    handle = centre + RADIUS * place * (1, -1)
    disc(handle, 6, (0, 0, 0))
    disc(handle, 4.5, WHITE)
    picture.paste(large.resize(part.size, Image.Resampling.LANCZOS), corner)
    return picture
