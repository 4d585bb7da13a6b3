"""Edits of compositing that is the artist's own."""

import bpy

from relume.addon.graph import nodes

from . import kinds
from .kinds import add_node, artists_nodes, edit, own_layers, pick


def _own_tree(scene):
    kinds.pause()  # what Relume added there follows the edit before
    tree = scene.compositing_node_group
    return tree if tree is not None and tree.library is None and not tree.get(nodes.ROLE) else None


def _shown(chance, tree, scene):
    """A Render Layers node of this scene."""
    found = artists_nodes(tree, "CompositorNodeRLayers") if tree else []
    return pick(chance, [node for node in found if node.scene == scene])


def _picture(render):
    """What a Render Layers node gives as its picture: while the scene is set up, what Relume makes of it."""
    image = render.outputs["Image"]
    for link in render.outputs["Alpha"].links:
        if nodes.role(link.to_node) == "recombination":
            image = link.to_node.outputs["Image"]
            denoised = [k.to_node for k in image.links if "relume_added" in k.to_node and k.to_node.type == "DENOISE"]
            image = denoised[0].outputs["Image"] if denoised else image
    return image


@edit
def new_compositing(chance, scene):
    tree = bpy.data.node_groups.new("own compositing", "CompositorNodeTree")
    tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    render, end = add_node(tree, "CompositorNodeRLayers"), add_node(tree, "NodeGroupOutput")
    render.scene, render.layer = scene, own_layers(scene)[0].name
    tree.links.new(render.outputs["Image"], end.inputs[0])
    scene.compositing_node_group = tree
    return tree.name


@edit
def no_compositing(chance, scene):
    if _own_tree(scene) is None:
        return None
    scene.compositing_node_group = None
    return "no compositing"


@edit
def blur_in_the_compositor(chance, scene):
    tree = _own_tree(scene)
    output = next(iter(artists_nodes(tree, "NodeGroupOutput")), None) if tree else None
    if output is None or not output.inputs[0].is_linked:
        return None
    blur = add_node(tree, "CompositorNodeBlur")
    source = output.inputs[0].links[0].from_socket
    tree.links.new(source, blur.inputs["Image"])
    tree.links.new(blur.outputs["Image"], output.inputs[0])
    return "a blur"


@edit
def tint_with_a_pass(chance, scene):
    tree, layer = _own_tree(scene), own_layers(scene)[0]
    render = _shown(chance, tree, scene)
    end = next(iter(artists_nodes(tree, "NodeGroupOutput")), None) if tree else None
    if render is None or end is None:
        return None
    layer.use_pass_diffuse_color = True
    kinds.pause()  # until then the node shows no such pass
    mix = add_node(tree, "ShaderNodeMix")
    mix.data_type, mix.blend_type = "RGBA", "MULTIPLY"
    a, b = (next(s for s in mix.inputs if s.name == n and s.type == "RGBA") for n in "AB")
    render.layer = render.layer
    passes = [s for s in render.outputs if s.name == "Diffuse Color"]
    tree.links.new(_picture(render), a)
    if passes:
        tree.links.new(passes[0], b)
    tree.links.new(next(s for s in mix.outputs if s.type == "RGBA"), end.inputs[0])
    return "tinted with Diffuse Color" if passes else "no Diffuse Color to tint with"


@edit
def another_render_layers_node(chance, scene):
    tree, layer = _own_tree(scene), pick(chance, own_layers(scene))
    end = next(iter(artists_nodes(tree, "NodeGroupOutput")), None) if tree else None
    if end is None:
        return None
    render = add_node(tree, "CompositorNodeRLayers")
    render.scene, render.layer = scene, layer.name
    tree.links.new(render.outputs["Image"], end.inputs[0])
    return f"shows layer {layer.name}"


@edit
def delete_a_render_layers_node(chance, scene):
    tree = _own_tree(scene)
    render = _shown(chance, tree, scene)
    if render is None:
        return None
    tree.nodes.remove(render)
    return "a Render Layers node deleted"


@edit
def see_it_in_a_viewer(chance, scene):
    tree = _own_tree(scene)
    render = _shown(chance, tree, scene)
    if render is None:
        return None
    viewer = add_node(tree, "CompositorNodeViewer")
    tree.links.new(_picture(render), viewer.inputs["Image"])
    return "a viewer"


@edit
def two_scenes_use_one_compositing(chance, scene):
    other = pick(chance, sorted((s for s in bpy.data.scenes if s != scene and not s.library), key=lambda s: s.name))
    if other is None or _own_tree(scene) is None:
        return None
    other.compositing_node_group = scene.compositing_node_group
    return f"{other.name} uses {scene.compositing_node_group.name}"
