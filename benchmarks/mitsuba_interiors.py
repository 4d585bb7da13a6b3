"""Interiors in an independent spectral renderer: Mitsuba 3 against Cycles and the reference model.

`python -m relume.benchmarks.mitsuba_interiors [--interiors NAME ...] [--samples N] [--percent P] [--out DIR]`

Both sides start from the same data (`assets.room`, `benchmarks.interiors`): corners, spheres, lamps, camera, measured
spectra. Mitsuba renders 380 to 780 nm with the CIE 1931 observer; no Russian roulette, as many bounces, box filters.
Lamps are given the radiance of Blender's watts, W / (pi area), scaled as Relume scales illuminants: a perfect white
keeps its luminance. Nothing is fitted: the ratio of the two pictures' luminance is printed, not divided out.

Each side renders twice. *Of noise alone* is what the means would differ by if both sides were right, from what the two
runs of each side differ by: half of these, in quadrature.
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
from .cycles_interiors import Cycles
from .interiors import INTERIORS

__all__ = ["Mitsuba", "agreement", "fastest_first", "white_of"]

_BANDS = 36  # of the reference model
_SAMPLER = "multijitter"  # the one with the least noise for its time in the room
_TRIAL = 64  # samples of the renders that say which variant is the fastest
BLOCK = 4  # pixels averaged in each direction, against noise


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
    if sphere.material == "glass":
        tint = _measured(library.reflectance(sphere.spectrum))
        glass = {"int_ior": sphere.index, "ext_ior": 1.0, "specular_reflectance": tint, "specular_transmittance": tint}
        if not sphere.roughness:
            return {"type": "dielectric", **glass}
        return {"type": "roughdielectric", "distribution": "ggx", "alpha": sphere.roughness**2, **glass}
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
    # Blender's lamps let other light through; chosen by power, as Cycles chooses them by power and place
    emitter = {"type": "area", "radiance": _emitted(lamp), "sampling_weight": lamp.watts}
    return _rectangle(mi, lamp.corners, bsdf={"type": "null"}, emitter=emitter)


def scene(mi, interior: room.Interior, lamps: Sequence[room.Lamp], size: tuple[int, int], sampler: dict) -> dict:
    """An interior lit by some of its lamps, as `mi.load_dict` takes it; size: (width, height) in pixels."""
    camera = interior.camera
    look = mi.ScalarTransform4f().look_at(origin=camera.position, target=camera.target, up=(0, 0, 1))
    film = {"type": "hdrfilm", "width": size[0], "height": size[1], "pixel_format": "xyz", "rfilter": {"type": "box"}}
    return {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": interior.max_bounces + 2, "rr_depth": 1000},
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
        **{wall.name: _rectangle(mi, wall.corners, bsdf=_diffuse(wall.reflectance)) for wall in interior.walls},
        **{
            sphere.name: {"type": "sphere", "center": sphere.centre, "radius": sphere.radius, "bsdf": _bsdf(sphere)}
            for sphere in interior.spheres
        },
    }


def _unit(mi) -> float:
    """Mitsuba's Y of a radiance whose integral with the CIE 1931 y-bar is 1 per nm: seen, not looked up."""
    flat = _spectrum(WAVELENGTHS, np.ones(WAVELENGTHS.size))
    film = {"type": "hdrfilm", "width": 16, "height": 16, "pixel_format": "xyz"}
    sensor = {"type": "perspective", "film": film, "sampler": {"type": "independent", "sample_count": 4096}}
    seen = {"type": "scene", "integrator": {"type": "direct"}, "sensor": sensor}
    sky = mi.load_dict(seen | {"sky": {"type": "constant", "radiance": flat}})
    return float(np.array(mi.render(sky))[..., 1].mean() / library.observer()[:, 1].sum())


class Mitsuba:
    """An interior in a variant of Mitsuba, in pictures of one size. Raises ImportError where that does not run."""

    def __init__(self, interior: room.Interior, size: tuple[int, int], variant: str):
        import mitsuba

        mitsuba.set_variant(variant)
        self.interior, self.size, self.variant, self.mi = interior, size, variant, mitsuba
        self.unit = _unit(mitsuba)

    def samples(self, count: int) -> int:
        return count

    def render(self, count: int, seed: int) -> tuple[float, np.ndarray]:
        """The processor's seconds, and (height, width, 3) XYZ in Blender's unit."""
        self.mi.set_variant(self.variant)
        sampler = {"type": _SAMPLER, "sample_count": count}
        began = time.process_time()
        described = self.mi.load_dict(scene(self.mi, self.interior, self.interior.lamps, self.size, sampler))
        xyz = np.array(self.mi.render(described, seed=seed))
        seconds = time.process_time() - began
        # In a long run a pixel or two is no number, and stays so; a median does not notice
        return seconds, np.nan_to_num(xyz / self.unit)


def _on_this_processor() -> list[str]:
    """Mitsuba's spectral variants that need no graphics card."""
    import mitsuba

    return [name for name in mitsuba.variants() if name.endswith("_spectral") and not name.startswith("cuda")]


def fastest_first(interior: room.Interior, size: tuple[int, int], names: Sequence[str] = ()) -> list[Mitsuba]:
    """Those of some variants (all spectral ones) that run here, by the seconds of a small render, once compiled."""
    found = []
    for name in names or _on_this_processor():
        try:
            each = Mitsuba(interior, size, name)
        except ImportError as why:
            print(f"{name} does not run here: {why}", flush=True)
            continue
        each.render(_TRIAL, seed=0)
        seconds = min(each.render(_TRIAL, seed=0)[0] for _ in range(2))
        print(f"{name}: {seconds:.2f} s for {_TRIAL} samples", flush=True)
        found.append((seconds, each))
    return [each for _, each in sorted(found, key=lambda pair: pair[0])]


def white_of(interior: room.Interior) -> np.ndarray:
    lights = {group: Light(library.illuminant(name)) for group, name in interior.lighting.items()}
    return recombination.mixed_white(bases.bands(), Mix(lights))


def _blocks(picture: np.ndarray) -> np.ndarray:
    height, width, _ = picture.shape
    height, width = height // BLOCK, width // BLOCK
    return picture[: height * BLOCK, : width * BLOCK].reshape(height, BLOCK, width, BLOCK, 3).mean(axis=(1, 3))


def reference(interior: room.Interior, percent: int) -> Cycles:
    """The interior in Cycles with the reference model."""
    return Cycles(interior, percent, bases.bands(_BANDS), as_sampled=True)


def agreement(ours: Sequence[np.ndarray], theirs: Sequence[np.ndarray], white: np.ndarray) -> tuple[np.ndarray, float]:
    """(blocks...) CIEDE2000 of the means of two runs of each side, and the median that noise alone would make."""
    sides = [[_blocks(run) for run in side] for side in (ours, theirs)]
    noise = [np.median(differences.picture_delta_E(*side, white)) / 2 for side in sides]
    means = [np.mean(side, axis=0) for side in sides]
    return differences.picture_delta_E(*means, white), float(np.hypot(*noise))


def _measure(name: str, arguments) -> str:
    """The row of one interior; draws its pictures."""
    interior, white = INTERIORS[name], white_of(INTERIORS[name])
    size = tuple(n * arguments.percent // 100 for n in interior.camera.resolution)
    variants = fastest_first(interior, size)
    ours = [reference(interior, arguments.percent).render(arguments.samples, seed)[1] for seed in (1, 2)]
    theirs = [variants[0].render(arguments.samples, seed)[1] for seed in (1, 2)]
    difference, noise = agreement(ours, theirs, white)
    means = {"Cycles, Relume": np.mean(ours, axis=0), "Mitsuba": np.mean(theirs, axis=0)}
    to_rgb = spaces.xyz_to_rgb()
    shown = [(side, spaces.srgb_encoded(xyz @ to_rgb.T)) for side, xyz in means.items()]
    figures.picture_row(arguments.out / f"{name}.png", shown)
    figures.delta_e_maps(arguments.out / f"{name}_delta_e.png", [("Cycles, Relume and Mitsuba", difference)])
    found = differences.statistics(difference)
    cells = [difference.mean(), found["median"], noise, found["p98"], found["max"]]
    ratio = means["Cycles, Relume"][..., 1].mean() / means["Mitsuba"][..., 1].mean()
    return f"| {name} |" + "".join(f" {cell:.2f} |" for cell in cells) + f" {ratio:.4f} |"


def main(argv: list[str] | None = None):
    parser = argparse.ArgumentParser(prog="python -m relume.benchmarks.mitsuba_interiors", description=__doc__)
    parser.add_argument("--interiors", nargs="+", choices=INTERIORS, default=list(INTERIORS), metavar="NAME")
    parser.add_argument("--samples", type=int, default=4096, help="per pixel and run, of all passes together (4096)")
    parser.add_argument("--percent", type=int, default=20, help="of the interiors' own resolution (20)")
    parser.add_argument("--out", type=Path, default=Path("out/mitsuba_interiors"), metavar="DIR")
    arguments = parser.parse_args(argv)

    from .. import register

    register()
    arguments.out.mkdir(parents=True, exist_ok=True)
    rows = [_measure(name, arguments) for name in arguments.interiors]
    print(f"\nCIEDE2000 in blocks of {BLOCK} × {BLOCK} pixels, {arguments.samples} samples in each of two runs\n")
    print("| | mean | median | of noise alone | p98 | max | luminance, Cycles over Mitsuba |")
    print("|---" * 7 + "|")
    print("\n".join([*rows, "", str(arguments.out)]))


if __name__ == "__main__":
    main()
