"""Build a still life of measured spectra, under four lights, and save it: `python -m relume.assets.still_life [PATH]`.

Fruit, glass, metal, a cloth and a print on the wall. The print is painted with three metamers that a palette designed:
one grey in daylight, a landscape under other lamps.
"""

from pathlib import Path

import bpy
from mathutils import Vector

from ..core.picture.mix import Light
from ..core.spectra import library
from . import still_life_things as things
from .saving import save_built

__all__ = ["LIGHTS", "PATH", "build", "main"]

PATH = Path(__file__).with_name("still_life.blend")


def _mix(**lights: tuple[str, float]) -> dict[str, Light]:
    """What shines in each light group: {group: Light}; those that are not named are out."""
    return {
        group: Light(library.illuminant(name), gain)
        for group in ("window", "candle", "bulb", "tube")
        for name, gain in [lights.get(group, ("D65", 0.0))]
    }


LIGHTS = {
    "a north window, and a candle": lambda: _mix(window=("D65", 0.8), candle=("Planckian 1900 K", 1.0)),
    "the candle, and dusk": lambda: _mix(window=("D 12000 K", 0.09), candle=("Planckian 1900 K", 3.2)),
    "a fluorescent tube": lambda: _mix(tube=("FL2", 1.0), candle=("Planckian 1900 K", 0.3)),
    "a sodium street lamp outside": lambda: _mix(window=("Sodium (low pressure)", 0.9), bulb=("LED-B1", 0.05)),
}


_ILLUMINANTS = {"window": "D65", "candle": "Planckian 1900 K", "bulb": "LED-B1", "tube": "FL2"}


def build():
    """Empty the file and build the still life in it; returns the scene."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.name = "Still life"
    scene.world = None
    things.room(scene)
    things.landscape(scene)
    things.bowl_of_fruit(scene)
    things.lemons(scene)
    things.glasses(scene)
    things.candlestick(scene)
    things.napkin(scene)
    _lamps(scene)
    _camera(scene)
    _choose_settings(scene)
    return scene


def _lamps(scene):
    _area(scene, "window", (-1.25, -0.55, 0.95), (0.0, 0.05, 0.05), (0.8, 1.0), 45.0)
    _area(scene, "bulb", (1.1, 0.5, 0.9), (0.0, 0.05, 0.08), (0.12, 0.12), 16.0)
    _area(scene, "tube", (0.0, -0.35, 1.3), (0.0, 0.15, 0.0), (1.2, 0.05), 26.0)

    first = next(iter(LIGHTS.values()))()
    for name, illuminant in _ILLUMINANTS.items():
        row = scene.relume.light_groups.add()
        row["name"], row["illuminant"], row.gain = name, illuminant, first[name].gain


def _area(scene, name, place, aim, size, watts):
    light = bpy.data.lights.new(name, "AREA")
    light.shape, light.size, light.size_y, light.energy = "RECTANGLE", *size, watts
    thing = bpy.data.objects.new(name, light)
    thing.location, thing.lightgroup = place, name
    thing.rotation_euler = (Vector(aim) - Vector(place)).to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(thing)


def _camera(scene):
    data = bpy.data.cameras.new("camera")
    data.lens, data.clip_start = 67.0, 0.01
    data.dof.use_dof, data.dof.aperture_fstop, data.dof.focus_distance = True, 11.0, 1.42
    camera = bpy.data.objects.new("camera", data)
    camera.location = (0.0, -1.5, 0.39)
    camera.rotation_euler = (Vector((0.0, 0.05, 0.116)) - camera.location).to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(camera)
    scene.camera = camera


def _choose_settings(scene):
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = 1600, 900
    scene.view_settings.view_transform = "AgX"
    scene.view_settings.look = "AgX - Medium High Contrast"
    cycles = scene.cycles
    cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = 96, False, False
    cycles.max_bounces, cycles.diffuse_bounces, cycles.glossy_bounces, cycles.transmission_bounces = 12, 3, 4, 12
    cycles.caustics_refractive = cycles.caustics_reflective = False
    # Clamping is not linear: it would act on every pass by itself
    cycles.sample_clamp_indirect = cycles.sample_clamp_direct = 0.0
    for name in ("window", "candle", "bulb", "tube"):
        scene.view_layers[0].lightgroups.add(name=name)


def main(arguments=None):
    save_built(build, PATH, arguments)


if __name__ == "__main__":
    main()
