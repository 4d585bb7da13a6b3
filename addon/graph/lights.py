"""What shines: light groups, the spectrum of each, and the colour of a lamp as a gel in front of it.

A black body, as the temperature of a lamp or in its nodes, is a Planckian illuminant. Where all that shines in a light
group is of one temperature, the group starts with that illuminant; otherwise each black body has its own spectrum,
relative to the D65 of its group.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import bpy
import numpy as np

from ...core.model import upsample
from ...core.model.factor_model import FactorModel
from ...core.picture.blender_exr import light_pass
from ...core.picture.coefficients import EVERYTHING_ELSE
from ...core.spectra import library
from ..host import animation, inventory
from ..store.remarks import Remark
from . import insertion, node_groups, nodes, sockets
from .closures import Kind, in_use, kind_of, spectral_sockets

__all__ = [
    "LONGEST",
    "Lamp",
    "Lighting",
    "blackbody_behind",
    "colours_of",
    "emitters_of",
    "first_illuminant",
    "glows_of",
    "group_named_by",
    "group_of",
    "has_emitters",
    "is_taken",
    "light_groups_of",
    "members_of",
    "restore",
    "strength_sockets",
    "take_colours",
    "temperature_of",
    "temperatures_of",
    "tints_of",
    "why_unusable",
]

_BEFORE = "relume_color"  # on a light: the colour, temperature switch and node switch that it had
_WHITE = (1.0, 1.0, 1.0)
_DAYLIGHT = "D65"
_NOTICED = 5.0  # CIEDE2000, of the most saturated surfaces
_FILTER = "its light is deeply coloured: what it does to coloured surfaces differs from plain RGB, even without bounces"
LONGEST = 63 - len(light_pass(""))  # bytes of a light group's name that leave room for that of its pass


def emitters_of(scene, found: inventory.Inventory | None = None, known=sockets) -> list:
    """The objects that shine, and the world if it does.

    found: the inventory of the scene, where it was taken. known: what tells of a tree whether it `emits` by itself, and
    the `groups_in` it; a `memory.Memory` reads nothing twice.
    """
    found = found or inventory.take(scene)
    shines = {None: False}
    things = [thing for thing in found.objects if _shines(thing, found, shines, known)]
    return [*things, scene.world] if scene.world and _tree_shines(scene.world.node_tree, shines, known) else things


def light_groups_of(scene) -> list[str]:
    """Names of the light groups that the scene's lamps, shining objects and world belong to, in order of appearance.

    `EVERYTHING_ELSE` comes last if anything that shines belongs to none.
    """
    return list(members_of(scene))


def members_of(scene, inventoried: inventory.Inventory | None = None, known=sockets) -> dict[str, list[str]]:
    """{light group: names of what shines in it}, in the order of `light_groups_of`; arguments as in `emitters_of`."""
    found = {}
    for thing in emitters_of(scene, inventoried, known):
        found.setdefault(group_named_by(thing), []).append(f"{thing.id_type} {thing.name}")
    rest = found.pop(EVERYTHING_ELSE, None)
    return found | ({EVERYTHING_ELSE: rest} if rest else {})


def group_named_by(thing) -> str:
    """The light group that an object or a world is in, `EVERYTHING_ELSE` where Blender renders none of its name."""
    return EVERYTHING_ELSE if why_unusable(thing.lightgroup) else thing.lightgroup or EVERYTHING_ELSE


def why_unusable(group: str) -> str:
    """Why Blender renders nothing into a light group of that name, "" if it does."""
    if len(group.encode()) > LONGEST:
        return "the name of this light group is too long for a render pass: its lamps belong to everything else"
    if "." in group:
        # Only scripts and old files give objects such a group: a view layer would call it by another name
        return "Blender has no light group with a dot in its name: its lamps belong to everything else; rename it"
    return ""


def strength_sockets(tree) -> list:
    """The inputs that say how strongly a node tree shines."""
    return [
        next(other for other in node.inputs if other.name in ("Strength", "Emission Strength"))
        for node in tree.nodes
        for socket in spectral_sockets(node)
        if kind_of(socket) is Kind.EMISSION and in_use(socket)
    ]


def has_emitters(scene) -> bool:
    return bool(light_groups_of(scene))


def _shines(thing, found, shines: dict, known) -> bool:
    if thing.type == "LIGHT":
        return True
    return any(_tree_shines(material.node_tree, shines, known) for material in found.materials_of(thing))


def _tree_shines(tree, shines: dict, known) -> bool:
    """shines: what was found already; a tree that is being looked at counts as dark, so that no circle goes on."""
    if tree not in shines:
        shines[tree] = False
        shines[tree] = known.emits(tree) or any(_tree_shines(each, shines, known) for each in known.groups_in(tree))
    return shines[tree]


@dataclass(frozen=True)
class Lamp:
    """The colour (RGB) that was taken out of a lamp, and its temperature: kelvin and the RGB colour of it, or None."""

    tint: tuple[float, float, float]
    temperature: float | None = None
    glow: tuple[float, float, float] = (1.0, 1.0, 1.0)


def take_colours(lights: Iterable, gentle: bool = False) -> tuple[dict, list[Remark]]:
    """Take colour and temperature out of lamps, so that they can stand in their nodes: {light: Lamp}, remarks.

    gentle: a colour that was chosen in a lamp whose colours are animated may stay until the artist has keyed it.
    """
    lamps, remarks = {}, []
    for light in lights:
        if not _is_own(light):
            if light.node_tree is None:  # others are reported with their nodes
                remarks.append(sockets.untouchable(light))
            continue
        why = _obstacle(light)
        if not why:
            lamps[light] = _take_colour(light, gentle)
            continue
        if _BEFORE in light:
            restore(light)
        if tuple(light.color) != _WHITE or light.use_temperature:
            remarks.append(Remark(light.name, "", why))
    return lamps, remarks


def colours_of(lights: Iterable) -> dict:
    """{light: Lamp} of the lamps whose colours `take_colours` takes, whether or not it has."""
    return {light: _colour_of(light) for light in lights if _is_own(light) and not _obstacle(light)}


def is_taken(light) -> bool:
    """Whether the colour of a lamp was taken out of it."""
    return _BEFORE in light and _uses_nodes(light)


def _is_own(light) -> bool:
    return not inventory.is_foreign(light)


def _obstacle(light) -> str:
    """Why the colour of a lamp has to stay where it is, "" if it can be moved."""
    moving = animation.paths(light, light)
    if moving & {"temperature", "use_temperature"}:
        return "its temperature is animated: its colour stays RGB"
    if any(animation.is_shared(light, path) for path in moving & {"color", light.get(insertion.MOVED)}):
        return "its animation is that of other lamps too: its colour stays RGB"
    if _uses_nodes(light) and not sockets.emits(light.node_tree):
        return "its nodes emit inside a node group, or not at all: the colour of the lamp itself stays RGB"
    return ""


def _uses_nodes(light) -> bool:
    """Whether the nodes of a lamp say how it shines; since Blender 5.1 they always do."""
    return light.node_tree is not None if bpy.app.version >= (5, 1, 0) else light.use_nodes


def _take_colour(light, gentle: bool) -> Lamp:
    lamp = _colour_of(light)
    uses_nodes = light[_BEFORE]["use_nodes"] if _BEFORE in light else _uses_nodes(light)
    kept = {
        "color": list(lamp.tint),
        "temperature": lamp.temperature or 0.0,
        "glow": list(lamp.glow),
        "use_nodes": bool(uses_nodes),
    }
    if _BEFORE not in light or light[_BEFORE].to_dict() != kept:
        light[_BEFORE] = kept
    if not _uses_nodes(light):
        light.use_nodes = True
    if light.use_temperature:
        light.use_temperature = False
    is_being_keyed = gentle and insertion.MOVED in light and not animation.is_animated(light, "color")
    if tuple(light.color) != _WHITE and not is_being_keyed:
        light.color = _WHITE
    return lamp


def _colour_of(light) -> Lamp:
    """The colour that the artist gave a lamp: itself, or since it was taken from there, its *Light*."""
    if _BEFORE not in light:
        if light.use_temperature:
            return Lamp(tuple(light.color), light.temperature, tuple(light.temperature_color))
        return Lamp(tuple(light.color))
    kept = light[_BEFORE].to_dict()
    tint, temperature, glow = tuple(kept["color"]), kept["temperature"], tuple(kept["glow"])
    if insertion.MOVED not in light:
        tint = tuple(light.color) if tuple(light.color) != _WHITE else next(_chosen_tints(light), tint)
    if light.use_temperature or (temperature and light.temperature != temperature):
        temperature, glow = light.temperature, tuple(light.temperature_color)
    return Lamp(tint, temperature or None, glow)


def _chosen_tints(light) -> Iterator[tuple]:
    """The colours that the artist chose in *Light* nodes of a lamp."""
    for node in light.node_tree.nodes if light.node_tree else ():
        if nodes.role(node) == "light":
            tint = tuple(node.inputs["Tint"].default_value[:3])
            if tint != tuple(node.get(insertion.TINT, _WHITE)):
                yield tint


def tints_of(light) -> list:
    """The inputs of the *Light* nodes that hold the colour of a lamp while it is converted; none while it is not."""
    if _BEFORE not in light or light.node_tree is None:
        return []
    return [node.inputs["Tint"] for node in light.node_tree.nodes if nodes.role(node) == "light"]


def temperature_of(light) -> float | None:
    """The temperature in kelvin that was taken out of a lamp, None if there is none."""
    return (_BEFORE in light and light[_BEFORE]["temperature"]) or None


def restore(light) -> None:
    """Give a lamp back the colour that `take_colours` took, as it is now."""
    lamp = _colour_of(light)
    if insertion.MOVED in light:
        path = insertion.moved_path(light)
        animation.move(light, "color", path)  # what was keyed there since is newer
        animation.move(light, path, "color")
        del light[insertion.MOVED]
    if _BEFORE not in light:
        return
    light.color = lamp.tint
    if lamp.temperature:
        light.use_temperature = True
    if not light[_BEFORE]["use_nodes"]:
        light.use_nodes = False
    del light[_BEFORE]


def local_lights() -> list:
    return [light for light in bpy.data.lights if light.library is None]


def temperatures_of(groups: list[str], glows: dict) -> dict[str, float]:
    """{light group: kelvin} of the groups in which all that shines is one black body.

    glows: {shading: what `glows_of` says of it}.
    """
    found = {}
    for shading, kelvins in glows.items():
        if kelvins:
            found.setdefault(group_of(shading, groups), set()).update(kelvins)
    return {name: next(iter(kinds)) for name, kinds in found.items() if len(kinds) == 1 and None not in kinds}


def group_of(shading, groups: list[str]) -> str:
    """The light group, of those of a scene, that what a node tree emits belongs to."""
    return shading.light_group if shading.light_group in groups else groups[-1]


def glows_of(shading, lamp: Lamp | None) -> tuple[float | None, ...]:
    """Kelvin of each emission of a tree; None for what is no black body."""
    return tuple(_glows_in(shading, lamp))


def _glows_in(shading, lamp: Lamp | None) -> Iterator[float | None]:
    for node in shading.tree.nodes:
        for socket in spectral_sockets(node):
            if kind_of(socket) is Kind.EMISSION and in_use(socket):
                own = blackbody_behind(socket)
                if lamp and lamp.temperature:
                    yield None if own else lamp.temperature
                else:
                    yield own


def first_illuminant(temperatures: dict[str, float], group: str) -> str:
    """The illuminant that a light group has before the artist chooses one."""
    return _planckian(temperatures[group]) if group in temperatures else _DAYLIGHT


class Lighting:
    """How the emission of a scene is converted: the number of each light group, its spectrum, and the lamps."""

    def __init__(self, model: FactorModel, groups: dict[str, int], lamps: dict, glows: dict) -> None:
        """glows: {shading: kelvins}, as `glows_of` tells them."""
        self.model, self.groups, self.numbers, self.lamps = model, list(groups), groups, lamps
        self.temperatures = temperatures_of(self.groups, glows)
        self.glows = {shading.owner: kelvins for shading, kelvins in glows.items()}

    def _emitter(self, name: str, kelvin: float):
        """The emitter group of a black body in a light group."""
        spectrum = library.illuminant(_planckian(kelvin))
        reference = _planckian(kelvin) if name in self.temperatures else _DAYLIGHT
        coefficients = self.model.emission(spectrum, library.illuminant(reference))
        return node_groups.emitter_group(f"Relume {kelvin:g} K on {reference}", coefficients)

    def describe(self, conversion, shading, socket) -> None:
        """Want the light of its light group in front of a socket that sends out light."""
        name = group_of(shading, self.groups)
        spectral = conversion.carries_spectrum(socket)
        if spectral:
            conversion.upsample(socket)
        kelvin, lamp, wanted = blackbody_behind(socket), self.lamps.get(shading.owner), []
        if kelvin:
            wanted.append(sockets.Insertion(self._emitter(name, kelvin)))
        group = node_groups.light_group(self.numbers[name], self.model.channels, spectral or kelvin is not None)
        glow = self._emitter(name, lamp.temperature) if lamp and lamp.temperature else None
        conversion.wanted[socket] = [*wanted, sockets.Insertion(group, lamp, glow)]
        self._remark_on_colour(conversion, shading, socket, lamp)

    def _remark_on_colour(self, conversion, shading, socket, lamp: Lamp | None) -> None:
        """Remark on light whose colour, as far as it is known, changes coloured surfaces otherwise than RGB does."""
        colour = np.ones(3) if conversion.wiring.link(socket) else np.array(conversion.value(socket))
        colour *= lamp.tint if lamp else 1.0
        space = bpy.data.colorspace.working_space
        if upsample.filter_difference(self.model, colour, space) > _NOTICED:
            conversion.remarks.append(Remark(shading.words, "", _FILTER))


def _planckian(kelvin: float) -> str:
    return f"Planckian {kelvin:g} K"


def blackbody_behind(socket) -> float | None:
    """Kelvin of the Blackbody node whose colour, and nothing else, comes into a socket; None if there is none.

    A temperature that is linked or animated, or that the library's law does not reach, counts as a colour.
    """
    while socket.is_linked and not socket.links[0].is_muted:
        node = socket.links[0].from_node
        if node.type == "BLACKBODY":
            temperature = node.inputs["Temperature"]
            tree = temperature.id_data
            moving = temperature.path_from_id("default_value") in animation.paths(tree, tree)
            kelvin = round(temperature.default_value, 2)
            return kelvin if not (temperature.is_linked or moving) and 800.0 <= kelvin <= 40_000.0 else None
        if node.type != "REROUTE" and nodes.role(node) not in nodes.INSERTED:
            return None
        socket = node.inputs[0]
    return None
