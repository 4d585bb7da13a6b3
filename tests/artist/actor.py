"""A Blender of its own, told what to do through a pipe: an artist's session, its twin without Relume, or the checker.

`python -m tests.artist.actor FD LOG` is asked (name of a function of `COMMANDS`, its arguments) and answers (result,
error, what Blender printed).
"""

import faulthandler
import os
import random
import sys
import traceback
from multiprocessing.connection import Connection
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests" / "addon")]

import bpy  # noqa: E402

import relume  # noqa: E402
from relume.addon.scene import follower, rows, setup  # noqa: E402
from relume.addon.store import properties  # noqa: E402

from . import compositing, kinds, lighting, scenes, session, shading, staging  # noqa: E402, F401
from .carried import carried  # noqa: E402
from .kinds import EDITS  # noqa: E402
from .plain import plain, unlike  # noqa: E402

_UNDO = {"undo", "redo", "undo_twice_and_redo", "save_and_reload"}  # these push no step, or begin anew


def _set_up() -> list:
    return [scene for scene in bpy.data.scenes if scene.library is None and scene.relume.is_set_up]


def names() -> tuple[list[str], list[str]]:
    """The scenes and the kinds of edits that there are."""
    return list(scenes.SCENES), list(EDITS)


def library(path: str) -> None:
    session.make_library(Path(path))


def begin(scene: str, channels: str, with_relume: bool, folder: str) -> None:
    """Build a scene, set it up, and let its history begin there."""
    session.keep_files_in(Path(folder))
    scenes.build(scene, channels)
    if with_relume:
        for each in list(bpy.data.scenes):
            setup.set_up(each)
    bpy.context.view_layer.update()
    bpy.ops.ed.undo_push(message="begin")


def do(kind: str, number: int, follow: bool) -> str | None:
    """Make one edit, as an artist would, with its undo step; then pause, if the follower is to have its turn."""
    words = EDITS[kind](random.Random(number), bpy.context.scene)
    if kind == "save_and_reload" or (words and kind not in _UNDO):
        bpy.ops.ed.undo_push(message=kind)
    bpy.context.view_layer.update()
    if follow:
        _pause()
    return words


def _pause() -> None:
    bpy.context.view_layer.update()
    if _set_up():
        follower.follow()


kinds.pause = _pause


def _show_frames() -> None:
    """Give what is animated the value of its frame, as a render does."""
    for scene in bpy.data.scenes:
        if scene.library is None:
            scene.frame_set(scene.frame_current)


def keep(path: str) -> dict:
    """Settle every scene that is set up, and save a copy of the file; returns what it carries."""
    _show_frames()
    follower.settle_all()
    found = carried()
    bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
    return found


def compare(artists: str, twins: str, carries: dict) -> list[str]:
    """Where a copy of an artist's file, which `carries` that, differs from one set up afresh, and from the twin's.

    Each line begins with what differs: "loaded" the file from the session, "afresh" the session from a fresh set-up,
    "removed" the file after *Remove* from the one that never had Relume.
    """
    from dump import differences

    loaded = _opened(artists)
    _afresh()
    afresh = carried()
    _opened(artists)
    for scene in _set_up():
        setup.remove(scene)
    removed = plain()
    _opened(twins)
    found = {
        "loaded": differences(carries, loaded),
        "afresh": differences(afresh, carries),
        "removed": unlike(plain(), removed),
    }
    return [f"{stage}{line}" for stage, lines in found.items() for line in lines]


def _opened(path: str) -> dict:
    """Open a file; returns what it carries."""
    bpy.ops.wm.open_mainfile(filepath=path)
    _show_frames()
    return carried()


def _afresh() -> None:
    """Remove the set-up of every scene, and set them up again with the models that they had."""
    models = {s: (s.relume.model(), s[properties.PLAN].to_dict(), s.render.engine) for s in _set_up()}
    for scene in models:
        unlit = rows.unlit(scene)
        setup.remove(scene)
        for name in unlit:  # else the only one may be taken for a group that got another name meanwhile
            scene.relume.light_groups[name].is_lit = False
    for scene, (model, plan, engine) in models.items():
        setup.set_up(scene, model)
        scene[properties.PLAN] = plan
        if engine != scene.render.engine:  # set-up chooses Cycles, and an artist something else again
            scene.render.engine = engine
    follower.settle_all()


def pictures(path: str, folder: str) -> list[str]:
    """Where renders of a file differ from renders of it after a fresh set-up."""
    _opened(path)
    names = [scene.name for scene in _set_up() if scene.render.engine == "CYCLES" and scene.camera]
    before = {name: _rendered(bpy.data.scenes[name], folder) for name in names}
    _opened(path)
    _afresh()
    return [line for name in names for line in _unlike(name, before[name], _rendered(bpy.data.scenes[name], folder))]


def _rendered(scene, folder: str) -> dict:
    """{layer, pass and channel: pixels} of a render, all layers and the composited picture."""
    import OpenImageIO as oiio

    output, path = scene.render.image_settings, f"{folder}/picture.exr"
    output.media_type, output.color_depth, scene.render.filepath = "MULTI_LAYER_IMAGE", "32", path
    bpy.ops.render.render(write_still=True, scene=scene.name)
    image, found, part = oiio.ImageInput.open(path), {}, 0
    while image.seek_subimage(part, 0):
        spec, pixels = image.spec(), image.read_image(part, 0, 0, image.spec().nchannels, "float")
        name = spec.get_string_attribute("oiio:subimagename")
        found |= {f"{name} {channel}": pixels[..., k] for k, channel in enumerate(spec.channelnames)}
        part += 1
    image.close()
    return found


def _unlike(name: str, before: dict, after: dict) -> list[str]:
    lines = [
        f"pictures/{name}/{key}: only {'before' if key in before else 'afresh'}" for key in before.keys() ^ after.keys()
    ]
    for key in before.keys() & after.keys():
        if before[key].shape != after[key].shape or before[key].tobytes() != after[key].tobytes():
            size = abs(before[key] - after[key]).max() if before[key].shape == after[key].shape else "size"
            lines.append(f"pictures/{name}/{key}: differs by {size}")
    return sorted(lines)


COMMANDS = {function.__name__: function for function in (names, library, begin, do, keep, compare, pictures)}


def main() -> None:
    pipe, log = Connection(int(sys.argv[1])), sys.argv[2]
    printed = os.open(log, os.O_CREAT | os.O_TRUNC | os.O_RDWR)
    for number in (1, 2):
        os.dup2(printed, number)
    faulthandler.enable()
    relume.register()
    pipe.send("ready")
    while True:
        try:
            name, arguments = pipe.recv()
        except EOFError:
            return
        begun, result, error = os.fstat(printed).st_size, None, ""
        try:
            result = COMMANDS[name](*arguments)
        except Exception:
            error = traceback.format_exc()
        sys.stdout.flush()
        sys.stderr.flush()
        pipe.send((result, error, os.pread(printed, 1 << 20, begun).decode(errors="replace")))


if __name__ == "__main__":
    main()
