"""Relume's assets in the Asset Browser: in a window, for as long as the add-on is enabled."""

from pathlib import Path

import bpy

from ..host import asset_library

__all__ = ["FOLDER", "NAME", "register", "unregister"]

NAME = "Relume"
FOLDER = Path(__file__).resolve().parents[2] / "assets"


def register() -> None:
    if not bpy.app.background and (FOLDER / "library.blend").exists():
        asset_library.offer(NAME, FOLDER)


def unregister() -> None:
    if not bpy.app.background:
        asset_library.withdraw(NAME, FOLDER)
