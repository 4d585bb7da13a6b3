"""Where the colours of node trees come from: links, followed through reroutes, mixes and node groups."""

from functools import cached_property

from . import nodes

__all__ = ["THROUGH", "Wiring"]

_COLOURS = {"RGBA", "VECTOR"}  # types of sockets that differ by channel
# Nodes that a spectrum passes through channel by channel
THROUGH = {"REROUTE", "MIX", "MIX_RGB", "BRIGHTCONTRAST", "GAMMA", "INVERT", "CURVE_RGB", "VECT_MATH"}


class Wiring:
    """What comes into the inputs of some node trees as the artist sees it: as if nothing were inserted. What comes out
    of other trees starts there.

    Blender looks through all links of a tree to find those of one socket: here that is done once for each tree.
    """

    def __init__(self, trees) -> None:
        self.trees = dict.fromkeys(trees)
        self._incoming = {}

    def link(self, socket):
        """The artist's link that comes into a socket, muted or not; None if there is none."""
        return self._links_of(socket.id_data).get(self.holder(socket))

    def holder(self, socket):
        """The socket that holds the link or the value: that of the first of the nodes inserted before it."""
        links = self._links_of(socket.id_data)
        while (link := links.get(socket)) is not None and nodes.role(link.from_node) in nodes.INSERTED:
            socket = link.from_node.inputs[0]
        return socket

    def inserted(self, socket) -> list:
        """The inserted nodes before a socket, the one that feeds it first."""
        links, found = self._links_of(socket.id_data), []
        while (link := links.get(socket)) is not None and nodes.role(link.from_node) in nodes.INSERTED:
            found.append(link.from_node)
            socket = link.from_node.inputs[0]
        return found

    def forget(self, tree) -> None:
        """Read the links of a tree anew: they have changed."""
        self._incoming.pop(tree, None)

    def _links_of(self, tree) -> dict:
        if tree not in self._incoming:
            self._incoming[tree] = {link.to_socket: link for link in tree.links}
        return self._incoming[tree]

    def feeds(self, socket) -> list | None:
        """The inputs that a colour passes just before it comes into a socket, [] if it is made of a number; None where
        it starts there.
        """
        link = self.link(socket)
        if link is None or link.is_muted:
            return None
        if link.from_socket.type not in _COLOURS:
            return []
        node, identifier = link.from_node, link.from_socket.identifier
        if node.type in THROUGH:
            return [s for s in node.inputs if s.type in _COLOURS and not s.is_unavailable]
        if node.type == "GROUP" and node.node_tree and not nodes.role(node):
            inner = node.node_tree.nodes if node.node_tree in self.trees else ()
            ends = [n for n in inner if n.type == "GROUP_OUTPUT" and n.is_active_output]
            return [s for end in ends for s in end.inputs if s.identifier == identifier and s.type in _COLOURS]
        if node.type == "GROUP_INPUT":
            callers = self._callers.get(link.id_data, ())
            return [s for caller in callers for s in caller.inputs if s.identifier == identifier and s.type in _COLOURS]
        return None

    @cached_property
    def _callers(self) -> dict:
        """{node group: the nodes that use it}."""
        found = {}
        for tree in self.trees:
            for node in tree.nodes:
                if node.type == "GROUP" and node.node_tree:
                    found.setdefault(node.node_tree, []).append(node)
        return found
