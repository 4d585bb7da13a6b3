"""Every input of every shader node of the Blender that runs this is classified."""

import bpy
import pytest

from relume.addon.graph import closures


def all_nodes():
    """A node of every type that Blender itself registers for shaders, in a material."""
    bpy.ops.wm.read_factory_settings()
    tree = bpy.data.materials.new("every node").node_tree
    # dir() makes Blender give every type, also those that no file has used yet
    types = [getattr(bpy.types, name) for name in dir(bpy.types)]
    kinds = {cls.bl_rna.identifier for cls in types if isinstance(cls, type) and issubclass(cls, bpy.types.ShaderNode)}
    assert len(kinds) > 80
    return [tree.nodes.new(kind) for kind in sorted(kinds - {"ShaderNode", "ShaderNodeCustomGroup"})]


def closures_of_blender():
    return [n for n in all_nodes() if any(s.type == "SHADER" for s in n.outputs)]


def test_every_input_of_every_closure_is_classified():
    nodes = closures_of_blender()
    assert len(nodes) > 20
    for node in nodes:
        if node.bl_idname in {"ShaderNodeGroup", "ShaderNodeScript"}:
            continue
        for socket in node.inputs:
            places = [
                socket.identifier in closures.SPECTRAL.get(node.bl_idname, {}),
                socket.identifier in closures.CANNOT,
                socket.identifier in closures.NOT_SPECTRAL and (node.bl_idname, socket.identifier) not in TWO_MEANINGS,
            ]
            assert sum(places) == 1, f"{node.bl_idname}: input {socket.identifier!r} is classified {sum(places)} times"


TWO_MEANINGS = {("ShaderNodeBsdfMetallic", "IOR")}  # a vector there, one number in every other closure


def test_the_classification_names_nothing_that_blender_lacks():
    found = {node.bl_idname: {socket.identifier for socket in node.inputs} for node in closures_of_blender()}
    for kind, inputs in closures.SPECTRAL.items():
        assert inputs.keys() <= found[kind], kind


def test_no_colour_of_a_closure_is_left_out():
    for node in closures_of_blender():
        colors = {s.identifier for s in node.inputs if s.type == "RGBA" and s.identifier not in closures.CANNOT}
        if node.type not in {"GROUP", "SCRIPT"}:
            assert colors <= closures.SPECTRAL.get(node.bl_idname, {}).keys(), node.bl_idname


@pytest.mark.parametrize(
    ("kind", "mode", "expected"),
    [
        ("ShaderNodeBsdfMetallic", {"fresnel_type": "F82"}, ["Base Color", "Edge Tint"]),
        ("ShaderNodeBsdfMetallic", {"fresnel_type": "PHYSICAL_CONDUCTOR"}, ["IOR", "Extinction"]),
        ("ShaderNodeBsdfHairPrincipled", {"parametrization": "COLOR"}, ["Color"]),
        ("ShaderNodeBsdfHairPrincipled", {"parametrization": "ABSORPTION"}, ["Absorption Coefficient"]),
        ("ShaderNodeBsdfHairPrincipled", {"parametrization": "MELANIN"}, ["Tint"]),
        ("ShaderNodeBsdfHairPrincipled", {"model": "HUANG", "parametrization": "COLOR"}, ["Color"]),
        ("ShaderNodeMixShader", {}, []),
        ("ShaderNodeMix", {"data_type": "RGBA"}, []),
    ],
)
def test_spectral_sockets_follow_the_mode_of_a_node(startup, kind, mode, expected):
    tree = bpy.data.materials.new("one").node_tree
    node = tree.nodes.new(kind)
    for name, value in mode.items():
        setattr(node, name, value)
    tree.update_tag()
    bpy.context.view_layer.update()
    assert [socket.identifier for socket in closures.spectral_sockets(node)] == expected
