"""Opening a .blend for a command."""

import os
import re
from pathlib import Path

import bpy

from ...core.errors import RelumeError, UsageError
from . import console

__all__ = ["first_line", "located", "open_scene"]

# What Blender tells a user; its "WARNING" and "ERROR" are for developers
_WARNING = re.compile(r"(?:Warning|Error): (.+)")


def located(text: str) -> Path:
    """The path that a user means: ~ is the home folder, // that of the .blend that is open. Raises UsageError."""
    if text.startswith("//"):
        if not bpy.data.filepath:
            raise UsageError(f"{text}: // is the folder of the .blend, and none is open here; write the folder itself")
        return Path(bpy.data.filepath).parent / text[2:]
    try:
        path = Path(text).expanduser()
    except RuntimeError as error:
        raise UsageError(f"{text}: there is no such home folder") from error
    # new/../x would need the folder that nobody asks for
    return path if path.parent.is_dir() or ".." not in path.parts else Path(os.path.normpath(path))


def first_line(error: Exception) -> str:
    """What Blender says, in one line."""
    lines = str(error).strip().removeprefix("Error: ").removeprefix("Warning: ").splitlines()
    return lines[0] if lines else type(error).__name__


def open_scene(path: Path, remarks: bool = True):
    """The scene of a .blend, which is open afterwards. Raises UsageError, RelumeError.

    remarks: say what Blender warns of, and which drivers do not work.
    """
    if path.is_dir():
        raise UsageError(f"{path}: is a folder; expected a .blend file")
    if not path.exists():
        raise UsageError(f"{path}: no such file")
    if not path.is_file():
        raise UsageError(f"{path}: is a device or a pipe; expected a .blend file")
    loaded = []

    @bpy.app.handlers.persistent
    def note(*_) -> None:
        loaded.append(True)

    bpy.app.handlers.load_post.append(note)
    try:
        with console.heard() as lines:
            bpy.ops.wm.open_mainfile(filepath=os.path.abspath(path), load_ui=False)
    except RuntimeError as error:
        # Blender raises for what it only warns of as well
        if not loaded:
            raise RelumeError(f"{path}: not a file that Blender can open ({first_line(error)})") from error
        lines += str(error).splitlines()
    finally:
        bpy.app.handlers.load_post.remove(note)
    with console.heard():
        bpy.context.view_layer.update()  # drivers run, and those that fail say so in many lines
    warnings = dict.fromkeys(found[1] for line in lines if (found := _WARNING.fullmatch(line)))
    if warnings and remarks:
        console.say(f"{path}: {'; '.join(warnings)}")
    broken = _broken_drivers() if remarks else ()
    if broken:
        more = f" and {len(broken) - 3} more" if len(broken) > 3 else ""
        console.say(f"{path}: drivers do not work and are left as they are: {', '.join(broken[:3])}{more}")
    return bpy.context.scene


def _broken_drivers() -> list[str]:
    found = []
    for block in bpy.data.user_map():
        for owner in (block, getattr(block, "node_tree", None)):
            animation = getattr(owner, "animation_data", None)
            for curve in animation.drivers if animation else ():
                if not (curve.is_valid and curve.driver.is_valid):
                    found.append(f"{curve.data_path} of {block.name}")
    return found
