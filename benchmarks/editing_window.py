"""What an artist pays in the window for a scene that follows: playing it, and dragging a colour.

    BLENDER=/path/to/blender python -m relume.benchmarks.editing_window [--materials 10 1000] [--rounds 3]

The zip is built and installed in that Blender, with settings of its own. In its window a scene of
`benchmarks.conversion` is played and a colour dragged, 20 frames and 20 values, each drawn, in turn without Relume
and set up. Printed are milliseconds of the processor for each of them, and the ratio of the two: medians of all rounds.
"""

import argparse
import os
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

__all__ = ["main"]

_ROOT = Path(__file__).resolve().parents[1]
_PLATFORM = {"linux": "linux-x64", "darwin": "macos-arm64", "win32": "windows-x64"}[sys.platform]

_SESSION = """
import importlib.util
import os
import statistics
import sys
import time
import traceback

import bpy

PACKAGE = "bl_ext.user_default.relume"
FRAMES, VALUES = 20, 20


def module(name):
    return sys.modules[f"{PACKAGE}.{name}"]


def scenes():
    path = os.path.join(os.environ["RELUME_ROOT"], "benchmarks", "conversion.py")
    found = importlib.util.spec_from_file_location(f"{PACKAGE}.benchmarks.conversion", path)
    loaded = importlib.util.module_from_spec(found)
    found.loader.exec_module(loaded)
    return loaded


def played():
    scene, drawn = bpy.context.scene, []
    count = lambda *_: drawn.append(1)
    bpy.app.handlers.frame_change_post.append(count)
    began = time.process_time()
    bpy.ops.screen.animation_play()
    while len(drawn) < FRAMES:
        yield 0.01
    spent = time.process_time() - began
    bpy.app.handlers.frame_change_post.remove(count)
    bpy.ops.screen.animation_cancel()
    return 1e3 * spent / len(drawn)


def dragged():
    nodes = module("addon.graph.nodes")
    socket = nodes.holder(bpy.data.materials["material 1"].node_tree.nodes["Principled BSDF"].inputs["Coat Tint"])
    path = socket.path_from_id("default_value").rpartition(".")[0]
    spent = 0.0
    for value in range(VALUES):
        began = time.process_time()
        tree = bpy.data.materials["material 1"].node_tree
        tree.path_resolve(path).default_value = (0.9, 0.5, value / VALUES, 1.0)
        bpy.ops.wm.redraw_timer(type="DRAW_WIN_SWAP", iterations=1)
        spent += time.process_time() - began
        if value % 5 == 4:
            yield 0.0
    return 1e3 * spent / VALUES


def settled():
    timers, tick = bpy.app.timers, module("addon.scene.follower").tick
    yield 0.5
    while timers.is_registered(tick):
        yield 0.1


def steps():
    setup = module("addon.scene.setup")
    materials = int(os.environ["RELUME_MATERIALS"])
    scene = scenes().generate(materials, is_new=False)
    scene.render.fps, scene.frame_end = 1000, 100000
    scene.sync_mode = "NONE"
    for area in bpy.context.window.screen.areas:
        if area.type == "VIEW_3D":  # what is drawn over the scene may take longer than the scene
            area.spaces.active.overlay.show_overlays = False
    bpy.data.objects["object 1"].keyframe_insert("rotation_euler", frame=1)
    bpy.data.objects["object 1"].rotation_euler[0] = 3.0
    bpy.data.objects["object 1"].keyframe_insert("rotation_euler", frame=1000)
    found = {}
    for turn in range(int(os.environ["RELUME_ROUNDS"]) + 1):
        for state in ("bare", "with"):
            if state == "with":
                setup.set_up(scene)
            yield from settled()
            for kind in (played, dragged):
                spent = yield from kind()
                if turn:  # the first time Blender makes what it draws with
                    found.setdefault((kind.__name__, state), []).append(spent)
                yield from settled()
            if state == "with":
                setup.remove(scene)
    for kind in ("played", "dragged"):
        bare, own = (statistics.median(found[kind, state]) for state in ("bare", "with"))
        report(f"{materials:>9}  {kind:<9}{bare:>10.2f}{own:>10.2f}{own / bare:>9.3f}")
    bpy.context.preferences.use_preferences_save = False
    bpy.ops.wm.quit_blender()


def report(line):
    with open(os.environ["RELUME_REPORT"], "a") as file:
        print(line, file=file)


def advance():
    try:
        with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
            return next(session)
    except StopIteration:
        return None
    except Exception:
        report(traceback.format_exc())
        os._exit(1)  # a timer's exception would leave Blender open


session = steps()
bpy.context.preferences.view.show_splash = False
bpy.app.timers.register(advance, first_interval=2.0)
"""


def _window(command: list[str]) -> list[str]:
    """The command that runs a script in a window."""
    *tool, last = command
    return [*tool, "gui"] if tool and Path(tool[-1]).name == "blender-app" else [*tool, last, "--python"]


def main(argv: list[str] | None = None):
    parser = argparse.ArgumentParser(prog="python -m relume.benchmarks.editing_window", description=__doc__)
    parser.add_argument("--materials", type=int, nargs="+", default=[10, 1000], metavar="N")
    parser.add_argument("--rounds", type=int, default=3, metavar="N")
    arguments = parser.parse_args(argv)
    if "BLENDER" not in os.environ:
        parser.error("BLENDER is not set to a command that runs Blender")
    blender = shlex.split(os.environ["BLENDER"])
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        environment = os.environ | {
            "BLENDER_USER_RESOURCES": str(out / "blender"),
            "RELUME_ROOT": str(_ROOT),
            "RELUME_ROUNDS": str(arguments.rounds),
            "RELUME_REPORT": str(out / "report.txt"),
            "GUI_WAIT": "1200",
        }

        def run(*words, **more) -> str:
            done = subprocess.run(
                [*map(str, words)], cwd=_ROOT, env=environment | more, stdout=subprocess.PIPE, text=True
            )
            if done.returncode:
                told = out / "report.txt"
                raise SystemExit(f"{done.stdout}\n{told.read_text() if told.exists() else ''}")
            return done.stdout

        printed = run(*blender, "-b", "--python-expr", "import sys; print('runs Python %d.%d' % sys.version_info[:2])")
        python = printed.split("runs Python ")[1].split()[0]
        run(sys.executable, "tools/build_extension.py", "--platform", _PLATFORM, "--python", python, "--out", out)
        (built,) = out.glob("*.zip")
        run(*blender, "--command", "extension", "install-file", "--repo", "user_default", "--enable", built)
        session = out / "session.py"
        session.write_text(_SESSION)
        for materials in arguments.materials:
            run(*_window(blender), session, RELUME_MATERIALS=str(materials))
        print(f"{'materials':>9}  {'':<9}{'without':>10}{'set up':>10}{'ratio':>9}  (ms of the processor)")
        print((out / "report.txt").read_text(), end="")


if __name__ == "__main__":
    main()
