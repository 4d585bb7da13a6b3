"""Time to the same error: the room in Mitsuba 3 and in Relume, held against Mitsuba's long run. Prints ratios.

`python -m relume.benchmarks.peers [--percent P] [--counts N ...] [--runs R] [--long N] [--errors E ...]
[--variant NAME ...] [--out DIR]`

Every spectral variant of Mitsuba that runs on this processor is measured, the fastest first; `llvm_ad_spectral` needs
LLVM (Debian: `libllvm19`; `DRJIT_LIBLLVM_PATH` says where, if Mitsuba does not find it). The long run is the fastest's.

Both renderers start from the data of `assets.room`, with box filters and as many bounces (`mitsuba_room`), on all
cores; seconds are those of the processor, which a busy machine changes least. Error: median CIEDE2000 over pixels, of
model and noise together. Every renderer is measured at a few sample counts, taking turns; counts at an error are
interpolated, both logarithmic. Beyond the measured counts, error^2 = floor^2 + c / N goes on; an error below a model's
floor is never reached. A long run's own noise, half of what its two halves differ by, is taken off in quadrature.

Samples are those of all passes together. Eleven renders of three wavelengths are what a Blender user would pay without
a factor model: made as view layers of one file, which saves ten starts, either with one seed and all samples each, as
Blender does by itself, or with samples shared and seeds of their own. *RGB, noise alone* is held against a long run of
its own: it shows other colours, but that is what Blender users wait for now. *Without start* leaves out what does not
grow with samples, which large pictures pay as well, but hardly notice.
"""

import argparse
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import bpy
import numpy as np

from ..addon.scene import render, setup
from ..assets import make_room, room
from ..core.colour import differences
from ..core.model import bases
from ..core.picture import coefficients, recombination
from ..core.picture.mix import Light, Mix
from ..core.spectra import library
from ..studies import figures
from . import mitsuba_room

_OURS = "p = 9"
_WAVELENGTHS = 33  # of a user's eleven renders
_SAMPLER = "multijitter"  # of Mitsuba's, the one with the least noise for its time in this room
_SEED_STEP = 1000
_TRIAL = 64  # samples of the renders that say which variant is the fastest


@dataclass
class Row:
    """A renderer: what it renders, and {samples: (runs, 2) of seconds and error}."""

    name: str
    model: object = None  # a factor model; None for Mitsuba
    mitsuba: object = None  # a variant of Mitsuba
    same_seed: bool = False  # every pass takes all the samples, with the same noise
    own: bool = False  # held against a long run of its own, not Mitsuba's
    taken: dict = field(default_factory=dict)

    def per_pass(self, count: int) -> int:
        """What a scene is set to for `count` samples of all passes together."""
        return -(-count // self.model.passes) if self.same_seed else count

    def samples(self, count: int) -> int:
        """Of all passes together, in fact."""
        return self.per_pass(count) * self.model.passes if self.same_seed else count

    def curve(self) -> np.ndarray:
        """(counts, 3): samples, seconds, error; of several runs the fastest, errors as a mean square."""
        rows = [
            (samples, min(seconds for seconds, _ in runs), np.sqrt(np.mean([error**2 for _, error in runs])))
            for samples, runs in sorted(self.taken.items())
        ]
        return np.array(rows)


def floor_of(samples, errors) -> float:
    """What an error goes down to: error^2 = floor^2 + c / N through the last two counts."""
    (n, m), (e, f) = samples[-2:], errors[-2:]
    return float(np.sqrt(max((f**2 * m - e**2 * n) / (m - n), 0.0)))


def samples_for(error: float, samples, errors) -> float:
    """Samples that reach an error; infinite where the floor lies above it."""
    if errors[-1] <= error <= errors[0]:
        return float(np.exp(np.interp(-np.log(error), -np.log(errors), np.log(samples))))
    if error > errors[0]:
        return float(samples[0] * (errors[0] / error) ** 2)
    floor = floor_of(samples, errors)
    if floor >= error:
        return np.inf
    return float(samples[-1] * (errors[-1] ** 2 - floor**2) / (error**2 - floor**2))


def start_and_rate(samples, seconds) -> tuple[float, float]:
    """Seconds before the first sample and for each, by least squares of the relative differences."""
    from scipy.optimize import nnls

    design = np.stack([np.ones_like(samples), samples], axis=1) / seconds[:, None]
    start, rate = nnls(design, np.ones_like(seconds))[0]
    return start, rate


def _rows(variants, channels) -> list[Row]:
    rows = [Row(f"Mitsuba, {each.variant}", mitsuba=each) for each in variants]
    rows += [Row("RGB", bases.rgb()), Row("RGB, noise alone", bases.rgb(), own=True)]
    rows += [*(Row(f"p = {p}", bases.fitted(p)) for p in channels)]
    bands = bases.bands(_WAVELENGTHS)
    return [*rows, Row("11 renders, shared", bands), Row("11 renders, one seed", bands, same_seed=True)]


def _relume(row: Row, arguments, samples: int, seed: int) -> tuple[float, np.ndarray]:
    """Seconds, and (height, width, 3) XYZ under the room's own lamps."""
    bpy.ops.wm.open_mainfile(filepath=str(make_room.PATH), load_ui=False)
    scene = bpy.context.scene
    scene.render.resolution_percentage, scene.cycles.samples = arguments.percent, row.per_pass(samples)
    scene.cycles.pixel_filter_type, scene.cycles.seed = "BOX", _SEED_STEP * seed
    scene.relume.same_seed, scene.relume.split_samples = row.same_seed, not row.same_seed
    setup.set_up(scene, row.model)
    with tempfile.TemporaryDirectory() as folder:
        began = time.process_time()
        image = render.render(scene, Path(folder)).image
        xyz = coefficients.to_xyz(image, {group.name: group.light() for group in scene.relume.light_groups})
        return time.process_time() - began, xyz


class _Mitsuba:
    """The room in a variant of Mitsuba, at one size of picture. Raises ImportError where that does not run."""

    def __init__(self, variant: str, size: tuple[int, int]):
        import mitsuba

        mitsuba.set_variant(variant)
        self.variant, self.mi, self.size, self.unit = variant, mitsuba, size, mitsuba_room.unit(mitsuba)

    def render(self, samples: int, seed: int) -> tuple[float, np.ndarray]:
        """Seconds, and (height, width, 3) XYZ."""
        self.mi.set_variant(self.variant)
        sampler = {"type": _SAMPLER, "sample_count": samples}
        began = time.process_time()
        scene = self.mi.load_dict(mitsuba_room.scene(self.mi, room.LAMPS, self.size, sampler))
        xyz = np.array(self.mi.render(scene, seed=seed))
        seconds = time.process_time() - began
        # In the long run a pixel or two is no number, and stays so; a median does not notice
        return seconds, np.nan_to_num(xyz / self.unit)


def _on_this_processor() -> list[str]:
    """Mitsuba's spectral variants that need no graphics card."""
    import mitsuba

    return [name for name in mitsuba.variants() if name.endswith("_spectral") and not name.startswith("cuda")]


def _fastest_first(names: list[str], size: tuple[int, int]) -> list[_Mitsuba]:
    """Those of some variants that run here, by the seconds that a small render takes once it is compiled."""
    found = []
    for name in names:
        try:
            each = _Mitsuba(name, size)
        except ImportError as why:
            print(f"{name} does not run here: {why}", flush=True)
            continue
        each.render(_TRIAL, seed=0)
        seconds = min(each.render(_TRIAL, seed=0)[0] for _ in range(2))
        print(f"{name}: {seconds:.2f} s for {_TRIAL} samples", flush=True)
        found.append((seconds, each))
    return [each for _, each in sorted(found, key=lambda pair: pair[0])]


def _white() -> np.ndarray:
    lights = {lamp.name: Light(library.illuminant(lamp.illuminant)) for lamp in room.LAMPS}
    return recombination.mixed_white(bases.bands(), Mix(lights))


def _median(xyz, truth) -> float:
    return float(np.median(differences.picture_delta_E(xyz, truth, _white())))


def _long_run(render) -> tuple[np.ndarray, float]:
    """The mean of two renders with seeds 1 and 2, and its noise."""
    halves = [render(seed)[1] for seed in (1, 2)]
    return np.mean(halves, axis=0), _median(*halves) / 2


def _table(rows: list[Row], errors: list[float]) -> list[str]:
    """Ratios to nine channels of the times to each error, with and without the start."""
    head = "".join(f" samples for {e:g} | time | without start |" for e in errors)
    lines = [f"| median ΔE2000 | floor |{head}", "|---|---|" + "---|" * 3 * len(errors)]
    found = {row.name: [_at(row, error) for error in errors] for row in rows}
    for row in rows:
        samples, _, measured = row.curve().T
        cells = f"| {row.name} | {floor_of(samples, measured):.2f} |"
        for (count, *times), (_, *ours) in zip(found[row.name], found[_OURS], strict=True):
            if np.isinf(count):
                cells += " never | | |"
            else:
                cells += f" {count:.0f} |" + "".join(f" {a / b:.2f} |" for a, b in zip(times, ours, strict=True))
        lines.append(cells)
    return lines


def _at(row: Row, error: float) -> tuple[float, float, float]:
    """Samples, seconds, and seconds without the start, that an error takes."""
    samples, seconds, errors = row.curve().T
    count = samples_for(error, samples, errors)
    start, rate = start_and_rate(samples, seconds)
    return count, start + rate * count, rate * count


def main(argv: list[str] | None = None):
    parser = argparse.ArgumentParser(prog="python -m relume.benchmarks.peers", description=__doc__)
    parser.add_argument("--percent", type=int, default=20, help="of the room's own resolution (20)")
    parser.add_argument("--counts", type=int, nargs="+", default=[64, 256, 1024], metavar="N", help="samples")
    parser.add_argument("--runs", type=int, default=1, help="renders at each count (1)")
    parser.add_argument("--long", type=int, default=2048, metavar="N", help="samples of Mitsuba's long run (2048)")
    parser.add_argument("--errors", type=float, nargs="+", default=[2.0, 1.0, 0.5], metavar="E", help="(2 1 0.5)")
    parser.add_argument("--channels", type=int, nargs="+", default=[9], metavar="P", help="9 among them (9)")
    parser.add_argument("--variant", nargs="+", metavar="NAME", help="of Mitsuba (every spectral one that runs here)")
    parser.add_argument("--out", type=Path, default=Path("out/peers"), metavar="DIR")
    arguments = parser.parse_args(argv)
    if 9 not in arguments.channels or len(arguments.counts) < 2:
        parser.error("expected 9 among the channels, which others are held against, and 2 counts or more")

    from .. import register

    register()
    size = tuple(n * arguments.percent // 100 for n in room.CAMERA.resolution)
    variants = _fastest_first(arguments.variant or _on_this_processor(), size)
    if not variants:
        parser.error("no such variant of Mitsuba runs here")
    rows = _rows(variants, arguments.channels)
    plain = next(row for row in rows if row.own)
    theirs = _long_run(lambda seed: variants[0].render(arguments.long // 2, seed))
    own = _long_run(lambda seed: _relume(plain, arguments, arguments.long // 2, seed))
    seed = 2  # those of the long runs' halves come before it
    for _ in range(arguments.runs):
        for count in sorted(arguments.counts):
            seed += 1
            for row in rows:
                taken = _relume(row, arguments, count, seed) if row.model else row.mitsuba.render(count, seed)
                truth, noise = own if row.own else theirs
                error = np.sqrt(max(_median(taken[1], truth) ** 2 - noise**2, 0.0))
                row.taken.setdefault(row.samples(count), []).append((taken[0], error))
    _report(rows, arguments, size, theirs[1])


def _report(rows: list[Row], arguments, size, noise: float):
    lines = [f"{size[0]} × {size[1]} pixels; Mitsuba's {_SAMPLER}; noise of its long run {noise:.2f}.", ""]
    lines += ["Times are ratios to nine channels.", "", *_table(rows, arguments.errors), ""]
    lines += ["| | samples: seconds, median ΔE2000 |", "|---|---|"]
    for row in rows:
        measured = "; ".join(f"{n:.0f}: {seconds:.2f}, {error:.2f}" for n, seconds, error in row.curve())
        lines.append(f"| {row.name} | {measured} |")
    arguments.out.mkdir(parents=True, exist_ok=True)
    curves = [(row.name, row.curve()[:, 1], row.curve()[:, 2]) for row in rows]
    panel = figures.Panel("seconds", curves, "ΔE2000 to Mitsuba's long run, median", log="xy")
    figures.curves(arguments.out / "peers.png", [panel])
    (arguments.out / "peers.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(["", *lines, "", str(arguments.out / "peers.md")]))


if __name__ == "__main__":
    main()
