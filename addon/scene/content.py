"""What a scene shows and how it is lit, as `core.plan` needs it."""

import hashlib
from collections import Counter
from collections.abc import Generator
from dataclasses import dataclass

import bpy

from ...core.errors import SetupError
from ...core.picture import finish, plan
from ...core.spectra import library
from ...core.spectra.spectrum import Spectrum, SpectrumError
from ..graph import glass, lights, sockets
from ..graph.lamps import first_illuminants
from ..graph.memory import Memory
from ..graph.sources import Source, is_grey, sources_of
from ..host import inventory
from ..host.steps import finished
from . import shading

__all__ = ["checksum", "content_of", "dominant", "looking"]

_COMMON = ("D65", "A", "FL2", "FL11", "LED-B3", "HP1")
_COLUMNS = 48  # rays through the picture from left to right
_GREY = (0.8, 0.8, 0.8)
_WAY = 1.0  # metres through what has no size, as the air of a world
_LEAST = 0.1  # of the picture: what colours count for together, however small they are in it


def content_of(scene) -> plan.Content:
    """The surfaces of a scene, each with its part of the picture, its lights, and what they may be switched to."""
    return finished(looking(scene))


def looking(scene) -> Generator[None, None, plan.Content]:
    """`content_of`, with pauses."""
    found, shining = yield from _shining(scene)
    lamps, temperatures = lights.colours_of(found.lights), shining.temperatures
    kelvin = {s.owner: temperatures.get(lights.group_of(s, shining.groups)) for s in shining.shadings if temperatures}
    seen = yield from _shares(scene, found)

    shown: dict[object, _Shown] = {}
    filtered = []
    for owner, sources, part, way in _parts(found, seen, lamps, kelvin):
        yield
        filtered += _filtered(found, shining, owner, sources)
        for source in sources:
            colour = source.colour
            key = colour.name if isinstance(colour, Spectrum) else colour
            kind = key, source.density > 0, source.right_at
            shown.setdefault(kind, _Shown(colour)).add(source, part / len(sources), way)
    textures = [each for each in shown.values() if each.colour is None]
    greys = [each for each in shown.values() if is_grey(each.colour)]
    known = sum(each.share for each in shown.values()) - sum(each.share for each in greys)
    grey = sum(each.share for each in greys)
    if known and grey * _LEAST > known * (1 - _LEAST):
        for each in greys:
            each.shrink(known * (1 - _LEAST) / (grey * _LEAST))
    measured = [each for each in shown.values() if isinstance(each.colour, Spectrum)]
    colours = [each for each in shown.values() if isinstance(each.colour, tuple)]
    surfaces = [*measured, *colours]
    unknown = sum(each.share for each in textures)
    return plan.Content(
        reflectances=[each.colour for each in measured],
        colours=[each.colour for each in colours],
        shares=[each.share for each in surfaces],
        textures=unknown,
        again=[*(each.again for each in surfaces), sum(e.again * e.share for e in textures) / (unknown or 1.0)],
        depths=[each.depth for each in surfaces],
        right_at=[each.right_at for each in surfaces],
        filtered=filtered,
        lights=_illuminants(scene, shining),
        choices=_choices(scene.relume.switching),
        bounces=scene.cycles.max_bounces,
        space=bpy.data.colorspace.working_space,
        disperses=shining.disperses,
    )


def checksum(content: plan.Content) -> str:
    """A checksum of all that a plan depends on."""
    spectra = [*content.reflectances, *content.lights, *content.choices]
    said = [spectrum.name.encode() + spectrum.values.tobytes() for spectrum in spectra]
    said += [content.colours.tobytes(), content.shares.tobytes()]
    said += [repr((content.textures, content.bounces, content.space, content.disperses)).encode()]
    said += [each.tobytes() for each in (content.parts_again, content.optical_depths, content.rights) if each.any()]
    return hashlib.sha256(b"|".join(said)).hexdigest()[:16]


@dataclass
class _Shown:
    """A colour that a scene shows: its part of the picture, and means over that of what is made of it."""

    colour: Spectrum | tuple | None
    share: float = 0.0
    again: float = 0.0
    depth: float = 0.0
    right_at: float = 0.0

    def add(self, source: Source, share: float, way: float) -> None:
        self.share += share
        part = share / self.share if self.share else 1.0
        self.again += part * (source.again - self.again)
        self.depth += part * (source.density * way - self.depth)
        self.right_at = source.right_at

    def shrink(self, scale: float) -> None:
        self.share *= scale


def _parts(found: inventory.Inventory, seen: Counter, lamps: dict, kelvin: dict):
    """(owner, sources, share, way) of what is seen, and of coloured lamps and the world, which together light it.

    way: the mean way through what shows it, in metres.
    """
    for owner, share in seen.items():
        thing = found.materials.get(owner)
        way = finish.way_through(thing.dimensions) if thing else _WAY
        yield owner, (sources_of(owner, kelvin.get(owner)) if owner else []) or [Source(_GREY)], share, way
    shining = [*found.lights, *([found.world] if found.world else [])]
    for owner in shining:
        sources = sources_of(owner, kelvin.get(owner))
        if owner != found.world:
            sources += map(Source, _lamp_sources(owner, lamps.get(owner), kelvin.get(owner)))
        coloured = [source for source in sources if not is_grey(source.colour)]
        if coloured:
            yield owner, coloured, seen.total() / len(shining), _WAY


def _filtered(found: inventory.Inventory, shining: "_Shining", owner, sources: list[Source]) -> list[tuple]:
    """(name, light group, spectrum) of light that goes through a spectrum in a light group where others shine too."""
    spectra = [each.colour for each in sources if each.shines and isinstance(each.colour, Spectrum)]
    thing = found.lights.get(owner) or found.materials.get(owner) or (owner if owner == found.world else None)
    if not spectra or thing is None:
        return []
    group = lights.group_named_by(thing)
    return [(thing.name, group, each) for each in spectra] if len(shining.members.get(group, ())) > 1 else []


def _lamp_sources(light, lamp, kelvin: float | None) -> list:
    """Sources of the colour that a lamp has outside its nodes."""
    if lamp is None:
        return [tuple(light.color)]
    return [lamp.tint] if lamp.temperature in (None, kelvin) else [lamp.tint, None]


@dataclass
class _Shining:
    """What shines in each light group of a scene, the temperature of those that are one black body, the illuminants
    that they begin with, and all that shades the scene; whether any glass makes a spectrum."""

    members: dict[str, list[str]]
    temperatures: dict[str, float]
    firsts: dict[str, str]
    shadings: list[sockets.Shading]
    disperses: bool

    @property
    def groups(self) -> list[str]:
        return list(self.members)


def _shining(scene) -> Generator[None, None, tuple[inventory.Inventory, _Shining]]:
    """The inventory of a scene, and what shines in it."""
    surveyed = yield from shading.survey(scene, Memory(is_lasting=False))
    found, groups, glows, disperses = surveyed.found, list(surveyed.members), {}, False
    lamps = lights.colours_of(found.lights)
    for each in sockets.shadings_of(found)[0]:
        glows[each] = lights.glows_of(each, lamps.get(each.owner))
        disperses = disperses or any(map(glass.disperses, each.tree.nodes))
        yield
    temperatures = lights.temperatures_of(groups, glows)
    firsts = first_illuminants(scene, groups, temperatures)
    return found, _Shining(surveyed.members, temperatures, firsts, list(glows), disperses)


def _illuminants(scene, shining: _Shining) -> list:
    """What shines in the mixer, or will when the scene is set up. The mixer reports what cannot be used."""
    found = [_illuminant(scene, group, shining) for group in shining.groups]
    return list({(spectrum.name, spectrum.values.tobytes()): spectrum for spectrum in found}.values())


def _illuminant(scene, group: str, shining: _Shining) -> Spectrum:
    row = scene.relume.light_groups.get(group)
    try:
        if row is None or not (row.is_property_set("source") or row.is_property_set("illuminant")):
            return library.illuminant(shining.firsts[group])
        return row.spectrum()
    except (library.LibraryError, SpectrumError):
        return library.illuminant("D65")


def dominant(scene) -> Spectrum:
    """What shines in the light group that the artist called dominant, by default the first. Raises SetupError."""
    _, shining = finished(_shining(scene))
    groups, chosen = shining.groups, scene.relume.dominant_group
    if chosen and chosen not in groups:
        raise SetupError(f"nothing shines in {chosen!r}, the dominant light; there are {', '.join(groups) or 'none'}")
    return _illuminant(scene, chosen or groups[0], shining) if groups else library.illuminant("D65")


def _choices(switching: str) -> list:
    if switching == "ANY":
        return [library.illuminant(name) for names in library.cie_illuminants().values() for name in names]
    return [library.illuminant(name) for name in _COMMON] if switching == "COMMON" else []


def _shares(scene, found: inventory.Inventory) -> Generator[None, None, Counter]:
    """How many of a grid of camera rays hit each material, or the world (None: no material); each used material at
    least a little, for it lights what is seen."""
    shares = Counter()
    for thing in found.objects:
        if not thing.hide_render:
            shares.update(dict.fromkeys(found.materials_of(thing), 0))
        yield
    shares = Counter(dict.fromkeys(shares, 0.5))
    rays = list(_camera_rays(scene))
    for row in range(0, len(rays), _COLUMNS):
        depsgraph = _depsgraph_of(scene)  # which may be another after a pause
        for origin, direction in rays[row : row + _COLUMNS]:
            hit, _, _, face, thing, matrix = scene.ray_cast(depsgraph, origin, direction)
            seen = _materials_at(found, thing.evaluated_get(depsgraph), face, matrix) if hit else [found.world]
            for material in seen:
                shares[material] += 1 / len(seen)
        yield
    return shares


def _depsgraph_of(scene):
    if scene == bpy.context.scene:
        return bpy.context.evaluated_depsgraph_get()
    layer = next(layer for layer in scene.view_layers if layer.use)
    layer.update()
    return layer.depsgraph


def _materials_at(found: inventory.Inventory, thing, face: int, matrix) -> list:
    """The material of a face of an evaluated object; where Geometry Nodes made an instance of it, all that they may
    have given it."""
    slots = [slot.material and slot.material.original for slot in thing.material_slots]
    if isinstance(thing.data, bpy.types.Mesh):
        own = matrix == thing.matrix_world or not any(modifier.type == "NODES" for modifier in thing.modifiers)
        if not own or not 0 <= face < len(thing.data.polygons):
            return found.materials_of(thing.original) or [None]
        index = thing.data.polygons[face].material_index
        return [slots[min(index, len(slots) - 1)] if slots else None]
    return slots[:1] or [None]


def _camera_rays(scene):
    """(origin, direction) of rays spread evenly over the picture."""
    camera = scene.camera
    if camera.type != "CAMERA":
        return  # Blender looks through a lamp as well: nobody knows what is seen
    frame = camera.data.view_frame(scene=scene)  # top right, bottom right, bottom left, top left, in camera space
    matrix = camera.evaluated_get(_depsgraph_of(scene)).matrix_world.copy()
    right, down = frame[0] - frame[3], frame[2] - frame[3]
    rows = max(1, round(_COLUMNS * down.length / right.length))
    for y in range(rows):
        for x in range(_COLUMNS):
            point = frame[3] + right * ((x + 0.5) / _COLUMNS) + down * ((y + 0.5) / rows)
            if camera.data.type == "ORTHO":
                start = matrix @ point
                yield start, -matrix.col[2].to_3d()
            else:
                yield matrix.translation, (matrix @ point - matrix.translation).normalized()
