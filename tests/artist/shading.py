"""Edits of materials and their nodes."""

import bpy

from relume.addon.graph import nodes, spectra
from relume.core.spectra import library

from .kinds import add_node, artists_nodes, colour, edit, materials, meshes, own_socket, pick, things

_CLOSURES = ("ShaderNodeBsdfPrincipled", "ShaderNodeBsdfDiffuse", "ShaderNodeBsdfGlass", "ShaderNodeEmission")
_COLOURS = {"Base Color", "Color", "Emission Color", "Coat Tint", "Sheen Tint", "Specular Tint"}
_WEIGHTS = ("Coat Weight", "Sheen Weight", "Subsurface Weight", "Transmission Weight", "Metallic", "Roughness")


def _closure(chance, material):
    return pick(chance, artists_nodes(material.node_tree, *_CLOSURES)) if material else None


def _colour_socket(chance, node):
    return pick(chance, [s for s in node.inputs if s.type == "RGBA" and s.name in _COLOURS]) if node else None


def _plug(chance, source, socket):
    """Link into an input, as often before what set-up inserted as in its place."""
    before = chance.random() < 0.5
    socket.id_data.links.new(source, own_socket(socket) if before else socket)


@edit
def change_a_colour(chance, scene):
    material = pick(chance, materials())
    socket = _colour_socket(chance, _closure(chance, material))
    chosen = colour(chance)
    if socket is None or own_socket(socket).is_linked:
        return None
    own_socket(socket).default_value = (*chosen, 1.0)
    return f"{material.name}: {socket.name} {chosen}"


@edit
def make_it_shine(chance, scene):
    material = pick(chance, materials())
    node = pick(chance, artists_nodes(material.node_tree, "ShaderNodeBsdfPrincipled")) if material else None
    strength = chance.choice([0.0, 0.5, 3.0])
    if node is None:
        return None
    node.inputs["Emission Strength"].default_value = strength
    return f"{material.name} shines {strength}"


@edit
def change_a_weight(chance, scene):
    material = pick(chance, materials())
    node = pick(chance, artists_nodes(material.node_tree, "ShaderNodeBsdfPrincipled")) if material else None
    name, weight = chance.choice(_WEIGHTS), chance.choice([0.0, 0.3, 1.0])
    if node is None:
        return None
    node.inputs[name].default_value = weight
    return f"{material.name}: {name} {weight}"


@edit
def put_a_texture_on(chance, scene):
    material = pick(chance, materials())
    socket = _colour_socket(chance, _closure(chance, material))
    kind = chance.choice(["ShaderNodeTexChecker", "ShaderNodeTexNoise", "ShaderNodeVertexColor", "ShaderNodeTexImage"])
    if socket is None:
        return None
    texture = add_node(material.node_tree, kind)
    if kind == "ShaderNodeTexImage":
        texture.image = bpy.data.images.new("grid", 8, 8)
        texture.image.generated_type = "COLOR_GRID"
    _plug(chance, texture.outputs["Color"], socket)
    return f"{material.name}: {kind} on {socket.name}"


@edit
def mix_two_colours(chance, scene):
    material = pick(chance, materials())
    socket = _colour_socket(chance, _closure(chance, material))
    first, second = colour(chance), colour(chance)
    if socket is None:
        return None
    mix = add_node(material.node_tree, "ShaderNodeMix")
    mix.data_type = "RGBA"
    for name, chosen in (("A", first), ("B", second)):
        next(s for s in mix.inputs if s.name == name and s.type == "RGBA").default_value = (*chosen, 1.0)
    result = next(s for s in mix.outputs if s.type == "RGBA")
    _plug(chance, result, socket)
    return f"{material.name}: a mix on {socket.name}"


@edit
def unplug(chance, scene):
    material = pick(chance, materials())
    socket = _colour_socket(chance, _closure(chance, material))
    if socket is None or not own_socket(socket).is_linked:
        return None
    material.node_tree.links.remove(own_socket(socket).links[0])
    return f"{material.name}: nothing on {socket.name}"


@edit
def mute_a_link(chance, scene):
    material = pick(chance, materials())
    socket = _colour_socket(chance, _closure(chance, material))
    if socket is None or not own_socket(socket).is_linked:
        return None
    link = own_socket(socket).links[0]
    link.is_muted = not link.is_muted
    return f"{material.name}: {'muted' if link.is_muted else 'unmuted'} {socket.name}"


@edit
def add_a_closure(chance, scene):
    material = pick(chance, materials())
    kind, chosen = chance.choice(_CLOSURES), colour(chance)
    if material is None:
        return None
    tree = material.node_tree
    output = next((n for n in artists_nodes(tree, "ShaderNodeOutputMaterial") if n.is_active_output), None)
    if output is None:
        return None
    closure = add_node(tree, kind)
    next(s for s in closure.inputs if s.type == "RGBA").default_value = (*chosen, 1.0)
    tree.links.new(closure.outputs[0], output.inputs["Surface"])
    return f"{material.name} is {kind}"


@edit
def delete_a_node(chance, scene):
    material = pick(chance, materials())
    kinds = ("ShaderNodeTexChecker", "ShaderNodeTexNoise", "ShaderNodeTexImage", "ShaderNodeMix", "ShaderNodeEmission")
    node = pick(chance, artists_nodes(material.node_tree, *kinds)) if material else None
    if node is None:
        return None
    name = node.name
    material.node_tree.nodes.remove(node)
    return f"{material.name}: {name} deleted"


@edit
def put_nodes_into_a_group(chance, scene):
    material = pick(chance, materials())
    socket = _colour_socket(chance, _closure(chance, material))
    chosen = colour(chance)
    if socket is None:
        return None
    tree = bpy.data.node_groups.new("artist's group", "ShaderNodeTree")
    tree.interface.new_socket("Color", in_out="OUTPUT", socket_type="NodeSocketColor")
    source, output = add_node(tree, "ShaderNodeRGB"), add_node(tree, "NodeGroupOutput")
    source.outputs[0].default_value = (*chosen, 1.0)
    tree.links.new(source.outputs[0], output.inputs[0])
    node = add_node(material.node_tree, "ShaderNodeGroup")
    node.node_tree = tree
    _plug(chance, node.outputs[0], socket)
    return f"{material.name}: a group on {socket.name}"


@edit
def keyframe_a_colour(chance, scene):
    material = pick(chance, materials())
    socket = _colour_socket(chance, _closure(chance, material))
    if socket is None or own_socket(socket).is_linked:
        return None
    own = own_socket(socket)
    for frame, chosen in ((1, colour(chance)), (10, colour(chance))):
        own.default_value = (*chosen, 1.0)
        own.keyframe_insert("default_value", frame=frame)
    return f"{material.name}: {socket.name} animated"


@edit
def new_material(chance, scene):
    thing, chosen = pick(chance, meshes(scene)), colour(chance)
    if thing is None:
        return None
    material = bpy.data.materials.new("fresh")
    material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (*chosen, 1.0)
    thing.data.materials.clear()
    thing.data.materials.append(material)
    return f"{thing.name} has {material.name} {chosen}"


@edit
def assign_another_material(chance, scene):
    thing, material = pick(chance, meshes(scene)), pick(chance, materials())
    if thing is None or material is None:
        return None
    thing.data.materials.clear()
    thing.data.materials.append(material)
    return f"{thing.name} has {material.name}"


@edit
def duplicate_a_material(chance, scene):
    material, thing = pick(chance, materials()), pick(chance, meshes(scene))
    if thing is None or material is None:
        return None
    copy = material.copy()
    thing.data.materials.append(copy)
    return f"{copy.name} copied from {material.name}"


@edit
def rename_a_material(chance, scene):
    material, number = pick(chance, materials()), chance.randint(1, 999)
    if material is None:
        return None
    before, material.name = material.name, f"named {number}"
    return f"{before} is {material.name}"


@edit
def delete_a_material(chance, scene):
    material = pick(chance, materials())
    if material is None or len(materials()) < 2:
        return None
    name = material.name
    bpy.data.materials.remove(material)
    return f"{name} deleted"


@edit
def delete_what_set_up_inserted(chance, scene):
    material = pick(chance, materials())
    socket = _colour_socket(chance, _closure(chance, material))
    if socket is None or not own_socket(socket).is_linked:
        return None
    own, tree = own_socket(socket), material.node_tree
    tree.links.remove(own.links[0])
    while socket.is_linked:
        tree.nodes.remove(socket.links[0].from_node)
    return f"{material.name}: cut off before {socket.name}"


@edit
def mute_a_node(chance, scene):
    material = pick(chance, materials())
    node = pick(chance, artists_nodes(material.node_tree)) if material else None
    if node is None:
        return None
    node.mute = not node.mute
    return f"{material.name}: {node.name} {'muted' if node.mute else 'unmuted'}"


@edit
def change_a_colour_in_a_group(chance, scene):
    groups = things(bpy.data.node_groups, lambda tree: tree.bl_idname == "ShaderNodeTree")
    tree, chosen = pick(chance, groups), colour(chance)
    node = pick(chance, artists_nodes(tree, *_CLOSURES, "ShaderNodeRGB", "ShaderNodeBsdfAnisotropic")) if tree else None
    if node is None:
        return None
    if node.bl_idname == "ShaderNodeRGB":
        node.outputs[0].default_value = (*chosen, 1.0)
    else:
        own_socket(next(s for s in node.inputs if s.type == "RGBA")).default_value = (*chosen, 1.0)
    return f"{tree.name}: {node.name} {chosen}"


@edit
def use_a_group_again(chance, scene):
    material = pick(chance, materials())
    groups = things(bpy.data.node_groups, lambda tree: tree.bl_idname == "ShaderNodeTree")
    tree = pick(chance, [g for g in groups if g.interface.items_tree and g.interface.items_tree[-1].in_out == "OUTPUT"])
    socket = _colour_socket(chance, _closure(chance, material))
    if tree is None or socket is None:
        return None
    node = add_node(material.node_tree, "ShaderNodeGroup")
    node.node_tree = tree
    if node.outputs[0].type == "SHADER":
        end = next((n for n in material.node_tree.nodes if n.type == "OUTPUT_MATERIAL"), None)
        socket = end and end.inputs["Surface"]
    if socket is not None:
        material.node_tree.links.new(node.outputs[0], own_socket(socket))
    return f"{material.name}: {tree.name} again"


@edit
def make_a_group_single(chance, scene):
    material = pick(chance, materials())
    node = pick(chance, artists_nodes(material.node_tree, "ShaderNodeGroup")) if material else None
    if node is None or node.node_tree is None or nodes.role(node):
        return None
    node.node_tree = node.node_tree.copy()
    return f"{material.name}: {node.node_tree.name} of its own"


@edit
def fill_with_a_volume(chance, scene):
    material, chosen = pick(chance, materials()), colour(chance)
    kind = chance.choice(["ShaderNodeVolumeAbsorption", "ShaderNodeVolumeScatter"])
    end = next(iter(artists_nodes(material.node_tree, "ShaderNodeOutputMaterial")), None) if material else None
    if end is None:
        return None
    volume = add_node(material.node_tree, kind)
    volume.inputs["Color"].default_value = (*chosen, 1.0)
    material.node_tree.links.new(volume.outputs[0], end.inputs["Volume"])
    return f"{material.name}: {kind} {chosen}"


@edit
def give_it_a_measured_spectrum(chance, scene):
    material, name = pick(chance, materials()), chance.choice(["ColorChecker: red", "ColorChecker: cyan"])
    socket = _colour_socket(chance, _closure(chance, material))
    if socket is None:
        return None
    spectrum = library.reflectance(name)
    tree = spectra.existing({"Color": spectrum}) or spectra.new_reflectance(spectrum)
    spectra.assign(material, socket, tree).name = f"measured {socket.name}"
    return f"{material.name}: {name} on {socket.name}"


@edit
def drive_a_colour(chance, scene):
    material = pick(chance, materials())
    socket = _colour_socket(chance, _closure(chance, material))
    if socket is None or own_socket(socket).is_linked:
        return None
    own_socket(socket).driver_add("default_value", 0).driver.expression = "frame / 20"
    return f"{material.name}: {socket.name} driven"
