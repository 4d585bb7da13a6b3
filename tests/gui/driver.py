"""Runs inside Blender: takes the steps of the script $WINDOW_STEPS in the window, photographs it, and quits.

Where the variable GUI_SHOT names a file, whoever watches that file takes the pictures: a path written there is taken
and the file removed. Elsewhere Blender photographs itself.
"""

import os
import runpy
import traceback
from pathlib import Path

import bpy

SCRIPT = Path(os.environ["WINDOW_STEPS"])
SHOT = Path(os.environ["GUI_SHOT"]) if "GUI_SHOT" in os.environ else None
REDRAWN = 0.5  # seconds after which Blender has drawn what a step changed


def take_steps():
    for name in runpy.run_path(str(SCRIPT))["steps"]():
        yield REDRAWN
        if name is not None:
            yield from photograph(SCRIPT.with_name(name))


def photograph(path: Path):
    if SHOT is None:
        bpy.ops.screen.screenshot(filepath=str(path))
        return
    SHOT.write_text(str(path))
    while SHOT.exists():
        yield 0.1


def advance() -> float | None:
    """Take the next step; a timer's seconds until the one after it."""
    try:
        with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
            return next(steps)
    except StopIteration:
        bpy.ops.wm.quit_blender()
    except Exception:
        traceback.print_exc()
        os._exit(1)  # a timer's exception would leave Blender open


bpy.context.preferences.view.show_splash = False
bpy.context.preferences.use_preferences_save = False  # one test leaves nothing to the next
steps = take_steps()
# A script may load another file.
bpy.app.timers.register(advance, first_interval=REDRAWN, persistent=True)
