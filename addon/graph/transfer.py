"""Spectral transfer functions: ranges of a volume's values, each with a spectrum and an opacity.

[BMD] S. Bergner, T. Moller, M. S. Drew, "A spectral engine for visualization", SFU-CMPT-TR2004-06, section 5.1.

One is an ordinary node group, of Blender's own nodes and groups with spectra: a value comes in, the spectrum and the
density of the range that holds it come out. It holds its own numbers, so that it can be shared, appended and edited
like any other group; set-up makes its spectra spectral as it does anywhere.
"""

from dataclasses import dataclass

import bpy

from ...core.spectra.spectrum import Spectrum
from . import nodes, spectra

__all__ = [
    "TRANSFER",
    "Range",
    "add_range",
    "attach",
    "is_transfer",
    "new",
    "of",
    "ranges_of",
    "remove_range",
    "spectrum_of",
]

TRANSFER = "relume_transfer"  # on a node group: how many ranges it has had
_RANGE = "relume_range"  # on a node: which range it belongs to
_PART = "relume_part"  # and what it is there
_STEP = 190  # from node to node


@dataclass(frozen=True)
class Range:
    """The nodes of one range, lowest first: what is above `low`'s second input and up to `high`'s has the colour of
    `spectrum`, the density of `opacity`'s second input, and takes the place of what ranges before it say."""

    index: int
    low: bpy.types.Node
    high: bpy.types.Node
    opacity: bpy.types.Node
    spectrum: bpy.types.Node


def new(name: str = "Spectral Transfer Function"):
    """A transfer function without ranges: everything is empty -> node group with Value; Color and Density."""
    tree = bpy.data.node_groups.new(name, "ShaderNodeTree")
    tree[TRANSFER] = 0
    nodes.add_socket(tree, "Value", "Float", output=False)
    nodes.add_socket(tree, "Color", "Color", output=True)
    nodes.add_socket(tree, "Density", "Float", output=True)
    for kind, x in (("NodeGroupInput", -_STEP), ("NodeGroupOutput", 0)):
        tree.nodes.new(kind).location = (x, 0)
    return tree


def is_transfer(tree) -> bool:
    """Whether a node group is a transfer function."""
    return tree is not None and TRANSFER in tree


def of(material) -> list:
    """The transfer functions in a material, each once."""
    found = [node.node_tree for node in material.node_tree.nodes if node.type == "GROUP"] if material.node_tree else []
    return list(dict.fromkeys(tree for tree in found if is_transfer(tree)))


def ranges_of(tree) -> list[Range]:
    """The ranges of a transfer function in the order in which they take each other's place; broken ones left out."""
    parts: dict[int, dict] = {}
    for node in tree.nodes:
        if _RANGE in node:
            parts.setdefault(node[_RANGE], {})[node[_PART]] = node
    wanted = {"low", "high", "opacity", "spectrum"}
    return [
        Range(index, *(found[part] for part in ("low", "high", "opacity", "spectrum")))
        for index, found in sorted(parts.items())
        if wanted <= found.keys()
    ]


def add_range(tree, low: float, high: float, group, opacity: float = 1.0) -> Range:
    """Add a range above those that are there; group: a spectrum group of `spectra.new_reflectance`."""
    index = tree[TRANSFER]
    tree[TRANSFER] = index + 1
    output = next(node for node in tree.nodes if node.bl_idname == "NodeGroupOutput")
    value = next(node for node in tree.nodes if node.bl_idname == "NodeGroupInput").outputs["Value"]
    before = {name: _source(output.inputs[name]) for name in ("Color", "Density")}

    def node(part: str, kind: str, column: int, row: int, **settings):
        made = tree.nodes.new(kind)
        made[_RANGE], made[_PART] = index, part
        made.location = (_STEP * (4 * index + column), -_STEP * row)
        for name, setting in settings.items():
            setattr(made, name, setting)
        return made

    above = node("low", "ShaderNodeMath", 0, 1, operation="GREATER_THAN", label="From")
    beyond = node("high", "ShaderNodeMath", 0, 2, operation="GREATER_THAN", label="To")
    inside = node("inside", "ShaderNodeMath", 1, 1, operation="SUBTRACT", use_clamp=True)
    dense = node("opacity", "ShaderNodeMath", 2, 2, operation="MULTIPLY", label="Opacity")
    colour = node("spectrum", "ShaderNodeGroup", 1, 0, node_tree=group)
    tint = node("colour", "ShaderNodeMix", 3, 0, data_type="RGBA")
    density = node("density", "ShaderNodeMix", 3, 1, data_type="FLOAT")
    above.inputs[1].default_value, beyond.inputs[1].default_value = low, high
    dense.inputs[1].default_value = opacity
    tree.links.new(value, above.inputs[0])
    tree.links.new(value, beyond.inputs[0])
    tree.links.new(above.outputs[0], inside.inputs[0])
    tree.links.new(beyond.outputs[0], inside.inputs[1])
    tree.links.new(inside.outputs[0], dense.inputs[0])
    for mix, name, made in ((tint, "Color", colour.outputs["Color"]), (density, "Density", dense.outputs[0])):
        kind = "RGBA" if name == "Color" else "VALUE"
        first, second = [s for s in mix.inputs if s.enabled and s.type == kind and s.name in ("A", "B")]
        tree.links.new(inside.outputs[0], next(s for s in mix.inputs if s.enabled and s.name == "Factor"))
        if before[name] is not None:
            tree.links.new(before[name], first)
        elif name == "Color":
            first.default_value = (0.0, 0.0, 0.0, 1.0)
        else:
            first.default_value = 0.0
        tree.links.new(made, second)
        result = next(s for s in mix.outputs if s.enabled)
        tree.links.new(result, output.inputs[name])
    output.location = (_STEP * (4 * index + 5), 0)
    return Range(index, above, beyond, dense, colour)


def remove_range(tree, index: int) -> None:
    """Take a range out; the others stay as they are."""
    own = [node for node in tree.nodes if node.get(_RANGE) == index]
    for mix in (node for node in own if node[_PART] in ("colour", "density")):
        first = next(s for s in mix.inputs if s.enabled and s.name == "A")
        source, value = _source(first), first.default_value
        for link in list(next(s for s in mix.outputs if s.enabled).links):
            target = link.to_socket
            tree.links.remove(link)
            if source is not None:
                tree.links.new(source, target)
            elif target.node.bl_idname != "NodeGroupOutput":
                target.default_value = value
    for node in own:
        tree.nodes.remove(node)


def attach(material, tree, field, shines: bool = True):
    """Make a material the volume that a transfer function of a field (socket) says -> the Principled Volume node.

    shines: every point sends out the light of its light group as its spectrum reflects it, and takes in light as its
    density says, as in the paper's raycasting; else it scatters light that reaches it.
    """
    own = material.node_tree
    group = own.nodes.new("ShaderNodeGroup")
    group.node_tree = tree
    volume = own.nodes.new("ShaderNodeVolumePrincipled")
    output = next((node for node in own.nodes if getattr(node, "is_active_output", False)), None)
    output = output or own.nodes.new("ShaderNodeOutputMaterial")
    own.links.new(field, group.inputs["Value"])
    own.links.new(group.outputs["Density"], volume.inputs["Density"])
    if shines:
        volume.inputs["Color"].default_value = (0.0, 0.0, 0.0, 1.0)
        own.links.new(group.outputs["Color"], volume.inputs["Emission Color"])
        own.links.new(group.outputs["Density"], volume.inputs["Emission Strength"])
    else:
        own.links.new(group.outputs["Color"], volume.inputs["Color"])
    own.links.new(volume.outputs["Volume"], output.inputs["Volume"])
    for column, node in enumerate((group, volume, output)):
        node.location = (field.node.location.x + 250 * (column + 1), field.node.location.y)
    return volume


def spectrum_of(one: Range) -> Spectrum | None:
    """The reflectance that a range has, None where its group is none."""
    tree = one.spectrum.node_tree
    return spectra.spectra_of(tree).get("Color") if tree is not None and spectra.SPECTRA in tree else None


def _source(socket):
    return socket.links[0].from_socket if socket.is_linked else None
