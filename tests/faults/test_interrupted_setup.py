"""Set-up and *Remove*, stopped at any of their calls by an error or by Ctrl-C: done whole, or not at all.

A place is a call of a function of the add-on, or from it of one of `core` or of Blender's operators. What `core` calls
by itself finds the scene as it was. A first run counts the places.
"""

import inspect
import os
import random
import signal
import sys
from contextlib import suppress
from functools import partial

import pytest
from dump import differences as compared
from dump import dump

from . import outcome

bpy = pytest.importorskip("bpy", reason="the add-on needs bpy")

LAST_BITS = 1e-6  # numbers computed again may differ in BLAS's last bits
differences = partial(compared, tolerance=LAST_BITS)
FAST = 6  # places of each action and scene in `make test`


class Stopped(Exception):
    """An error that nobody expects."""


def fail():
    raise Stopped("injected")


def interrupt():
    raise KeyboardInterrupt


def press_ctrl_c():
    signal.raise_signal(signal.SIGINT)


STOPS = (fail, interrupt, press_ctrl_c)


def run(action, place: int = 0, stop=None) -> int:
    """Do it, and `stop` at the call of that number; returns how many calls there were."""
    from relume import addon, core

    count, own, others = 0, addon.__path__[0], (core.__path__[0], bpy.ops.__file__)

    def called(frame, event, _):
        nonlocal count
        if event != "call" or frame.f_code.co_flags & inspect.CO_GENERATOR:
            return
        name, caller = frame.f_code.co_filename, frame.f_back.f_code.co_filename if frame.f_back else ""
        if name.startswith(own) or (name.startswith(others) and caller.startswith(own)):
            count += 1
            if count == place:
                stop()

    sys.setprofile(called)
    try:
        action()
    finally:
        sys.setprofile(None)
    return count


def coloured():
    """A scene with RGB, a spectrum, a glass, coloured, glowing and animated lamps, and a mixer that was touched."""
    from relume.addon.graph import glass, spectra
    from relume.addon.scene import setup
    from relume.core.model import bases
    from relume.core.spectra import library

    bpy.ops.wm.read_factory_settings()
    scene = bpy.context.scene
    cube = bpy.data.objects["Cube"]
    shader = cube.active_material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (0.7, 0.2, 0.1, 1.0)
    shader.inputs["Base Color"].keyframe_insert("default_value", frame=1)
    shader.inputs["Emission Strength"].default_value = 0.5
    bpy.data.lights["Light"].color = (1.0, 0.8, 0.5)
    bpy.data.lights["Light"].keyframe_insert("color", frame=1)
    candle = bpy.data.lights.new("candle", "POINT")
    candle.use_temperature, candle.temperature = True, 1900
    scene.collection.objects.link(bpy.data.objects.new("candle", candle))
    for name, group in (("Light", "key"), ("Cube", "cube"), ("candle", "candle")):
        bpy.data.objects[name].lightgroup = group
    painted, prism = (bpy.data.materials.new(name) for name in ("painted", "prism"))
    red = spectra.new_reflectance(library.reflectance("ColorChecker: red"))
    spectra.assign(painted, painted.node_tree.nodes["Principled BSDF"].inputs["Base Color"], red)
    glass.replace(prism.node_tree.nodes.new("ShaderNodeBsdfGlass"), library.glass("BK7"))
    for material in (painted, prism):
        cube.data.materials.append(material)
    setup.set_up(scene, bases.fitted(3))
    scene.relume.light_groups["cube"].stops = 1.0
    scene.relume.light_groups["cube"].keyframe_insert("stops", frame=1)
    scene.relume.light_groups["candle"].illuminant = "A"
    setup.remove(scene)
    bpy.data.objects["candle"].lightgroup = "flame"  # and its row stays without lights
    return scene


def shared():
    """A scene beside another that has the same spectra and is set up with other channels."""
    from relume.addon.scene import setup
    from relume.assets import make_room
    from relume.core.model import bases

    bpy.ops.wm.open_mainfile(filepath=str(make_room.PATH))
    room = bpy.context.scene
    other = room.copy()
    setup.set_up(other, bases.fitted(6))
    other.relume.light_groups[0].stops = 1.0
    setup.update(other)  # its samples are dealt out for the mixer as it is
    return room


def again():
    """A scene that is set up with other channels."""
    from relume.addon.scene import setup
    from relume.core.model import bases

    scene = coloured()
    setup.set_up(scene, bases.fitted(6))
    scene.relume.light_groups["flame"].stops = -1.0
    setup.update(scene)
    return scene


def cases(count: int, part: float) -> list[tuple]:
    """(place, stop) of some of the places 1 to `count` by chance: in `make torture` a part of them, 1 for all."""
    chance, scale = random.Random(os.environ.get("RELUME_SEED", "0")), os.environ.get("RELUME_TORTURE")
    wanted = min(round(count * part * float(scale)) if scale else FAST, count)
    return [(place, chance.choice(STOPS)) for place in sorted(chance.sample(range(1, count + 1), wanted))]


def check(action, undo, part: float = 1.0) -> int:
    """Stop an action at its places: what it leaves is what was before it or what is after it. Returns how many.

    undo: brings back what was before.
    """
    from relume.core.errors import SetupError

    before = dump()
    count = run(action)
    after = dump()
    undo()
    assert differences(before, dump()) == [] != differences(before, after)
    done = cases(count, part)
    for place, stop in done:
        with suppress(Stopped, KeyboardInterrupt, SetupError):
            run(action, place, stop)
        now = dump()
        if differences(before, now):
            where = f"stopped by {stop.__name__} at call {place} of {count}"
            assert differences(after, now) == [], f"{where}, nothing of what was: {differences(before, now)}"
            undo()
            assert differences(before, dump()) == [], f"{where}, then undone"
    action()
    assert differences(after, dump()) == []
    return len(done)


@pytest.mark.parametrize(("build", "part"), [(coloured, 1.0), (shared, 0.125), (again, 0.125)])
def test_set_up_is_whole_or_not_at_all(relume, settle, build, part):
    from relume.addon.scene import setup
    from relume.core.model import bases

    scene = build()
    others = {each: each.relume.model() for each in bpy.data.scenes if each.relume.is_set_up}

    def undo():
        if scene not in others:
            setup.remove(scene)
        for each, model in others.items():
            setup.set_up(each, model)
            each["relume_plan"] = plans[each]

    plans = {each: each["relume_plan"].to_dict() for each in others}
    settle(outcome.RIGHT, check(lambda: setup.set_up(scene, bases.fitted(3)), undo, part))


@pytest.mark.parametrize("build", [coloured, shared])
def test_remove_is_whole_or_not_at_all(relume, settle, build):
    from relume.addon.scene import setup
    from relume.core.model import bases

    scene = build()
    setup.set_up(scene, bases.fitted(3))
    settle(outcome.RIGHT, check(lambda: setup.remove(scene), lambda: setup.set_up(scene, bases.fitted(3))))
