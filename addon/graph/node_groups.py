"""The node groups that Relume adds to a file, built from Blender's own nodes alone.

In shaders:
- *View* reads the matrix of the view layer being rendered (see `scene.view_layers`);
- a *spectrum* group holds p coefficients and gives the colour `W @ c`, or a plain RGB colour where there is no W (see
  `spectra`);
- a *glass* group refracts each channel by its own index (see `glass`);
- *Upsample* does the same for an RGB input, or a vector that holds one number for each of red, green and blue;
- *Light* upsamples the colour of a lamp and colours it as its light group;
- an *emitter* is a lamp's own spectrum, relative to that of its light group, in place of an RGB colour.

In the compositor:
- *Recombination* sums matrices times coefficient passes.

A group that Relume made says what it is in custom properties: its `ROLE` and, where a file has several of one role,
which of them. So artists may rename groups. Inside a *Recombination*, the nodes that hold matrices are found by their
names.
"""

from collections.abc import Callable

import bpy
import numpy as np

from ...core.picture.blender_exr import light_pass
from ...core.picture.coefficients import EVERYTHING_ELSE
from . import nodes

__all__ = [
    "add_view",
    "emitter_group",
    "light_group",
    "matrix_sockets",
    "recombination_group",
    "set_spectral",
    "upsample_group",
    "view_group",
    "write_recombination",
]

_COEFFICIENTS = "relume_coefficients"  # on an emitter group: what it is filled with
_LIGHT = "relume_light"  # on a Light group: the number of its light group


def _shared_tree(name: str, role_name: str) -> tuple[bpy.types.NodeTree, bool]:
    """The one local group of this file with that role and name, made when there is none; and whether it is new."""
    for tree in bpy.data.node_groups:
        if tree.get(nodes.ROLE) == role_name and tree.get("relume_name") == name and tree.library is None:
            return tree, False
    tree = nodes.new_tree(name, "ShaderNodeTree", role_name)
    tree["relume_name"] = name
    return tree, True


def view_group(channels: int):
    """The shared *View* group for p channels: On, B0 to B2 and W0 to W(p-1) of the view layer being rendered."""
    tree, new = _shared_tree("Relume View", "view")
    if not new and tree["relume_channels"] == channels:
        return tree
    tree["relume_channels"] = channels
    tree.nodes.clear()
    output = nodes.add(tree, "NodeGroupOutput", 2)
    names = ["relume_on", *(f"relume_b{i}" for i in range(3)), *(f"relume_w{i}" for i in range(channels))]
    sockets = [name.removeprefix("relume_").upper() for name in names]
    for item in [item for item in tree.interface.items_tree if item.name not in sockets]:
        tree.interface.remove(item)
    for row, (name, socket) in enumerate(zip(names, sockets, strict=True)):
        if socket not in tree.interface.items_tree:
            nodes.add_socket(tree, socket, "Vector" if row else "Float", output=True)
        attribute = nodes.add(tree, "ShaderNodeAttribute", 0, row, attribute_type="VIEW_LAYER", attribute_name=name)
        tree.links.new(attribute.outputs["Vector" if row else "Factor"], output.inputs[socket])
    return tree


def add_view(tree, channels: int):
    """A node of the *View* group."""
    return nodes.add(tree, "ShaderNodeGroup", 0, node_tree=view_group(channels), label="View")


def upsample_group(channels: int, vector: bool = False, bounds: str = ""):
    """The shared *Upsample* group: an RGB colour in, `B @ rgb` out; or a vector, whose result is never negative.

    bounds: of the colour, as in `closures.Bounds`: "positive" or "unit".
    """
    kind = "Vector" if vector else bounds.capitalize()
    tree, new = _shared_tree(f"Relume Upsample {kind}".rstrip(), "upsample")
    if not new:
        view_group(channels)
        return tree
    name = kind = "Vector" if vector else "Color"
    nodes.add_socket(tree, name, kind, output=False, default=(1.0, 1.0, 1.0) if vector else (0.8, 0.8, 0.8, 1.0))
    nodes.add_socket(tree, name, kind, output=True)
    source = nodes.add(tree, "NodeGroupInput", 0, 1)
    view = add_view(tree, channels)
    held = source.outputs[name]
    if bounds:
        held = _held(tree, 1, held, "MAXIMUM", 0.0)
    if bounds == "unit":
        held = _held(tree, 1, held, "MINIMUM", 1.0)
    upsampled = _upsampled(tree, view, held, 2)
    if vector:
        upsampled = _held(tree, 4, upsampled, "MAXIMUM", 0.0)
    chosen = nodes.choose(tree, 5, view.outputs["ON"], source.outputs[name], upsampled)
    output = nodes.add(tree, "NodeGroupOutput", 6)
    tree.links.new(chosen, output.inputs[name])
    return tree


def _held(tree, column: int, vector, operation: str, limit: float):
    """A vector held to a limit, number by number."""
    node = nodes.add(tree, "ShaderNodeVectorMath", column, 2, operation=operation)
    tree.links.new(vector, node.inputs[0])
    node.inputs[1].default_value = (limit,) * 3
    return node.outputs[0]


def _upsampled(tree, view, colour, column: int):
    separate = nodes.add(tree, "ShaderNodeSeparateColor", column - 1, 1)
    tree.links.new(colour, separate.inputs[0])
    total = None
    for i in range(3):
        total = nodes.multiply_add(tree, column + i, 1, view.outputs[f"B{i}"], separate.outputs[i], total)
    return total


def light_group(index: int, channels: int, spectral: bool = False):
    """The shared *Light* group of light group number `index`: the colours that a lamp has in, its emission out.

    Color and Tint are multiplied as RGB, and Spectrum comes from a spectrum; `spectral` when Color does so as well.
    """
    tree, new = _shared_tree(f"Relume {'Spectral ' if spectral else ''}Light {index + 1}", "light")
    if not new:
        view_group(channels)
        return tree
    tree[_LIGHT] = index
    for name in ("Color", "Tint", "Spectrum"):
        nodes.add_socket(tree, name, "Color", output=False, default=(1.0, 1.0, 1.0, 1.0))
    nodes.add_socket(tree, "Color", "Color", output=True)
    source = nodes.add(tree, "NodeGroupInput", 0, 1)
    view = add_view(tree, channels)
    filtered = _product(tree, 1, 2, source.outputs["Color"], source.outputs["Tint"])
    if spectral:
        tint = _upsampled(tree, view, source.outputs["Tint"], 2)
        coloured = _product(tree, 5, 3, source.outputs["Color"], tint)
    else:
        coloured = _upsampled(tree, view, filtered, 2)
    colour = nodes.add(
        tree, "ShaderNodeAttribute", 4, 2, attribute_type="VIEW_LAYER", attribute_name=f"relume_light{index}"
    )
    lit = _product(tree, 5, 1, coloured, colour.outputs["Vector"])
    plain, spectrally = (_product(tree, 6, 1 + k, v, source.outputs["Spectrum"]) for k, v in enumerate((filtered, lit)))
    chosen = nodes.choose(tree, 7, view.outputs["ON"], plain, spectrally)
    output = nodes.add(tree, "NodeGroupOutput", 8)
    tree.links.new(chosen, output.inputs["Color"])
    return tree


def set_spectral(node, channels: int, spectral: bool) -> None:
    """Set whether the Color of an inserted node of a *Light* group comes from a spectrum."""
    node.node_tree = light_group(node.node_tree[_LIGHT], channels, spectral)
    node.label = node.node_tree.name


def _product(tree, column: int, row: int, a, b):
    node = nodes.add(tree, "ShaderNodeVectorMath", column, row, operation="MULTIPLY")
    tree.links.new(a, node.inputs[0])
    tree.links.new(b, node.inputs[1])
    return node.outputs[0]


def emitter_group(name: str, coefficients: np.ndarray):
    """The shared *emitter* group of that name: an RGB colour in, which shows where no W is set, `W @ c` out."""
    tree, new = _shared_tree(name, "emitter")
    if new:
        nodes.add_socket(tree, "Color", "Color", output=False, default=(1.0, 1.0, 1.0, 1.0))
        nodes.add_socket(tree, "Color", "Color", output=True)
    elif list(tree.get(_COEFFICIENTS, ())) == coefficients.tolist():
        return tree
    tree[_COEFFICIENTS] = coefficients.tolist()
    tree.nodes.clear()
    channels = len(coefficients)
    source = nodes.add(tree, "NodeGroupInput", 0, 1)
    view = add_view(tree, channels)
    chosen = nodes.choose(
        tree, channels + 1, view.outputs["ON"], source.outputs["Color"], nodes.weighed(tree, view, coefficients, 0)
    )
    output = nodes.add(tree, "NodeGroupOutput", channels + 2)
    tree.links.new(chosen, output.inputs["Color"])
    return tree


def recombination_group(name: str, groups: list[str], passes: int):
    """A compositor group: for every light group and pass an image in, the picture out; all matrices zero.

    The picture in the light of each light group alone comes out beside it, named as the pass whose place it takes.
    """
    tree = nodes.new_tree(name, "CompositorNodeTree", "recombination")
    nodes.add_socket(tree, "Alpha", "Float", output=False, default=1.0)
    for group in groups:
        for k in range(passes):
            nodes.add_socket(tree, f"{group} {k + 1}", "Color", output=False, default=(0.0, 0.0, 0.0, 1.0))
    nodes.add_socket(tree, "Image", "Color", output=True)
    source = nodes.add(tree, "NodeGroupInput", 0)
    images = [
        [_channels(tree, source, f"{group} {k + 1}", row * passes + k) for k in range(passes)]
        for row, group in enumerate(groups)
    ]
    lights = [_weighed(tree, row, image, _column_name) for row, image in enumerate(images)]
    total = None
    for row, light in enumerate(lights):
        total = light if total is None else _sum(tree, row * passes, total, light)
    alpha = nodes.add(tree, "CompositorNodeSetAlpha", 7)
    alpha.inputs["Type"].default_value = "Replace Alpha"
    tree.links.new(total, alpha.inputs["Image"])
    tree.links.new(source.outputs["Alpha"], alpha.inputs["Alpha"])
    output = nodes.add(tree, "NodeGroupOutput", 8)
    tree.links.new(alpha.outputs[0], output.inputs["Image"])
    rest = groups[-1] == EVERYTHING_ELSE
    for row, group in enumerate(groups[:-1] if rest else groups):
        nodes.add_socket(tree, light_pass(group), "Color", output=True)
        alone = lights[row]
        if rest:  # everything else is the image of all light: its matrix has been taken off those of the groups
            alone = _sum(tree, row * passes, alone, _weighed(tree, row, images[row], _rest_name))
        tree.links.new(alone, output.inputs[light_pass(group)])
    return tree


def _channels(tree, source, image: str, row: int):
    """The three channels of a coefficient pass of a light group."""
    separate = nodes.add(tree, "ShaderNodeSeparateXYZ", 1, row)
    tree.links.new(source.outputs[image], separate.inputs[0])
    return separate.outputs


def _weighed(tree, row: int, image: list, name: Callable[[int, int], str]):
    """A matrix times the coefficients of a light group; `name` says which node holds which of its columns."""
    total = None
    for k, channels in enumerate(image):
        for j in range(3):
            total = nodes.multiply_add(tree, 2 + j, row * len(image) + k, 0.0, channels[j], total)
            total.node.name = name(row, 3 * k + j)
    return total


def _sum(tree, row: int, a, b):
    node = nodes.add(tree, "ShaderNodeVectorMath", 6, row, operation="ADD")
    tree.links.new(a, node.inputs[0])
    tree.links.new(b, node.inputs[1])
    return node.outputs[0]


def _column_name(group: int, channel: int) -> str:
    return f"matrix {group} column {channel}"


def _rest_name(group: int, channel: int) -> str:
    return f"matrix {group} rest {channel}"


def write_recombination(tree, matrices: np.ndarray) -> bool:
    """Write (groups, 3, p) matrices into the sockets of a recombination group; those that hold them already stay.

    Returns whether any changed.
    """
    matrices, changed = np.asarray(matrices, dtype=np.float32), []
    for group, matrix in enumerate(matrices):
        for channel, column in enumerate(matrix.T):
            held = [(tree.nodes[_column_name(group, channel)], column)]
            if rest := tree.nodes.get(_rest_name(group, channel)):
                held.append((rest, matrices[-1, :, channel]))
            for node, numbers in held:
                if tuple(node.inputs[0].default_value) != tuple(numbers.tolist()):
                    node.inputs[0].default_value.foreach_set(numbers)
                    changed.append((node.inputs[0], numbers))
    if changed:
        # One assignment tells Blender. To assign each makes it look through the whole file as often: 25 ms with 2,000
        # materials, for one illuminant
        socket, column = changed[-1]
        socket.default_value = column
    return bool(changed)


def matrix_sockets(tree) -> list:
    """The sockets of a recombination group that hold its matrices, by group and channel."""
    return [node.inputs[0] for node in tree.nodes if node.name.startswith("matrix ")]
