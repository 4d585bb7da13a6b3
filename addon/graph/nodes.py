"""Node trees: adding nodes, putting one in front of a socket and taking it out again.

A node group that Relume made says what it is in the custom property `ROLE`: artists may rename it.
"""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager

import bpy

__all__ = [
    "INSERTED",
    "ROLE",
    "add",
    "add_socket",
    "choose",
    "clear_orphans",
    "delete",
    "holder",
    "insert",
    "inserted_before",
    "is_undo_unsafe",
    "keep_spares",
    "kept_image",
    "mixed",
    "multiply_add",
    "new_tree",
    "orphans_stay",
    "role",
    "take_out",
    "unplugged",
    "weighed",
]

ROLE = "relume_role"
INSERTED = frozenset({"upsample", "light", "emitter"})  # roles of the groups that `insert` puts in front of sockets
_KEPT = "relume_kept"  # on an inserted node: its value is not the artist's, and goes nowhere
_SPARES = {"ShaderNodeTree": 8, "CompositorNodeTree": 8}  # node groups that are kept ready, by kind
_staying = 0
_is_unsafe = False
_STEP = 180  # editor units between columns of nodes


def role(node) -> str:
    """What Relume's node group behind `node` is for ("spectrum", "upsample", ...), "" for any other node."""
    tree = getattr(node, "node_tree", None)
    return tree.get(ROLE, "") if tree is not None else ""


def new_tree(name: str, kind: str, role_name: str):
    """An empty node tree of a kind that says which role it has: a spare one, where there is one."""
    global _is_unsafe
    tree = next((t for t in _spares(kind)), None)
    if tree is None:
        tree, _is_unsafe = bpy.data.node_groups.new(name, kind), True
    tree.name, tree[ROLE] = name, role_name
    return tree


def _spares(kind: str) -> list:
    found = (t for t in bpy.data.node_groups if t.get(ROLE) == "spare" and t.bl_idname == kind)
    return [tree for tree in found if tree.users == 0 and tree.library is None]


def keep_spares() -> None:
    """Have node groups ready that nothing uses yet.

    An undo step knows the data-blocks of when it was made, and Blender ends where a step leaves something unchanged
    that has come to use a data-block since. So what is needed without a step of undo has to be there before.
    """
    global _is_unsafe
    for kind, count in _SPARES.items():
        for _ in range(count - len(_spares(kind))):
            bpy.data.node_groups.new("Relume Spare", kind)[ROLE] = "spare"
    if not bpy.app.background and kept_image() is None:
        bpy.data.images.new("Relume Denoised", 1, 1)[ROLE] = "denoised"
        _is_unsafe = True  # until a step of undo is sure to know it


def kept_image():
    """The image of Relume's own that shows what a render in this window denoised; None where there is none yet."""
    return next((image for image in bpy.data.images if image.get(ROLE) == "denoised" and image.library is None), None)


def is_undo_unsafe(now_safe: bool = False) -> bool:
    """Whether a node group was made, for want of a spare one, since it was last said that all are known to undo."""
    global _is_unsafe
    if now_safe:
        _is_unsafe = False
    return _is_unsafe


def add(tree, kind: str, column: int, row: int = 0, **settings):
    """A new node in a column and a row of a tree, with those of its properties set."""
    node = tree.nodes.new(kind)
    node.location = (column * _STEP, -row * _STEP)
    for key, value in settings.items():
        setattr(node, key, value)
    return node


def add_socket(tree, name: str, kind: str, *, output: bool, default: float | tuple[float, ...] | None = None):
    """A new input or output of a node group."""
    socket = tree.interface.new_socket(name, in_out="OUTPUT" if output else "INPUT", socket_type=f"NodeSocket{kind}")
    if default is not None:
        socket.default_value = default
    return socket


def multiply_add(tree, column: int, row: int, vector, scalar, addend):
    """A node for vector · scalar + addend; each operand is a socket to link, or a number."""
    node = add(tree, "ShaderNodeVectorMath", column, row, operation="MULTIPLY_ADD")
    for socket, operand in zip(node.inputs, (vector, scalar, addend), strict=False):
        if isinstance(operand, bpy.types.NodeSocket):
            tree.links.new(operand, socket)
        elif operand is not None:
            socket.default_value = (operand,) * 3
    return node.outputs[0]


def choose(tree, column: int, on, plain, spectral):
    """A colour: `spectral` where the view layer carries a matrix, else `plain` (a socket, or an RGB colour)."""
    mix = add(tree, "ShaderNodeMix", column, data_type="RGBA")
    tree.links.new(on, mix.inputs["Factor"])
    a, b = mixed(mix, "A"), mixed(mix, "B")
    if isinstance(plain, bpy.types.NodeSocket):
        tree.links.new(plain, a)
    else:
        a.default_value = (*plain, 1.0)
    tree.links.new(spectral, b)
    return next(socket for socket in mix.outputs if socket.type == "RGBA")


def weighed(tree, view, coefficients: Iterable[float], row: int):
    """The colour `W @ c`."""
    total = None
    for k, value in enumerate(coefficients):
        total = multiply_add(tree, k + 1, row, view.outputs[f"W{k}"], float(value), total)
    return total


def mixed(mix, name: str):
    """Colour input A or B of a Mix node."""
    return next(socket for socket in mix.inputs if socket.name == name and socket.type == "RGBA")


@contextmanager
def unplugged(tree) -> Iterator[None]:
    """While it lasts, the output of a material, world or light gets nothing, so that changes to its nodes are quick.

    Blender looks at all trees of the file whenever the output of one changes: with 2,000 materials that is what
    setting up would spend its time on.
    """
    outputs = [node for node in tree.nodes if node.type in {"OUTPUT_MATERIAL", "OUTPUT_WORLD", "OUTPUT_LIGHT"}]
    links = [socket.links[0] for node in outputs for socket in node.inputs if socket.is_linked]
    ends = [(link.from_socket, link.to_socket, link.is_muted) for link in links]
    for link in links:
        tree.links.remove(link)
    try:
        yield
    finally:
        for source, target, muted in ends:
            tree.links.new(source, target).is_muted = muted


def inserted_before(socket):
    """The node that `insert` put right in front of a socket, None if there is none."""
    node = socket.links[0].from_node if socket.is_linked else None
    return node if node is not None and role(node) in INSERTED else None


def holder(socket):
    """The socket that holds the artist's own link or value of a socket: the one before all that was inserted."""
    while (node := inserted_before(socket)) is not None:
        socket = node.inputs[0]
    return socket


def insert(tree, socket, link, group, value: Sequence[float] | None = None):
    """Put a node of `group` in front of `socket`; it takes over the socket's link or value. Returns the node.

    link: what comes into the socket, None if nothing does. value: a colour to show in place of the socket's own, that
    `take_out` is not to hand back.
    """
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    node.label = group.name
    node.hide = True
    node.select = False
    # Beside the socket's own node, inside the same frame
    node.parent = socket.node.parent
    node.location = (socket.node.location.x - _STEP, socket.node.location.y - 40)
    own = node.inputs[0]
    given = socket.default_value if value is None else value
    own.default_value = (*given, 1.0) if own.type == "RGBA" and len(given) == 3 else given[: len(own.default_value)]
    if value is not None:
        node[_KEPT] = True
    if link is not None:
        tree.links.new(link.from_socket, own).is_muted = link.is_muted
    tree.links.new(node.outputs[0], socket)
    return node


def take_out(tree, node) -> None:
    """Undo `insert`: what fed the node feeds its users again; otherwise they get its value, edited or not."""
    own, link = node.inputs[0], None
    if own.is_linked:
        link = own.links[0]
    targets = [out.to_socket for out in node.outputs[0].links]
    if _KEPT not in node:
        for target in targets:
            value = own.default_value[: len(target.default_value)]
            if tuple(target.default_value[: len(value)]) != tuple(value):
                target.default_value[: len(value)] = value
    if link is not None:
        source, muted = link.from_socket, link.is_muted
        for target in targets:
            tree.links.new(source, target).is_muted = muted
    tree.nodes.remove(node)


def clear_orphans(*roles: str) -> None:
    """Delete the groups of Relume's own that nothing uses any more (a spectrum is the artist's: it stays), or those of
    some roles: spare ones too are used by nothing."""
    every = ("compositing", *INSERTED, "recombination", "noise", "noise", "comparison", "view", "spare")
    for role_name in roles or every:  # noise twice: one of its groups is in the other
        for tree in [t for t in bpy.data.node_groups if t.get(ROLE) == role_name and t.library is None]:
            if tree.users == 0:
                delete(tree)
    image = None if roles else kept_image()
    if image is not None and image.users == 0 and not _staying:
        bpy.data.images.remove(image)


def delete(tree) -> None:
    """Delete a node group that nothing uses; while `orphans_stay`, later."""
    if not _staying:
        bpy.data.node_groups.remove(tree)


@contextmanager
def orphans_stay() -> Iterator[None]:
    """While it is entered no data-block is deleted: Blender, which begins to render, would still look at it and end."""
    global _staying
    _staying += 1
    try:
        yield
    finally:
        _staying -= 1
