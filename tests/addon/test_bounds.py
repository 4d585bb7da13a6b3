"""Colours outside 0..1, and what cannot be RGB's picture even without bounces: the same, or reported."""

import bpy
import pytest
from fidelity import delta_E, rgb_render

from relume.addon.graph import closures, nodes
from relume.addon.scene import render, setup
from relume.addon.store import remarks
from relume.core.model import bases


@pytest.fixture
def sphere(startup):
    """A sphere in white and grey light, without bounces; returns its scene."""
    startup.render.engine, startup.cycles.max_bounces, startup.cycles.samples = "CYCLES", 0, 512
    startup.cycles.use_adaptive_sampling, startup.cycles.light_sampling_threshold = False, 0.0
    startup.relume.split_samples, startup.relume.same_seed = False, True
    startup.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.5, 0.5, 0.5, 1.0)
    bpy.data.lights["Light"].color = (1.0, 1.0, 1.0)
    for name in ("Cube", "Plane"):
        bpy.data.objects.remove(bpy.data.objects[name])
    bpy.ops.mesh.primitive_uv_sphere_add(radius=2.0)
    bpy.ops.object.shade_smooth()
    bpy.context.object.data.materials.append(bpy.data.materials.new("surface"))
    return startup


def surface(kind: str, values: dict):
    """The tree of the sphere's material, and its closure."""
    tree = bpy.data.materials["surface"].node_tree
    node = tree.nodes["Principled BSDF"] if kind == "ShaderNodeBsdfPrincipled" else tree.nodes.new(kind)
    tree.links.new(node.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    for name, value in values.items():
        node.inputs[name].default_value = value
    return tree, node


def color_of(node):
    return node.inputs.get("Base Color") or node.inputs["Color"]


def worst(scene, folder) -> float:
    """ΔE2000 of the spectral render under D65 to Blender's own, 98th percentile."""
    plain = rgb_render(scene, folder)
    setup.set_up(scene, bases.fitted(9))
    image = render.render(scene, folder).image
    lit = render.picture(image, {row.name: row.light() for row in scene.relume.light_groups})
    return sorted(delta_E(lit, plain).ravel())[int(0.98 * lit[..., 0].size)]


# Cycles makes up for light that a rough metal loses between its facets by a law that is not linear in the colour
@pytest.mark.parametrize(
    ("kind", "values", "noticed"),
    [
        ("ShaderNodeBsdfDiffuse", {}, 0.01),
        ("ShaderNodeBsdfTranslucent", {}, 0.01),
        ("ShaderNodeEmission", {}, 0.01),
        ("ShaderNodeBsdfPrincipled", {}, 0.3),
        ("ShaderNodeBsdfPrincipled", {"Metallic": 1.0}, 1.0),
    ],
)
def test_a_normal_shown_as_a_colour_is_the_original(sphere, tmp_path, kind, values, noticed):
    tree, closure = surface(kind, values)
    geometry = tree.nodes.new("ShaderNodeNewGeometry")  # half of what it gives is below 0
    tree.links.new(geometry.outputs["Normal"], color_of(closure))
    assert worst(sphere, tmp_path) < noticed


@pytest.mark.parametrize(
    ("kind", "values", "noticed"),
    [
        ("ShaderNodeBsdfDiffuse", {}, 0.01),
        ("ShaderNodeEmission", {}, 0.01),
        ("ShaderNodeBsdfPrincipled", {}, 0.3),
        ("ShaderNodeBsdfPrincipled", {"Metallic": 1.0}, 1.0),
        ("ShaderNodeBsdfMetallic", {"Edge Tint": (1.0, 1.0, 1.0, 1.0)}, 1.0),
    ],
)
def test_a_colour_above_one_is_the_original(sphere, tmp_path, kind, values, noticed):
    _, closure = surface(kind, values)
    color_of(closure).default_value = (4.0, 0.2, 0.1, 1.0)
    assert worst(sphere, tmp_path) < noticed


def test_a_colour_in_a_mix_keeps_its_negative_part(sphere):
    tree, closure = surface("ShaderNodeBsdfDiffuse", {})
    assert closures.bounds_of(color_of(closure)) == closures.Bounds.POSITIVE
    mix = tree.nodes.new("ShaderNodeMix")
    mix.data_type = "RGBA"
    assert closures.bounds_of(nodes.mixed(mix, "A")) == closures.Bounds.NONE


def test_deep_coloured_light_is_named_and_a_warm_lamp_is_not(sphere):
    def named() -> list[str]:
        setup.set_up(sphere, bases.fitted(9))
        return [remark.owner for remark in remarks.of(sphere) if "deeply coloured" in remark.why]

    bpy.data.lights["Light"].color = (1.0, 0.85, 0.7)
    assert named() == []
    setup.remove(sphere)
    bpy.data.lights["Light"].color = (1.0, 0.1, 0.05)
    assert named() == ["Light"]
    setup.remove(sphere)
    sphere.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.05, 0.2, 1.0, 1.0)
    bpy.data.lights["Light"].color = (1.0, 1.0, 1.0)
    assert named() == [sphere.world.name]


def test_a_surface_outside_rec709_is_told(sphere):
    _, closure = surface("ShaderNodeBsdfDiffuse", {"Color": (0.0, 1.0, 0.0, 1.0)})
    setup.set_up(sphere, bases.fitted(9))
    assert remarks.of(sphere) == []
    setup.remove(sphere)
    bpy.ops.wm.set_working_color_space(working_space="Linear Rec.2020", convert_colors=False)
    setup.set_up(sphere, bases.fitted(9))
    (remark,) = remarks.of(sphere)
    assert (remark.owner, remark.node) == ("surface", closure.name) and "outside Rec.709" in remark.why
