"""What is known of node trees, and holds for as long as they are as they were.

To read a tree takes an eighth of what it takes to work out what should be before its sockets. What is kept are numbers,
words and data-blocks: nodes and sockets may go away at any time.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import bpy

from ..host import animation
from . import lights, nodes, sockets
from .closures import decides, is_missing, is_shader
from .wiring import THROUGH

__all__ = ["Facts", "Memory"]

_COLOURS = {"RGBA", "VECTOR"}


@dataclass(eq=False)
class Facts:
    """What was found out about a node tree. state: what it was then; two that are the same object, say the same."""

    state: tuple | None
    emits: bool | None = None
    groups: list | None = None
    glows: dict = field(default_factory=dict)


class Memory:
    """Facts about node trees, and which of them carry what they should.

    is_lasting: whether it is used more than once; trees are read only then.
    """

    def __init__(self, is_lasting: bool = True) -> None:
        self.is_lasting = is_lasting
        self._kept: dict[bpy.types.NodeTree, Facts] = {}
        self._read: set[bpy.types.NodeTree] = set()
        self._in_line: dict[int, tuple] = {}
        self._under = None

    def look_again(self) -> None:
        """From now on any tree may have changed."""
        self._read.clear()

    def facts(self, tree) -> Facts:
        """What is known of a tree, which is read once after each `look_again`."""
        kept = self._kept.get(tree)
        if kept is None or tree not in self._read:
            state = _state_of(tree) if self.is_lasting else None
            if kept is None or state is None or kept.state != state:
                kept = self._kept[tree] = Facts(state)
            self._read.add(tree)
        return kept

    def forget(self, tree) -> None:
        """A tree has changed."""
        self._read.discard(tree)

    def emits(self, tree) -> bool:
        facts = self.facts(tree)
        if facts.emits is None:
            facts.emits = sockets.emits(tree)
        return facts.emits

    def groups_in(self, tree) -> list:
        facts = self.facts(tree)
        if facts.groups is None:
            facts.groups = sockets.groups_in(tree)
        return facts.groups

    def glows_of(self, shading, lamp) -> tuple[float | None, ...]:
        facts, kelvin = self.facts(shading.tree), lamp and lamp.temperature
        if kelvin not in facts.glows:
            facts.glows[kelvin] = lights.glows_of(shading, lamp)
        return facts.glows[kelvin]

    def in_line(self, owner, under: tuple, saying: tuple) -> list | None:
        """The remarks on node trees that carry what they should; None where that is not known.

        owner: that of the first of them. under: what holds for all trees. saying: all that says what they should carry.
        """
        if not self.is_lasting:
            return None
        if self._under != under:
            self._under = under
            self._in_line.clear()
        before, found = self._in_line.get(owner.session_uid, ((), None))
        return found if before == saying else None

    def note_in_line(self, owner, under: tuple, saying: tuple, remarks: list) -> None:
        if self.is_lasting and self._under == under:
            self._in_line[owner.session_uid] = saying, remarks


def _state_of(tree) -> tuple:
    """All of a node tree that says what should be before its sockets, and what is there."""
    said = []
    for node in tree.nodes:
        kind = node.bl_idname
        said.append(kind)
        reader = _readers.get(kind, _readers)
        if reader is _readers:
            reader = _readers[kind] = _reader_of(node)
        if reader is not None:
            said += reader(node)
    for link in tree.links:
        said += (link.from_socket.as_pointer(), link.to_socket.as_pointer(), link.is_muted)
    return tuple(said), animation.paths(tree, tree)


Reader = Callable[[bpy.types.Node], list | tuple]
_readers: dict[str, Reader | None] = {}  # by kind of node; None: nothing depends on such a node but its links


def _reader_of(node) -> Reader | None:
    kind = node.bl_idname
    if node.type in {"GROUP", "CUSTOM GROUP"}:
        return _group
    if is_shader(node):
        deciding = [number for number, socket in enumerate(node.inputs) if decides(socket)]
        return lambda each: [each.name, *_values(map(each.inputs.__getitem__, deciding), each)]
    if node.type in THROUGH:
        return _mix
    if node.type in {"TEX_IMAGE", "TEX_ENVIRONMENT"}:
        return _image
    if node.type == "BLACKBODY":
        return lambda each: (each.name, each.inputs[0].default_value)
    if node.type in {"GROUP_INPUT", "GROUP_OUTPUT"}:
        return _end
    if hasattr(node, "is_active_output"):
        return lambda each: (each.is_active_output,)
    # Remarks say the names of others
    return None if kind in _DULL else lambda each: (each.name,)


_DULL = {"ShaderNodeMath", "ShaderNodeMixShader", "ShaderNodeAddShader", "ShaderNodeTexCoord", "ShaderNodeMapping"}


def _values(inputs, node) -> list:
    found = [getattr(node, "parametrization", None)]
    for socket in inputs:
        value = socket.default_value
        found += (socket.is_unavailable, value if isinstance(value, float) else value[:])
    return found


def _mix(node) -> list:
    """Of a node that colours pass: they may be taken from where nothing is linked to it."""
    return [node.name, *((s.type, s.is_unavailable, s.default_value[:]) for s in node.inputs if s.type in _COLOURS)]


def _group(node) -> list:
    tree = node.node_tree
    found = [node.name, node.mute, tree and tree.as_pointer()]
    if tree is not None and tree.get(nodes.ROLE) in nodes.INSERTED:
        return found + [socket.default_value[:] for socket in node.inputs[:2]]  # Color, Tint
    found.append(tree is not None and tree.library is None)
    for socket in node.inputs:
        kind = socket.type
        found += (socket.identifier, kind)
        if kind in _COLOURS:
            found += (socket.is_unavailable, socket.default_value[:])
    return found + [socket.type for socket in node.outputs]


def _image(node) -> tuple:
    image = node.image
    return (node.name, image and image.name, is_missing(image))


def _end(node) -> list:
    ends = node.inputs if node.type == "GROUP_OUTPUT" else node.outputs
    return [getattr(node, "is_active_output", None), *((s.identifier, s.type) for s in ends)]
