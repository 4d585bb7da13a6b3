"""Time to the same error: Relume and its peers in three interiors, held against Mitsuba's long run. Prints ratios.

`python -m relume.benchmarks.peers [--interiors NAME ...] [--percent P] [--counts N ...] [--runs R] [--long N]
[--errors E ...] [--channels P ...] [--variant NAME ...] [--few] [--out DIR]`

Every spectral variant of Mitsuba that runs on this processor is measured, the fastest first; `llvm_ad_spectral` needs
LLVM (Debian: `libllvm19`; `DRJIT_LIBLLVM_PATH` says where, if Mitsuba does not find it). The long run is the fastest's.
LuxCore (`pyluxcore`), which knows no spectra, stands beside it for orientation, held against a long run of its own.

All renderers start from the same data (`assets.room`, `interiors`), with box filters and as many bounces, on all cores;
seconds are those of the processor, which a busy machine changes least. Error: median CIEDE2000 over pixels, of model
and noise together. Every renderer is measured at a few sample counts, taking turns; counts at an error are
interpolated, both logarithmic. Beyond the measured counts, error^2 = floor^2 + c / N goes on; an error below a model's
floor is never reached. A long run's own noise, half of what its two halves differ by, is taken off in quadrature.
Cycles with 36 narrow bands is held against the long run first: where they differ by more than half again what noise
alone explains (`mitsuba_interiors`), the table says that it is void.

Samples are those of all passes together. Eleven renders of three wavelengths are what a Blender user would pay without
a factor model: made as view layers of one file, which saves ten starts, either with one seed and all samples each, as
Blender does by itself, or with samples shared and seeds of their own. *Noise alone* is held against a long run of its
own: it shows other colours, but that is what Blender users wait for now. *Without start* leaves out what does not grow
with samples, which large pictures pay as well, but hardly notice.
"""

import argparse
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..core.colour import differences
from ..core.model import bases
from ..studies import figures
from . import mitsuba_interiors
from .cycles_interiors import Cycles
from .interiors import INTERIORS
from .luxcore_interiors import LuxCore

_OURS = "p = 9"
_WAVELENGTHS = 33  # of a user's eleven renders
_AGREES = 1.5  # times the difference that noise alone makes


@dataclass
class Row:
    """A renderer, and {samples: [(seconds, error) of each run]}."""

    name: str
    renderer: Cycles | LuxCore | mitsuba_interiors.Mitsuba
    own: bool = False  # held against a long run of its own, not Mitsuba's
    taken: dict = field(default_factory=dict)

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


def _rows(interior, variants, size, arguments) -> list[Row]:
    def cycles(model, same_seed=False):
        return Cycles(interior, arguments.percent, model, same_seed)

    rows = [Row(f"Mitsuba, {each.variant}", each) for each in variants]
    if arguments.few:
        return [*rows, *(Row(f"p = {p}", cycles(bases.fitted(p))) for p in arguments.channels)]
    try:
        rows.append(Row("LuxCore RGB, noise alone", LuxCore(interior, size), own=True))
    except ImportError as why:
        print(f"LuxCore does not run here: {why}", flush=True)
    rows += [Row("RGB", cycles(bases.rgb())), Row("RGB, noise alone", cycles(bases.rgb()), own=True)]
    rows += [*(Row(f"p = {p}", cycles(bases.fitted(p))) for p in arguments.channels)]
    bands = bases.bands(_WAVELENGTHS)
    return [*rows, Row("11 renders, shared", cycles(bands)), Row("11 renders, one seed", cycles(bands, True))]


def _median(xyz, truth, white) -> float:
    return float(np.median(differences.picture_delta_E(xyz, truth, white)))


def _halves(renderer, arguments) -> list[np.ndarray]:
    """Those of a long run."""
    return [renderer.render(arguments.long // 2, seed)[1] for seed in (1, 2)]


def _truth(halves, white) -> tuple[np.ndarray, float]:
    """The mean of a long run's halves, and its noise."""
    return np.mean(halves, axis=0), _median(*halves, white) / 2


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


def _measure(name: str, arguments) -> tuple[list[str], list[Row]]:
    """The lines that tell of one interior, and the rows behind them."""
    interior = INTERIORS[name]
    white = mitsuba_interiors.white_of(interior)
    size = tuple(n * arguments.percent // 100 for n in interior.camera.resolution)
    variants = mitsuba_interiors.fastest_first(interior, size, arguments.variant)
    if not variants:
        raise SystemExit("no such variant of Mitsuba runs here")
    rows = _rows(interior, variants, size, arguments)
    theirs = _halves(variants[0], arguments)
    check = mitsuba_interiors.reference(interior, arguments.percent)
    difference, expected = mitsuba_interiors.agreement(_halves(check, arguments), theirs, white)
    truths = {row.name: _truth(_halves(row.renderer, arguments) if row.own else theirs, white) for row in rows}
    seed = 2  # those of the long runs' halves come before it
    for _ in range(arguments.runs):
        for count in sorted(arguments.counts):
            seed += 1
            for row in rows:
                seconds, xyz = row.renderer.render(count, seed)
                truth, noise = truths[row.name]
                error = np.sqrt(max(_median(xyz, truth, white) ** 2 - noise**2, 0.0))
                row.taken.setdefault(row.renderer.samples(count), []).append((seconds, error))
    differ = float(np.median(difference))
    lines = [
        f"**{interior.name}**: {size[0]} × {size[1]} pixels; noise of the long run {truths[rows[0].name][1]:.2f}.",
        "",
    ]
    block = f"{mitsuba_interiors.BLOCK} × {mitsuba_interiors.BLOCK}"
    lines += [
        f"Cycles with narrow bands differs from it by {differ:.2f} (blocks of {block}), noise alone by {expected:.2f}."
    ]
    if differ > _AGREES * expected:
        lines += ["", "**Void**: that is more than noise; the two do not show the same thing."]
    lines += ["", "Times are ratios to nine channels.", "", *_table(rows, arguments.errors), ""]
    lines += ["| | samples: seconds, median ΔE2000 |", "|---|---|"]
    for row in rows:
        measured = "; ".join(f"{n:.0f}: {seconds:.2f}, {error:.2f}" for n, seconds, error in row.curve())
        lines.append(f"| {row.name} | {measured} |")
    return [*lines, ""], rows


def main(argv: list[str] | None = None):
    parser = argparse.ArgumentParser(prog="python -m relume.benchmarks.peers", description=__doc__)
    parser.add_argument(
        "--interiors", nargs="+", choices=INTERIORS, default=list(INTERIORS), metavar="NAME", help="(all)"
    )
    parser.add_argument("--percent", type=int, default=20, help="of the interiors' own resolution (20)")
    parser.add_argument("--counts", type=int, nargs="+", default=[64, 256, 1024], metavar="N", help="samples")
    parser.add_argument("--runs", type=int, default=1, help="renders at each count (1)")
    parser.add_argument("--long", type=int, default=2048, metavar="N", help="samples of the long runs (2048)")
    parser.add_argument("--errors", type=float, nargs="+", default=[2.0, 1.0, 0.5], metavar="E", help="(2 1 0.5)")
    parser.add_argument("--channels", type=int, nargs="+", default=[9], metavar="P", help="9 among them (9)")
    parser.add_argument("--variant", nargs="+", metavar="NAME", help="of Mitsuba (every spectral one that runs here)")
    parser.add_argument("--few", action="store_true", help="Mitsuba and factor models alone")
    parser.add_argument("--out", type=Path, default=Path("out/peers"), metavar="DIR")
    arguments = parser.parse_args(argv)
    if 9 not in arguments.channels or len(arguments.counts) < 2:
        parser.error("expected 9 among the channels, which others are held against, and 2 counts or more")

    from .. import register

    register()
    arguments.out.mkdir(parents=True, exist_ok=True)
    told, panels = [], []
    for name in arguments.interiors:
        lines, rows = _measure(name, arguments)
        print("\n".join(["", *lines]), flush=True)
        told += lines
        curves = [(row.name, row.curve()[:, 1], row.curve()[:, 2]) for row in rows]
        panels.append(figures.Panel(f"{name}: seconds", curves, "ΔE2000 to the long run, median", log="xy"))
    figures.curves(arguments.out / "peers.png", panels)
    (arguments.out / "peers.md").write_text("\n".join(told) + "\n", encoding="utf-8")
    print(arguments.out / "peers.md")


if __name__ == "__main__":
    main()
