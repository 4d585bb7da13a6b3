"""Render the pictures that the documentation shows: `python -m relume.assets.make_pictures [FOLDER [NAME ...]]`."""

import sys
import tempfile
from functools import cache
from pathlib import Path

import bpy
import numpy as np
from PIL import Image

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
from . import library as library_assets
from . import make_room, prism, spheres, still_life

__all__ = ["main"]

_SAMPLES = 900  # in all passes together
_GAP = 8  # pixels between pictures
_ASSET = 72  # pixels of a preview
_PAGE_SIZE = 1200
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


@cache
def _still_life_image():
    """The still life as coefficients, denoised."""
    scene = still_life.build()
    setup.set_up(scene, bases.fitted(9))
    guides = denoising.guides_of(scene)
    with tempfile.TemporaryDirectory() as temporary:
        rendered = render.render(scene, Path(temporary), Progress(scene.relume.model().passes), guides)
    return denoising.denoised_image(rendered.image, rendered.guides, denoising.prefilter_of(scene))


def _still_life(path: Path):
    """The still life large in the first of its lights, and below it in the others."""
    image = _still_life_image()
    mixes = {title: mix() for title, mix in still_life.LIGHTS.items()}
    pictures = [shown(render.picture(image, {g: mix[g] for g in image.groups}, 0.0), image) for mix in mixes.values()]
    first, *others = [Image.fromarray((np.clip(picture, 0, 1) * 255 + 0.5).astype(np.uint8)) for picture in pictures]
    width = (first.width - _GAP * (len(others) - 1)) // len(others)
    others = [other.resize((width, width * first.height // first.width), Image.Resampling.LANCZOS) for other in others]
    sheet = Image.new("RGB", (first.width, first.height + _GAP + others[0].height), "white")
    sheet.paste(first, (0, 0))
    for k, other in enumerate(others):
        sheet.paste(other, (k * (width + _GAP), first.height + _GAP))
    sheet.save(path, quality=90)


def _still_life_page(path: Path):
    image = _still_life_image()
    picture = page.Picture("still life", {1: lambda: image})
    page.write(path, [picture], title="A still life", size=_PAGE_SIZE, quality=1.5, show=shown)


def _assets(path: Path):
    """The previews of the asset library, in the order of its catalogues."""
    names = [asset.thing.name for asset in library_assets.build()]
    previews = library_assets.previews_in(library_assets.PATH)
    size, columns = _ASSET, 17
    sheet = Image.new("RGB", (columns * size, -(-len(names) // columns) * size), "#303030")
    for number, name in enumerate(names):
        cell = Image.fromarray((np.clip(previews[name], 0, 1) * 255 + 0.5).astype(np.uint8)).resize((size, size))
        sheet.paste(cell, (number % columns * size, number // columns * size), cell)
    sheet.save(path, quality=88)


def _rendered(scene):
    with tempfile.TemporaryDirectory() as temporary:
        return render.render(scene, Path(temporary), Progress(scene.relume.model().passes)).image


_MADE = {
    "room.png": _room,
    "prism.png": _prism,
    "room.html": _room_page,
    "spheres.html": _spheres_page,
    "palette.html": _palette_page,
    "assets.jpg": _assets,
    "still_life.jpg": _still_life,
    "still_life.html": _still_life_page,
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
