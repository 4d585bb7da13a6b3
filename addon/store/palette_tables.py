"""Between the palettes of a .blend and those of `core.palette`: tables one way, designs the other, colours to show."""

import json
from math import copysign, inf

import bpy

from ..host import viewing
from .palette import FAMILIES, MODELS, cell_at, quiet, reshape

__all__ = ["design_of", "fill", "redraw", "show", "show_view", "table_of"]

MOST = 1e6  # stands for no bound: numbers of the interface are finite
_USUAL = ((0.0, 1.0), (0.0, inf), (-inf, inf))


def table_of(design) -> dict:
    """The table of a design, as `core.palette.from_dict` reads it."""
    from ...core.palette import xyz_from_scene

    space = bpy.data.colorspace.working_space
    cells = []
    for row, reflectance in enumerate(design.reflectances):
        for column, light in enumerate(design.lights):
            cell = cell_at(design, row, column)
            here = {"reflectance": reflectance.name, "light": light.name, "weight": cell.weight}
            if cell.use == "TARGET":
                cells.append(here | {"xyz": xyz_from_scene(tuple(cell.target), space)})
            elif cell.use == "FREE":
                cells.append(here | {"free": cell.free})
    names = [light.name for light in design.lights]
    return {
        "version": design.version,
        "title": design.name,
        "criteria": {
            "space": design.space,
            "model": design.family,
            "channels": int(design.channels),
            "use_model": design.use_model and design.channels != "0",
            "model_error": design.model_error,
            "smoothness": design.smoothness,
            "bounded": design.bounded,
        },
        "lights": [_entry_table(entry) for entry in design.lights],
        "reflectances": [_entry_table(entry) for entry in design.reflectances],
        "cells": cells,
        "free_colours": [
            {"name": one.name, "lower": _open(one.lower), "upper": _open(one.upper)} for one in design.free_colours
        ],
        "differences": [
            {
                "light": one.light,
                "between": [one.first, one.second],
                "least" if one.kind == "LEAST" else "most": one.amount,
                "weight": one.weight,
            }
            for one in design.differences
        ],
        "constancies": [
            {
                "reflectance": one.reflectance,
                "lights": [name for name in names if name not in [left_out.name for left_out in one.left_out]],
                "adapted": one.adapted,
                "weight": one.weight,
            }
            for one in design.constancies
        ],
    }


def _entry_table(entry) -> dict:
    table = {"name": entry.name, "designed": entry.designed, "luminance": entry.luminance}
    if entry.spectrum:
        table["spectrum"] = json.loads(entry.spectrum)
    if entry.own_bounds:
        table["bounds"] = _open((entry.lower, entry.upper))
    if entry.near:
        table |= {"near": json.loads(entry.near), "near_weight": entry.near_weight}
    if entry.span != "NONE":
        table |= {"span": entry.span, "span_weight": entry.span_weight}
    return table


def _open(bounds) -> list:
    return [copysign(inf, bound) if abs(bound) >= MOST else bound for bound in bounds]


def _closed(bounds) -> list:
    return [min(max(bound, -MOST), MOST) for bound in bounds]


def design_of(design):
    """The `core.palette.Palette` of a design. Raises PaletteError."""
    from ...core import palette

    return palette.from_dict(table_of(design))


def fill(design, made):
    """Make a design of the artist's of a `core.palette.Palette`."""
    from ...core.palette import scene_from_xyz

    space = bpy.data.colorspace.working_space
    with quiet():
        design.name = made.title or design.name
        design.differences.clear()
        design.constancies.clear()
        design.free_colours.clear()
        for kind, collection, entries in (
            ("light", design.lights, made.lights),
            ("reflectance", design.reflectances, made.reflectances),
        ):
            collection.clear()
            for entry in entries:
                _fill_entry(collection.add(), entry, made.bounds(kind, entry))
        for one in made.free_colours:
            item = design.free_colours.add()
            item.name, item.lower, item.upper = one.name, _closed(one.lower), _closed(one.upper)
        criteria = made.criteria
        design.space, design.bounded, design.smoothness = criteria.space, criteria.bounded, criteria.smoothness
        design.model_error, design.use_model = criteria.model_error, criteria.use_model
        channels = "0" if criteria.model is None else str(criteria.model.channels)
        design.channels = channels if channels in [key for key, *_ in MODELS] else "6"
        family = "fitted" if criteria.model is None else criteria.model.name.split()[0]
        design.family = family if family in [key for key, *_ in FAMILIES] else "fitted"
    reshape(design, [None] * len(made.reflectances), [None] * len(made.lights), 0)
    with quiet():
        for one in made.cells:
            cell = cell_at(design, one.reflectance, one.light)
            cell.weight, cell.use = one.weight, "FREE" if one.free else "TARGET"
            if one.free:
                cell.free = one.free if one.free in "ABCDEF" else "A"
            else:
                cell.target = scene_from_xyz(one.target, space)
        for one in made.differences:
            for kind, amount in (("LEAST", one.least), ("MOST", one.most)):
                if amount is not None:
                    item = design.differences.add()
                    item.light = made.lights[one.light].name
                    item.first, item.second = (made.reflectances[index].name for index in (one.first, one.second))
                    item.kind, item.amount, item.weight = kind, amount, one.weight
        for one in made.constancies:
            item = design.constancies.add()
            item.reflectance, item.adapted = made.reflectances[one.reflectance].name, one.adapted
            item.weight = one.weight
            for index, light in enumerate(made.lights):
                if index not in one.lights:
                    item.left_out.add().name = light.name
    show(design)


def _fill_entry(item, entry, bounds: tuple):
    item.name, item.designed, item.luminance = entry.name, entry.designed, entry.luminance
    if entry.spectrum is not None:
        item.spectrum = json.dumps(entry.spectrum.to_dict())
        item.source = entry.spectrum.name
    # Those of the whole design where they are others than the editor's own
    if entry.designed and tuple(bounds) not in _USUAL:
        item.own_bounds, (item.lower, item.upper) = True, _closed(bounds)
    if entry.near is not None:
        item.near, item.near_name = json.dumps(entry.near.to_dict()), entry.near.name
        item.near_weight = entry.near_weight
    if entry.span:
        item.span, item.span_weight = entry.span, entry.span_weight


def show(design):
    """Draw the colours of a design anew, as its spectra and the scene's view are now."""
    from ...core.errors import RelumeError
    from ...core.palette import matrix_xyz

    redraw()
    try:
        shown = [_shown(design, xyz) for xyz in matrix_xyz(design_of(design))]
    except RelumeError as error:
        design.remarks = str(error)
        return
    wanted, full, model, lights, reflectances = shown
    with quiet():
        design.view = _view(design)
        for entries, colors in ((design.lights, lights), (design.reflectances, reflectances)):
            for entry, color in zip(entries, colors.tolist(), strict=True):
                entry.swatch = color
        for row in range(len(design.reflectances)):
            for column in range(len(design.lights)):
                cell, here = cell_at(design, row, column), (row, column)
                cell.full, cell.model = full[here].tolist(), model[here].tolist()
                cell.wanted = wanted[here].tolist() if cell.use == "TARGET" else cell.full


def _shown(design, xyz):
    """Colours as the editor draws them, 0..1, of XYZ (..., 3)."""
    from ...core.palette import scene_linear, srgb_from_xyz

    if design.shown == "COLOUR" or not xyz.size:
        return srgb_from_xyz(xyz)
    return viewing.displayed(design.id_data, scene_linear(xyz, bpy.data.colorspace.working_space))


def _view(design) -> str:
    return viewing.view_of(design.id_data) if design.shown == "VIEW" else ""


def show_view(design):
    """Draw the colours of a design anew, soon, where the scene's view is no longer the one they were drawn through."""
    if design.view != _view(design) and not bpy.app.timers.is_registered(_show_views):
        bpy.app.timers.register(_show_views)


def _show_views():
    for scene in bpy.data.scenes:
        for design in scene.relume_palettes:
            if design.view != _view(design):
                show(design)


def redraw():
    """Draw the editor anew, wherever it is open."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type in {"VIEW_3D", "IMAGE_EDITOR"}:
                area.tag_redraw()
