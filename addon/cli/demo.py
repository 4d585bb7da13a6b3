"""`relume demo`: the test room rendered once, relit many times, and held against plain RGB and the reference."""

import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...core import results
from ...core.colour import differences, spaces
from ...core.model import bases
from ...core.model.factor_model import FactorModel
from ...core.picture import coefficients
from ...core.picture.mix import Light
from ...core.spectra import library
from ...studies import figures
from ..host import console, denoising
from ..host.blend_file import open_scene
from ..scene import render, render_settings, setup
from ..store import properties

__all__ = ["run"]

_ROOM = Path(__file__).parents[2] / "assets" / "room.blend"
_RESOLUTION = (320, 240)
_SAMPLES = 24  # per pixel in every pass

# What shines in the two lamps; None is a lamp that is off. The room is rendered for the first three.
_LIGHTINGS = {
    "tungsten": {"tungsten": "A", "fluorescent": None},
    "fluorescent": {"tungsten": None, "fluorescent": "FL2"},
    "both": {"tungsten": "A", "fluorescent": "FL2"},
    "D65": {"tungsten": "D65", "fluorescent": "D65"},
    "sodium": {"tungsten": "Sodium (low pressure)", "fluorescent": "Sodium (low pressure)"},
    "LED": {"tungsten": "LED-B1", "fluorescent": "LED-RGB1"},
}


@dataclass(frozen=True)
class _Take:
    """One render of the room: its coefficient image and the seconds that it took."""

    image: coefficients.CoefficientImage
    seconds: float

    def lights(self, lighting: str) -> dict[str, Light]:
        chosen = _LIGHTINGS[lighting]
        return {
            group: Light(library.illuminant(chosen[group] or "E"), 1.0 if chosen[group] else 0.0)
            for group in self.image.groups
        }

    def rgb(self, lighting: str) -> np.ndarray:
        return render.picture(self.image, self.lights(lighting), 0.0)


def _take(scene, folder: Path, model: FactorModel, words: str) -> _Take:
    setup.set_up(scene, model)
    progress = console.Progress(model.passes, words)
    began = time.perf_counter()
    try:
        image = render.render(scene, folder, progress).image
    finally:
        progress.done()
    return _Take(image, time.perf_counter() - began)


def run(folder: Path) -> None:
    """Render the room as plain RGB, with nine channels and as the reference; write pictures and print a table."""
    with results.folder(folder):
        scene = open_scene(_ROOM)
        scene.render.resolution_x, scene.render.resolution_y = _RESOLUTION
        scene.cycles.samples = _SAMPLES
        render_settings.compare(scene)
        console.say(
            "the test room, rendered three times: as Blender does, with nine channels, and in 36 bands to compare"
        )
        plain = _take(scene, folder, bases.rgb(), "plain RGB")
        nine = _take(scene, folder, properties.model_for("9"), "Relume, 9 channels")
        reference = _take(scene, folder, properties.model_for("reference"), "reference")
        console.say(f"the light chosen, {len(_LIGHTINGS)} times, without rendering")
        errors = _compare(plain, nine, reference)
        with results.together():
            written = _save(folder, nine) + _draw(folder, plain, nine, reference, errors)
    _print_table(plain, nine, reference, errors)
    for path in written:
        console.wrote(path)


def _save(folder: Path, nine: _Take) -> list[Path]:
    written = [folder / "room.exr"]
    coefficients.write(written[0], nine.image, nine.rgb("both"))
    for lighting in _LIGHTINGS:
        written.append(folder / f"room_{lighting}.png")
        render.save_picture(written[-1], _shown(nine, lighting), nine.image)
    return written


def _compare(plain: _Take, nine: _Take, reference: _Take) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """{lighting: ΔE2000 of plain RGB and of nine channels to the reference}, (height, width) each."""
    to_xyz = np.linalg.inv(spaces.xyz_to_rgb(reference.image.space))
    white = to_xyz.sum(axis=1)  # of the display: the pictures are shown without white balance
    found = {}
    for lighting in _LIGHTINGS:
        plain_xyz, nine_xyz, xyz = (take.rgb(lighting) @ to_xyz.T for take in (plain, nine, reference))
        found[lighting] = tuple(differences.picture_delta_E(other, xyz, white) for other in (plain_xyz, nine_xyz))
    return found


def _shown(take: _Take, lighting: str) -> np.ndarray:
    """The picture to look at: without noise where this Blender has a denoiser. Comparisons are made of `rgb`."""
    return denoising.denoised(take.rgb(lighting)) if denoising.available() else take.rgb(lighting)


def _draw(folder: Path, plain: _Take, nine: _Take, reference: _Take, errors: dict[str, tuple]) -> list[Path]:
    written = []
    for lighting in _LIGHTINGS:
        row = [("Blender RGB", plain), ("Relume, 9 channels", nine), ("Reference, 36 bands", reference)]
        written.append(folder / f"side_by_side_{lighting}.png")
        with results.replacing(written[-1]) as partial:
            figures.picture_row(partial, [(title, spaces.srgb_encoded(_shown(take, lighting))) for title, take in row])
    maps = []
    for lighting in ("both", "D65", "sodium"):
        plain_map, nine_map = errors[lighting]
        maps += [(f"Blender RGB, {lighting}", plain_map), (f"Relume, 9 channels, {lighting}", nine_map)]
    written.append(folder / "delta_e.png")
    with results.replacing(written[-1]) as partial:
        figures.delta_e_maps(partial, maps)
    return written


def _print_table(plain: _Take, nine: _Take, reference: _Take, errors: dict[str, tuple]) -> None:
    print(f"\n{'ΔE2000 to the reference':<26}{'Blender RGB':>18}{'Relume, 9 channels':>24}")
    print(f"{'lighting':<26}{'median':>9}{'p98':>9}{'median':>15}{'p98':>9}")
    for lighting, maps in errors.items():
        (a, b), (c, d) = ((s["median"], s["p98"]) for s in map(differences.statistics, maps))
        print(f"{lighting:<26}{a:>9.2f}{b:>9.2f}{c:>15.2f}{d:>9.2f}")
    print(f"{'seconds':<26}{plain.seconds:>18.1f}{nine.seconds:>24.1f}   (reference {reference.seconds:.1f})")
    print(f"{_SAMPLES} samples a pixel in every pass, one noise for all; white balance none\n")
