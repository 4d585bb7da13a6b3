"""A comparison of two mixes in the compositing: the nodes that show one left of a line and the other right of it."""

from ..graph import nodes

__all__ = ["COMPARISON", "LINE", "end", "move_wipe"]

COMPARISON = "relume_comparison"  # on the nodes of a comparison
LINE = "relume_line"  # on the node that says where the pictures meet


def move_wipe(scene, position: float) -> None:
    """Move the line of a comparison to a part, 0 to 1, of the picture's width; without a comparison, does nothing."""
    tree = scene.compositing_node_group
    for node in tree.nodes if tree else ():
        if LINE in node:
            node.inputs[1].default_value = position


def end(scene) -> None:
    """Show only the mixer's own picture again."""
    tree = scene.compositing_node_group
    added = [node for node in tree.nodes if COMPARISON in node] if tree else []
    for mix in [node for node in added if node.type == "MIX"]:
        first = next(s for s in mix.inputs if s.name == "A" and s.enabled).links[0].from_socket
        for link in list(next(s for s in mix.outputs if s.enabled).links):
            tree.links.new(first, link.to_socket)
    for node in added:
        tree.nodes.remove(node)
    nodes.clear_orphans("comparison")
