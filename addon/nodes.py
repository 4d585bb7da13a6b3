"""The node groups that Relume adds to a file, built from Blender's own nodes alone.

In shaders:
- *View* reads the matrix of the view layer being rendered (see `passes`);
- a *spectrum* group holds p coefficients and gives the colour `W @ c`, or a plain RGB colour where there is no W;
- *Upsample* does the same for an RGB input;
- *Light* upsamples the colour of a lamp and colours it as its light group.

In the compositor:
- *Recombination* sums matrices times coefficient passes.

A group that Relume made says what it is in the custom property `ROLE`; nothing goes by name.
"""

import bpy
import numpy as np

__all__ = [
    "ROLE",
    "clear_orphans",
    "fill_spectrum",
    "fill_spectrum_plain",
    "insert",
    "light_group",
    "new_spectrum",
    "plain_of",
    "recombination_group",
    "role",
    "take_out",
    "upsample_group",
    "view_group",
    "write_recombination",
]

ROLE = "relume_role"
_STEP = 180  # editor units between columns of nodes


def role(node) -> str:
    """What Relume's node group behind `node` is for ("spectrum", "upsample", ...), "" for any other node."""
    tree = getattr(node, "node_tree", None)
    return tree.get(ROLE, "") if tree is not None else ""


def _new_tree(name: str, kind: str, role_name: str):
    tree = bpy.data.node_groups.new(name, kind)
    tree[ROLE] = role_name
    return tree


def _shared_tree(name: str, role_name: str):
    """The one local group of this file with that role and name, made when there is none; and whether it is new."""
    for tree in bpy.data.node_groups:
        if tree.get(ROLE) == role_name and tree.get("relume_name") == name and tree.library is None:
            return tree, False
    tree = _new_tree(name, "ShaderNodeTree", role_name)
    tree["relume_name"] = name
    return tree, True


def _add(tree, kind: str, column: int, row: int = 0, **settings):
    node = tree.nodes.new(kind)
    node.location = (column * _STEP, -row * _STEP)
    for key, value in settings.items():
        setattr(node, key, value)
    return node


def _socket(tree, name: str, kind: str, *, output: bool, default=None):
    socket = tree.interface.new_socket(name, in_out="OUTPUT" if output else "INPUT", socket_type=f"NodeSocket{kind}")
    if default is not None:
        socket.default_value = default
    return socket


def _multiply_add(tree, column: int, row: int, vector, scalar, addend):
    """A node for vector · scalar + addend; each operand is a socket to link, or a number."""
    node = _add(tree, "ShaderNodeVectorMath", column, row, operation="MULTIPLY_ADD")
    for socket, operand in zip(node.inputs, (vector, scalar, addend), strict=False):
        if isinstance(operand, bpy.types.NodeSocket):
            tree.links.new(operand, socket)
        elif operand is not None:
            socket.default_value = (operand,) * 3
    return node.outputs[0]


def _choose(tree, column: int, on, plain, spectral):
    """A colour: `spectral` where the view layer carries a matrix, else `plain` (a socket, or an RGB colour)."""
    mix = _add(tree, "ShaderNodeMix", column, data_type="RGBA")
    tree.links.new(on, mix.inputs["Factor"])
    a, b = _mixed(mix, "A"), _mixed(mix, "B")
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
    output = _add(tree, "NodeGroupOutput", 2)
    names = ["relume_on", *(f"relume_b{i}" for i in range(3)), *(f"relume_w{i}" for i in range(channels))]
    for row, name in enumerate(names):
        _socket(tree, name.removeprefix("relume_").upper(), "Vector" if row else "Float", output=True)
        attribute = _add(tree, "ShaderNodeAttribute", 0, row, attribute_type="VIEW_LAYER", attribute_name=name)
        tree.links.new(attribute.outputs["Vector" if row else "Factor"], output.inputs[row])
    return tree


def _add_view(tree, channels: int):
    return _add(tree, "ShaderNodeGroup", 0, node_tree=view_group(channels), label="View")


def upsample_group(channels: int):
    """The shared *Upsample* group: an RGB colour in, `B @ rgb` out."""
    tree, new = _shared_tree("Relume Upsample", "upsample")
    if not new:
        return tree
    _socket(tree, "Color", "Color", output=False, default=(0.8, 0.8, 0.8, 1.0))
    _socket(tree, "Color", "Color", output=True)
    source = _add(tree, "NodeGroupInput", 0, 1)
    view = _add_view(tree, channels)
    upsampled = _upsampled(tree, view, source.outputs["Color"], 2)
    chosen = _choose(tree, 5, view.outputs["ON"], source.outputs["Color"], upsampled)
    output = _add(tree, "NodeGroupOutput", 6)
    tree.links.new(chosen, output.inputs["Color"])
    return tree


def _upsampled(tree, view, color, column: int):
    separate = _add(tree, "ShaderNodeSeparateColor", column - 1, 1)
    tree.links.new(color, separate.inputs[0])
    total = None
    for i in range(3):
        total = _multiply_add(tree, column + i, 1, view.outputs[f"B{i}"], separate.outputs[i], total)
    return total


def light_group(index: int, channels: int):
    """The shared *Light* group of light group number `index`: colour and tint of a lamp in, its emission out."""
    tree, new = _shared_tree(f"Relume Light {index + 1}", "light")
    if not new:
        return tree
    white = (1.0, 1.0, 1.0, 1.0)
    _socket(tree, "Color", "Color", output=False, default=white)
    _socket(tree, "Tint", "Color", output=False, default=white)
    _socket(tree, "Color", "Color", output=True)
    source = _add(tree, "NodeGroupInput", 0, 1)
    view = _add_view(tree, channels)
    filtered = _add(tree, "ShaderNodeVectorMath", 1, 2, operation="MULTIPLY")
    tree.links.new(source.outputs["Color"], filtered.inputs[0])
    tree.links.new(source.outputs["Tint"], filtered.inputs[1])
    upsampled = _upsampled(tree, view, filtered.outputs[0], 2)
    color = _add(tree, "ShaderNodeAttribute", 4, 2, attribute_type="VIEW_LAYER", attribute_name=f"relume_light{index}")
    lit = _add(tree, "ShaderNodeVectorMath", 5, 1, operation="MULTIPLY")
    tree.links.new(upsampled, lit.inputs[0])
    tree.links.new(color.outputs["Vector"], lit.inputs[1])
    chosen = _choose(tree, 6, view.outputs["ON"], filtered.outputs[0], lit.outputs[0])
    output = _add(tree, "NodeGroupOutput", 7)
    tree.links.new(chosen, output.inputs["Color"])
    return tree


def new_spectrum(name: str, outputs: dict[str, str]):
    """An empty *spectrum* group with those outputs: socket name -> "Color" or "Vector"."""
    tree = _new_tree(name, "ShaderNodeTree", "spectrum")
    for socket, kind in outputs.items():
        _socket(tree, socket, kind, output=True)
    return tree


def fill_spectrum_plain(tree, plain: dict[str, tuple]):
    """Give a spectrum group only the values that it shows in a scene without Relume: output -> three numbers."""
    tree.nodes.clear()
    output = _add(tree, "NodeGroupOutput", 1)
    for row, (name, value) in enumerate(plain.items()):
        if output.inputs[name].type == "RGBA":
            node = _add(tree, "ShaderNodeRGB", 0, row)
            node.outputs[0].default_value = (*value, 1.0)
        else:
            node = _add(tree, "ShaderNodeCombineXYZ", 0, row)
            for socket, number in zip(node.inputs, value, strict=True):
                socket.default_value = number
        tree.links.new(node.outputs[0], output.inputs[name])


def plain_of(tree) -> dict[str, tuple]:
    """The plain values of a spectrum group, whichever way it is filled."""
    output = next(node for node in tree.nodes if node.type == "GROUP_OUTPUT")
    found = {}
    for socket in output.inputs:
        if not socket.is_linked:
            continue
        node = socket.links[0].from_node
        if node.type == "RGB":
            found[socket.name] = tuple(node.outputs[0].default_value[:3])
        elif node.type == "COMBXYZ":
            found[socket.name] = tuple(number.default_value for number in node.inputs)
        else:
            found[socket.name] = tuple(_mixed(node, "A").default_value[:3])
    return found


def _mixed(mix, name: str):
    """Colour input A or B of a Mix node."""
    return next(socket for socket in mix.inputs if socket.name == name and socket.type == "RGBA")


def fill_spectrum(tree, plain: dict[str, tuple], coefficients: dict[str, np.ndarray]):
    """Give a spectrum group p coefficients for each output, and the plain values for a scene without Relume."""
    tree.nodes.clear()
    channels = len(next(iter(coefficients.values())))
    output = _add(tree, "NodeGroupOutput", channels + 3)
    view = _add_view(tree, channels)
    for row, (name, values) in enumerate(coefficients.items()):
        total = None
        for k, value in enumerate(values):
            total = _multiply_add(tree, k + 1, row, view.outputs[f"W{k}"], float(value), total)
        if output.inputs[name].type == "VECTOR":
            # n and k of a metal: what the preview makes of them may not be negative
            bound = _add(tree, "ShaderNodeVectorMath", channels + 1, row, operation="MAXIMUM")
            tree.links.new(total, bound.inputs[0])
            total = bound.outputs[0]
        chosen = _choose(tree, channels + 2, view.outputs["ON"], plain[name], total)
        tree.links.new(chosen, output.inputs[name])


def insert(tree, socket, group):
    """Put a node of `group` in front of `socket`; it takes over the socket's link or value. Returns the node."""
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    node.label = group.name
    node.hide = True
    node.select = False
    # Beside the socket's own node, inside the same frame
    node.parent = socket.node.parent
    node.location = (socket.node.location.x - _STEP, socket.node.location.y - 40)
    color = node.inputs["Color"]
    if socket.is_linked:
        link = socket.links[0]
        muted = link.is_muted
        tree.links.new(link.from_socket, color).is_muted = muted
    else:
        color.default_value = socket.default_value
    tree.links.new(node.outputs["Color"], socket)
    return node


def take_out(tree, node):
    """Undo `insert`: what fed the node feeds its users again, and unlinked users show their own value."""
    color = node.inputs["Color"]
    targets = [link.to_socket for link in node.outputs["Color"].links]
    if color.is_linked:
        source, muted = color.links[0].from_socket, color.links[0].is_muted
        for target in targets:
            tree.links.new(source, target).is_muted = muted
    tree.nodes.remove(node)


def recombination_group(name: str, groups: list[str], passes: int):
    """A compositor group: for every light group and pass an image in, the picture out; all matrices zero."""
    tree = _new_tree(name, "CompositorNodeTree", "recombination")
    _socket(tree, "Alpha", "Float", output=False, default=1.0)
    for group in groups:
        for k in range(passes):
            _socket(tree, f"{group} {k + 1}", "Color", output=False, default=(0.0, 0.0, 0.0, 1.0))
    _socket(tree, "Image", "Color", output=True)
    source = _add(tree, "NodeGroupInput", 0)
    total = None
    for row, group in enumerate(groups):
        for k in range(passes):
            separate = _add(tree, "ShaderNodeSeparateXYZ", 1, row * passes + k)
            tree.links.new(source.outputs[f"{group} {k + 1}"], separate.inputs[0])
            for j in range(3):
                total = _multiply_add(tree, 2 + j, row * passes + k, 0.0, separate.outputs[j], total)
                total.node.name = _column_name(row, 3 * k + j)
    alpha = _add(tree, "CompositorNodeSetAlpha", 6)
    alpha.inputs["Type"].default_value = "Replace Alpha"
    tree.links.new(total, alpha.inputs["Image"])
    tree.links.new(source.outputs["Alpha"], alpha.inputs["Alpha"])
    output = _add(tree, "NodeGroupOutput", 7)
    tree.links.new(alpha.outputs[0], output.inputs["Image"])
    return tree


def _column_name(group: int, channel: int) -> str:
    return f"matrix {group} column {channel}"


def write_recombination(tree, matrices: np.ndarray):
    """Write (groups, 3, p) matrices into the sockets of a recombination group."""
    for group, matrix in enumerate(matrices):
        for channel, column in enumerate(matrix.T):
            tree.nodes[_column_name(group, channel)].inputs[0].default_value = column


def clear_orphans():
    """Delete the shared groups that nothing uses any more (a spectrum is the artist's: it stays)."""
    roles = ("upsample", "light", "recombination", "view")
    for role_name in roles:
        for tree in [t for t in bpy.data.node_groups if t.get(ROLE) == role_name and t.library is None]:
            if tree.users == 0:
                bpy.data.node_groups.remove(tree)
