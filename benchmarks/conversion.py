"""How long setting up and removing take, and how that grows.

`python -m relume.benchmarks.conversion [--materials N ...]`

Scenes are generated: every material has 25 nodes with an image texture behind a mix, a colour ramp, an emission and a
shared node group; a tenth are animated. What is timed is what the two buttons do, the factor model made beforehand as
it is once in a session.
"""

import argparse
import time

import bpy

from ..addon.scene import setup
from ..core.model import bases

_NODES = 25
_ANIMATED = 10  # one in so many materials


def _shared_group():
    group = bpy.data.node_groups.new("shared", "ShaderNodeTree")
    group.interface.new_socket("Color", in_out="INPUT", socket_type="NodeSocketColor")
    group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    source, diffuse, output = (
        group.nodes.new(kind) for kind in ("NodeGroupInput", "ShaderNodeBsdfDiffuse", "NodeGroupOutput")
    )
    group.links.new(source.outputs["Color"], diffuse.inputs["Color"])
    group.links.new(diffuse.outputs[0], output.inputs["Shader"])
    return group


def _material(index: int, group, image):
    material = bpy.data.materials.new(f"material {index}")
    tree = material.node_tree
    principled = tree.nodes["Principled BSDF"]
    shared, mixed, add, emission, ramp, mix, texture = (
        tree.nodes.new(kind)
        for kind in (
            "ShaderNodeGroup",
            "ShaderNodeMixShader",
            "ShaderNodeAddShader",
            "ShaderNodeEmission",
            "ShaderNodeValToRGB",
            "ShaderNodeMixRGB",
            "ShaderNodeTexImage",
        )
    )
    shared.node_tree, texture.image = group, image
    for source, target in (
        (texture.outputs["Color"], mix.inputs["Color1"]),
        (ramp.outputs["Color"], mix.inputs["Color2"]),
        (mix.outputs["Color"], principled.inputs["Base Color"]),
        (texture.outputs["Color"], shared.inputs["Color"]),
        (shared.outputs["Shader"], mixed.inputs[1]),
        (emission.outputs[0], mixed.inputs[2]),
        (principled.outputs[0], add.inputs[0]),
        (mixed.outputs[0], add.inputs[1]),
        (add.outputs[0], tree.nodes["Material Output"].inputs["Surface"]),
    ):
        tree.links.new(source, target)
    principled.inputs["Coat Weight"].default_value = 0.5
    principled.inputs["Coat Tint"].default_value = (0.9, 0.7, 0.5, 1.0)
    if index % _ANIMATED == 0:
        tree.keyframe_insert(emission.inputs["Color"].path_from_id("default_value"), frame=1)
    while len(tree.nodes) < _NODES:
        tree.nodes.new("ShaderNodeMath")
    return material


def _copy(material, index: int):
    """Another material like it: to build each anew takes Blender a look at the whole file for each of its links."""
    copied = material.copy()
    copied.name = f"material {index}"
    if copied.node_tree.animation_data:
        copied.node_tree.animation_data.action = copied.node_tree.animation_data.action.copy()
    return copied


def generate(materials: int, is_new: bool = True):
    """A scene with one object for every material. is_new: the file is read anew before, without any add-on."""
    if is_new:
        bpy.ops.wm.read_factory_settings()
    scene = bpy.context.scene
    scene.relume.channels = "9"
    cube, group, image = bpy.data.objects["Cube"], _shared_group(), bpy.data.images.new("image", 8, 8)
    kinds = [_material(index, group, image) for index in range(min(materials, 2))]  # animated, and not
    for index in range(materials):
        mesh = cube.data.copy()
        mesh.materials[0] = kinds[index] if index < len(kinds) else _copy(kinds[index % _ANIMATED > 0], index)
        scene.collection.objects.link(bpy.data.objects.new(f"object {index}", mesh))
    bpy.data.objects.remove(cube)
    return scene


def _seconds(what, scene) -> tuple[float, float]:
    """Seconds by the clock, and of the processor: on a busy machine only the second says anything."""
    began, worked = time.perf_counter(), time.process_time()
    what(scene)
    return time.perf_counter() - began, time.process_time() - worked


def main(argv: list[str] | None = None):
    parser = argparse.ArgumentParser(prog="python -m relume.benchmarks.conversion", description=__doc__)
    parser.add_argument("--materials", type=int, nargs="+", default=[1, 10, 100, 500, 1000, 2000], metavar="N")
    arguments = parser.parse_args(argv)

    from .. import register

    register()
    setup.set_up(generate(1), bases.fitted(9))
    print(f"{'':>18}{'set up':>22}{'remove':>22}")
    print(f"{'materials':>9}{'nodes':>9}" + f"{'clock':>11}{'processor':>11}" * 2)
    for count in arguments.materials:
        scene = generate(count)
        nodes = sum(len(m.node_tree.nodes) for m in bpy.data.materials if m.users)
        taken = [*_seconds(setup.set_up, scene), *_seconds(setup.remove, scene)]
        print(f"{count:>9}{nodes:>9}" + "".join(f"{seconds:>9.3f} s" for seconds in taken), flush=True)


if __name__ == "__main__":
    main()
