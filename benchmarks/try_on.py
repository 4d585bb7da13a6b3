"""Other reflectances tried on in finished renders, against the scenes rendered with them.

`python -m relume.benchmarks.try_on [--samples N] [--percent P] [--scene room|interior|spheres]`

The room; an interior, the same room with a varnished floor and a sphere of glass; and spheres of five paints on the
ground, one of them of varnished red, under the sun and a bright sky. For each material CIEDE2000 in the pixels that are
the material, and in the others: before, by new over old alone, and as the editor does it, beside what that expects; and
what carrying surfaces costs in memory and time.
"""

import argparse
import os
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import bpy
import numpy as np

from ..addon.graph import places, spectra
from ..addon.scene import render, render_settings, setup, surfaces
from ..assets import spheres
from ..core import Light, Mix, palette, recombination
from ..core.colour import differences
from ..core.model import bases
from ..core.spectra import library
from .hard_scenes import glossy_and_glass
from .room_accuracy import open_room


class _Case(NamedTuple):
    build: Callable
    lights: dict
    tried: tuple  # (material, what is tried on it)


_LAMPS = {"tungsten": "A", "fluorescent": "FL2"}
_SCENES = {
    "room": _Case(
        lambda: open_room(1, 100),
        _LAMPS,
        (("red", "ColorChecker: green"), ("red", "CES 30"), ("green plastic", "ColorChecker: orange")),
    ),
    "interior": _Case(
        glossy_and_glass,
        _LAMPS,
        (("ShaderNodeBsdfPrincipled", "ColorChecker: green"), ("blue", "ColorChecker: yellow")),
    ),
    "spheres": _Case(
        lambda: spheres.build([library.reflectance(name) for name in spheres.PAINTS]),
        {"sun": "D50", "sky": "D65"},
        (("ColorChecker: red", "ColorChecker: blue"), ("ColorChecker: yellow", "CES 30"), ("CES 30", "CES 60")),
    ),
}


def _worn(material, spectrum=None):
    """The spectrum that a material has, or had until it is given another."""
    nodes = material.node_tree.nodes
    found = [(nodes[name], key) for name, key, takes in places.of(material) if takes == places.REFLECTANCE]
    sockets = [places.socket_of(node, key) for node, key in found]
    trees = [spectra.source_of(socket) for socket in sockets]
    tree = next((tree for tree in trees if tree is not None and spectra.SPECTRA in tree), None)
    if tree is None:
        return spectra.assign(material, sockets[0], spectra.new_reflectance(spectrum))
    before = spectra.spectra_of(tree)["Color"]
    if spectrum is not None:
        spectra.replace(tree, spectrum)
    return before


def _rendered(scene):
    began = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        done = render.render(scene, Path(folder))
    return done, time.perf_counter() - began


def _said(values) -> str:
    return " / ".join(f"{value:.2f}" for value in np.percentile(values, (50, 90, 99))) if values.size else "-"


def _judge(name: str, arguments) -> list[str]:
    """The lines of the table for one scene."""
    case = _SCENES[name]
    scene = case.build()
    scene.render.resolution_percentage, scene.cycles.samples = arguments.percent, arguments.samples
    render_settings.compare(scene)
    for material in [bpy.data.materials[material] for material, _ in case.tried]:
        if not any(node.type == "GROUP" and spectra.SPECTRA in node.node_tree for node in material.node_tree.nodes):
            _worn(material, library.reflectance("ColorChecker: dark skin"))
    setup.set_up(scene, bases.fitted(9))
    _, bare = _rendered(scene)
    without = surfaces.add(scene)
    before, carried = _rendered(scene)
    megabytes = surfaces.cost(scene) / 1e6
    print(f"{name}: surfaces cost {megabytes:.1f} MB, {bare:.1f} s without, {carried:.1f} s with them", flush=True)
    print(f"{name}: without a colour to carry: {', '.join(without) or 'none'}", flush=True)
    model = before.image.model
    lights = {group: Light(library.illuminant(case.lights.get(group, "D65"))) for group in before.image.groups}
    mix = Mix(lights)
    white = recombination.mixed_white(model, mix)

    def apart(groups, truth):
        pictures = (recombination.color_of(model, mix, list(each.values())) for each in (groups, truth))
        return differences.picture_delta_E(*pictures, white)

    lines = []
    for worn, new in case.tried:
        material, becomes = bpy.data.materials[worn], library.reflectance(new)
        was = _worn(material, becomes)
        truth = _rendered(scene)[0].image.groups
        _worn(material, was)
        covered = before.materials[worn]
        here, there = covered > 0.99, covered < 0.01
        wears = [palette.Worn(worn, model.coefficients(becomes), surfaces.mirrors(material))]
        done = palette.trial(model, mix, before.image.groups, before.surface, before.materials, wears)
        old, seen = model.coefficients(was), here[..., None] * before.surface
        alone = {
            group: palette.try_on(values, seen, old, model.coefficients(becomes)).coefficients
            for group, values in before.image.groups.items()
        }
        errors = [apart(groups, truth) for groups in (before.image.groups, alone, done.groups)]
        words = [name, worn, new, f"{np.median(errors[0][here]):.1f}"]
        words += [_said(errors[1][here]), _said(errors[2][here]), _said(done.expected[here])]
        words += [_said(errors[0][there]), _said(errors[2][there]), _said(done.expected[there])]
        hatched = done.expected > palette.HATCHED
        words += [f"{100 * hatched.mean():.0f} %"]
        lines.append(f"| {' | '.join(words)} |")
        print(lines[-1], flush=True)
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--percent", type=int, default=25)
    parser.add_argument("--scene", choices=_SCENES)
    arguments = parser.parse_args()
    from .. import register

    register()
    lines = [line for name in _SCENES if arguments.scene in (None, name) for line in _judge(name, arguments)]
    columns = ["scene", "material", "tried on", "before", "new over old", "told apart", "expected"]
    columns += ["elsewhere: before", "elsewhere: told apart", "expected", "hatched"]
    print("| " + " | ".join(columns) + " |\n|" + " --- |" * len(columns))
    print("\n".join(lines), flush=True)
    os._exit(0)  # bpy and OpenImageIO tear down in an order that reports leaks


if __name__ == "__main__":
    main()
