"""The recombination in a scene's compositing: coefficient passes in, the picture out for whatever comes after."""

import bpy

from ..core import view
from ..core.coefficients import EVERYTHING_ELSE
from . import nodes, passes

__all__ = ["add", "remove", "write_matrices"]

_SOURCE = "relume_source"  # on the artist's Render Layers node: the view layer that it showed
_ADDED = "relume_added"  # on the nodes that Relume added
_TREE = "Relume Compositing"
_STEP = 240


def _new_tree(source: str):
    """Compositing for a scene that had none: the render goes straight to the output."""
    tree = bpy.data.node_groups.new(_TREE, "CompositorNodeTree")
    tree[nodes.ROLE] = "compositing"
    tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    render_layers = tree.nodes.new("CompositorNodeRLayers")
    render_layers.layer = source
    render_layers.location = (-3 * _STEP, 0)
    output = tree.nodes.new("NodeGroupOutput")
    output.location = (2 * _STEP, 0)
    tree.links.new(render_layers.outputs["Image"], output.inputs["Image"])
    return tree


def add(scene, groups: list[str]):
    """Put the recombination in the place of the Render Layers image, in the compositing that the scene has or gets."""
    layers = passes.pass_layers(scene)
    if scene.compositing_node_group is None:
        scene.compositing_node_group = _new_tree(next(iter(layers)))
    tree = scene.compositing_node_group
    for source, copies in layers.items():
        shown = [n for n in tree.nodes if n.type == "R_LAYERS" and n.scene == scene and n.layer == source]
        if shown:
            group = nodes.recombination_group(f"Relume Recombination {source}", groups, len(copies))
            for node in shown:
                _feed(tree, node, group, copies, groups)


def _feed(tree, first, group, copies, groups):
    """Make the artist's Render Layers node the first pass, and give its users the recombined picture for its image."""
    users = [link.to_socket for link in first.outputs["Image"].links]
    first[_SOURCE] = first.layer
    first.layer = copies[0].name
    renders = [first]
    for k, copy in enumerate(copies[1:], 1):
        node = _added(tree, "CompositorNodeRLayers", first, 0, -k)
        node.scene, node.layer = first.scene, copy.name
        renders.append(node)
    recombination = _added(tree, "CompositorNodeGroup", first, 1.5, 0)
    recombination.node_tree = group
    recombination.label = "Relume"
    tree.links.new(first.outputs["Alpha"], recombination.inputs["Alpha"])
    for name in groups:
        image = "Image" if name == EVERYTHING_ELSE else passes.light_pass(name)
        for k, node in enumerate(renders):
            tree.links.new(node.outputs[image], recombination.inputs[f"{name} {k + 1}"])
    picture = recombination.outputs["Image"]
    if first.scene.cycles.use_denoising:
        # Light groups come out of Cycles undenoised, and coefficients are no picture yet
        denoise = _added(tree, "CompositorNodeDenoise", first, 2.3, 0)
        tree.links.new(picture, denoise.inputs["Image"])
        picture = denoise.outputs["Image"]
    for user in users:
        tree.links.new(picture, user)


def _added(tree, kind: str, beside, column: float, row: int):
    node = tree.nodes.new(kind)
    node[_ADDED] = True
    node.parent = beside.parent
    node.location = (beside.location.x + column * _STEP, beside.location.y + row * 1.5 * _STEP)
    node.select = False
    return node


def write_matrices(scene, matrices, groups: list[str]):
    """Write the (groups, 3, p) recombination matrices into the sockets of the scene's recombination."""
    if groups[-1] == EVERYTHING_ELSE:
        matrices = view.for_passes(matrices)
    for tree in {node.node_tree for node in _recombinations(scene)}:
        nodes.write_recombination(tree, matrices)


def _recombinations(scene):
    tree = scene.compositing_node_group
    return [node for node in tree.nodes if nodes.role(node) == "recombination"] if tree else []


def _users(picture):
    """The sockets that the recombined picture goes to in the end, through the denoiser that Relume put behind it."""
    for link in list(picture.links):
        if link.to_node.type == "DENOISE" and _ADDED in link.to_node:
            yield from _users(link.to_node.outputs["Image"])
        else:
            yield link.to_socket


def remove(scene):
    """Give the compositing back as it was."""
    tree = scene.compositing_node_group
    if tree is None:
        return
    for recombination in _recombinations(scene):
        if not recombination.inputs["Alpha"].is_linked:
            continue  # the artist deleted the Render Layers node
        first = recombination.inputs["Alpha"].links[0].from_node
        for user in _users(recombination.outputs["Image"]):
            tree.links.new(first.outputs["Image"], user)
    for node in [node for node in tree.nodes if _ADDED in node]:
        tree.nodes.remove(node)
    names = passes.source_names(scene)
    for node in [node for node in tree.nodes if _SOURCE in node]:
        if node[_SOURCE] in names:
            node.layer = names[node[_SOURCE]]
        del node[_SOURCE]
    if tree.get(nodes.ROLE) == "compositing":
        scene.compositing_node_group = None
        if tree.users == 0:
            bpy.data.node_groups.remove(tree)
