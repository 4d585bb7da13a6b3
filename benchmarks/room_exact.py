"""Where the 98th percentiles of [WE] Table 1 come from: its room without noise, one thing changed at a time.

`python -m relume.benchmarks.room_exact [--out DIR]`

[WE] G. Ward, E. Eydelberg-Vileshin, "Picture perfect RGB rendering using spectral prefiltering and sharp color
     primaries", Eurographics Workshop on Rendering (2002).

Known of the paper's scene is what its text says: a square room, two lamps, a green plastic ball with a mirror of 5 %, a
gold one, and which wall has which patch. Sizes, places and the camera are ours (`assets/room.py`).
"""

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..assets.room import ROOM, SIZE
from ..core.colour import differences
from ..core.model import bases, fresnel
from ..core.model.relight import power_weights
from ..core.spectra import library
from ..core.spectra.spectrum import WAVELENGTHS
from ..studies import enclosure
from ..studies.reports import Section, publish
from .room_paper import PRINTED, SPACES

PIXELS = (160, 120)
LIT = {"tungsten": ("A", 0), "fluorescent": ("FL2", 1)}  # illuminant, lamp


def room_of(width: float = 1.0, spheres: float = 1.0) -> enclosure.Room:
    """The room, with its camera's angle and its spheres' radii times these."""
    plastic, gold = (((*ball.centre[:2], ball.radius * spheres), ball.radius * spheres) for ball in ROOM.spheres)
    lamps = tuple((lamp.centre, lamp.side) for lamp in ROOM.lamps)
    camera = ROOM.camera
    eye = camera.position, camera.target, camera.horizontal_degrees * width, PIXELS
    return enclosure.Room(SIZE, ROOM.max_bounces, plastic, gold, lamps, eye)


def surfaces(filters: np.ndarray, gold: str = "index") -> enclosure.Surfaces:
    """The room's surfaces through filters (81, c); the identity for spectra.

    gold: "index", n and k of each channel, as a renderer takes them; "angle", its colour at each angle; "head on", its
    colour head on at all angles.
    """
    named = {wall.name: wall.reflectance for wall in ROOM.walls}
    order = ("floor", "ceiling", "far wall", "near wall", "left wall", "right wall")
    walls = np.array([library.reflectance(named[name]).sampled() for name in order]) @ filters
    n, k = (each.sampled() for each in library.conductor("gold"))
    plastic = ROOM.spheres[0]
    channels = fresnel.filtered_conductor(filters, n, k) if gold == "index" and filters.shape[1] < n.size else (n, k)

    def metal(cosines: np.ndarray) -> np.ndarray:
        if gold == "head on":
            cosines = np.ones_like(cosines)
        found = fresnel.reflectance(*channels, cosines[:, None])
        return found if len(channels[0]) == filters.shape[1] else found @ filters

    return enclosure.Surfaces(walls, library.reflectance(plastic.spectrum).sampled() @ filters, plastic.specular, metal)


def apart(room, space: str, lit: str, gold="index", shown: float | None = 98.0, limits=(380, 780)):
    """CIE 1994 of a prefiltered picture to full spectra (height, width), and what pixels see first.

    shown: percentile of luminance that is white; None for twice the median.
    """
    name, lamp = LIT[lit]
    light = library.illuminant(name)
    cmfs = library.observer() * ((limits[0] <= WAVELENGTHS) & (limits[1] >= WAVELENGTHS))[:, None]
    model = bases.prefiltered(light, SPACES[space])
    weights = power_weights(light.sampled(), cmfs)
    full, names = enclosure.look(room, surfaces(np.eye(WAVELENGTHS.size), gold), lamp, np.ones(WAVELENGTHS.size))
    reduced, _ = enclosure.look(room, surfaces(model.filters, gold), lamp, np.ones(model.channels))
    true, found = full @ weights, reduced @ model.relight(light).T
    white = weights.sum(axis=0)
    level = 2 * np.median(true[..., 1]) if shown is None else np.percentile(true[..., 1], shown)
    return differences.delta_E_1994(true / level, found / level, white / white[1]), names


AS_IT_IS = room_of()
CHANGES: dict[str, dict] = {
    "as it is": {},
    "gold: its colour at each angle": {"gold": "angle"},
    "gold: its colour head on, at all angles": {"gold": "head on"},
    "spheres of three quarters the size": {"room": room_of(spheres=0.75)},
    "spheres of half the size": {"room": room_of(spheres=0.5)},
    "a camera 1.2 times as wide": {"room": room_of(width=1.2)},
    "no light between walls": {"room": replace(AS_IT_IS, bounces=0)},
    "380 to 720 nm": {"limits": (380, 720)},
    "median half white": {"shown": None},
    "the brightest pixel white": {"shown": 100.0},
    "half the size, the brightest pixel white": {"room": room_of(spheres=0.5), "shown": 100.0},
}


def _cells(values: np.ndarray) -> str:
    return f"{np.median(values):.2f} / {np.percentile(values, 98):.2f}"


def sections() -> Iterator[Section]:
    """One thing changed at a time; what of the picture it is; what gold makes of what it mirrors."""
    columns = [(lit, space) for lit in LIT for space in SPACES]
    head = [f"{lit}, {space}" for lit, space in columns]
    rows = []
    for words, change in CHANGES.items():
        change = {"room": AS_IT_IS} | change
        rows.append([words, *(_cells(apart(space=space, lit=lit, **change)[0]) for lit, space in columns)])
    printed = [PRINTED[f"{lit}, prefiltered"][list(SPACES).index(space)] for lit, space in columns]
    rows.append(["printed", *(f"{a:.1f} / {b:.1f}" for a, b in printed)])
    words = (
        "Prefiltered, CIE 1994 to full spectra, 50th / 98th percentile of the pixels. No Monte Carlo: radiosity of the "
        "walls, rays into the spheres. The 98th percentile of luminance is shown as white unless said."
    )
    yield Section("One thing changed", words, ("", *head), rows)

    rows = []
    for size in (1.0, 0.5):
        maps = [apart(room_of(spheres=size), space, lit) for lit, space in columns]
        names = maps[0][1]
        for part in ("gold", "plastic", "walls"):
            seen = names == part
            rows.append([f"{size:g}", part, f"{100 * seen.mean():.0f} %", *(_cells(found[seen]) for found, _ in maps)])
    yield Section("By what is seen first", "The same, by size of the spheres.", ("size", "", "share", *head), rows)

    gold = fresnel.reflectance(*(each.sampled() for each in library.conductor("gold")), 1.0)
    rows = []
    for name in dict.fromkeys(wall.reflectance for wall in ROOM.walls):
        row = [name.split(": ")[1]]
        wall = library.reflectance(name).sampled()
        for lit, space in columns:
            light = library.illuminant(LIT[lit][0])
            model, weights = bases.prefiltered(light, SPACES[space]), power_weights(light.sampled(), library.observer())
            product = (wall @ model.filters) * (gold @ model.filters) @ model.relight(light).T
            error = differences.delta_E_1994((wall * gold) @ weights, product, weights.sum(axis=0))
            row.append(f"{error:.2f}")
        rows.append(row)
    words = "CIE 1994 of a wall lit by the lamp alone, seen in gold: nothing of a scene is in this."
    yield Section("Seen in gold", words, ("wall", *head), rows)


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m relume.benchmarks.room_exact", description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, metavar="DIR", help="write Markdown and CSV files there too")
    publish("room_exact", sections(), parser.parse_args(argv).out)


if __name__ == "__main__":
    main()
