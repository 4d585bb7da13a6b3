"""Linked data that is made local on request, and becomes spectral."""

import bpy
import pytest

from relume.addon.graph import nodes
from relume.addon.scene import linked, setup
from relume.addon.store import remarks
from relume.core.model import bases


@pytest.fixture(scope="module")
def library(relume, tmp_path_factory):
    """A .blend with an object whose material has a colour in a node group, a lamp, and a collection of both."""
    path = tmp_path_factory.mktemp("library") / "library.blend"
    bpy.ops.wm.read_factory_settings(use_empty=True)
    group = bpy.data.node_groups.new("paint", "ShaderNodeTree")
    group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    shader, end = group.nodes.new("ShaderNodeBsdfDiffuse"), group.nodes.new("NodeGroupOutput")
    shader.inputs["Color"].default_value = (0.7, 0.1, 0.1, 1.0)
    group.links.new(shader.outputs[0], end.inputs[0])
    material = bpy.data.materials.new("painted")
    if material.node_tree is None:
        material.use_nodes = True
    use = material.node_tree.nodes.new("ShaderNodeGroup")
    use.node_tree = group
    material.node_tree.links.new(use.outputs[0], material.node_tree.nodes["Material Output"].inputs["Surface"])
    mesh = bpy.data.meshes.new("sheet")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    mesh.materials.append(material)
    lamp = bpy.data.lights.new("bulb", "POINT")
    lamp.color = (1.0, 0.4, 0.2)
    collection = bpy.data.collections.new("set")
    for name, data in (("sheet", mesh), ("bulb", lamp)):
        collection.objects.link(bpy.data.objects.new(name, data))
    bpy.context.scene.collection.children.link(collection)
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def link_objects(scene, found):
    found.objects = ["sheet", "bulb"]
    return lambda: [scene.collection.objects.link(thing) for thing in found.objects]


def link_a_collection(scene, found):
    found.collections = ["set"]

    def show():
        thing = bpy.data.objects.new("set", None)
        thing.instance_type, thing.instance_collection = "COLLECTION", found.collections[0]
        scene.collection.objects.link(thing)

    return show


def link_a_material(scene, found):
    found.materials = ["painted"]
    return lambda: bpy.data.objects["Cube"].data.materials.__setitem__(0, found.materials[0])


def override_a_material(scene, found):
    found.materials = ["painted"]
    return lambda: bpy.data.objects["Cube"].data.materials.__setitem__(0, found.materials[0].override_create())


def complaints(scene) -> set[str]:
    return {remark.owner for remark in remarks.of(scene) if "Make it local" in remark.why}


@pytest.mark.parametrize("bring", [link_objects, link_a_collection, link_a_material, override_a_material])
def test_what_is_made_local_is_spectral(library, startup, bring):
    with bpy.data.libraries.load(str(library), link=True) as (_, found):
        show = bring(startup, found)
    show()
    setup.set_up(startup, bases.fitted(6))
    assert "painted" in complaints(startup)
    assert bpy.ops.relume.make_local() == {"FINISHED"}
    assert complaints(startup) == set()
    shown = [material for material in bpy.data.materials if material.library is None and "painted" in material.name]
    (group,) = {node.node_tree for m in shown for node in m.node_tree.nodes if node.type == "GROUP"}
    assert [nodes.role(node) for node in group.nodes if nodes.role(node)] == ["upsample"]
    assert linked.make_local(startup) == []
    setup.remove(startup)
    assert not any(nodes.role(node) for node in group.nodes)
