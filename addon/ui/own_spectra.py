"""The user's own library: files of spectra in the folders that the preferences name, offered where Relume's own are."""

import os
from pathlib import Path

import bpy

from ..store import preferred
from .spectrum_types import EXTENSIONS, TEXT

__all__ = ["LAMPS", "PAINTS", "is_own", "listed"]

LAMPS, PAINTS = "lamp_folder", "paint_folder"
_MOST = 2000  # files of a folder
_ENDS = {*EXTENSIONS, *TEXT}
_known = {}  # folder: (when it changed, its files). Blender keeps no reference to the strings


def listed(which: str) -> list[tuple[str, str]]:
    """(path, name without ending) of each file in a folder of the preferences, `LAMPS` or `PAINTS`, by name."""
    preferences = preferred.of()
    folder = bpy.path.abspath(getattr(preferences, which, "") or "")
    if not folder:
        return []
    try:
        changed = os.stat(folder).st_mtime_ns
        if _known.get(folder, (None,))[0] != changed:
            found = sorted(path for path in Path(folder).iterdir() if path.suffix.lower() in _ENDS and path.is_file())
            _known[folder] = changed, [(str(path), path.stem) for path in found[:_MOST]]
        return _known[folder][1]
    except OSError:
        return []


def is_own(identifier: str) -> bool:
    """Whether the identifier of a choice is that of a file, and no name of Relume's library."""
    return Path(identifier).is_absolute()
