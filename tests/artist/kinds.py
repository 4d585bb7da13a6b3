"""The kinds of edits that a scripted artist makes: {name: function}, and what the functions need to pick things.

An edit is a function of (chance, scene) that does something as an artist would and says what, or returns None where
there is nothing to do it to. What it picks depends on the artist's own things alone: the same chance makes the same
edit whether or not the scene is set up.
"""

import random

import bpy

from relume.addon.graph import nodes

__all__ = [
    "EDITS",
    "active_layer",
    "add_node",
    "artists_nodes",
    "colour",
    "edit",
    "lamps",
    "materials",
    "meshes",
    "own_layers",
    "own_socket",
    "pause",
    "pick",
    "things",
]

EDITS = {}


def edit(function):
    """Register a kind of edit under its name."""
    EDITS[function.__name__] = function
    return function


def things(collection, wanted=lambda thing: True) -> list:
    """The artist's own members of a collection of bpy.data, by name: not what Relume made, nor what is linked."""
    own = (t for t in collection if t.library is None and not t.get(nodes.ROLE) and wanted(t))
    return sorted(own, key=lambda thing: thing.name)


def artists_nodes(tree, *kinds: str) -> list:
    """Nodes of a tree that Relume did not add, of some types if any are given, by name."""
    own = (n for n in tree.nodes if nodes.role(n) not in nodes.INSERTED and "relume_added" not in n)
    return sorted((n for n in own if not kinds or n.bl_idname in kinds), key=lambda n: n.name)


def add_node(tree, kind: str):
    """A new node, named so that the nodes that Relume added have no say in its name."""
    taken = {node.name for node in tree.nodes}
    node = tree.nodes.new(kind)
    node.name = next(name for n in range(1, 999) if (name := f"{kind} {n}") not in taken)
    return node


def own_socket(socket):
    """The socket that holds the artist's value or link: the one before what set-up inserted."""
    while socket.is_linked and nodes.role(socket.links[0].from_node) in nodes.INSERTED:
        socket = socket.links[0].from_node.inputs[0]
    return socket


def pause() -> None:
    """Wait, in the middle of an edit, for what Relume does while the artist is idle: the actor puts that here."""


def pick(chance: random.Random, members: list):
    """One of some members, None if there are none; takes as much of the chance either way."""
    number = chance.random()
    return members[int(number * len(members))] if members else None


def own_layers(scene) -> list:
    """The view layers that are the artist's own."""
    return [layer for layer in scene.view_layers if "relume_pass" not in layer]


def active_layer(scene):
    """The first view layer that is the artist's own."""
    return own_layers(scene)[0]


def colour(chance: random.Random) -> tuple[float, float, float]:
    """A colour that an artist may choose: saturated, grey, black, white, or brighter than white."""
    kind = chance.random()
    rgb = tuple(round(chance.random(), 3) for _ in range(3))
    if kind < 0.15:
        return (rgb[0],) * 3
    if kind < 0.2:
        return (0.0, 0.0, 0.0)
    if kind < 0.25:
        return (1.0, 1.0, 1.0)
    if kind < 0.3:
        return (rgb[0] * 4, rgb[1], rgb[2])
    return rgb


def materials(wanted=lambda material: True) -> list:
    """The artist's own materials that have nodes."""
    return things(bpy.data.materials, lambda m: m.node_tree is not None and not m.is_grease_pencil and wanted(m))


def meshes(scene) -> list:
    """The scene's own mesh objects, by name."""
    return _objects(scene, "MESH")


def lamps(scene) -> list:
    """The scene's own lamps, by name."""
    return _objects(scene, "LIGHT")


def _objects(scene, kind: str) -> list:
    own = (o for o in scene.objects if o.type == kind and o.library is None and o.data.library is None)
    return sorted(own, key=lambda thing: thing.name)
