"""The node groups that Relume adds to a file, built from Blender's own nodes alone.

In shaders:
- *View* reads the matrix of the view layer being rendered (see `passes`);
- a *spectrum* group holds p coefficients and gives the colour `W @ c`, or a plain RGB colour where there is no W (see
  `spectra`);
- a *glass* group refracts each channel by its own index (see `glass`);
- *Upsample* does the same for an RGB input, or a vector that holds one number for each of red, green and blue;
- *Light* upsamples the colour of a lamp and colours it as its light group;
- an *emitter* is a lamp's own spectrum, relative to that of its light group, in place of an RGB colour.

In the compositor:
- *Recombination* sums matrices times coefficient passes.

A group that Relume made says what it is in the custom property `ROLE`; nothing goes by name.
"""

from contextlib import contextmanager

import bpy
import numpy as np

__all__ = [
    "INSERTED",
    "ROLE",
    "add",
    "add_socket",
    "add_view",
    "choose",
    "clear_orphans",
    "emitter_group",
    "insert",
    "light_group",
    "matrix_sockets",
    "mixed",
    "new_tree",
    "recombination_group",
    "role",
    "set_spectral",
    "take_out",
    "unplugged",
    "upsample_group",
    "view_group",
    "weighed",
    "write_recombination",
]

ROLE = "relume_role"
INSERTED = frozenset({"upsample", "light", "emitter"})  # roles of the groups that `insert` puts in front of sockets
_KEPT = "relume_kept"  # on an inserted node: its value is not the artist's, and goes nowhere
_LIGHT = "relume_light"  # on a Light group: the number of its light group
_STEP = 180  # editor units between columns of nodes


def role(node) -> str:
    """What Relume's node group behind `node` is for ("spectrum", "upsample", ...), "" for any other node."""
    tree = getattr(node, "node_tree", None)
    return tree.get(ROLE, "") if tree is not None else ""


def new_tree(name: str, kind: str, role_name: str):
    """An empty node tree of a kind that says which role it has."""
    tree = bpy.data.node_groups.new(name, kind)
    tree[ROLE] = role_name
    return tree


def _shared_tree(name: str, role_name: str):
    """The one local group of this file with that role and name, made when there is none; and whether it is new."""
    for tree in bpy.data.node_groups:
        if tree.get(ROLE) == role_name and tree.get("relume_name") == name and tree.library is None:
            return tree, False
    tree = new_tree(name, "ShaderNodeTree", role_name)
    tree["relume_name"] = name
    return tree, True


def add(tree, kind: str, column: int, row: int = 0, **settings):
    """A new node in a column and a row of a tree, with those of its properties set."""
    node = tree.nodes.new(kind)
    node.location = (column * _STEP, -row * _STEP)
    for key, value in settings.items():
        setattr(node, key, value)
    return node


def add_socket(tree, name: str, kind: str, *, output: bool, default=None):
    """A new input or output of a node group."""
    socket = tree.interface.new_socket(name, in_out="OUTPUT" if output else "INPUT", socket_type=f"NodeSocket{kind}")
    if default is not None:
        socket.default_value = default
    return socket


def _multiply_add(tree, column: int, row: int, vector, scalar, addend):
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


def view_group(channels: int):
    """The shared *View* group for p channels: On, B0 to B2 and W0 to W(p-1) of the view layer being rendered."""
    tree, new = _shared_tree("Relume View", "view")
    if not new and tree["relume_channels"] == channels:
        return tree
    tree["relume_channels"] = channels
    tree.nodes.clear()
    tree.interface.clear()
    output = add(tree, "NodeGroupOutput", 2)
    names = ["relume_on", *(f"relume_b{i}" for i in range(3)), *(f"relume_w{i}" for i in range(channels))]
    for row, name in enumerate(names):
        add_socket(tree, name.removeprefix("relume_").upper(), "Vector" if row else "Float", output=True)
        attribute = add(tree, "ShaderNodeAttribute", 0, row, attribute_type="VIEW_LAYER", attribute_name=name)
        tree.links.new(attribute.outputs["Vector" if row else "Factor"], output.inputs[row])
    return tree


def add_view(tree, channels: int):
    """A node of the *View* group."""
    return add(tree, "ShaderNodeGroup", 0, node_tree=view_group(channels), label="View")


def upsample_group(channels: int, vector: bool = False, bounds: str = ""):
    """The shared *Upsample* group: an RGB colour in, `B @ rgb` out; or a vector, whose result is never negative.

    bounds: of the colour, as in `closures.Bounds`: "positive" or "unit".
    """
    kind = "Vector" if vector else bounds.capitalize()
    tree, new = _shared_tree(f"Relume Upsample {kind}".rstrip(), "upsample")
    if not new:
        return tree
    name = kind = "Vector" if vector else "Color"
    add_socket(tree, name, kind, output=False, default=(1.0, 1.0, 1.0) if vector else (0.8, 0.8, 0.8, 1.0))
    add_socket(tree, name, kind, output=True)
    source = add(tree, "NodeGroupInput", 0, 1)
    view = add_view(tree, channels)
    held = source.outputs[name]
    if bounds:
        held = _held(tree, 1, held, "MAXIMUM", 0.0)
    if bounds == "unit":
        held = _held(tree, 1, held, "MINIMUM", 1.0)
    upsampled = _upsampled(tree, view, held, 2)
    if vector:
        upsampled = _held(tree, 4, upsampled, "MAXIMUM", 0.0)
    chosen = choose(tree, 5, view.outputs["ON"], source.outputs[name], upsampled)
    output = add(tree, "NodeGroupOutput", 6)
    tree.links.new(chosen, output.inputs[name])
    return tree


def _held(tree, column: int, vector, operation: str, limit: float):
    """A vector held to a limit, number by number."""
    node = add(tree, "ShaderNodeVectorMath", column, 2, operation=operation)
    tree.links.new(vector, node.inputs[0])
    node.inputs[1].default_value = (limit,) * 3
    return node.outputs[0]


def _upsampled(tree, view, color, column: int):
    separate = add(tree, "ShaderNodeSeparateColor", column - 1, 1)
    tree.links.new(color, separate.inputs[0])
    total = None
    for i in range(3):
        total = _multiply_add(tree, column + i, 1, view.outputs[f"B{i}"], separate.outputs[i], total)
    return total


def light_group(index: int, channels: int, spectral: bool = False):
    """The shared *Light* group of light group number `index`: the colours that a lamp has in, its emission out.

    Color and Tint are multiplied as RGB, and Spectrum comes from a spectrum; `spectral` when Color does so as well.
    """
    tree, new = _shared_tree(f"Relume {'Spectral ' if spectral else ''}Light {index + 1}", "light")
    if not new:
        return tree
    tree[_LIGHT] = index
    for name in ("Color", "Tint", "Spectrum"):
        add_socket(tree, name, "Color", output=False, default=(1.0, 1.0, 1.0, 1.0))
    add_socket(tree, "Color", "Color", output=True)
    source = add(tree, "NodeGroupInput", 0, 1)
    view = add_view(tree, channels)
    filtered = _product(tree, 1, 2, source.outputs["Color"], source.outputs["Tint"])
    if spectral:
        tint = _upsampled(tree, view, source.outputs["Tint"], 2)
        colored = _product(tree, 5, 3, source.outputs["Color"], tint)
    else:
        colored = _upsampled(tree, view, filtered, 2)
    color = add(tree, "ShaderNodeAttribute", 4, 2, attribute_type="VIEW_LAYER", attribute_name=f"relume_light{index}")
    lit = _product(tree, 5, 1, colored, color.outputs["Vector"])
    plain, spectrally = (_product(tree, 6, 1 + k, v, source.outputs["Spectrum"]) for k, v in enumerate((filtered, lit)))
    chosen = choose(tree, 7, view.outputs["ON"], plain, spectrally)
    output = add(tree, "NodeGroupOutput", 8)
    tree.links.new(chosen, output.inputs["Color"])
    return tree


def set_spectral(node, channels: int, spectral: bool):
    """Tell an inserted node of a *Light* group whether its Color comes from a spectrum."""
    node.node_tree = light_group(node.node_tree[_LIGHT], channels, spectral)
    node.label = node.node_tree.name


def _product(tree, column: int, row: int, a, b):
    node = add(tree, "ShaderNodeVectorMath", column, row, operation="MULTIPLY")
    tree.links.new(a, node.inputs[0])
    tree.links.new(b, node.inputs[1])
    return node.outputs[0]


def emitter_group(name: str, coefficients: np.ndarray):
    """The shared *emitter* group of that name: an RGB colour in, which shows where no W is set, `W @ c` out."""
    tree, new = _shared_tree(name, "emitter")
    if not new:
        return tree
    add_socket(tree, "Color", "Color", output=False, default=(1.0, 1.0, 1.0, 1.0))
    add_socket(tree, "Color", "Color", output=True)
    channels = len(coefficients)
    source = add(tree, "NodeGroupInput", 0, 1)
    view = add_view(tree, channels)
    chosen = choose(
        tree, channels + 1, view.outputs["ON"], source.outputs["Color"], weighed(tree, view, coefficients, 0)
    )
    output = add(tree, "NodeGroupOutput", channels + 2)
    tree.links.new(chosen, output.inputs["Color"])
    return tree


def weighed(tree, view, coefficients, row: int):
    """The colour `W @ c`."""
    total = None
    for k, value in enumerate(coefficients):
        total = _multiply_add(tree, k + 1, row, view.outputs[f"W{k}"], float(value), total)
    return total


def mixed(mix, name: str):
    """Colour input A or B of a Mix node."""
    return next(socket for socket in mix.inputs if socket.name == name and socket.type == "RGBA")


@contextmanager
def unplugged(tree):
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


def insert(tree, socket, link, group, value=None):
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


def take_out(tree, node):
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


def recombination_group(name: str, groups: list[str], passes: int):
    """A compositor group: for every light group and pass an image in, the picture out; all matrices zero."""
    tree = new_tree(name, "CompositorNodeTree", "recombination")
    add_socket(tree, "Alpha", "Float", output=False, default=1.0)
    for group in groups:
        for k in range(passes):
            add_socket(tree, f"{group} {k + 1}", "Color", output=False, default=(0.0, 0.0, 0.0, 1.0))
    add_socket(tree, "Image", "Color", output=True)
    source = add(tree, "NodeGroupInput", 0)
    total = None
    for row, group in enumerate(groups):
        for k in range(passes):
            separate = add(tree, "ShaderNodeSeparateXYZ", 1, row * passes + k)
            tree.links.new(source.outputs[f"{group} {k + 1}"], separate.inputs[0])
            for j in range(3):
                total = _multiply_add(tree, 2 + j, row * passes + k, 0.0, separate.outputs[j], total)
                total.node.name = _column_name(row, 3 * k + j)
    alpha = add(tree, "CompositorNodeSetAlpha", 6)
    alpha.inputs["Type"].default_value = "Replace Alpha"
    tree.links.new(total, alpha.inputs["Image"])
    tree.links.new(source.outputs["Alpha"], alpha.inputs["Alpha"])
    output = add(tree, "NodeGroupOutput", 7)
    tree.links.new(alpha.outputs[0], output.inputs["Image"])
    return tree


def _column_name(group: int, channel: int) -> str:
    return f"matrix {group} column {channel}"


def write_recombination(tree, matrices: np.ndarray):
    """Write (groups, 3, p) matrices into the sockets of a recombination group; those that hold them are let alone."""
    changed = []
    for group, matrix in enumerate(np.asarray(matrices, dtype=np.float32)):
        for channel, column in enumerate(matrix.T):
            socket = tree.nodes[_column_name(group, channel)].inputs[0]
            if tuple(socket.default_value) != tuple(column.tolist()):
                socket.default_value.foreach_set(column)
                changed.append((socket, column))
    if changed:
        # One assignment tells Blender. To assign each makes it look through the whole file as often: 25 ms with 2,000
        # materials, for one illuminant
        socket, column = changed[-1]
        socket.default_value = column


def matrix_sockets(tree) -> list:
    """The sockets of a recombination group that hold its matrices, by group and channel."""
    return [node.inputs[0] for node in tree.nodes if node.name.startswith("matrix ")]


def clear_orphans():
    """Delete the groups of Relume's own that nothing uses any more (a spectrum is the artist's: it stays)."""
    roles = ("compositing", *INSERTED, "recombination", "comparison", "view")
    for role_name in roles:
        for tree in [t for t in bpy.data.node_groups if t.get(ROLE) == role_name and t.library is None]:
            if tree.users == 0:
                bpy.data.node_groups.remove(tree)
