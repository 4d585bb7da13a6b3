"""Light groups: who belongs to which, new ones by lamp, collection or illuminant, and new names."""

from collections.abc import Generator

from ...core.picture.coefficients import EVERYTHING_ELSE
from ..graph import lights
from ..store import mixer
from . import compositing, faults, rows, setup

__all__ = ["WAYS", "add", "empty", "regroup", "remove_empty", "rename", "setting_up", "write_gains"]

WAYS = [
    ("LIGHT", "One per Light", "Every lamp and every shining object gets a light group of its own"),
    ("COLLECTION", "One per Collection", "What shines in the same collection shares a light group"),
    ("ILLUMINANT", "One per Illuminant", "What has the same illuminant in the mixer shares a light group"),
]


MOST = 12  # light groups that setting up makes for single lights: each is another image in every pass


def lamps_of(scene) -> list:
    """What shines: objects of the scene, and its world."""
    return lights.emitters_of(scene)


def _free(name: str, taken) -> str:
    """The name as a light group may have it (Blender puts _ for a dot), and as no other in `taken` has."""
    name = name.strip().replace(".", "_") or "Lights"
    name = name.encode()[: lights.LONGEST].decode(errors="ignore")
    number, stem = 2, name.encode()[: lights.LONGEST - 4].decode(errors="ignore")
    while name in taken or name == EVERYTHING_ELSE:
        name, number = f"{stem} {number}", number + 1
    return name


def rename(scene, before: str, after: str) -> str:
    """Give a light group a new name in everything that belongs to it; returns the name that it got.

    What belongs to no group cannot be renamed. A render made before has no pass of the new name: render again.
    """
    if before == EVERYTHING_ELSE or after == before:
        return before
    taken = {row.name for row in scene.relume.light_groups} - {before}
    name = _free(after, taken)
    for thing in [*scene.objects, *([scene.world] if scene.world else [])]:
        if thing.lightgroup == before and thing.is_editable:
            thing.lightgroup = name
            thing.update_tag()  # Blender 5.0's persistent data would not notice
    for layer in scene.view_layers:
        if before in layer.lightgroups:
            layer.lightgroups[before].name = name
    rows.renamed(scene.relume, before, name)
    if scene.relume.is_set_up:
        compositing.rename(scene, before, name)
    return name


def regroup(scene, way: str) -> int:
    """Put everything that shines into groups, in one of the `WAYS`; returns how many groups there are now.

    What a lamp's old group had in the mixer is what its new group starts with.
    """
    members = {}
    for thing in lamps_of(scene):
        members.setdefault(_key(scene, thing, way), []).append(thing)
    assigned, taken = [], set()
    for key, things in members.items():
        name = _free(key, taken)
        taken.add(name)
        assigned.append((name, things))
    _assign(scene, assigned)
    return len(assigned)


def setting_up(scene, way: str) -> Generator[str, None, str]:
    """Set a scene up with what shines in groups, in one of the `WAYS` or as it is: "KEEP". As `setup.setting_up`.

    Returns why another way was taken, "" if none was. Raises SetupError; the groups are then what they were.
    """
    if way == "KEEP":
        yield from setup.setting_up(scene)
        return ""
    faults.check(scene)
    things, why = lamps_of(scene), ""
    if way == "LIGHT" and len(things) > MOST:
        way, why = "COLLECTION", f"by collection, for {len(things)} lights are more than {MOST}"
    before = [(thing, thing.lightgroup) for thing in things]
    listed = [(layer, set(layer.lightgroups.keys())) for layer in scene.view_layers]
    regroup(scene, way)
    try:
        yield from setup.setting_up(scene)
    except BaseException:
        for thing, group in before:
            thing.lightgroup = group
        for layer, names in listed:
            for name in set(layer.lightgroups.keys()) - names:
                layer.lightgroups.remove(layer.lightgroups[name])
        raise
    return why


def _key(scene, thing, way: str) -> str:
    if way == "LIGHT":
        return thing.name
    if way == "COLLECTION":
        collections = getattr(thing, "users_collection", ())
        return next((c.name for c in collections if c != scene.collection), thing.name if not collections else "Scene")
    row = scene.relume.light_groups.get(thing.lightgroup or EVERYTHING_ELSE)
    if row is None:
        return "D65"
    return row.spectrum().name if row.is_tinted else row.label


def add(scene, name: str, things: list) -> int:
    """Put things that shine into one light group, a new one where there is none of that name; returns how many."""
    shining = set(lamps_of(scene))
    chosen = [thing for thing in things if thing in shining]
    if chosen:
        _assign(scene, [("" if name == EVERYTHING_ELSE else name, chosen)])
    return len(chosen)


def _assign(scene, assigned: list[tuple[str, list]]) -> None:
    """Put things into groups, and let new rows of the mixer start as the old ones of their first member were."""
    settings, lit = scene.relume, set(lights.light_groups_of(scene))
    known = mixer.choices(settings)
    starts = {name: known["light_groups"].get(things[0].lightgroup or EVERYTHING_ELSE) for name, things in assigned}
    for name, things in assigned:
        for thing in things:
            thing.lightgroup = name
            thing.update_tag()
    with mixer.quiet():
        for name, start in starts.items():
            if start and name and name not in settings.light_groups:
                settings.light_groups.add()["name"] = name
                mixer.apply(settings, {"light_groups": {name: start}, "balance": {}})
        rows.discard(scene, lit.difference(lights.light_groups_of(scene)))  # what their lamps left
    for layer in scene.view_layers:  # as Blender's own buttons do
        for name in [name for name, _ in assigned if name and name not in layer.lightgroups]:
            layer.lightgroups.add(name=name)
    if settings.is_set_up:
        setup.update(scene)


def empty(scene) -> list[str]:
    """Light groups of the mixer in which nothing shines."""
    lit = set(lights.light_groups_of(scene))
    return [row.name for row in scene.relume.light_groups if row.name not in lit]


def remove_empty(scene) -> list[str]:
    """Remove the groups in which nothing shines, from the mixer and from the view layers; returns their names."""
    names = empty(scene)
    rows.discard(scene, names)
    for name in names:
        for layer in scene.view_layers:
            if name in layer.lightgroups:
                layer.lightgroups.remove(layer.lightgroups[name])
    if names and scene.relume.is_set_up:
        setup.update(scene)
    return names


def write_gains(scene) -> list[str]:
    """Multiply the strength of what shines by the gain of its group, and set the gains back to one.

    Returns the names of what could not be changed: its strength is linked, or other groups share it. Their groups keep
    their gain. Groups that are mute stay so, and solo is not looked at.
    """
    settings, members = scene.relume, {}
    for thing in lamps_of(scene):
        members.setdefault(thing.lightgroup or EVERYTHING_ELSE, []).append(thing)
    owners = {name: {_data(thing) for thing in things} for name, things in members.items()}
    kept = []
    with mixer.quiet():
        for row in settings.light_groups:
            if row.mute or row.stops == 0.0:
                continue
            others = set().union(*(data for name, data in owners.items() if name != row.name))
            strengths = [(thing, _strengths(thing)) for thing in members.get(row.name, ())]
            blocked = [thing.name for thing, found in strengths if found is None or _data(thing) in others]
            if blocked:
                kept += blocked
                continue
            for owner, attribute in {pair: None for _, found in strengths for pair in found}:
                setattr(owner, attribute, getattr(owner, attribute) * row.gain)
            row.stops = 0.0
    mixer.mix_changed(settings, None)
    return kept


def _data(thing):
    return getattr(thing, "data", thing)


def _strengths(thing):
    """(owner, attribute) of all that says how strongly a thing shines, None where it is not a plain number."""
    if getattr(thing, "type", "") == "LIGHT":
        return [(thing.data, "energy")] if thing.data.is_editable else None
    trees = (
        [thing.node_tree]
        if not hasattr(thing, "material_slots")
        else [slot.material.node_tree for slot in thing.material_slots if slot.material]
    )
    found = []
    for tree in trees:
        sockets = lights.strength_sockets(tree)
        if any(socket.is_linked for socket in sockets):
            return None
        found += [(socket, "default_value") for socket in sockets]
    return found or None
