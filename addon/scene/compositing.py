"""The recombination in a scene's compositing: coefficient passes in, the picture out for whatever comes after."""

import json
from collections import Counter

import bpy
import numpy as np

from ...core.picture.blender_exr import light_pass
from ...core.picture.coefficients import EVERYTHING_ELSE
from ...core.picture.recombination import for_passes
from ..graph import node_groups, nodes, noise_nodes
from ..host import denoising
from ..store import properties
from ..store.remarks import Remark
from . import comparison, kept, noise, view_layers
from .comparison import COMPARISON, LINE
from .compositing_nodes import (
    ADDED,
    PART,
    SOURCE,
    belongs,
    fed,
    left_behind,
    links_to_artist,
    raw_outputs,
    recombinations,
    recombinations_in,
    users_of,
)

__all__ = [
    "compare",
    "follow_names",
    "patch",
    "recombinations",
    "remove",
    "rename",
    "write_matrices",
]

_TREE = "Relume Compositing"
_WIRING = "relume_wiring"  # on a scene: what its compositing looked like when it was set up
_STEP = 240
_NO_LIGHT = {"Image", "Noisy Image", "Denoising Albedo"}
_RAW = "{} is that of the first coefficient pass, and no colour: use the picture, or a pass that is no colour"


def _new_tree(scene, source: str):
    """Compositing for a scene that had none: the render goes straight to the output."""
    tree = nodes.new_tree(_TREE, "CompositorNodeTree", "compositing")
    tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    render_layers = tree.nodes.new("CompositorNodeRLayers")
    render_layers.scene, render_layers.layer = scene, source
    render_layers.location = (-3 * _STEP, 0)
    output = tree.nodes.new("NodeGroupOutput")
    output.location = (2 * _STEP, 0)
    tree.links.new(render_layers.outputs["Image"], output.inputs["Image"])
    return tree


def patch(scene, groups: list[str]) -> bool:
    """Have the recombination in the place of the Render Layers image, in the compositing that the scene has or gets.

    What is right already stays untouched; returns whether anything was not.
    """
    if _is_anothers(scene):
        scene.compositing_node_group = None
    if _is_right(scene, groups):
        kept.put(scene)
        return False
    _take_out_all(scene)
    layers = view_layers.pass_layers(scene)
    if scene.compositing_node_group is None or _is_empty(scene.compositing_node_group, scene):
        scene.compositing_node_group = _new_tree(scene, next(iter(layers)))
    tree = scene.compositing_node_group
    for source, copies in layers.items():
        shown = [n for n in tree.nodes if n.type == "R_LAYERS" and n.scene == scene and n.layer == source]
        if shown:
            group = node_groups.recombination_group(f"Relume Recombination {source}", groups, len(copies))
            treated = noise.group(scene, f"Relume Noise {source}", groups, len(copies))
            for node in shown:
                _feed(tree, node, group, treated, copies, groups)
    scene[_WIRING] = _wiring(scene, groups)
    kept.put(scene)
    return True


def _is_anothers(scene) -> bool:
    """Whether a scene shows the compositing that Relume made for the scene that it is a copy of."""
    tree = scene.compositing_node_group
    if tree is None or tree.get(nodes.ROLE) != "compositing" or fed(scene):
        return False
    return any(other != scene and other.compositing_node_group == tree for other in bpy.data.scenes)


def _is_empty(tree, scene) -> bool:
    """Whether a tree of Relume's shows nothing of its scene: undo may leave one so."""
    own = (node for node in tree.nodes if node.type == "R_LAYERS" and node.scene == scene)
    return tree.get(nodes.ROLE) == "compositing" and not any(own)


def _is_right(scene, groups: list[str]) -> bool:
    tree, layers = scene.compositing_node_group, view_layers.pass_layers(scene)
    if tree is None or scene.get(_WIRING) != _wiring(scene, groups) or left_behind(scene):
        return False
    for node in tree.nodes:
        own = node.type == "R_LAYERS" and node.scene == scene and ADDED not in node
        if own and SOURCE not in node and node.layer in layers:
            return False  # the artist's own, of later
        if (
            own
            and SOURCE in node
            and any(link for socket in raw_outputs(node, groups) for link in links_to_artist(socket))
        ):
            return False
    treated = [node for node in tree.nodes if PART in node and belongs(node, scene)]
    used = Counter(node.node_tree for node in [*recombinations(scene), *treated])
    return all(group.users == count for group, count in used.items())


def _wiring(scene, groups: list[str]) -> str:
    """What the nodes that Relume added are to each other, and what they were made for, as text."""
    tree, cycles = scene.compositing_node_group, scene.cycles
    layers = {source: [copy.name for copy in copies] for source, copies in view_layers.pass_layers(scene).items()}
    made_for = [groups, layers, noise.choice(scene), cycles.use_denoising]
    added = [node for node in tree.nodes if ADDED in node and COMPARISON not in node and kept.KEPT not in node]
    shown = [(node.name, getattr(node, "layer", ""), node.mute, node.get(PART, "")) for node in [*added, *fed(scene)]]
    ends = [(kept.source_of(link), link) for link in tree.links if link.to_node in added]
    links = [
        (source.node.name, source.identifier, link.to_node.name, link.to_socket.name, link.is_muted)
        for source, link in ends
    ]
    return json.dumps([made_for, sorted(shown), sorted(links)])


def _feed(tree, first, group, treated, copies: list, groups: list[str]) -> None:
    """Make the artist's Render Layers node the first pass, and give its users the recombined picture for its image.

    So do the users of a light group's pass: they get its light, recombined.
    """
    users = {socket.name: [link.to_socket for link in socket.links] for socket in raw_outputs(first, groups)}
    first[SOURCE] = first.layer
    first.layer = copies[0].name
    renders = [first]
    for k, copy in enumerate(copies[1:], 1):
        node = _added(tree, "CompositorNodeRLayers", first, 0, -k)
        node.scene, node.layer = first.scene, copy.name
        renders.append(node)
    recombination = _added(tree, "CompositorNodeGroup", first, 2.1, 0)
    recombination.node_tree = group
    recombination.label = "Relume"
    tree.links.new(first.outputs["Alpha"], recombination.inputs["Alpha"])
    target = recombination
    if treated is not None:
        target = _added(tree, "CompositorNodeGroup", first, 1.25, 0)
        target.node_tree, target.label = treated, "Relume Noise"
        target[PART] = f"part {sum(PART in other for other in tree.nodes)}"
        for socket in target.outputs:
            tree.links.new(socket, recombination.inputs[socket.name])
        for k, node in enumerate(renders):
            for guide in ("Albedo", "Normal"):
                if (name := noise_nodes.guide_socket(guide, k)) in target.inputs:
                    tree.links.new(node.outputs[f"Denoising {guide}"], target.inputs[name])
    for name in groups:
        image = "Image" if name == EVERYTHING_ELSE else light_pass(name)
        for k, node in enumerate(renders):
            tree.links.new(node.outputs[image], target.inputs[f"{name} {k + 1}"])
        for user in users.get(image, ()) if image != "Image" else ():
            tree.links.new(recombination.outputs[image], user)
    picture = recombination.outputs["Image"]
    if first.scene.cycles.use_denoising and not first.scene.relume.denoises_passes:
        # One denoising whatever the number of passes and light groups: the light is changed more often than rendered
        picture = _denoise(tree, first, picture)
    for user in users["Image"]:
        tree.links.new(picture, user)


def _denoise(tree, render, image):
    """Denoise the picture with the guides of a Render Layers node."""
    node = _added(tree, "CompositorNodeDenoise", render, 2.9, 0)
    tree.links.new(image, node.inputs["Image"])
    for guide in denoising.guides_of(render.scene):
        tree.links.new(render.outputs[f"Denoising {guide}"], node.inputs[guide])
    node.inputs["Prefilter"].default_value = denoising.prefilter_of(render.scene)
    return node.outputs["Image"]


def _added(tree, kind: str, beside, column: float, row: float):
    node = tree.nodes.new(kind)
    node[ADDED] = True
    node.parent = beside.parent
    node.location = (beside.location.x + column * _STEP, beside.location.y + row * 1.5 * _STEP)
    node.select = False
    return node


def write_matrices(scene, matrices: np.ndarray) -> bool:
    """Write the (groups, 3, p) recombination matrices into the sockets of the scene's recombination; whether any
    changed."""
    changed = False
    for tree in {node.node_tree for node in recombinations(scene)}:
        changed |= node_groups.write_recombination(tree, _as_rendered(scene, matrices))
    return changed


def follow_names(scene, names: dict[str, str]) -> None:
    """Follow the artist's view layers to new names: {before: now}."""
    for node in fed(scene) if names and scene.compositing_node_group else ():
        node[SOURCE] = names.get(node[SOURCE], node[SOURCE])


def rename(scene, before: str, after: str) -> None:
    """Follow a light group that got a new name on the view layers: sockets, and the passes that feed them."""
    kept.take_out(scene)
    tree = scene.compositing_node_group
    fed = []  # Render Layers node, the node that it feeds, and by which input
    for node in [*recombinations(scene), *(n for n in tree.nodes if PART in n and belongs(n, scene))]:
        for socket in node.inputs:
            group, _, number = socket.name.rpartition(" ")
            if group == before and socket.is_linked and socket.links[0].from_node.type == "R_LAYERS":
                fed.append((socket.links[0].from_node, node, f"{after} {number}"))
        for item in node.node_tree.interface.items_tree:
            group, _, number = item.name.rpartition(" ")
            if group == before:
                item.name = f"{after} {number}"
            elif item.name == light_pass(before) and item.in_out == "OUTPUT":
                item.name = light_pass(after)
    for render in {render for render, _, _ in fed}:
        render.layer = render.layer  # reads the names of the passes anew
    for render, node, name in fed:
        tree.links.new(render.outputs[light_pass(after)], node.inputs[name])


def _as_rendered(scene, matrices: np.ndarray) -> np.ndarray:
    """Matrices for the images that the scene composites: a render's last may hold all light, Relume's files' never."""
    rows, own = scene.relume.lit, scene.relume.exr and properties.STOCK not in scene
    return for_passes(matrices) if not own and rows[-1].name == EVERYTHING_ELSE else matrices


def remarks_on(scene) -> list[Remark]:
    """On passes of colour in the artist's compositing that the recombination has no picture for."""
    found = []
    for first in fed(scene) if scene.compositing_node_group else ():
        for socket in first.outputs:
            if socket.type == "RGBA" and socket.name not in _NO_LIGHT and links_to_artist(socket):
                found.append(Remark("Compositing", first.name, _RAW.format(socket.name)))
    return found


def remove(scene) -> None:
    """Give the compositing back as it was."""
    _take_out_all(scene)
    tree = scene.compositing_node_group
    if tree is not None and tree.get(nodes.ROLE) == "compositing":
        scene.compositing_node_group = None
        if tree.users == 0:
            nodes.delete(tree)


def _take_out_all(scene) -> None:
    """Take what was added out of a scene's compositing."""
    if _WIRING in scene:
        del scene[_WIRING]
    if scene.compositing_node_group is not None:
        comparison.end(scene)
        kept.take_out(scene)
        _clear(scene.compositing_node_group, scene)
    for tree in left_behind(scene):
        _clear(tree, scene)


def _clear(tree, scene) -> None:
    for recombination in recombinations_in(tree, scene):
        if recombination.inputs["Alpha"].is_linked:
            _take_out(tree, recombination.inputs["Alpha"].links[0].from_node, recombination)
    for node in [node for node in tree.nodes if ADDED in node and belongs(node, scene)]:
        tree.nodes.remove(node)
    names = view_layers.source_names(scene)
    shown = {copy.name: source for source, copies in view_layers.pass_layers(scene).items() for copy in copies}
    for node in fed(scene, tree):
        # Undo may bring back the name that a view layer had, and not that which is noted here
        node.layer = names.get(node[SOURCE]) or shown.get(node.layer) or node.layer
        del node[SOURCE]


def _take_out(tree, first, recombination) -> None:
    """Give what the recombination feeds to the Render Layers node that it is fed by."""
    for node in [n for n in tree.nodes if n.type == "DENOISE" and ADDED in n and n.inputs["Image"].is_linked]:
        source = node.inputs["Image"].links[0]
        if ADDED not in source.from_node:  # the artist put a node in between
            for link in list(node.outputs["Image"].links):
                tree.links.new(source.from_socket, link.to_socket)
    for user in users_of(recombination.outputs["Image"]):
        tree.links.new(first.outputs["Image"], user)
    for socket in recombination.outputs[1:]:
        for link in list(socket.links):
            if light_pass(socket.name) in first.outputs:
                tree.links.new(first.outputs[light_pass(socket.name)], link.to_socket)


def compare(scene, matrices: np.ndarray) -> None:
    """Show the picture of other (groups, 3, p) matrices right of a line that `move_wipe` moves."""
    comparison.end(scene)
    tree = scene.compositing_node_group
    for first in recombinations(scene):
        users = [link.to_socket for link in first.outputs["Image"].links]
        other = _added(tree, "CompositorNodeGroup", first, 0, -2)
        other.node_tree = first.node_tree.copy()
        other.node_tree[nodes.ROLE] = "comparison"
        other.node_tree.animation_data_clear()
        node_groups.write_recombination(other.node_tree, _as_rendered(scene, matrices))
        for name, socket in first.inputs.items():
            if socket.is_linked:
                tree.links.new(socket.links[0].from_socket, other.inputs[name])
        place = _added(tree, "CompositorNodeImageCoordinates", first, 1, -2)
        across = _added(tree, "ShaderNodeSeparateXYZ", first, 1.3, -2)
        right = _added(tree, "ShaderNodeMath", first, 1.6, -2)
        right.operation = "GREATER_THAN"
        mix = _added(tree, "ShaderNodeMix", first, 1.9, -2)
        mix.data_type = "RGBA"
        mix[COMPARISON] = True
        factor, a, b = (next(s for s in mix.inputs if s.name == n and s.enabled) for n in ("Factor", "A", "B"))
        tree.links.new(first.outputs["Image"], place.inputs["Image"])
        tree.links.new(place.outputs["Normalized"], across.inputs[0])
        tree.links.new(across.outputs[0], right.inputs[0])
        tree.links.new(right.outputs[0], factor)
        tree.links.new(first.outputs["Image"], a)
        tree.links.new(other.outputs["Image"], b)
        picture = next(s for s in mix.outputs if s.enabled)
        for user in users:
            tree.links.new(picture, user)
        for node in (other, place, across, right):
            node[COMPARISON] = True
        right[LINE] = True
    comparison.move_wipe(scene, scene.relume.wipe)
