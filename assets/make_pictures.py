"""Render the pictures that the documentation shows: `python -m relume.assets.make_pictures [FOLDER [NAME ...]]`."""

import sys
import tempfile
from pathlib import Path

import bpy

from ..addon.cli.web import shown
from ..addon.graph import glass
from ..addon.host import denoising
from ..addon.host.console import Progress
from ..addon.scene import render, setup
from ..core import palette
from ..core.colour import spaces
from ..core.model import bases
from ..core.picture.mix import Light
from ..core.spectra import library
from ..core.web import page
from ..studies import figures
from . import make_room, prism, spheres

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
    """The room as a page of `relume web`."""
    bpy.ops.wm.open_mainfile(filepath=str(make_room.PATH), load_ui=False)
    scene = bpy.context.scene
    scene.render.resolution_percentage = 150
    _page(scene, path, "The test room", _SAMPLES // 6)


def _spheres_page(path: Path):
    """Five paints under the sun and the sky."""
    scene = spheres.build([library.reflectance(name) for name in spheres.PAINTS])
    scene.render.resolution_x, scene.render.resolution_y = 720, 360
    _page(scene, path, "Five paints under sun and sky")


def _palette_page(path: Path):
    """Three paints that a palette designed: one grey in daylight, three colours under tungsten."""
    designed = palette.create(palette.read(Path(__file__).with_name("palettes") / "three_metamers.toml"))
    scene = spheres.build([entry.spectrum for entry in designed.palette.reflectances], varnished=-1)
    scene.render.resolution_x, scene.render.resolution_y = 720, 360
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    _page(scene, path, "One grey in daylight")


def _page(scene, path: Path, title: str, samples: int = _SAMPLES // 2):
    """A page of `relume web` of a scene, its passes denoised."""
    scene.view_settings.view_transform = "Standard"
    scene.cycles.samples = samples
    setup.set_up(scene, bases.fitted(9))
    with tempfile.TemporaryDirectory() as temporary:
        guides = denoising.guides_of(scene)
        rendered = render.render(scene, Path(temporary), Progress(scene.relume.model().passes), guides)
    image = denoising.denoised_image(rendered.image, rendered.guides, denoising.prefilter_of(scene))
    page.write(path, [page.Picture(path.stem, {1: lambda: image})], title=title, show=shown)


def _rendered(scene):
    with tempfile.TemporaryDirectory() as temporary:
        return render.render(scene, Path(temporary), Progress(scene.relume.model().passes)).image


_MADE = {
    "room.png": _room,
    "prism.png": _prism,
    "room.html": _room_page,
    "spheres.html": _spheres_page,
    "palette.html": _palette_page,
}


def main(arguments: list[str] | None = None):
    """Render all of them, or those named, into a folder, docs/ by default."""
    from .. import register

    register()
    arguments = arguments or sys.argv[1:] or ["docs"]
    folder = Path(arguments[0])
    for name in arguments[1:] or _MADE:
        _MADE[name](folder / name)
        print(folder / name)


if __name__ == "__main__":
    main()
