"""A scene that a script builds, saved as a .blend."""

import sys
from collections.abc import Callable
from pathlib import Path

import bpy

__all__ = ["save_built"]


def save_built(build: Callable[[], object], path: Path, arguments: list[str] | None = None) -> None:
    """Build a scene with Relume registered and save it, at the path that the command line names or at `path`."""
    from .. import register

    if not hasattr(bpy.types.Scene, "relume"):
        register()
    chosen = Path((arguments or sys.argv[1:] or [path])[0])
    build()
    bpy.ops.wm.save_as_mainfile(filepath=str(chosen.resolve()), compress=True)
    print(chosen)
