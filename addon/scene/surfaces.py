"""What the first hit of each pixel is: AOVs with the coefficients of surfaces, one colour for each coefficient pass.

The view layers' own numbers pick the channels, as they do for light: one AOV Output node in each material does for all
passes. Nothing of it is there unless asked for.
"""

import bpy

from ...core.picture import coefficients
from ..graph import places, spectra
from . import view_layers

__all__ = ["AOV", "add", "read", "remove"]

AOV = view_layers.SURFACE


def _output_of(tree):
    return next((n for n in tree.nodes if n.bl_idname == "ShaderNodeOutputAOV" and n.aov_name == AOV), None)


def add(scene) -> list[str]:
    """Let the next render carry surfaces; returns the names of materials that have no colour to carry."""
    without = []
    for layers in view_layers.pass_layers(scene).values():
        for layer in layers:
            if AOV not in layer.aovs:
                layer.aovs.add().name = AOV
            layer.aovs[AOV].type = "COLOR"
    for material in _materials(scene):
        tree, socket = material.node_tree, _color_of(material)
        if socket is None:
            without.append(material.name)
            continue
        output = _output_of(tree) or tree.nodes.new("ShaderNodeOutputAOV")
        output.aov_name = AOV
        output.location = (socket.node.location.x, socket.node.location.y + 160)
        if socket.is_linked:
            tree.links.new(socket.links[0].from_socket, output.inputs["Color"])
        else:
            output.inputs["Color"].default_value = socket.default_value
    return without


def _color_of(material):
    """The socket of a material that has the colour of what reflects, one with a spectrum first; None for none.

    A grey that set-up leaves unlinked has equal coefficients: its colour is as good.
    """
    found = []
    for name, identifier, takes in places.of(material):
        if takes == "reflectance":
            node = material.node_tree.nodes[name]
            found.append(next(one for one in node.inputs if one.identifier == identifier))
    found = [socket for socket in found if not spectra.shines(socket)]
    return next((socket for socket in found if socket.is_linked), found[0] if found else None)


def remove(scene):
    """Take the AOVs and their nodes away."""
    for layer in scene.view_layers:
        if AOV in layer.aovs:
            layer.aovs.remove(layer.aovs[AOV])
    for material in bpy.data.materials:
        if material.node_tree and (output := _output_of(material.node_tree)):
            material.node_tree.nodes.remove(output)


def _materials(scene):
    found = [slot.material for thing in scene.objects for slot in thing.material_slots if slot.material]
    return [material for material in dict.fromkeys(found) if material.node_tree and material.is_editable]


def read(path, scene):
    """(height, width, p): the surface of each pixel, of a multilayer EXR that Blender wrote.

    Raises CoefficientImageError where the render carried none.
    """
    layers = next(iter(view_layers.pass_layers(scene).values()))
    return coefficients.read_pass(path, scene.relume.model(), [layer.name for layer in layers], AOV)
