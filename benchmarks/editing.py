"""What an artist pays for a scene that follows: milliseconds for each edit, and when playing, rendering and saving.

    python -m relume.benchmarks.editing [--materials 10 100 1000 2000] [--repeats 3]

Scenes are those of `benchmarks.conversion`, in which every material shines. For each kind of edit:

- *noticed*: time in the handler that Blender calls after the edit, while the artist still works;
- *longest*: the longest piece of work at a time once the artist pauses;
- *followed*: all pieces together;
- *Blender*: the longest that Blender then evaluates what was changed, as it does after any edit.

Then, at the end: looking at a scene for the first time, a render start or a save with nothing left to do, and as parts
of the same without Relume, in one run: 50 frames played, and a colour dragged through 100 values. All is time of the
processor; `benchmarks.editing_window` plays and drags in the window.
"""

import argparse
import statistics
import time
from collections.abc import Callable
from functools import cache

import bpy

from ..addon.graph import nodes
from ..addon.host import viewing
from ..addon.scene import follower, setup
from .conversion import generate

__all__ = ["main"]

_FRAMES = 50
_VALUES = 100


class _Clock:
    """Stands in for a handler, and adds up the seconds that it takes."""

    def __init__(self, handler) -> None:
        self.handler, self.seconds = handler, 0.0

    def __call__(self, *arguments) -> None:
        began = time.thread_time()
        self.handler(*arguments)
        self.seconds += time.thread_time() - began


@cache
def _evaluation() -> _Clock:
    clock = viewing.update = _Clock(viewing.update)
    return clock


@cache
def _clocked() -> _Clock:
    handlers = bpy.app.handlers.depsgraph_update_post
    at = next(i for i, handler in enumerate(handlers) if "relume" in handler.__module__)
    clock = _Clock(handlers[at])

    @bpy.app.handlers.persistent
    def timed(*arguments) -> None:
        clock(*arguments)

    handlers[at] = timed
    return clock


def _seconds(what: Callable, *arguments) -> float:
    began = time.thread_time()
    what(*arguments)
    return time.thread_time() - began


def _pieces() -> tuple[list[float], float]:
    """Follow as Blender's timer does; the seconds of each piece, and the most that Blender evaluated after one."""
    pieces, most, wait, evaluation = [], 0.0, 0.0, _evaluation()
    while wait is not None:
        if wait > 0.02:
            time.sleep(wait)
        began, evaluation.seconds = time.thread_time(), 0.0
        wait = follower.tick()
        pieces.append(time.thread_time() - began - evaluation.seconds)
        most = max(most, evaluation.seconds)
        bpy.context.view_layer.update()
    return pieces, most


def _colour(material):
    """The socket in which an artist finds the coat's tint."""
    return nodes.holder(material.node_tree.nodes["Principled BSDF"].inputs["Coat Tint"])


def _edits(scene) -> dict[str, Callable[[int], None]]:
    material, thing = bpy.data.materials["material 1"], bpy.data.objects["object 1"]
    lamp = next(light for light in bpy.data.lights if light.users)

    def add(turn: int) -> None:
        made = bpy.data.objects.new(f"new {turn}", thing.data.copy())
        made.data.materials[0] = bpy.data.materials.new(f"new {turn}")
        colour = made.data.materials[0].node_tree.nodes["Principled BSDF"].inputs["Base Color"]
        colour.default_value = (0.8, 0.2, 0.1 * turn, 1.0)
        scene.collection.objects.link(made)

    return {
        "a colour": lambda turn: setattr(_colour(material), "default_value", (0.9, 0.5, 0.1 + 0.1 * turn, 1.0)),
        "an object moved": lambda turn: setattr(thing, "location", (turn, 0.0, 1.0)),
        "an object added": add,
        "a lamp's colour": lambda turn: setattr(lamp, "color", (1.0, 0.5, 0.1 + 0.1 * turn)),
        "samples": lambda turn: setattr(scene.cycles, "samples", 64 + turn),
    }


def _play(scene) -> None:
    for frame in range(1, _FRAMES + 1):
        scene.frame_set(frame)


def _drag(material) -> None:
    path = _colour(material).path_from_id()
    for value in range(_VALUES):
        material.node_tree.path_resolve(path).default_value = (0.9, 0.5, value / _VALUES, 1.0)
        bpy.context.view_layer.update()


def _measure(materials: int, repeats: int) -> None:
    scene, clock = generate(materials), _clocked()
    material, thing = bpy.data.materials["material 1"], bpy.data.objects["object 1"]
    scene.camera.keyframe_insert("location", frame=1)
    thing.keyframe_insert("rotation_euler", frame=1)
    plain = {kind: [] for kind in ("played", "dragged")}
    bare = {"played": lambda: _play(scene), "dragged": lambda: _drag(material)}
    for _ in range(repeats + 1):
        for kind, what in bare.items():
            plain[kind].append(_seconds(what))
    setup.set_up(scene)
    bpy.context.view_layer.update()
    first, _ = _pieces()

    for name, edit in _edits(scene).items():
        edit(0)  # the first may make node groups that others only use
        bpy.context.view_layer.update()
        _pieces()
        noticed, longest, followed, evaluated = [], [], [], []
        for turn in range(1, repeats + 1):
            edit(turn)
            clock.seconds = 0.0
            bpy.context.view_layer.update()
            noticed.append(clock.seconds)
            time.sleep(0.26)
            pieces, most = _pieces()
            longest.append(max(pieces))
            followed.append(sum(pieces))
            evaluated.append(most)
        columns = [1e3 * statistics.median(each) for each in (noticed, longest, followed, evaluated)]
        print(f"{materials:>9}  {name:<18}" + "".join(f"{each:>11.1f}" for each in columns), flush=True)

    settled = statistics.median(_seconds(follower.settle, scene) for _ in range(repeats))
    print(f"{materials:>9}  {'looked at first':<18}{'':>11}{1e3 * max(first):>11.1f}{1e3 * sum(first):>11.1f}")
    print(f"{materials:>9}  {'rendered, saved':<18}{'':>11}{1e3 * settled:>11.1f}{1e3 * settled:>11.1f}")
    for kind, what in bare.items():
        with_relume = statistics.median(_seconds(what) for _ in range(repeats + 1))
        ratio = with_relume / statistics.median(plain[kind])
        print(f"{materials:>9}  {kind:<18}{ratio:>33.3f} of the same without Relume", flush=True)
        _pieces()


def main(argv: list[str] | None = None):
    parser = argparse.ArgumentParser(prog="python -m relume.benchmarks.editing", description=__doc__)
    parser.add_argument("--materials", type=int, nargs="+", default=[10, 100, 1000, 2000], metavar="N")
    parser.add_argument("--repeats", type=int, default=3, metavar="N")
    arguments = parser.parse_args(argv)

    from .. import register

    register()
    print(
        f"{'materials':>9}  {'edit':<18}"
        + "".join(f"{name:>11}" for name in ("noticed", "longest", "followed", "Blender"))
        + "  (ms)"
    )
    for count in arguments.materials:
        _measure(count, arguments.repeats)


if __name__ == "__main__":
    main()
