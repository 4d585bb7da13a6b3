"""The colours of a scene: which of them need an *Upsample* or *Light* group in front, so that they are spectral.

A spectrum is spectral already. Where it reaches a closure through reroutes, mixes or node groups, the RGB colours that
it is mixed with are upsampled before the mix.
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass

import bpy

from ...core.model import upsample
from ..host import animation
from ..host.inventory import Inventory, is_foreign, take
from ..store.remarks import Remark
from . import node_groups, nodes
from .closures import Bounds, Kind, bounds_of, in_use, is_animated, kind_of, reasons, spectral_sockets
from .wiring import Wiring

__all__ = [
    "Conversion",
    "Insertion",
    "Shading",
    "all_trees",
    "can_be_made_local",
    "describe",
    "emits",
    "groups_in",
    "has_spectra",
    "is_converted",
    "shadings_of",
    "spectral_sockets",
    "trees_of",
    "untouchable",
    "upsample_group_for",
]

# Nodes that turn a spectrum into another colour
_RGB_ONLY = {"HUE_SAT", "SEPARATE_COLOR", "VALTORGB", "RGBTOBW"}
_MAKE_LOCAL = "its colours stay RGB, which shifts them even in daylight. Make it local to have them exact"
_LINKED = f"linked from {{}}: Blender cannot change it here, and {_MAKE_LOCAL}"
_SHARED = "its animation is that of other materials too: the colour stays RGB"
_TOO_PURE = "this colour lies outside Rec.709: the surface comes out less pure than plain RGB shows it"
_OVERRIDE = f"a library override: Blender keeps no new nodes in it, and {_MAKE_LOCAL}"


def untouchable(owner) -> Remark:
    """What the artist reads about linked data and library overrides."""
    why = _OVERRIDE if owner.library is None else _LINKED.format(owner.library.filepath)
    return Remark(owner.name, "", why)


def can_be_made_local(remark: Remark) -> bool:
    """Whether a remark is one of `untouchable`."""
    return remark.why.endswith(_MAKE_LOCAL)


@dataclass(frozen=True)
class Shading:
    """A node tree that shades a scene.

    owner: the material, world or light that it belongs to, or the tree itself if it is a node group. light_group: the
    light group of what it emits.
    """

    tree: bpy.types.NodeTree
    owner: bpy.types.ID
    light_group: str

    @property
    def words(self) -> str:
        return self.owner.name


def trees_of(scene) -> list:
    """The node trees that shade a scene and can be changed, each with the light group of what it emits."""
    return [(shading.tree, shading.light_group) for shading in shadings_of(take(scene))[0]]


def shadings_of(inventory: Inventory, inner: Callable | None = None) -> tuple[list[Shading], list[Remark]]:
    """The node trees that shade a scene and can be changed, and remarks on those that cannot.

    Groups inside trees come once, as part of the first tree that uses them. inner: `groups_in`, where that is known.
    """
    inner = inner or groups_in
    found, remarks = {}, []

    def visit(tree, owner, light_group) -> None:
        if tree is None or tree in found or tree.get(nodes.ROLE):
            return
        if is_foreign(owner):
            if not is_converted(tree):
                remarks.append(untouchable(owner))
            return
        found[tree] = Shading(tree, owner, light_group)
        for group in inner(tree):
            visit(group, group, light_group)

    if inventory.world:
        visit(inventory.world.node_tree, inventory.world, inventory.world.lightgroup)
    for light, thing in inventory.lights.items():
        visit(light.node_tree, light, thing.lightgroup)
    for material, thing in inventory.materials.items():
        visit(material.node_tree, material, thing.lightgroup if thing else "")
        if material.node_tree is None and not material.is_grease_pencil:
            remarks.append(Remark(material.name, "", "it has no nodes: its colour stays RGB"))
    return list(found.values()), remarks


def is_converted(tree) -> bool:
    """Whether a node tree was set up, maybe in its own file."""
    return any(nodes.role(node) for node in tree.nodes)


def _is_closed(node) -> bool:
    """Whether a node is a linked group that makes a shader: colours take part if they are spectral before it."""
    if node.type != "GROUP" or node.node_tree is None or node.node_tree.library is None or nodes.role(node):
        return False
    return any(s.type == "SHADER" for s in node.outputs) and not is_converted(node.node_tree)


def emits(tree) -> bool:
    """Whether a node tree has a socket that sends out light."""
    return any(
        kind_of(socket) is Kind.EMISSION and in_use(socket) for node in tree.nodes for socket in spectral_sockets(node)
    )


def groups_in(tree) -> list:
    """The artist's node groups in a tree."""
    return [node.node_tree for node in tree.nodes if node.type == "GROUP" and node.node_tree and not nodes.role(node)]


def has_spectra() -> bool:
    """Whether the file has measured spectra."""
    return any(tree.get(nodes.ROLE) == "spectrum" for tree in bpy.data.node_groups)


def upsample_group_for(socket, channels: int):
    """The *Upsample* group that goes in front of a socket; before a mix nothing is held to the bounds of a closure."""
    return node_groups.upsample_group(channels, vector=socket.type == "VECTOR", bounds=bounds_of(socket))


@dataclass(frozen=True)
class Insertion:
    """A node that goes in front of a socket: a node of `group`.

    lamp, glow: for the *Light* of a lamp, its `lights.Lamp` and the emitter group of its temperature.
    """

    group: bpy.types.NodeTree
    lamp: object = None
    glow: bpy.types.NodeTree | None = None


class Conversion:
    """What should be in front of the sockets of some node trees, as a function of the artist's own nodes alone.

    wanted: {socket: the insertions before it, the one at the source first}.
    neutral: sockets that need nothing because their colour is grey.
    """

    def __init__(self, shadings: list[Shading], channels: int) -> None:
        self.channels = channels
        self.has_spectra = has_spectra()
        self.by_tree = {shading.tree: shading for shading in shadings}
        self.wiring = Wiring(self.by_tree)
        self.wanted: dict[bpy.types.NodeSocket, list[Insertion]] = {}
        self.neutral: set[bpy.types.NodeSocket] = set()
        self.animated, self.remarks = {}, []

    def animated_in(self, shading: Shading) -> frozenset[str]:
        if shading.tree not in self.animated:
            self.animated[shading.tree] = animation.paths(shading.tree, shading.owner)
        return self.animated[shading.tree]

    def animated_path(self, socket) -> str:
        """The path that the animation of the value of a socket acts on, "" if there is none."""
        animated = self.animated_in(self.by_tree[socket.id_data])
        for place in (self.wiring.holder(socket), socket):
            if is_animated(place, animated):
                return place.path_from_id("default_value")
        return ""

    def is_held(self, shading: Shading, socket) -> bool:
        """Whether the value of a socket is animated in a way that cannot be moved to another."""
        path = self.animated_path(socket)
        return bool(path) and (
            animation.is_shared(shading.tree, path) or animation.is_shared(shading.owner, f"node_tree.{path}")
        )

    def carries_spectrum(self, socket, visited: set | None = None) -> bool:
        """Whether a measured spectrum reaches a socket. visited: sockets that need not be looked at."""
        visited, waiting = set() if visited is None else visited, [socket] if self.has_spectra else []
        while waiting:
            socket = waiting.pop()
            if socket in visited:
                continue
            visited.add(socket)
            link = self.wiring.link(socket)
            if link is not None and not link.is_muted and nodes.role(link.from_node) == "spectrum":
                return True
            if link is not None and link.from_node.type in _RGB_ONLY:
                self.remark_on_rgb_only(link.from_node, visited)
            else:
                waiting += self.wiring.feeds(socket) or ()
        return False

    def remark_on_rgb_only(self, node, visited: set) -> None:
        if any(self.carries_spectrum(s, visited) for s in node.inputs if s.type == "RGBA"):
            why = "it changes a spectrum as if it were an RGB colour: put the spectrum behind it"
            self.remarks.append(Remark(self.by_tree[node.id_data].words, node.name, why))

    def upsample(self, socket) -> None:
        """Want what comes into a socket spectral: at the socket itself, or before a mix that a spectrum is part of."""
        visited, waiting = set(), [socket]
        while waiting:
            socket = waiting.pop()
            link = self.wiring.link(socket)
            if socket in visited or (link and nodes.role(link.from_node) == "spectrum"):
                continue
            visited.add(socket)
            if self.carries_spectrum(socket):
                waiting += self.wiring.feeds(socket) or ()
            elif self.is_neutral(socket, link):
                self.neutral.add(socket)
            elif socket not in self.wanted:
                if self.is_too_pure(socket, link):
                    self.remarks.append(Remark(self.by_tree[socket.id_data].words, socket.node.name, _TOO_PURE))
                self.wanted[socket] = [Insertion(upsample_group_for(socket, self.channels))]

    def value(self, socket) -> tuple[float, float, float]:
        """The colour or vector that a socket has where nothing is linked to it."""
        return tuple(self.wiring.holder(socket).default_value[:3])

    def is_too_pure(self, socket, link) -> bool:
        """Whether Cycles cuts channels of the colour that a socket holds, for they are below 0."""
        if (link is not None and not link.is_muted) or bounds_of(socket) is Bounds.NONE:
            return False
        return upsample.is_outside_rec709(self.value(socket), bpy.data.colorspace.working_space)

    def is_neutral(self, socket, link) -> bool:
        """Whether the value of a socket is the same in every channel, and stays so."""
        if (link is not None and not link.is_muted) or self.animated_path(socket):
            return False
        return len(set(self.value(socket))) == 1


Light = Callable[[Conversion, Shading, bpy.types.NodeSocket], None]


def describe(shadings: list[Shading], channels: int, light: Light, only: Collection | None = None) -> Conversion:
    """What should be in front of every colour of the node trees of a scene; grey ones need nothing.

    light: called for each socket that sends out light. only: trees to look at; the others say what reaches them.
    """
    conversion = Conversion(shadings, channels)
    for shading in shadings:
        if only is None or shading.tree in only:
            _describe_tree(conversion, shading, light)
    return conversion


def _describe_tree(conversion: Conversion, shading: Shading, light: Light) -> None:
    has_output = shading.owner == shading.tree
    for node in shading.tree.nodes:
        has_output |= getattr(node, "is_active_output", False)
        conversion.remarks += [Remark(shading.words, node.name, why) for why in reasons(node)]
        for socket in spectral_sockets(node):
            if not in_use(socket, conversion.animated_in(shading)):
                continue
            if conversion.is_held(shading, socket):
                conversion.remarks.append(Remark(shading.words, node.name, _SHARED))
            elif kind_of(socket) is Kind.EMISSION:
                light(conversion, shading, socket)
            else:
                conversion.upsample(socket)
        if _is_closed(node):
            for socket in [s for s in node.inputs if s.type == "RGBA"]:
                conversion.upsample(socket)
    if not has_output:
        conversion.remarks.append(Remark(shading.words, "", "it has no output node: Cycles shows nothing of it"))


def all_trees():
    """Every local node tree of the file that may hold a converted socket, and its owner."""
    for collection in (bpy.data.materials, bpy.data.worlds, bpy.data.lights):
        for owner in collection:
            if owner.node_tree and owner.library is None:
                yield owner.node_tree, owner
    for tree in bpy.data.node_groups:
        if tree.bl_idname == "ShaderNodeTree" and tree.library is None and not tree.get(nodes.ROLE):
            yield tree, tree
