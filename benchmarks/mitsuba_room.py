"""The room in an independent spectral renderer: Mitsuba 3 (`scalar_spectral`) against Cycles and the reference model.

`python -m relume.benchmarks.mitsuba_room [--samples N] [--percent P] [--out DIR]`

Both sides start from the data of `assets.room`: corners, spheres, lamps, camera, measured spectra. Mitsuba renders each
lamp by itself, over 380 to 780 nm with the CIE 1931 observer; no Russian roulette, as many bounces, box filters. Lamps
are given the radiance of Blender's watts, W / (pi area), scaled as Relume scales illuminants: a perfect white keeps its
luminance. Nothing is fitted: the ratio of the two pictures' luminance is printed, not divided out.
"""

import argparse
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..assets import room
from ..core.colour import differences, spaces
from ..core.model import bases
from ..core.picture import recombination
from ..core.picture.mix import Light, Mix
from ..core.spectra import library
from ..core.spectra.spectrum import WAVELENGTHS, Spectrum
from ..studies import figures
from . import room_accuracy

BLOCK = 4  # pixels averaged in each direction, against noise
LIGHTING = {lamp.name: lamp.illuminant for lamp in room.LAMPS}


def _spectrum(wavelengths, values) -> dict:
    words = (", ".join(f"{x:.9g}" for x in column) for column in (wavelengths, values))
    return dict(zip(("wavelengths", "values"), words, strict=True)) | {"type": "irregular"}


def _measured(spectrum: Spectrum) -> dict:
    return _spectrum(WAVELENGTHS, spectrum.sampled())


def _emitted(lamp: room.Lamp) -> dict:
    """Spectral radiance of a lamp whose integral with the y-bar of the observer is Blender's radiance."""
    power = library.illuminant(lamp.illuminant).sampled()
    density = power / (power @ library.observer()[:, 1])
    return _spectrum(WAVELENGTHS, density * lamp.watts / (np.pi * lamp.side**2))


def _bsdf(sphere: room.Sphere) -> dict:
    if sphere.material == "conductor":
        n, k = library.conductor(sphere.spectrum)
        return {"type": "conductor", "eta": _measured(n), "k": _measured(k)}
    # Barely rough: a blend loses part of the light of a perfect mirror (under a sky of 1, a weight of 0.5 gives 0.38)
    mirror = {"type": "roughconductor", "material": "none", "distribution": "ggx", "alpha": 0.002}
    return {"type": "blendbsdf", "weight": sphere.specular, "a": _diffuse(sphere.spectrum), "b": mirror}


def _diffuse(name: str) -> dict:
    return {"type": "diffuse", "reflectance": _measured(library.reflectance(name))}


def _rectangle(mi, corners, **more) -> dict:
    """A parallelogram by three of its corners; its normal is that of the corners' order."""
    first, second, _, fourth = (np.array(corner, dtype=float) for corner in corners)
    across, up = (second - first) / 2, (fourth - first) / 2
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 3] = across, up, first + across + up
    matrix[:3, 2] = np.cross(across, up) / np.linalg.norm(np.cross(across, up))
    return {"type": "rectangle", "to_world": mi.ScalarTransform4f(matrix), **more}


def _lamp(mi, lamp: room.Lamp) -> dict:
    x, y, z = lamp.centre
    half = lamp.side / 2
    corners = [(x - half, y - half, z), (x - half, y + half, z), (x + half, y + half, z), (x + half, y - half, z)]
    # Blender's lamps let other light through
    return _rectangle(mi, corners, bsdf={"type": "null"}, emitter={"type": "area", "radiance": _emitted(lamp)})


def scene(mi, lamps: Sequence[room.Lamp], size: tuple[int, int], sampler: dict) -> dict:
    """The room lit by some of its lamps, as `mi.load_dict` takes it; size: (width, height) in pixels."""
    camera = room.CAMERA
    look = mi.ScalarTransform4f().look_at(origin=camera.position, target=camera.target, up=(0, 0, 1))
    film = {"type": "hdrfilm", "width": size[0], "height": size[1], "pixel_format": "xyz", "rfilter": {"type": "box"}}
    return {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": room.MAX_BOUNCES + 2, "rr_depth": 1000},
        "sensor": {
            "type": "perspective",
            "fov": camera.horizontal_degrees,
            "fov_axis": "x",
            "near_clip": 0.01,
            "to_world": look,
            "film": film,
            "sampler": sampler,
        },
        **{lamp.name: _lamp(mi, lamp) for lamp in lamps},
        **{wall.name: _rectangle(mi, wall.corners, bsdf=_diffuse(wall.reflectance)) for wall in room.WALLS},
        **{
            sphere.name: {"type": "sphere", "center": sphere.centre, "radius": sphere.radius, "bsdf": _bsdf(sphere)}
            for sphere in room.SPHERES
        },
    }


def unit(mi) -> float:
    """Mitsuba's Y of a radiance whose integral with the CIE 1931 y-bar is 1 per nm: seen, not looked up."""
    flat = _spectrum(WAVELENGTHS, np.ones(WAVELENGTHS.size))
    film = {"type": "hdrfilm", "width": 16, "height": 16, "pixel_format": "xyz"}
    sensor = {"type": "perspective", "film": film, "sampler": {"type": "independent", "sample_count": 4096}}
    seen = {"type": "scene", "integrator": {"type": "direct"}, "sensor": sensor}
    sky = mi.load_dict(seen | {"sky": {"type": "constant", "radiance": flat}})
    return float(np.array(mi.render(sky))[..., 1].mean() / library.observer()[:, 1].sum())


def _render(mi, size, samples: int, seed: int) -> np.ndarray:
    """(height, width, 3) XYZ of the room under all its lamps, in Blender's unit."""
    picture = np.zeros((size[1], size[0], 3))
    for lamp in room.LAMPS:
        described = scene(mi, [lamp], size, {"type": "independent", "sample_count": samples})
        picture += np.array(mi.render(mi.load_dict(described), seed=seed))
    return picture / unit(mi)


def _blocks(picture: np.ndarray) -> np.ndarray:
    height, width, _ = picture.shape
    return picture.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, 3).mean(axis=(1, 3))


def main(argv: list[str] | None = None):
    parser = argparse.ArgumentParser(prog="python -m relume.benchmarks.mitsuba_room", description=__doc__)
    parser.add_argument("--samples", type=int, default=512, help="per pixel: of Mitsuba's two runs, of each pass (512)")
    parser.add_argument("--percent", type=int, default=20, help="of the room's own resolution (20)")
    parser.add_argument("--out", type=Path, default=Path("out/mitsuba_room"), metavar="DIR")
    arguments = parser.parse_args(argv)

    import mitsuba as mi

    from .. import register

    register()
    mi.set_variant("scalar_spectral")
    opened = room_accuracy.open_room(arguments.samples, arguments.percent)
    opened.cycles.pixel_filter_type = "BOX"
    ours = room_accuracy.lit_xyz(room_accuracy.render_room(opened, bases.bands(36), "Cycles, 36 bands"), LIGHTING)
    height, width, _ = ours.shape
    began = time.perf_counter()
    runs = [_render(mi, (width, height), arguments.samples, seed) for seed in (1, 2)]
    seconds = time.perf_counter() - began

    ours, *runs = (_blocks(picture) for picture in (ours, *runs))
    theirs = np.mean(runs, axis=0)
    white = recombination.mixed_white(
        bases.bands(36), Mix({lamp: Light(library.illuminant(name)) for lamp, name in LIGHTING.items()})
    )
    difference = differences.picture_delta_E(ours, theirs, white)
    noise = differences.picture_delta_E(runs[0], runs[1], white)
    arguments.out.mkdir(parents=True, exist_ok=True)
    to_rgb = spaces.xyz_to_rgb()
    pictures = {"Cycles, Relume": ours, "Mitsuba": theirs}
    shown = [(name, spaces.srgb_encoded(xyz @ to_rgb.T)) for name, xyz in pictures.items()]
    figures.picture_row(arguments.out / "side_by_side.png", shown)
    maps = [("Cycles, Relume and Mitsuba", difference), ("two runs of Mitsuba", noise)]
    figures.delta_e_maps(arguments.out / "delta_e.png", maps)
    print(f"\n{width} × {height} pixels in blocks of {BLOCK} × {BLOCK}, {arguments.samples} samples; ΔE2000")
    print(f"{'':<28}{'mean':>7}{'median':>9}{'p98':>7}{'max':>7}")
    for name, values in maps:
        found = differences.statistics(values)
        print(f"{name:<28}{values.mean():>7.2f}{found['median']:>9.2f}{found['p98']:>7.2f}{found['max']:>7.2f}")
    print(f"mean luminance, Cycles over Mitsuba: {ours[..., 1].mean() / theirs[..., 1].mean():.4f}")
    print(f"Mitsuba took {seconds:.0f} s for its two runs\n{arguments.out}")


if __name__ == "__main__":
    main()
