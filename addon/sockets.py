"""The colours of a scene: finding every spectral socket, and putting an *Upsample* or *Light* group in front of it."""

import bpy

from . import nodes

__all__ = ["all_trees", "convert", "emits", "restore", "trees_of"]

_EMITTERS = {
    "ShaderNodeEmission": "Color",
    "ShaderNodeBackground": "Color",
    "ShaderNodeBsdfPrincipled": "Emission Color",
}


def trees_of(scene):
    """Node trees that shade a scene, each with the light group that its emission belongs to: (tree, light group name).

    Groups inside trees come once, as part of the first tree that uses them. Linked trees are left out: they cannot be
    changed here.
    """
    found = {}

    def visit(tree, light_group):
        if tree is None or tree in found or tree.library is not None or tree.get(nodes.ROLE):
            return
        found[tree] = light_group
        for node in tree.nodes:
            if node.type == "GROUP":
                visit(node.node_tree, light_group)

    if scene.world:
        visit(scene.world.node_tree, scene.world.lightgroup)
    for thing in scene.objects:
        if thing.type == "LIGHT":
            visit(thing.data.node_tree, thing.lightgroup)
        for slot in thing.material_slots:
            if slot.material:
                visit(slot.material.node_tree, thing.lightgroup)
    return list(found.items())


def _spectral_sockets(node):
    """Colour inputs of a node that makes a shader (not those that mix shaders)."""
    if node.type in {"GROUP", "MIX_SHADER", "ADD_SHADER"} or not any(s.type == "SHADER" for s in node.outputs):
        return []
    return [socket for socket in node.inputs if socket.type == "RGBA" and not socket.is_unavailable]


def _is_neutral(socket) -> bool:
    red, green, blue = socket.default_value[:3]
    return not socket.is_linked and red == green == blue


def _from_spectrum(socket) -> bool:
    while socket.is_linked:
        node = socket.links[0].from_node
        if node.type != "REROUTE":
            return nodes.role(node) == "spectrum"
        socket = node.inputs[0]
    return False


def convert(tree, light_index: int, channels: int, tint=(1.0, 1.0, 1.0)):
    """Make every colour of a node tree take part in the spectral render. What is spectral or grey stays as it is.

    light_index: number of the light group of what the tree emits. tint: colour of the lamp itself. Running it twice
    changes nothing more.
    """
    for node in list(tree.nodes):
        for socket in _spectral_sockets(node):
            emits = _EMITTERS.get(node.bl_idname) == socket.name
            if socket.is_linked and nodes.role(socket.links[0].from_node) in {"upsample", "light"}:
                continue
            if _from_spectrum(socket):
                continue
            if emits and _may_emit(node, socket):
                lamp = nodes.insert(tree, socket, nodes.light_group(light_index, channels))
                lamp.inputs["Tint"].default_value = (*tint, 1.0)
            elif not emits and not _is_neutral(socket):
                nodes.insert(tree, socket, nodes.upsample_group(channels))


def _may_emit(node, socket) -> bool:
    """Whether the emission of a node can be anything but black: most Principled materials emit nothing."""
    strength = node.inputs["Emission Strength" if socket.name == "Emission Color" else "Strength"]
    dark = not socket.is_linked and not any(socket.default_value[:3])
    return not dark and (strength.is_linked or strength.default_value != 0.0)


def emits(tree) -> bool:
    """Whether a node tree has a socket that sends out light."""
    return any(
        _EMITTERS.get(node.bl_idname) == socket.name and _may_emit(node, socket)
        for node in tree.nodes
        for socket in _spectral_sockets(node)
    )


def restore(tree):
    """Take out of a node tree what `convert` put in."""
    for node in [node for node in tree.nodes if nodes.role(node) in {"upsample", "light"}]:
        nodes.take_out(tree, node)


def all_trees():
    """Every local node tree of the file that may hold a converted socket."""
    for collection in (bpy.data.materials, bpy.data.worlds, bpy.data.lights):
        for owner in collection:
            if owner.node_tree and owner.library is None:
                yield owner.node_tree
    for tree in bpy.data.node_groups:
        if tree.bl_idname == "ShaderNodeTree" and tree.library is None and not tree.get(nodes.ROLE):
            yield tree
