"""Glasses with dispersion: each channel refracts by its own index.

A closure of Cycles has one index of refraction. A *glass* group therefore adds several, each of which lets one of the
three channels of a pass through: wide channels have a closure for each of some equal shares of their wavelengths, so
that a spectrum has no stripes. In a scene without Relume they are red, green and blue. A glass group keeps its index as
`spectra` keep theirs.
"""

import bpy

from ...core.colour import spaces
from ...core.model.factor_model import FactorModel
from ...core.spectra.spectrum import Spectrum
from . import node_groups, nodes
from .spectra import FILLED, SPECTRA, filled_for, spectra_of

__all__ = ["GLASS_NODES", "disperses", "mend_all", "put_back", "replace", "restore_all", "update_all"]

GLASS_NODES = ("ShaderNodeBsdfGlass", "ShaderNodeBsdfRefraction")
_KIND = "relume_closure"  # on a glass group: which closure it is made of
_UNFINISHED = "relume_unfinished"  # on a glass group while it gets other nodes
_SODIUM_D = 589.3  # nm


def new_glass(name: str, index: Spectrum, kind: str = "ShaderNodeBsdfGlass", normal: bool = False):
    """A node group that is a glass of that refractive index, made of Glass or Refraction closures.

    normal: with an input for a normal.
    """
    tree = nodes.new_tree(name, "ShaderNodeTree", "glass")
    tree[SPECTRA], tree[_KIND] = {"IOR": index.to_dict()}, kind
    nodes.add_socket(tree, "Color", "Color", output=False, default=(1.0, 1.0, 1.0, 1.0))
    nodes.add_socket(tree, "Roughness", "Float", output=False, default=0.0)
    if normal:
        nodes.add_socket(tree, "Normal", "Vector", output=False)
    nodes.add_socket(tree, "BSDF", "Shader", output=True)
    _fill(tree, None)
    for scene in bpy.data.scenes:
        if scene.relume.shades:
            _fill(tree, scene.relume.model())
            break
    return tree


def _fill(tree, model: FactorModel | None) -> None:
    """Build the group for a model's channels, or for red, green and blue."""
    index = spectra_of(tree)["IOR"]
    plain = spaces.display_primaries(index)
    tree[_UNFINISHED] = True
    if FILLED in tree:
        del tree[FILLED]
    tree.nodes.clear()
    source, output = nodes.add(tree, "NodeGroupInput", 0, 3), nodes.add(tree, "NodeGroupOutput", 6)
    shares = [None] if model is None else model.shares(index)
    view_node = None if model is None else node_groups.add_view(tree, model.channels)
    total = None
    for number, share in enumerate(shares):
        indices = nodes.add(tree, "ShaderNodeSeparateXYZ", 2, 4 * number)
        if model is None:
            indices.inputs[0].default_value = plain
        else:
            spectral = nodes.weighed(tree, view_node, share, 4 * number)
            tree.links.new(nodes.choose(tree, 1, view_node.outputs["ON"], tuple(plain), spectral), indices.inputs[0])
        for channel in range(3):
            row = 4 * number + channel
            masked = nodes.add(tree, "ShaderNodeVectorMath", 3, row, operation="MULTIPLY")
            masked.inputs[1].default_value = [(channel == k) / len(shares) for k in range(3)]
            closure = nodes.add(tree, tree[_KIND], 4, row)
            tree.links.new(source.outputs["Color"], masked.inputs[0])
            tree.links.new(masked.outputs[0], closure.inputs["Color"])
            tree.links.new(indices.outputs[channel], closure.inputs["IOR"])
            for name in ("Roughness", "Normal"):
                if name in source.outputs:
                    tree.links.new(source.outputs[name], closure.inputs[name])
            total = closure.outputs[0] if total is None else _sum(tree, 5, row, total, closure.outputs[0])
    tree.links.new(total, output.inputs["BSDF"])
    if model is not None:
        tree[FILLED] = filled_for(tree, model)
    del tree[_UNFINISHED]


def _sum(tree, column: int, row: int, a, b):
    node = nodes.add(tree, "ShaderNodeAddShader", column, row)
    tree.links.new(a, node.inputs[0])
    tree.links.new(b, node.inputs[1])
    return node.outputs[0]


def disperses(node) -> bool:
    """Whether a node is a glass whose index of refraction is not the same at all wavelengths."""
    if nodes.role(node) != "glass" or SPECTRA not in node.node_tree:
        return False
    return len(set(spectra_of(node.node_tree)["IOR"].values)) > 1


def replace(node, index: Spectrum):
    """Put a glass of that refractive index in the place of a Glass or Refraction node, or of another glass."""
    tree, normal = node.id_data, "Normal" in node.inputs and node.inputs["Normal"].is_linked
    kind = node.bl_idname if node.bl_idname in GLASS_NODES else node.node_tree[_KIND]
    glass = tree.nodes.new("ShaderNodeGroup")
    glass.node_tree = _existing(index, kind, normal) or new_glass(index.name, index, kind, normal)
    _take_place(glass, node)
    return glass


def put_back(node):
    """Put a node of Blender's own, with the index at the sodium D line, in the place of a glass group."""
    own = node.id_data.nodes.new(node.node_tree[_KIND])
    own.inputs["IOR"].default_value = float(spectra_of(node.node_tree)["IOR"].sampled([_SODIUM_D])[0])
    _take_place(own, node)
    return own


def _take_place(new, old) -> None:
    tree = old.id_data
    new.parent, new.location = old.parent, old.location
    for socket in old.inputs:
        if socket.name not in new.inputs:
            continue
        if socket.is_linked:
            tree.links.new(socket.links[0].from_socket, new.inputs[socket.name])
        elif socket.name in {"Color", "Roughness"}:
            new.inputs[socket.name].default_value = socket.default_value
    for link in list(old.outputs[0].links):
        tree.links.new(new.outputs[0], link.to_socket)
    tree.nodes.remove(old)


def _existing(index: Spectrum, kind: str, normal: bool):
    """The glass group of this file that is the same."""
    for tree in _local():
        if tree[_KIND] == kind and ("Normal" in tree.interface.items_tree) == normal:
            own = spectra_of(tree)["IOR"]
            if own.name == index.name and own.values.tolist() == index.values.tolist():
                return tree
    return None


def _local() -> list:
    return [t for t in bpy.data.node_groups if t.get(nodes.ROLE) == "glass" and t.library is None and SPECTRA in t]


def update_all(model: FactorModel) -> None:
    """Give every glass of this file the indices of a model's channels; those that have them stay untouched."""
    for tree in _local():
        if tree.get(FILLED) != filled_for(tree, model):
            _fill(tree, model)


def mend_all(model: FactorModel) -> None:
    """Build what an update that ended part-way left unfinished."""
    for tree in _local():
        if _UNFINISHED in tree:
            _fill(tree, model)


def restore_all() -> None:
    """Leave in every glass of this file only the indices of red, green and blue."""
    for tree in _local():
        _fill(tree, None)
