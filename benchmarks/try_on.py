"""Another reflectance tried on in a finished render of the room, against the room rendered with it.

`python -m relume.benchmarks.try_on [--samples N] [--percent P]`

For a wall and for the plastic sphere: CIEDE2000 under both lamps, in the pixels that see the surface and in the others,
before and after the try-on; and what the surfaces' AOVs cost in memory and time.
"""

import argparse
import os
import tempfile
import time
from pathlib import Path

import bpy
import numpy as np

from ..addon.graph import spectra
from ..addon.scene import render, setup, surfaces
from ..core import Light, Mix, palette, recombination
from ..core.colour import differences
from ..core.model import bases
from ..core.spectra import library
from .room_accuracy import lit_xyz, open_room

LIGHTING = {"tungsten": "A", "fluorescent": "FL2"}
# material, and what is tried on it: the left wall, and the sphere that mirrors a little
TRIED = (("red", "ColorChecker: green"), ("red", "CES 30"), ("green plastic", "ColorChecker: orange"))


def _group_of(name):
    """The spectrum group of the material of that name."""
    material = bpy.data.materials[name]
    for node in material.node_tree.nodes:
        if node.type == "GROUP" and node.node_tree and spectra.SPECTRA in node.node_tree:
            return node.node_tree
    raise SystemExit(f"material {name!r} has no spectrum")


def _rendered(scene):
    began = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        done = render.render(scene, Path(folder))
    return done, time.perf_counter() - began


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--percent", type=int, default=20)
    arguments = parser.parse_args()
    from .. import register

    register()
    scene = open_room(arguments.samples, arguments.percent)
    setup.set_up(scene, bases.fitted(9))
    _, bare = _rendered(scene)
    without = surfaces.add(scene)
    before, carried = _rendered(scene)
    width, height = before.image.size
    model = before.image.model
    print(f"{model.passes} AOVs: {4 * 4 * model.passes} bytes a pixel, {bare:.1f} s without, {carried:.1f} s with them")
    print(f"materials without a colour to carry: {', '.join(without) or 'none'}")
    mix = Mix({group: Light(library.illuminant(name)) for group, name in LIGHTING.items()})
    white = recombination.mixed_white(model, mix)
    print("| surface | tried on | pixels | ΔE before | seen: median / p98 after | elsewhere: median / p98 |")
    print("| --- | --- | --- | --- | --- | --- |")
    for name, new in TRIED:
        tree, becomes = _group_of(name), library.reflectance(new)
        was = spectra.spectra_of(tree)["Color"]
        spectra.replace(tree, becomes)
        truth = _rendered(scene)[0].image
        spectra.replace(tree, was)
        groups = {}
        for group, values in before.image.groups.items():
            tried = palette.try_on(values, before.surface, model.coefficients(was), model.coefficients(becomes))
            groups[group] = tried.coefficients
        exact = lit_xyz(truth, LIGHTING)
        image = type(truth)(model, groups, truth.illuminants, truth.alpha)
        apart = [differences.picture_delta_E(lit_xyz(one, LIGHTING), exact, white) for one in (before.image, image)]
        seen, other = tried.seen, ~(tried.seen | tried.doubtful)
        words = [f"{np.median(apart[0][seen]):.1f}"]
        words += [
            f"{np.median(apart[1][mask]):.2f} / {np.percentile(apart[1][mask], 98):.2f}" for mask in (seen, other)
        ]
        print(f"| {name} | {new} | {seen.sum()} of {width * height} | {' | '.join(words)} |", flush=True)
    os._exit(0)  # bpy and OpenImageIO tear down in an order that reports leaks


if __name__ == "__main__":
    main()
