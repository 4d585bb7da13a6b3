"""Render the pictures that the documentation shows: `python -m relume.assets.make_pictures [FOLDER]`."""

import sys
import tempfile
from pathlib import Path

import bpy

from ..addon.cli.web import shown
from ..addon.graph import glass
from ..addon.host import denoising
from ..addon.host.console import Progress
from ..addon.scene import render, setup
from ..core.colour import spaces
from ..core.model import bases
from ..core.picture.mix import Light
from ..core.spectra import library
from ..core.web import page
from ..studies import figures
from . import make_room, prism

__all__ = ["main"]

_SAMPLES = 900  # in all passes together
_LIGHTS = {
    "daylight (D65)": ("D65", "D65"),
    "tungsten left, fluorescent right": ("A", "FL2"),
    "low-pressure sodium": ("Sodium (low pressure)", "Sodium (low pressure)"),
}
_PRISMS = {
    "9 channels": bases.fitted(9),
    "15 channels": bases.fitted(15),
    "81 wavelengths": bases.bands(81),
}


def _room(path: Path):
    """One render of the room, relit three times."""
    bpy.ops.wm.open_mainfile(filepath=str(make_room.PATH), load_ui=False)
    scene = bpy.context.scene
    scene.cycles.samples = _SAMPLES
    setup.set_up(scene, bases.fitted(9))
    image = _rendered(scene)
    pictures = []
    for title, names in _LIGHTS.items():
        lights = {group: Light(library.illuminant(n)) for group, n in zip(image.groups, names, strict=True)}
        pictures.append((title, spaces.srgb_encoded(denoising.denoised(render.picture(image, lights)))))
    figures.picture_row(path, pictures)


def _prism(path: Path):
    """A white line seen through a prism of flint glass, and every wavelength apart."""
    pictures = []
    for title, model in _PRISMS.items():
        scene, node = prism.build(320, 160)
        scene.cycles.samples = _SAMPLES
        glass.replace(node, library.glass("SF10"))
        setup.set_up(scene, model)
        image = _rendered(scene)
        lights = {group: Light(library.illuminant("D65")) for group in image.groups}
        pictures.append((title, spaces.srgb_encoded(denoising.denoised(render.picture(image, lights)))))
    figures.picture_row(path, pictures)


def _room_page(path: Path):
    """The room as a page of `relume web`, its passes denoised."""
    bpy.ops.wm.open_mainfile(filepath=str(make_room.PATH), load_ui=False)
    scene = bpy.context.scene
    scene.cycles.samples, scene.render.resolution_percentage = _SAMPLES // 2, 150
    setup.set_up(scene, bases.fitted(9))
    with tempfile.TemporaryDirectory() as temporary:
        guides = denoising.guides_of(scene)
        rendered = render.render(scene, Path(temporary), Progress(scene.relume.model().passes), guides)
    image = denoising.denoised_image(rendered.image, rendered.guides, denoising.prefilter_of(scene))
    page.write(path, [page.Picture("room", {1: lambda: image})], title="The test room", show=shown)


def _rendered(scene):
    with tempfile.TemporaryDirectory() as temporary:
        return render.render(scene, Path(temporary), Progress(scene.relume.model().passes)).image


def main(arguments: list[str] | None = None):
    """Render all of them into a folder, docs/ by default."""
    from .. import register

    register()
    folder = Path((arguments or sys.argv[1:] or ["docs"])[0])
    for make, name in ((_room, "room.png"), (_prism, "prism.png"), (_room_page, "room.html")):
        make(folder / name)
        print(folder / name)


if __name__ == "__main__":
    main()
