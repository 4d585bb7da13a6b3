"""Places in a material that can have a measured spectrum: a socket, or a whole node that is a metal or a glass."""

from . import glass, nodes, spectra
from .closures import in_use, spectral_sockets

__all__ = ["GLASS", "METAL", "REFLECTANCE", "chosen_at", "of", "socket_of", "tree_at"]

# What a place takes from the library
REFLECTANCE, METAL, GLASS = "reflectance", "metal", "glass"


def of(material) -> list[tuple[str, str, str]]:
    """(node, socket identifier, what it takes) of every place in a material.

    A metal or a glass is chosen for the whole of a node: its socket is "".
    """
    found = []
    for node in material.node_tree.nodes if material.node_tree else ():
        if node.bl_idname in glass.GLASS_NODES or nodes.role(node) == "glass":
            found.append((node.name, "", GLASS))
        if node.bl_idname == "ShaderNodeBsdfMetallic":
            found.append((node.name, "", METAL))
        else:
            found += [(node.name, s.identifier, REFLECTANCE) for s in spectral_sockets(node) if in_use(s)]
    return found


def chosen_at(node, identifier: str, takes: str) -> str:
    """Name of the spectrum at a place, "" if there is none."""
    tree = tree_at(node, identifier, takes)
    return "" if tree is None else next(iter(spectra.spectra_of(tree).values())).name


def tree_at(node, identifier: str, takes: str):
    """The group of the spectrum at a place, None if there is none."""
    if takes == GLASS:
        return node.node_tree if nodes.role(node) == "glass" else None
    socket = node.inputs["IOR"] if takes == METAL else socket_of(node, identifier)
    tree = spectra.source_of(socket)
    return tree if tree and spectra.SPECTRA in tree else None


def socket_of(node, identifier: str):
    return next(socket for socket in node.inputs if socket.identifier == identifier)
