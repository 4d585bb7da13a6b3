"""Slow libraries, imported in a thread while an artist looks at the panel: the first set-up does not wait for them."""

import importlib
import threading

import bpy

__all__ = ["begin"]

_LIBRARIES = ("scipy.optimize", "scipy.interpolate", "colour")
_begun = []


def begin() -> None:
    """Begin to import them, once in a session with a window."""
    if not _begun and not bpy.app.background:
        _begun.append(threading.Thread(target=_import, name="Relume's libraries"))
        _begun[0].start()


def _import() -> None:
    for name in _LIBRARIES:
        importlib.import_module(name)
