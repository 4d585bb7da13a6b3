"""Patching node trees: the nodes in front of their sockets become those that a `sockets.Conversion` wants there.

What is right already stays untouched, so that a tree in which an artist works changes no more than it must; to take
everything out again is a patch that wants nothing.
"""

import re
from collections.abc import Collection
from contextlib import ExitStack

import bpy

from ..host import animation
from . import nodes
from .sockets import Conversion, Insertion, Shading

__all__ = ["MOVED", "TINT", "moved_path", "patch", "restore", "take_out"]

_ANIMATED = "relume_animated"  # on an inserted node: the path whose animation acts on it
_GIVEN = "relume_given"  # on an inserted node: the value of the socket behind it, which whoever writes there changes
MOVED = "relume_moved"  # on a light: the path that the animation of its colour now acts on
_TINT_OF = re.compile(r'node_tree\.nodes\["((?:[^"\\]|\\.)+)"\]\.inputs\[1\]\.default_value')
TINT = "relume_tint"  # on a *Light*: the colour of its lamp, that it was given


def patch(conversion: Conversion, trees: Collection | None = None, gentle: bool = False) -> int:
    """Put in front of sockets what `conversion` wants there; returns how many nodes came, went or changed.

    trees: those to patch, of those described; all by default. gentle: what stands before a colour that has become grey
    may stay, for an artist may just be choosing that colour.
    """
    wanted = {tree: {} for tree in conversion.by_tree if trees is None or tree in trees}
    for socket, insertions in conversion.wanted.items():
        if socket.id_data in wanted:
            wanted[socket.id_data][socket] = insertions
    neutral = conversion.neutral if gentle else ()
    changes = 0
    with ExitStack() as until_done:
        for tree, chains in wanted.items():
            if chains or any(nodes.role(node) in nodes.INSERTED for node in tree.nodes):
                changes += _Tree(conversion, conversion.by_tree[tree], until_done).patch(chains, neutral)
    return changes


class _Tree:
    """One node tree while it is patched."""

    def __init__(self, conversion: Conversion, shading: Shading, until_done: ExitStack) -> None:
        self.conversion, self.shading, self.tree = conversion, shading, shading.tree
        self.until_done, self.is_touched, self.changes = until_done, False, 0

    def patch(self, wanted: dict, neutral: Collection) -> int:
        missing, right = [], set()
        for socket, insertions in wanted.items():
            chain = self.conversion.wiring.inserted(socket)[::-1]
            if self.is_right(chain, insertions) or self.becomes(chain, insertions):
                right.update(chain)
                self.follow(socket, chain, insertions)
            else:
                missing.append((socket, insertions))
        for socket in neutral:
            if socket.id_data == self.tree and socket not in wanted:
                chain = self.conversion.wiring.inserted(socket)
                if [nodes.role(node) for node in chain] == ["upsample"] and _is_plain(chain[0]):
                    right.update(chain)
        lit = [node.inputs["Spectrum"] for node in right if "Spectrum" in node.inputs]
        glows = {link.from_node for socket in lit for link in socket.links}
        for node in [n for n in self.tree.nodes if nodes.role(n) in nodes.INSERTED and n not in right | glows]:
            self.touch()
            take_out(self.tree, self.shading.owner, node)
            self.conversion.animated.pop(self.tree, None)  # the animation that acted on it went back
        for socket, insertions in missing:
            self.touch()
            self.insert(socket, insertions)
        return self.changes

    def touch(self) -> None:
        """Unplug a tree before it is changed, and note that it changes."""
        self.changes += 1
        if not self.is_touched:
            self.is_touched = True
            self.conversion.wiring.forget(self.tree)
            if self.shading.owner != self.tree:
                self.until_done.enter_context(nodes.unplugged(self.tree))

    def is_right(self, chain: list, insertions: list[Insertion]) -> bool:
        if [node.node_tree for node in chain] != [insertion.group for insertion in insertions]:
            return False
        return all(map(_is_plain, chain)) and all(map(_glows_as, chain, insertions))

    def becomes(self, chain: list, insertions: list[Insertion]) -> bool:
        """Give nodes other groups of the same kinds, where that is all that is wrong; whether it was."""
        roles = [nodes.role(node) for node in chain]
        if not chain or roles != [insertion.group[nodes.ROLE] for insertion in insertions]:
            return False
        if not (all(map(_is_plain, chain)) and all(map(_glows_as, chain, insertions))):
            return False
        for node, insertion in zip(chain, insertions, strict=True):
            if node.node_tree != insertion.group:
                self.touch()
                node.node_tree, node.label = insertion.group, insertion.group.name
        return True

    def follow(self, socket, chain: list, insertions: list[Insertion]) -> None:
        """Take over what was written to a socket itself since its chain of nodes was put there."""
        first, own = chain[0], chain[0].inputs[0]
        written = list(socket.default_value)
        if list(first.get(_GIVEN, written)) != written:
            self.changes += 1
            own.default_value = _fitted(written, own)
        elif not own.is_linked and list(own.default_value)[: len(written)] != written[: len(own.default_value)]:
            # The socket has it too, should the artist take the node away; quietly, for nothing looks different
            socket.default_value.foreach_set((*own.default_value, 1.0)[: len(written)])
        if list(first.get(_GIVEN, ())) != list(socket.default_value):
            first[_GIVEN] = list(socket.default_value)
        path, animated = socket.path_from_id("default_value"), self.conversion.animated_in(self.shading)
        if path in animated:
            self.move_animation(path, first)
        elif own.path_from_id("default_value") in animated and _ANIMATED not in first:
            first[_ANIMATED] = path
        for node, insertion in zip(chain, insertions, strict=True):
            if insertion.lamp:
                self.tint(node, insertion.lamp)
            elif TINT in node:  # the colour went back to its lamp
                self.changes += 1
                node.inputs["Tint"].default_value = (1.0, 1.0, 1.0, 1.0)
                del node[TINT]

    def insert(self, socket, insertions: list[Insertion]) -> None:
        """Put the nodes in front of a socket, one before the other."""
        path = self.conversion.animated_path(socket)
        link = socket.links[0] if socket.is_linked else None
        for number, insertion in enumerate(insertions):
            node = nodes.insert(self.tree, socket, link, insertion.group)
            link = node.outputs[0].links[0]
            if number == 0:
                node[_GIVEN] = list(socket.default_value)
                if path:
                    self.move_animation(path, node)
            if insertion.lamp:
                self.tint(node, insertion.lamp)
                if insertion.glow:
                    nodes.insert(self.tree, node.inputs["Spectrum"], None, insertion.glow, value=insertion.lamp.glow)

    def tint(self, node, lamp) -> None:
        """Give a *Light* the colour of its lamp, and the animation of it."""
        tint = node.inputs["Tint"]
        if tuple(tint.default_value[:3]) != tuple(lamp.tint):
            self.changes += 1
            tint.default_value = (*lamp.tint, 1.0)
        if tuple(node.get(TINT, ())) != tuple(lamp.tint):
            node[TINT] = lamp.tint
        path = f"node_tree.{tint.path_from_id('default_value')}"
        owner = self.shading.owner
        moved = MOVED in owner and moved_path(owner) != path and animation.move(owner, moved_path(owner), path)
        if animation.move(owner, "color", path) or moved:
            owner[MOVED] = path

    def move_animation(self, path: str, node) -> None:
        """Let the animation of a value act on the inserted node, which now holds it."""
        after = node.inputs[0].path_from_id("default_value")
        node[_ANIMATED] = path
        animation.move(self.tree, path, after)
        if self.shading.owner != self.tree:
            animation.move(self.shading.owner, f"node_tree.{path}", f"node_tree.{after}")
        self.conversion.animated[self.tree] = self.conversion.animated_in(self.shading) - {path} | {after}


def moved_path(light) -> str:
    """The path that the animation of a lamp's colour acts on.

    Undo brings back a lamp, with the path that it notes, and leaves an action alone that was edited in between: its
    curves may act on an inserted node of another name.
    """
    noted = light[MOVED]
    if not animation.is_animated(light, noted):
        for path in animation.paths(light, light):
            named = _TINT_OF.fullmatch(path)
            node = light.node_tree.nodes.get(named[1]) if named else None
            if named and (node is None or nodes.role(node) in nodes.INSERTED):
                return path
    return noted


def _fitted(value, socket) -> tuple:
    """A value as an input takes it: three numbers, and one for a colour that has alpha."""
    return (*value[:3], 1.0)[: len(socket.default_value)]


def _is_plain(node) -> bool:
    """Whether an inserted node feeds one socket and nothing else, as it was put there; AOVs may show what it does."""
    links = [link for link in node.outputs[0].links if link.to_node.bl_idname != "ShaderNodeOutputAOV"]
    return not node.mute and len(links) == 1 and not links[0].is_muted


def _glows_as(node, insertion: Insertion) -> bool:
    """Whether the spectrum that a *Light* has of its own is the wanted one."""
    if "Spectrum" not in node.inputs:
        return True
    before = nodes.inserted_before(node.inputs["Spectrum"])
    return (before.node_tree if before else None) == insertion.glow


def restore(tree, owner) -> None:
    """Take out of a node tree what was inserted. owner: as of a `Shading`."""
    inserted = [node for node in tree.nodes if nodes.role(node) in nodes.INSERTED]
    if not inserted:
        return
    with nodes.unplugged(tree):
        for node in inserted:
            if "Tint" in node.inputs and isinstance(owner, bpy.types.Light):
                animation.carry(tree, node.inputs["Tint"].path_from_id("default_value"), owner, "color")
            take_out(tree, owner, node)


def take_out(tree: bpy.types.NodeTree, owner, node) -> None:
    """Take one inserted node out of a tree; its animation goes back to where it was."""
    if _GIVEN in node and not node.inputs[0].is_linked:
        _take_over(node)
    if "Tint" in node.inputs and owner.get(MOVED) == f"node_tree.{node.inputs['Tint'].path_from_id('default_value')}":
        animation.move(owner, "color", owner[MOVED])  # what was keyed there since is newer
        animation.move(owner, owner[MOVED], "color")
        del owner[MOVED]
    targets = [link.to_socket for link in node.outputs[0].links]
    if _ANIMATED in node or targets:
        # What the artist animated since is animated at the node itself
        before = node.get(_ANIMATED) or targets[0].path_from_id("default_value")
        after = node.inputs[0].path_from_id("default_value")
        animation.move(tree, after, before)
        if owner != tree:
            animation.move(owner, f"node_tree.{after}", f"node_tree.{before}")
    nodes.take_out(tree, node)


def _take_over(node) -> None:
    """Take over what was written to the socket behind an inserted node."""
    for link in node.outputs[0].links:
        written = list(link.to_socket.default_value)
        if len(written) == len(node[_GIVEN]) and written != list(node[_GIVEN]):
            node.inputs[0].default_value = _fitted(written, node.inputs[0])
