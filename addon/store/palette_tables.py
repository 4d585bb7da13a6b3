"""Between the palettes of a .blend and those of `core.palette`: tables one way, designs the other, colours to show."""

import json

import bpy

from .palette import MODELS, cell_at, quiet, reshape

__all__ = ["design_of", "fill", "redraw", "show", "table_of"]


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
            "channels": int(design.channels),
            "use_model": design.use_model and design.channels != "0",
            "model_error": design.model_error,
            "smoothness": design.smoothness,
            "bounded": design.bounded,
        },
        "lights": [_entry_table(entry) for entry in design.lights],
        "reflectances": [_entry_table(entry) for entry in design.reflectances],
        "cells": cells,
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
            {"reflectance": one.reflectance, "lights": names, "adapted": one.adapted, "weight": one.weight}
            for one in design.constancies
        ],
    }


def _entry_table(entry) -> dict:
    table = {"name": entry.name, "designed": entry.designed, "luminance": entry.luminance}
    return table | ({"spectrum": json.loads(entry.spectrum)} if entry.spectrum else {})


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
        for collection, entries in ((design.lights, made.lights), (design.reflectances, made.reflectances)):
            collection.clear()
            for entry in entries:
                item = collection.add()
                item.name, item.designed, item.luminance = entry.name, entry.designed, entry.luminance
                if entry.spectrum is not None:
                    item.spectrum = json.dumps(entry.spectrum.to_dict())
                    item.source = entry.spectrum.name
        criteria = made.criteria
        design.space, design.bounded, design.smoothness = criteria.space, criteria.bounded, criteria.smoothness
        design.model_error, design.use_model = criteria.model_error, criteria.use_model
        channels = "0" if criteria.model is None else str(criteria.model.channels)
        design.channels = channels if channels in [key for key, *_ in MODELS] else "6"
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
    show(design)


def show(design):
    """Draw the colours of a design anew, as its spectra are now."""
    from ...core.errors import RelumeError
    from ...core.palette import matrix_colours

    redraw()
    try:
        wanted, full, model, lights, reflectances = matrix_colours(design_of(design))
    except RelumeError as error:
        design.remarks = str(error)
        return
    with quiet():
        for entries, colors in ((design.lights, lights), (design.reflectances, reflectances)):
            for entry, color in zip(entries, colors.tolist(), strict=True):
                entry.swatch = color
        for row in range(len(design.reflectances)):
            for column in range(len(design.lights)):
                cell, here = cell_at(design, row, column), (row, column)
                cell.full, cell.model = full[here].tolist(), model[here].tolist()
                cell.wanted = wanted[here].tolist() if cell.use == "TARGET" else cell.full


def redraw():
    """Draw the editor anew, wherever it is open."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type in {"VIEW_3D", "IMAGE_EDITOR"}:
                area.tag_redraw()
