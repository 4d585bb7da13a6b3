"""Edits of the mixer as a whole: put back as it began, illuminants pasted, the lights of a group selected."""

import bpy

from ...core.errors import SetupError
from ...core.picture.coefficients import EVERYTHING_ELSE
from ..graph import lights
from ..store import mixer, properties, schema
from . import rows, setup

__all__ = ["members", "move", "paste", "reset", "select"]


def reset(scene, names=None) -> None:
    """Have rows of the mixer begin anew, as set-up gives them; all where no names are given, and then the white too.

    Those of a scene that shows an EXR say what it was rendered with. Raises SetupError.
    """
    settings = scene.relume
    first = scene.get(properties.FIRST)
    if settings.exr and first is None:
        raise SetupError("this scene was opened with an older Relume: open its EXR again with Relight from EXR")
    if first is not None:
        kept = schema.snapshot(first)
        chosen = {name: kept["light_groups"][name] for name in names or kept["light_groups"]}
        mixer.apply(settings, {"light_groups": chosen, "balance": {} if names else kept["balance"]})
        return
    given = scene[rows.GIVEN].to_dict() if rows.GIVEN in scene else {}
    with mixer.quiet():
        for row in settings.light_groups:
            if names is None or row.name in names:
                for name in mixer.choice(row):
                    row.property_unset(name)
                if row.name in given:
                    row["illuminant"] = given[row.name]
        if names is None:
            for name in mixer.BALANCE:
                settings.property_unset(name)
    mixer.mix_changed(settings, bpy.context)


def paste(row, shines: dict) -> None:
    """Have a row show an illuminant, as `mix_file.illuminant_from` returns it; its gain stays."""
    mixer.apply(row.id_data.relume, {"light_groups": {row.name: mixer.choice(row) | shines}, "balance": {}})


def move(scene, name: str, by: int) -> None:
    """Move a row of the mixer by a number of places, as far as there are any. Raises SetupError.

    Rows without lights stay behind the others.
    """
    settings = scene.relume
    names, chosen = [row.name for row in settings.lit], settings.active_light_group
    if name not in names:
        raise SetupError(f"nothing shines in {name}: its row stays behind the others")
    active = settings.light_groups[chosen].name if 0 <= chosen < len(settings.light_groups) else ""
    place = names.index(name)
    names.insert(min(max(place + by, 0), len(names) - 1), names.pop(place))
    for position, each in enumerate(names):
        settings.light_groups[each].position = position
    if settings.shades:
        setup.update(scene)
    else:
        rows.arrange(settings)
    settings.active_light_group = max(0, settings.light_groups.find(active))


def members(scene, name: str) -> list:
    """The objects that shine in a light group."""
    shining = [thing for thing in lights.emitters_of(scene) if isinstance(thing, bpy.types.Object)]
    return [thing for thing in shining if lights.group_named_by(thing) == name]


def select(context, name: str) -> list[str]:
    """Select just the lights of a light group that can be seen; returns their names. Raises SetupError for none."""
    found = [thing for thing in members(context.scene, name) if thing.visible_get(view_layer=context.view_layer)]
    if not found:
        where = "belongs to no group" if name == EVERYTHING_ELSE else f"belongs to {name}"
        raise SetupError(f"no object that shines and can be seen {where}")
    for thing in context.view_layer.objects:
        thing.select_set(thing in found)
    context.view_layer.objects.active = found[0]
    return [thing.name for thing in found]
