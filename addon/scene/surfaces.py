"""What the first hit of each pixel is: AOVs with the coefficients of surfaces, one colour for each coefficient pass,
and in the first pass a Cryptomatte that says which material.

The view layers' own numbers pick the channels, as they do for light: one AOV Output node in each material does for all
passes. Nothing of it is there unless asked for.
"""

import bpy

from ...core.picture import coefficients
from ..graph import closures, places, spectra
from . import view_layers

__all__ = ["AOV", "add", "ask", "asked", "carried", "cost", "follow", "mirrors", "read", "read_materials", "remove"]

AOV = view_layers.SURFACE
_MAIN = ("Base Color", "Color")
_ASKED = "relume_surfaces"  # on a scene: that its renders are to carry surfaces
_DEPTH = 2  # materials that a pixel is made of, as far as a Cryptomatte tells: four numbers
_OWN = "relume_cryptomatte"  # on one of the artist's view layers: that its Cryptomatte is ours
_FLOATS = 4  # of an AOV, and of a Cryptomatte of two materials
# Closures that mirror, and what says that they do not; "" where they always do
_MIRRORS = {
    "ShaderNodeBsdfPrincipled": "Specular IOR Level",
    "ShaderNodeBsdfAnisotropic": "",
    "ShaderNodeBsdfGlossy": "",
    "ShaderNodeBsdfSheen": "",
}


def ask(scene, wanted: bool) -> list[str]:
    """Have the renders of a scene that is set up carry surfaces, or no more; returns what `add` does."""
    if wanted:
        scene[_ASKED] = True
        return add(scene)
    scene.pop(_ASKED, None)
    remove(scene)
    return []


def asked(scene) -> bool:
    """Whether renders of this scene are to carry surfaces, also after it is set up again."""
    return _ASKED in scene


def follow(scene):
    """Give a scene that was set up anew, or has new materials, what it was asked to carry."""
    if asked(scene) and scene.relume.is_set_up:
        add(scene)


def carried(scene) -> bool:
    """Whether the next render carries surfaces."""
    return any(AOV in layer.aovs for layers in view_layers.pass_layers(scene).values() for layer in layers)


def cost(scene) -> int:
    """Bytes of memory that surfaces take in a render of this scene."""
    part = scene.render.resolution_percentage / 100
    pixels = int(scene.render.resolution_x * part) * int(scene.render.resolution_y * part)
    return sum(4 * _FLOATS * pixels * (len(layers) + 1) for layers in view_layers.pass_layers(scene).values())


def mirrors(material) -> bool:
    """Whether the surface of a material mirrors beside what it reflects diffusely."""
    tree = material.node_tree
    for node in [tree.nodes[name] for name in _seen(tree)] if tree else ():
        if (level := _MIRRORS.get(node.bl_idname)) is not None:
            socket = node.inputs.get(level)
            if socket is None or socket.is_linked or socket.default_value > 0.0:
                return True
    return False


def _output_of(tree):
    return next((n for n in tree.nodes if n.bl_idname == "ShaderNodeOutputAOV" and n.aov_name == AOV), None)


def add(scene) -> list[str]:
    """Let the next render carry surfaces; returns the names of materials that have no colour to carry."""
    without = []
    for source, layers in view_layers.pass_layers(scene).items():
        if not layers[0].use_pass_cryptomatte_material:
            scene.view_layers[source][_OWN] = True
            # The first pass shows what the artist's own view layer does
            for layer in (scene.view_layers[source], layers[0]):
                layer.use_pass_cryptomatte_material, layer.pass_cryptomatte_depth = True, _DEPTH
        for layer in layers:
            if AOV not in layer.aovs:
                layer.aovs.add().name = AOV
            if layer.aovs[AOV].type != "COLOR":
                layer.aovs[AOV].type = "COLOR"
    for material in _materials(scene):
        tree, socket = material.node_tree, _color_of(material)
        if socket is None:
            without.append(material.name)
            continue
        output = _output_of(tree)
        if output is None:
            output = tree.nodes.new("ShaderNodeOutputAOV")
            output.aov_name = AOV
            output.location = (socket.node.location.x, socket.node.location.y + 160)
        _show(tree, socket, output.inputs["Color"])
    return without


def _show(tree, socket, shown) -> None:
    """Have an output show what comes into a socket, if it does not yet."""
    source, before = ((s.links[0].from_socket if s.is_linked else None) for s in (socket, shown))
    if source is not None and source != before:
        tree.links.new(source, shown)
    elif source is None:
        for link in list(shown.links):
            tree.links.remove(link)
        if list(shown.default_value) != list(socket.default_value):
            shown.default_value = socket.default_value


def _color_of(material):
    """The socket of a material that has the colour of what reflects, one with a spectrum first; None for none.

    A grey that set-up leaves unlinked has equal coefficients: its colour is as good.
    """
    found, seen = [], _seen(material.node_tree)
    for name, identifier, takes in places.of(material):
        if takes == "reflectance" and name in seen:
            node = material.node_tree.nodes[name]
            found.append(next(one for one in node.inputs if one.identifier == identifier))
    found = [one for one in found if closures.kind_of(one) is closures.Kind.COLOUR and not spectra.shines(one)]
    # Tints of what is mirrored say less of a surface than its own colour
    found = [socket for socket in found if socket.identifier in _MAIN] or found
    return next((socket for socket in found if socket.is_linked), found[0] if found else None)


def _seen(tree) -> set[str]:
    """Names of the nodes that the surface of a material is made of."""
    output = tree.get_output_node("CYCLES")
    found, left = set(), [output] if output is not None else []
    while left:
        node = left.pop()
        if node.name not in found:
            found.add(node.name)
            inputs = [node.inputs["Surface"]] if node == output else node.inputs
            left += [link.from_node for socket in inputs for link in socket.links]
    return found


def remove(scene):
    """Take the AOVs and their nodes away."""
    for layer in scene.view_layers:
        if AOV in layer.aovs:
            layer.aovs.remove(layer.aovs[AOV])
        if layer.pop(_OWN, None):
            for each in (layer, *view_layers.pass_layers(scene).get(layer.name, ())[:1]):
                each.use_pass_cryptomatte_material = False
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


def read_materials(path, scene) -> dict:
    """{material: (height, width), the part of each pixel that is it}, of that file. Raises CoefficientImageError."""
    layers = next(iter(view_layers.pass_layers(scene).values()))
    return coefficients.read_materials(path, layers[0].name)
