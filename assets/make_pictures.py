"""Render the pictures that the documentation shows: `python -m relume.assets.make_pictures [FOLDER]`."""

import sys
import tempfile
from pathlib import Path

import bpy

from ..addon import denoise, render, setup
from ..addon.jobs import Progress
from ..core import bases, figures, library, view
from . import make_room

__all__ = ["main"]

_SAMPLES = 900  # in all passes together
_LIGHTS = {
    "daylight (D65)": ("D65", "D65"),
    "tungsten left, fluorescent right": ("A", "FL2"),
    "low-pressure sodium": ("Sodium (low pressure)", "Sodium (low pressure)"),
}


def main(arguments: list[str] | None = None):
    """One render of the room, relit three times."""
    from .. import register

    register()
    folder = Path((arguments or sys.argv[1:] or ["docs"])[0])
    bpy.ops.wm.open_mainfile(filepath=str(make_room.PATH), load_ui=False)
    scene = bpy.context.scene
    scene.cycles.samples = _SAMPLES
    setup.set_up(scene, bases.fitted(9))
    with tempfile.TemporaryDirectory() as temporary:
        image = render.render(scene, Path(temporary), Progress(3)).image
    pictures = []
    for title, names in _LIGHTS.items():
        lights = {group: view.Light(library.illuminant(n)) for group, n in zip(image.groups, names, strict=True)}
        pictures.append((title, view.srgb_encoded(denoise.denoised(render.picture(image, lights)))))
    path = folder / "room.png"
    figures.picture_row(path, pictures)
    print(path)


if __name__ == "__main__":
    main()
