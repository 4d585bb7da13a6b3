"""Table 1 of [WE], all 21 combinations beside the printed ones: `python -m relume.benchmarks.room_accuracy --paper`.

[WE] G. Ward, E. Eydelberg-Vileshin, "Picture perfect RGB rendering using spectral prefiltering and sharp color
     primaries", Eurographics Workshop on Rendering (2002).
"""

from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np

from ..core.colour import differences
from ..core.model import bases
from ..core.spectra import library
from ..studies import figures
from ..studies.reports import Section, publish
from . import room_accuracy

SPACES = {"XYZ": "xyz", "sRGB": "srgb", "Sharp": "sharp"}
# Row: (lit by, dominant illuminant, E where it is naive)
ROWS = {
    "tungsten, naive": ("A", "E"),
    "tungsten, prefiltered": ("A", "A"),
    "fluorescent, naive": ("FL2", "E"),
    "fluorescent, prefiltered": ("FL2", "FL2"),
    "both, naive": ("both", "E"),
    "both, prefiltered for tungsten": ("both", "A"),
    "both, prefiltered for fluorescent": ("both", "FL2"),
}
# Printed: CIE 1994 median and 98th percentile, XYZ, sRGB, Sharp
PRINTED = {
    "tungsten, naive": ((10.4, 45.9), (4.8, 15.4), (0.8, 5.1)),
    "tungsten, prefiltered": ((2.3, 5.7), (0.6, 1.5), (0.5, 0.9)),
    "fluorescent, naive": ((6.1, 32.0), (5.8, 39.2), (1.1, 6.0)),
    "fluorescent, prefiltered": ((2.0, 6.6), (0.4, 1.2), (0.4, 0.8)),
    "both, naive": ((5.6, 31.6), (4.5, 21.5), (0.6, 2.8)),
    "both, prefiltered for tungsten": ((4.9, 15.1), (0.5, 2.0), (0.7, 2.2)),
    "both, prefiltered for fluorescent": ((4.8, 55.1), (0.6, 6.5), (0.7, 8.6)),
}
# How bright the picture is shown to the eye: [WE] does not say. Percentile of the reference's luminance that is white.
EXPOSURES = {"98th percentile white": 98.0, "brightest wall white": 90.0, "median half white": None}
FLOOR = 1e-4  # of white: darker pixels have no colour to speak of
TOP = 5.0  # of the error maps


def objects_seen(scene, width: int, height: int) -> np.ndarray:
    """The name of what the centre of each pixel sees first -> (height, width) of str."""
    graph = bpy.context.evaluated_depsgraph_get()
    camera = scene.camera
    frame = camera.data.view_frame(scene=scene)  # top right, bottom right, bottom left, top left, in camera space
    matrix, names = camera.matrix_world, np.empty((height, width), dtype=object)
    for y, x in np.ndindex(height, width):
        across, down = (x + 0.5) / width, (y + 0.5) / height
        point = frame[3] + (frame[0] - frame[3]) * across + (frame[2] - frame[3]) * down
        direction = (matrix @ point - matrix.translation).normalized()
        hit, *_, thing, _ = scene.ray_cast(graph, matrix.translation, direction)
        names[y, x] = thing.name if hit else ""
    return names


def difference(image, truth, lighting, percentile: float | None = 98.0) -> np.ndarray:
    """CIE 1994 of each pixel to the reference (height, width), with that percentile of luminance, or twice the median,
    shown as white."""
    white = room_accuracy.white_of(truth.model, lighting)
    found, true = room_accuracy.lit_xyz(image, lighting), room_accuracy.lit_xyz(truth, lighting)
    shown = 2 * np.median(true[..., 1]) if percentile is None else np.percentile(true[..., 1], percentile)
    return differences.delta_E_1994(true / shown, found / shown, white / white[1])


def _cells(values: np.ndarray) -> str:
    return f"{np.median(values):.2f} / {np.percentile(values, 98):.2f}"


def sections(images: dict, truth, finer, names: np.ndarray) -> Iterator[Section]:
    """Table 1, what the measure does to it, and where in the picture its 98th percentile comes from."""
    maps = {
        (row, space): difference(images[space, dominant], truth, room_accuracy.LIGHTINGS[lit])
        for row, (lit, dominant) in ROWS.items()
        for space in SPACES
    }
    rows = []
    for row in ROWS:
        rows.append([row, *(_cells(maps[row, space]) for space in SPACES)])
        rows.append([f"{row}, printed", *(f"{a:.1f} / {b:.1f}" for a, b in PRINTED[row])])
    average = [
        np.mean([[np.median(maps[row, space]), np.percentile(maps[row, space], 98)] for row in ROWS], axis=0)
        for space in SPACES
    ]
    rows.append(["average", *(f"{a:.2f} / {b:.2f}" for a, b in average)])
    rows.append(["average, printed", "5.7 / 27.4", "2.8 / 12.5", "0.7 / 3.8"])
    words = (
        "CIE 1994 to the reference, 50th / 98th percentile of the pixels. Naive: colours of materials under equal "
        "energy, white made white. Prefiltered: under the light named. The 98th percentile of luminance is shown as "
        "white."
    )
    yield Section("Table 1", words, ("", *SPACES), rows)

    rows = []
    for row in ("tungsten, prefiltered", "fluorescent, prefiltered"):
        lit, dominant = ROWS[row]
        for words, percentile in EXPOSURES.items():
            for space in ("sRGB", "Sharp"):
                values = difference(images[space, dominant], truth, room_accuracy.LIGHTINGS[lit], percentile)
                rows.append([row, space, words, _cells(values), f"{np.percentile(values, 95):.2f}"])
    yield Section("The measure", "The same with other exposures.", ("", "space", "shown", "50th / 98th", "95th"), rows)

    rows = []
    parts = {
        "everything": np.full(names.shape, True),
        "gold": names == "gold",
        "plastic": names == "green plastic",
    }
    parts["walls"] = ~(parts["gold"] | parts["plastic"])
    for row in ("tungsten, prefiltered", "fluorescent, prefiltered"):
        lit, dominant = ROWS[row]
        lighting = room_accuracy.LIGHTINGS[lit]
        noise = difference(finer, truth, lighting)
        for part, seen in parts.items():
            if seen.any():
                cells = [_cells(maps[row, space][seen]) for space in SPACES]
                rows.append([row, part, f"{100 * seen.mean():.1f} %", *cells, _cells(noise[seen])])
    words = (
        "By what a pixel sees first. The last column is a second reference of 48 bands: noise, and what 36 leave out."
    )
    yield Section("Where it is", words, ("", "seen", "of the picture", *SPACES, "48 bands"), rows)


def run(scene, out: Path) -> list[Section]:
    """Render every model and the references; print, write and return the tables; the error maps as one sheet."""
    truth = room_accuracy.render_room(scene, bases.bands(36), "reference, 36 bands")
    names = objects_seen(scene, *truth.size)
    finer = room_accuracy.render_room(scene, bases.bands(48), "reference, 48 bands")
    images = {
        (space, dominant): room_accuracy.render_room(
            scene, bases.prefiltered(library.illuminant(dominant), key), f"{space}, {dominant}"
        )
        for space, key in SPACES.items()
        for dominant in ("E", "A", "FL2")
    }
    done = publish("room_paper", sections(images, truth, finer, names), out)
    sheet = [
        (f"{space}: {row}", difference(images[space, dominant], truth, room_accuracy.LIGHTINGS[lit]))
        for row, (lit, dominant) in ROWS.items()
        for space in SPACES
    ]
    figures.delta_e_maps(out / "room_paper.png", sheet, TOP, columns=3, measure="CIE 1994")
    print(out / "room_paper.md")
    return done
