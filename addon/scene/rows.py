"""The rows of the mixer, which follow the scene's light groups. What the artist chose in one is never lost.

Rows are members of a collection, which animation knows by their numbers: it follows them.
"""

import json
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress

import bpy

from ...core.errors import SetupError
from ..host import animation
from ..store import mixer, schema
from ..store.mixer import CURVE

__all__ = [
    "GIVEN",
    "arrange",
    "discard",
    "forget_untouched",
    "mark",
    "members_of",
    "numbers",
    "put_back",
    "renamed",
    "settle",
    "sync",
    "unlit",
]

GIVEN = "relume_given"  # on a scene: illuminants that set-up itself put into the mixer, by light group
_MEMBERS = "relume_members"  # on a scene that is set up, as JSON: what shone in each light group
_WAS = "was"  # on a row during set-up: the number and the name that it had before
_PLACE = "place"  # on a row while its scene is set up, if it was there before: its number then
_COLLECTION = "relume.light_groups"


def members_of(scene) -> dict[str, list[str]]:
    """{light group: what shone in it} when the scene was set up last; empty where it is not set up."""
    return json.loads(scene.get(_MEMBERS, "{}"))


def sync(scene, before: dict[str, list[str]], now: dict[str, list[str]]) -> list[str]:
    """Bring the rows in line with the light groups that shine; returns the names of these, in order.

    before: what shone in each group when the rows were written (`members_of`). now: what does.
    A row whose group is gone follows its lamps, where these are all in one group that is new: in Blender's own lists a
    group is renamed so. So does a row of which nobody knows the lamps, if it is the only one that lost them and one
    group is new. Otherwise a row stays, without light and behind the others, if the artist chose anything in it.
    """
    settings = scene.relume
    rows = settings.light_groups
    _follow_renames(settings, before, now)
    names = _as_moved(settings, now)
    with _followed_by_animation(settings):
        for name in names:
            if name not in rows:
                rows.add()["name"] = name
        given = scene[GIVEN].to_dict() if GIVEN in scene else {}
        for index in reversed(range(len(rows))):
            row = rows[index]
            if row.name not in now and row.illuminant == given.get(row.name):
                row.property_unset("illuminant")
            if row.name not in now and not _is_kept(scene, index):
                rows.remove(index)
        for position, name in enumerate(names):
            rows.move(rows.find(name), position)
    for row in rows:
        if row.is_lit != (row.name in now):
            row.is_lit = row.name in now
    _note_members(scene, {name: before.get(name, []) for name in unlit(scene)} | now)
    return names


def _as_moved(settings, names: Collection[str]) -> list[str]:
    """Names of light groups in the order in which the artist put their rows; those that were never moved come last."""
    moved = {row.name: row.position for row in settings.light_groups if row.position >= 0}
    return sorted(names, key=lambda name: moved.get(name, len(settings.light_groups)))


def arrange(settings) -> None:
    """Put the rows that are lit where the artist moved them."""
    rows = settings.light_groups
    with _followed_by_animation(settings):
        for position, name in enumerate(_as_moved(settings, [row.name for row in settings.lit])):
            rows.move(rows.find(name), position)


def numbers(scene) -> dict[str, int]:
    """{light group: its number} of all scenes of the file that are set up: what shades one may shade another."""
    shown = sorted({scene, *(s for s in bpy.data.scenes if s.relume.shades)}, key=lambda each: each.name)
    return {name: number for number, name in enumerate(dict.fromkeys(row.name for s in shown for row in s.relume.lit))}


def _note_members(scene, members: dict) -> None:
    text = json.dumps(members, ensure_ascii=False)
    if scene.get(_MEMBERS) != text:
        scene[_MEMBERS] = text


def _follow_renames(settings, before: dict, now: dict) -> None:
    group_of = {thing: group for group, things in now.items() for thing in things}
    followed = {}
    for row in settings.light_groups:
        groups = {group_of[thing] for thing in before.get(row.name, ()) if thing in group_of}
        if row.name not in now and len(groups) == 1:
            followed.setdefault(groups.pop(), []).append(row.name)
    for group, names in followed.items():
        if group not in settings.light_groups and len(names) == 1:
            _rename(settings, names[0], group)
    gone = [row.name for row in settings.light_groups if row.name not in now and row.is_lit]
    new = [group for group in now if group not in settings.light_groups]
    if len(gone) == len(new) == 1 and gone[0] not in before:
        _rename(settings, gone[0], new[0])


def _rename(settings, before: str, after: str) -> None:
    """Give a row a new name."""
    settings.light_groups[before]["name"] = after
    renamed(settings, before, after)


def renamed(settings, before: str, after: str) -> None:
    """Rename a row in everything that knows it by its name."""
    scene = settings.id_data
    if before in (members := members_of(scene)):
        _note_members(scene, {after if name == before else name: things for name, things in members.items()})
    with mixer.quiet():
        if settings.white_group == before:
            settings.white_group = after
        if settings.white_pixel:
            settings.white_pixel = _renamed_pixel(settings.white_pixel, before, after)
        for snapshot in settings.snapshots:
            _rename_in(snapshot, before, after)


def _renamed_pixel(picked: str, before: str, after: str) -> str:
    """The coefficients of a picked pixel by light group, as JSON, after a group got a new name."""
    groups = json.loads(picked or "{}")
    named = {after if name == before else name: coefficients for name, coefficients in groups.items()}
    return json.dumps(named) if before in groups else picked


def _rename_in(snapshot, before: str, after: str) -> None:
    """Rename a light group in a snapshot that has it. Never raises: a damaged snapshot stays as it is."""
    with suppress(SetupError):
        kept = schema.snapshot(snapshot.mix)
        groups, balance = kept["light_groups"], kept["balance"]
        if before in groups:
            kept["light_groups"] = {after if name == before else name: row for name, row in groups.items()}
            if balance.get("white_group") == before:
                balance["white_group"] = after
            if balance.get("white_pixel"):
                balance["white_pixel"] = _renamed_pixel(balance["white_pixel"], before, after)
            snapshot.mix = schema.snapshot_text(kept)


def unlit(scene) -> list[str]:
    """Names of the rows that stay though nothing shines in their groups."""
    return [row.name for row in scene.relume.light_groups if not row.is_lit]


def discard(scene, names: Collection[str]) -> None:
    """Remove rows, whatever was chosen in them."""
    rows = scene.relume.light_groups
    with _followed_by_animation(scene.relume):
        for name in names:
            if name in rows:
                rows.remove(rows.find(name))


def forget_untouched(scene) -> None:
    """Drop the rows in which the artist chose nothing; what was chosen is there when the scene is set up again."""
    settings, rows = scene.relume, scene.relume.light_groups
    with _followed_by_animation(settings):
        places = {row.name: row.get(_PLACE, len(rows)) for row in rows}
        for position, name in enumerate(sorted(places, key=places.get)):
            rows.move(rows.find(name), position)
        for index in reversed(range(len(rows))):
            for name in ("swatch", "is_open", "is_lit"):
                rows[index].property_unset(name)
            for key in (CURVE, _PLACE):
                if key in rows[index]:
                    del rows[index][key]
            if not _is_kept(scene, index):
                rows.remove(index)
    if _MEMBERS in scene:
        del scene[_MEMBERS]
    if not rows:
        settings.property_unset("light_groups")


def _is_kept(scene, index: int) -> bool:
    path = f"{_COLLECTION}[{index}]"
    row = scene.relume.light_groups[index]
    return mixer.is_touched(row) or animation.acts_on(scene, path)


def mark(settings) -> None:
    """Note in every row its place and its name, for `put_back` and for when the set-up is removed."""
    for number, row in enumerate(settings.light_groups):
        if not settings.is_set_up:
            row[_PLACE] = number
        row[_WAS] = json.dumps([number, row.name])


def settle(settings) -> None:
    """Forget what `mark` noted."""
    for row in settings.light_groups:
        if _WAS in row:
            del row[_WAS]


def put_back(settings) -> None:
    """Give the rows the order and the names that they had at `mark`."""
    rows = settings.light_groups
    marked = {}
    for row in [row for row in rows if _WAS in row]:
        number, name = json.loads(row[_WAS])
        marked[number] = name
        if row.name != name:
            _rename(settings, row.name, name)
    with _followed_by_animation(settings):
        for position, number in enumerate(sorted(marked)):
            rows.move(rows.find(marked[number]), position)
    settle(settings)


@contextmanager
def _followed_by_animation(settings) -> Iterator[None]:
    """While it lasts rows may come, go and change places, but keep their names."""
    before = [row.name for row in settings.light_groups]
    try:
        yield
    finally:
        after = [row.name for row in settings.light_groups]
        if before != after:
            numbers = {before.index(name): number for number, name in enumerate(after) if name in before}
            animation.renumber(settings.id_data, _COLLECTION, numbers)
