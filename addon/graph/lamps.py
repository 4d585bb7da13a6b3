"""Lamps that say which illuminant they are, as those of the asset library do: their light group starts with it."""

from collections.abc import Iterable, Mapping

from . import lights

__all__ = ["ILLUMINANT", "first_illuminants"]

ILLUMINANT = "relume_illuminant"  # on a light: the name of an illuminant of the library


def _named_in(scene, temperatures: Mapping[str, float]) -> dict[str, str]:
    """{light group: illuminant} of the groups in which all lamps say the same one.

    temperatures: of the groups in which all that shines is one black body. A lamp whose temperature is not that of its
    group has a spectrum relative to daylight, and there the group stays daylight.
    """
    found: dict[str, set] = {}
    for thing in scene.objects:
        if thing.type == "LIGHT" and thing.lightgroup:
            said = thing.data.get(ILLUMINANT, "")
            has_own = thing.data.use_temperature or lights.temperature_of(thing.data)
            found.setdefault(thing.lightgroup, set()).add(
                "" if has_own and thing.lightgroup not in temperatures else said
            )
    return {group: said for group, names in found.items() if len(names) == 1 and (said := next(iter(names)))}


def first_illuminants(scene, groups: Iterable[str], temperatures: Mapping[str, float]) -> dict[str, str]:
    """{light group: illuminant that it has before the artist chooses one}: what its lamps say, a black body, daylight.

    temperatures: as in `lights.temperatures_of`.
    """
    named = _named_in(scene, temperatures)
    return {group: named.get(group) or lights.first_illuminant(temperatures, group) for group in groups}
