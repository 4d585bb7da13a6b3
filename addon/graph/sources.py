"""Where the colours of a material, lamp or world come from, as the planner needs it."""

from dataclasses import dataclass, replace

from ...core.model import fresnel
from ...core.picture import finish
from ...core.spectra.spectrum import Spectrum, SpectrumError
from ..host import animation
from . import nodes, spectra
from .closures import Kind, in_use, is_animated, kind_of, spectral_sockets
from .lights import blackbody_behind
from .wiring import Wiring

__all__ = ["Source", "is_grey", "sources_of"]

_METAL = ("IOR", "Extinction")
_SOME_DENSITY = 1.0  # where it is not a number


@dataclass(frozen=True)
class Source:
    """A colour, and what is made of it.

    colour: a Spectrum, an RGB colour as a tuple, or None for colours that are not known, as those of a texture. again:
    the part of the light that it reflects more than once. density: of what absorbs 1 less its colour, per metre; or 0.
    right_at: the optical depth at which its channels are right, 0 where they are means. shines: whether it is sent out.
    """

    colour: Spectrum | tuple | None
    again: float = 0.0
    density: float = 0.0
    right_at: float = 0.0
    shines: bool = False


def sources_of(owner, kelvin: float | None = None) -> list[Source]:
    """The sources of all colours that a material, lamp or world shows, groups included.

    Greys are left out, but for one where there is nothing else. kelvin: of the light group, where it is a black body;
    light of that temperature has no colour of its own.
    """
    trees = _trees_in(owner.node_tree)
    wiring = Wiring(trees)
    animated = {tree: animation.paths(tree, owner if tree == owner.node_tree else tree) for tree in trees}
    found = []
    for tree in trees:
        for node in tree.nodes:
            used = [socket for socket in spectral_sockets(node) if in_use(socket, animated[tree])]
            if _is_rgb_metal(wiring, node, used):
                found.append(_finished(wiring, used[0], _metal_colour(wiring, node)))
                continue
            for socket in used:
                shines = kelvin and kind_of(socket) is Kind.EMISSION
                if not (shines and blackbody_behind(socket) == kelvin):
                    found += [_finished(wiring, socket, colour) for colour in _ends(wiring, animated, socket)]
    return [source for source in found if not is_grey(source.colour)] or found[:1]


def is_grey(colour) -> bool:
    """Whether a colour is the same in every channel."""
    return isinstance(colour, tuple) and len(set(colour)) == 1


def _finished(wiring: Wiring, socket, colour) -> Source:
    """The source that a colour is in a socket of a closure."""
    node, source = socket.node, Source(colour, shines=kind_of(socket) is Kind.EMISSION)

    def number(name: str) -> float:
        return wiring.holder(node.inputs[name]).default_value

    match node.bl_idname:
        case "ShaderNodeBsdfDiffuse":
            return replace(source, again=finish.rough_diffuse(number("Roughness")))
        case "ShaderNodeBsdfMetallic" | "ShaderNodeBsdfAnisotropic":
            return replace(source, again=finish.rough_glossy(number("Roughness")))
        case "ShaderNodeBsdfPrincipled" if socket.identifier == "Base Color":
            if number("Metallic") > 0.5:
                return replace(source, again=finish.rough_glossy(number("Roughness")))
            return replace(source, again=finish.rough_diffuse(number("Diffuse Roughness")))
        case "ShaderNodeVolumeScatter" | "ShaderNodeVolumePrincipled" if socket.identifier == "Color":
            return replace(source, again=finish.VOLUME)
        case "ShaderNodeVolumeAbsorption":
            is_known = wiring.link(node.inputs["Density"]) is None
            density = max(number("Density"), 0.0) if is_known else _SOME_DENSITY
            link = wiring.link(socket)
            is_spectrum = link is not None and nodes.role(link.from_node) == "spectrum"
            right_at = spectra.depth_of(link.from_node.node_tree) if is_spectrum else 0.0
            return replace(source, density=density, right_at=right_at)
    return source


def _trees_in(start) -> list:
    """A node tree and the groups in it, each once; not those that Relume made."""
    found, waiting = {}, [start]
    while waiting:
        tree = waiting.pop()
        if tree is not None and tree not in found and not tree.get(nodes.ROLE):
            found[tree] = None
            waiting += [node.node_tree for node in tree.nodes if node.type == "GROUP"]
    return list(found)


def _ends(wiring: Wiring, animated: dict, start) -> list:
    """The sources of what comes into a socket, through reroutes, groups and mixes."""
    found, visited, waiting = [], set(), [(start, False)]
    while waiting:
        socket, changed = waiting.pop()
        socket = wiring.holder(socket)
        if socket in visited:
            continue
        visited.add(socket)
        link, feeds = wiring.link(socket), wiring.feeds(socket)
        if link is None or link.is_muted:
            sources = [None] if is_animated(socket, animated[socket.id_data]) else _value(socket)
        elif nodes.role(link.from_node) == "spectrum":
            sources = [_reflectance(link.from_node.node_tree)]
        elif feeds is None:
            sources = [None]
        else:
            becomes_another = bool(feeds) and not _is_passed_on(link.from_node)
            sources = [None] if becomes_another else []
            waiting += [(feed, changed or becomes_another) for feed in feeds]
        found += [source for source in sources if not (changed and isinstance(source, tuple))]
    return found


def _is_passed_on(node) -> bool:
    """Whether colours come out of a node as they went in, or mixed."""
    return node.type in {"REROUTE", "GROUP", "GROUP_INPUT"} or getattr(node, "blend_type", "") == "MIX"


def _value(socket) -> list:
    """The colour of a socket; lengths and coefficients that differ by channel count as colours that are not known."""
    value = tuple(socket.default_value[:3])
    if socket.type == "RGBA":
        return [value]
    return [] if is_grey(value) else [None]


def _reflectance(tree):
    """The reflectance of a spectrum group; of a metal, at normal incidence."""
    try:
        found = spectra.spectra_of(tree)
        return found["Color"] if "Color" in found else fresnel.normal_reflectance(*(found[name] for name in _METAL))
    except (KeyError, SpectrumError):
        return None


def _is_rgb_metal(wiring: Wiring, node, used: list) -> bool:
    """Whether n and k of a metal are numbers for red, green and blue."""
    if node.bl_idname != "ShaderNodeBsdfMetallic" or not used or used[0].name not in _METAL:
        return False
    return all(wiring.link(node.inputs[name]) is None for name in _METAL)


def _metal_colour(wiring: Wiring, node) -> tuple:
    n, k = (wiring.holder(node.inputs[name]).default_value[:3] for name in _METAL)
    return tuple(fresnel.reflectance(n, k, 1.0).tolist())
