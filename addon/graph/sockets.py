"""The colours of a scene: putting an *Upsample* or *Light* group in front of every spectral socket, and taking it out.

A spectrum is spectral already. Where it reaches a closure through reroutes, mixes or node groups, the RGB colours that
it is mixed with are upsampled before the mix.
"""

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass

import bpy

from ...core.model import upsample
from ..host import animation
from ..host.inventory import Inventory, take
from ..store.remarks import Remark
from . import node_groups, nodes
from .closures import Bounds, Kind, bounds_of, in_use, is_animated, kind_of, reasons, spectral_sockets
from .wiring import Wiring

__all__ = [
    "Shading",
    "all_trees",
    "convert",
    "emits",
    "restore",
    "shadings_of",
    "spectral_sockets",
    "take_out",
    "trees_of",
    "untouchable",
    "upsample_group_for",
]

# Nodes that turn a spectrum into another colour
_RGB_ONLY = {"HUE_SAT", "SEPARATE_COLOR", "VALTORGB", "RGBTOBW"}
_ANIMATED = "relume_animated"  # on an inserted node: the path whose animation acts on it
_LINKED = "linked from {}: Blender cannot change it here, and its colours stay RGB"
_SHARED = "its animation is that of other materials too: the colour stays RGB"
_TOO_PURE = "this colour lies outside Rec.709: the surface comes out less pure than plain RGB shows it"
_OVERRIDE = "a library override: Blender keeps no new nodes in it, and its colours stay RGB"


def untouchable(owner) -> Remark:
    """What the artist reads about linked data and library overrides."""
    why = _OVERRIDE if owner.library is None else _LINKED.format(owner.library.filepath)
    return Remark(owner.name, "", why)


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


def shadings_of(inventory: Inventory) -> tuple[list[Shading], list[Remark]]:
    """The node trees that shade a scene and can be changed, and remarks on those that cannot.

    Groups inside trees come once, as part of the first tree that uses them.
    """
    found, remarks = {}, []

    def visit(tree, owner, light_group) -> None:
        if tree is None or tree in found or tree.get(nodes.ROLE):
            return
        if owner.library is not None or owner.override_library is not None:
            if not _is_converted(tree):
                remarks.append(untouchable(owner))
            return
        found[tree] = Shading(tree, owner, light_group)
        for node in tree.nodes:
            if node.type == "GROUP":
                visit(node.node_tree, node.node_tree, light_group)

    if inventory.world:
        visit(inventory.world.node_tree, inventory.world, inventory.world.lightgroup)
    for light, thing in inventory.lights.items():
        visit(light.node_tree, light, thing.lightgroup)
    for material, thing in inventory.materials.items():
        visit(material.node_tree, material, thing.lightgroup if thing else "")
        if material.node_tree is None and not material.is_grease_pencil:
            remarks.append(Remark(material.name, "", "it has no nodes: its colour stays RGB"))
    return list(found.values()), remarks


def _is_converted(tree) -> bool:
    return any(nodes.role(node) for node in tree.nodes)


def _is_closed(node) -> bool:
    """Whether a node is a linked group that makes a shader: colours take part if they are spectral before it."""
    if node.type != "GROUP" or node.node_tree is None or node.node_tree.library is None or nodes.role(node):
        return False
    return any(s.type == "SHADER" for s in node.outputs) and not _is_converted(node.node_tree)


def emits(tree) -> bool:
    """Whether a node tree has a socket that sends out light."""
    return any(
        kind_of(socket) is Kind.EMISSION and in_use(socket) for node in tree.nodes for socket in spectral_sockets(node)
    )


def upsample_group_for(socket, channels: int):
    """The *Upsample* group that goes in front of a socket; before a mix nothing is held to the bounds of a closure."""
    return node_groups.upsample_group(channels, vector=socket.type == "VECTOR", bounds=bounds_of(socket))


class Conversion:
    """The state of one conversion: how the trees are wired, what of them is animated, and what stays RGB.

    until_done: closed when all is converted.
    """

    def __init__(self, shadings: list[Shading], channels: int, has_spectra: bool, until_done: ExitStack) -> None:
        self.channels, self.has_spectra, self.until_done = channels, has_spectra, until_done
        self.by_tree = {shading.tree: shading for shading in shadings}
        self.wiring = Wiring(self.by_tree)
        self.unplugged, self.animated = set(), {}
        self.remarks: list[Remark] = []

    def animated_in(self, shading: Shading) -> frozenset[str]:
        if shading.tree not in self.animated:
            self.animated[shading.tree] = animation.paths(shading.tree, shading.owner)
        return self.animated[shading.tree]

    def is_held(self, shading: Shading, socket) -> bool:
        """Whether the value of a socket is animated in a way that cannot be moved to another."""
        if not is_animated(socket, self.animated_in(shading)):
            return False
        path = socket.path_from_id("default_value")
        return animation.is_shared(shading.tree, path) or animation.is_shared(shading.owner, f"node_tree.{path}")

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
        """Make what comes into a socket spectral: at the socket itself, or before a mix that a spectrum is part of."""
        visited, waiting = set(), [socket]
        while waiting:
            socket = waiting.pop()
            link = self.wiring.link(socket)
            if socket in visited or (link and nodes.role(link.from_node) in nodes.INSERTED | {"spectrum"}):
                continue
            visited.add(socket)
            if self.carries_spectrum(socket):
                waiting += self.wiring.feeds(socket) or ()
            elif not self.is_neutral(socket, link):
                if self.is_too_pure(socket, link):
                    self.remarks.append(Remark(self.by_tree[socket.id_data].words, socket.node.name, _TOO_PURE))
                self.insert(socket, upsample_group_for(socket, self.channels))

    def is_too_pure(self, socket, link) -> bool:
        """Whether Cycles cuts channels of the colour that a socket holds, for they are below 0."""
        if (link is not None and not link.is_muted) or bounds_of(socket) is Bounds.NONE:
            return False
        return upsample.is_outside_rec709(socket.default_value[:3], bpy.data.colorspace.working_space)

    def is_neutral(self, socket, link) -> bool:
        """Whether the value of a socket is the same in every channel, and stays so."""
        animated = self.animated_in(self.by_tree[socket.id_data])
        if (link is not None and not link.is_muted) or is_animated(socket, animated):
            return False
        red, green, blue = socket.default_value[:3]
        return red == green == blue

    def insert(self, socket, group, value: Sequence[float] | None = None):
        """Put a node of `group` in front of a socket, as `nodes.insert` does."""
        shading = self.by_tree[socket.id_data]
        if shading.owner != shading.tree and shading.tree not in self.unplugged:
            self.unplugged.add(shading.tree)
            self.until_done.enter_context(nodes.unplugged(shading.tree))
        node = nodes.insert(shading.tree, socket, self.wiring.link(socket), group, value)
        self.wiring.note(node.outputs[0].links[0])
        if is_animated(socket, self.animated_in(shading)):
            self.move_animation(shading, socket.path_from_id("default_value"), node)
        return node

    def move_animation(self, shading: Shading, path: str, node) -> None:
        """Let the animation of a value act on the inserted node, which now holds it."""
        after = node.inputs[0].path_from_id("default_value")
        node[_ANIMATED] = path
        animation.move(shading.tree, path, after)
        if shading.owner != shading.tree:
            animation.move(shading.owner, f"node_tree.{path}", f"node_tree.{after}")
        self.animated[shading.tree] = self.animated[shading.tree] - {path} | {after}


def convert(
    shadings: list[Shading], channels: int, light: Callable[[Conversion, Shading, bpy.types.NodeSocket], None]
) -> list[Remark]:
    """Make every colour of the node trees of a scene take part in the spectral render; grey ones do already.

    light: called for each socket that sends out light. Returns remarks on what stays RGB. Running it twice changes
    nothing more.
    """
    has_spectra = any(tree.get(nodes.ROLE) == "spectrum" for tree in bpy.data.node_groups)
    with ExitStack() as stack:
        conversion = Conversion(shadings, channels, has_spectra, stack)
        for shading in shadings:
            _convert_tree(conversion, shading, light)
    return conversion.remarks


def _convert_tree(conversion: Conversion, shading: Shading, light) -> None:
    has_output = shading.owner == shading.tree
    for node in list(shading.tree.nodes):
        has_output |= getattr(node, "is_active_output", False)
        conversion.remarks += [Remark(shading.words, node.name, why) for why in reasons(node)]
        for socket in spectral_sockets(node):
            link = conversion.wiring.link(socket)
            if link is not None and nodes.role(link.from_node) in nodes.INSERTED:
                continue
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


def restore(tree, owner) -> None:
    """Take out of a node tree what `convert` put in. owner: as of a `Shading`."""
    inserted = [node for node in tree.nodes if nodes.role(node) in nodes.INSERTED]
    if not inserted:
        return
    with nodes.unplugged(tree):
        for node in inserted:
            take_out(tree, owner, node)


def take_out(tree, owner, node) -> None:
    """Take one inserted node out of a tree; its animation goes back to where it was."""
    if _ANIMATED in node:
        after = node.inputs[0].path_from_id("default_value")
        animation.move(tree, after, node[_ANIMATED])
        if owner != tree:
            animation.move(owner, f"node_tree.{after}", f"node_tree.{node[_ANIMATED]}")
    nodes.take_out(tree, node)


def all_trees():
    """Every local node tree of the file that may hold a converted socket, and its owner."""
    for collection in (bpy.data.materials, bpy.data.worlds, bpy.data.lights):
        for owner in collection:
            if owner.node_tree and owner.library is None:
                yield owner.node_tree, owner
    for tree in bpy.data.node_groups:
        if tree.bl_idname == "ShaderNodeTree" and tree.library is None and not tree.get(nodes.ROLE):
            yield tree, tree
