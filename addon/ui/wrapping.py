"""Sentences in panels, wrapped so that a narrow sidebar does not cut them, and how wide a panel is."""

import textwrap
from functools import lru_cache

import bpy

from .translation import said

__all__ = ["is_narrow", "words"]

_MARGIN = 54  # pixels of a region, at an interface scale of 1, that no words have: tabs, and the panel's sides
_BOX = 20  # the same of a box in it
_ICON = 24
_NARROW = 250  # pixels, at an interface scale of 1, in which a light group has no room on one line
_LETTERS = 34  # of a line where nothing is drawn


def _scale() -> float:
    return bpy.context.preferences.system.ui_scale


def is_narrow() -> bool:
    """Whether the region that is drawn has no room for what usually stands on one line."""
    region = bpy.context.region
    return region is not None and region.width < _NARROW * _scale()


def words(layout, text: str, alert: bool = False, boxed: bool = False, icon: str = "NONE") -> None:
    """A sentence, on as many lines as it takes. boxed: it stands in a box."""
    column = layout.column(align=True)
    column.alert = alert
    region, scale = bpy.context.region, _scale()
    if region is None or bpy.app.background:
        lines = textwrap.wrap(said(text), _LETTERS)
    else:
        taken = _MARGIN + _BOX * boxed + _ICON * (icon != "NONE")
        points = bpy.context.preferences.ui_styles[0].widget.points * scale
        lines = _wrapped(said(text), max(60 * scale, region.width - taken * scale), points)
    for number, line in enumerate(lines):
        if number == 0 and icon != "NONE":
            column.label(text=line, translate=False, icon=icon)
        else:
            column.label(text=line, translate=False, **({"icon": "BLANK1"} if icon != "NONE" else {}))


@lru_cache(maxsize=512)
def _wrapped(text: str, width: float, points: float) -> tuple[str, ...]:
    """Lines of a text that are no wider than a number of pixels, in letters of a size, where its words allow that."""
    import blf

    blf.size(0, points)
    lines, line = [], ""
    for word in text.split():
        longer = f"{line} {word}" if line else word
        if line and blf.dimensions(0, longer)[0] > width:
            lines.append(line)
            longer = word
        line = longer
    return (*lines, line) if line else tuple(lines)
