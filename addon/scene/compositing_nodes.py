"""Which nodes of a compositing tree a scene's coefficient passes feed: the artist's, and those that were added."""

import bpy

from ...core.picture.blender_exr import light_pass
from ...core.picture.coefficients import EVERYTHING_ELSE
from ..graph import nodes

__all__ = [
    "ADDED",
    "PART",
    "SOURCE",
    "belongs",
    "fed",
    "left_behind",
    "links_to_artist",
    "raw_outputs",
    "recombinations",
    "recombinations_in",
    "users_of",
]

SOURCE = "relume_source"  # on the artist's Render Layers node: the view layer that it showed
ADDED = "relume_added"  # on the nodes that Relume added
PART = "relume_part"  # on a node that takes noise from passes: what its outputs are called in a file


def fed(scene, tree=None) -> list:
    """The artist's Render Layers nodes that became first passes, in the scene's compositing or in another tree."""
    tree = tree or scene.compositing_node_group
    return [node for node in tree.nodes if SOURCE in node and node.scene == scene]


def left_behind(scene) -> list:
    """Compositing that the artist has taken from the scene, and that Relume has added to."""
    others = (t for t in bpy.data.node_groups if t.bl_idname == "CompositorNodeTree" and not t.get(nodes.ROLE))
    return [
        tree for tree in others if tree != scene.compositing_node_group and tree.library is None and fed(scene, tree)
    ]


def raw_outputs(first, groups: list[str]) -> list:
    """The outputs of a first pass that hold coefficients of what the recombination gives as a picture."""
    names = {"Image", *(light_pass(group) for group in groups if group != EVERYTHING_ELSE)}
    return [socket for socket in first.outputs if socket.name in names]


def links_to_artist(socket) -> list:
    """The links from an output to nodes that Relume did not add."""
    return [link for link in socket.links if ADDED not in link.to_node]


def recombinations(scene) -> list:
    """The nodes that recombine the scene's coefficient passes."""
    tree = scene.compositing_node_group
    return recombinations_in(tree, scene) if tree else []


def recombinations_in(tree, scene) -> list:
    found = [node for node in tree.nodes if nodes.role(node) == "recombination"]
    return [node for node in found if _scene_of(node) in (scene, None)]


def _scene_of(recombination):
    """Whose passes a node recombines; None where the artist took its Render Layers node away."""
    alpha = recombination.inputs["Alpha"]
    return getattr(alpha.links[0].from_node, "scene", None) if alpha.is_linked else None


def users_of(picture):
    """The sockets that the recombined picture goes to in the end, through the denoiser that Relume put behind it."""
    for link in list(picture.links):
        if link.to_node.type == "DENOISE" and ADDED in link.to_node:
            yield from users_of(link.to_node.outputs["Image"])
        else:
            yield link.to_socket


def belongs(node, scene) -> bool:
    """Whether a node that Relume added was added for a scene: another may show the same compositing."""
    if node.type == "R_LAYERS":
        return node.scene == scene
    if nodes.role(node) == "recombination":
        return _scene_of(node) in (scene, None)
    if PART in node:
        sources = [socket.links[0].from_node for socket in node.inputs if socket.is_linked]
        return all(getattr(source, "scene", None) in (scene, None) for source in sources)
    return True
