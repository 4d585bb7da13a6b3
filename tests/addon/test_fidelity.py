"""A scene that is set up looks as it did: the preview, and one bounce under D65, against Blender's own RGB render."""

from pathlib import Path

import bpy
import numpy as np
import pytest
from dump import changes, dump
from fidelity import delta_E, rgb_render

from relume.addon.scene import render, setup, view_layers
from relume.core.model import bases

HERE = Path(bpy.utils.resource_path("LOCAL")) / "datafiles"
# For each pass Cycles makes a map of where light comes from, which takes seconds: three kinds of light in `make test`
OFTEN = ("interior", "night", "sunrise")
HDRIS = [
    pytest.param(path, id=path.stem, marks=[] if path.stem in OFTEN else pytest.mark.torture)
    for path in sorted((HERE / "studiolights/world").glob("*.exr"))
]


def colourful(scene):
    """Spheres of many closures in saturated colours; none lights another, or itself between its facets."""
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = 48
    scene.cycles.use_denoising = False
    scene.cycles.samples, scene.cycles.seed = 64, 1
    scene.cycles.use_adaptive_sampling = False  # stops where a picture's own noise says
    scene.view_settings.view_transform = "Standard"
    for name in ("Cube", "Plane"):
        bpy.data.objects.remove(bpy.data.objects[name])
    colors = [(0.8, 0.05, 0.05), (0.05, 0.6, 0.1), (0.05, 0.1, 0.7), (0.9, 0.7, 0.05), (0.6, 0.1, 0.7), (0.1, 0.7, 0.7)]
    kinds = [
        "ShaderNodeBsdfDiffuse",
        "ShaderNodeBsdfPrincipled",
        "ShaderNodeBsdfAnisotropic",
        "ShaderNodeBsdfSheen",
        "ShaderNodeBsdfToon",
        "ShaderNodeEmission",
    ]
    for index, (color, kind) in enumerate(zip(colors, kinds, strict=True)):
        bpy.ops.mesh.primitive_uv_sphere_add(location=(2.4 * (index % 3 - 1), 2.4 * (index // 3), 0))
        material = bpy.data.materials.new(kind)
        tree = material.node_tree
        tree.nodes.remove(tree.nodes["Principled BSDF"])
        node = tree.nodes.new(kind)
        (node.inputs.get("Base Color") or node.inputs["Color"]).default_value = (*color, 1.0)
        tree.links.new(node.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
        if kind == "ShaderNodeBsdfAnisotropic":
            node.distribution = "GGX"
        bpy.context.object.data.materials.append(material)
        if kind == "ShaderNodeEmission":
            bpy.context.object.visible_diffuse = bpy.context.object.visible_glossy = False
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.3, 0.5, 0.9, 1.0)
    bpy.data.lights["Light"].color = (1.0, 0.8, 0.6)
    return scene


@pytest.fixture
def spheres(startup):
    return colourful(startup)


def test_the_preview_is_the_original(spheres, tmp_path):
    plain = rgb_render(spheres, tmp_path)
    setup.set_up(spheres, bases.fitted(9))
    layers = view_layers.preview_layers(spheres)
    for layer in spheres.view_layers:
        layer.use = layer in layers
    spheres.cycles.seed = 1
    preview = rgb_render(spheres, tmp_path)
    assert delta_E(plain, plain[::-1]).mean() > 5, "the picture is colourful"
    assert delta_E(preview, plain).mean() < 0.5


@pytest.mark.parametrize("channels", [6, 9])
def test_one_bounce_under_daylight_is_the_original_everywhere(spheres, tmp_path, channels):
    spheres.cycles.max_bounces = 0
    spheres.render.resolution_x = spheres.render.resolution_y = 32
    spheres.cycles.samples = 2048  # Principled chooses its lobes by their colour: its noise is not the same
    spheres.relume.split_samples = False
    spheres.relume.same_seed = True
    spheres.cycles.light_sampling_threshold = 0.0
    bpy.data.lights["Light"].color = (1.0, 1.0, 1.0)  # a gel is a product of its own
    spheres.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.5, 0.5, 0.5, 1.0)
    plain = rgb_render(spheres, tmp_path)
    setup.set_up(spheres, bases.fitted(channels))
    image = render.render(spheres, tmp_path).image
    lit = render.picture(image, {row.name: row.light() for row in spheres.relume.light_groups})
    assert delta_E(lit, plain).max() < 0.3


@pytest.mark.parametrize("hdri", HDRIS)
def test_blenders_own_hdris_light_as_they_did(startup, tmp_path, hdri):
    world = startup.world.node_tree
    texture = world.nodes.new("ShaderNodeTexEnvironment")
    texture.image = bpy.data.images.load(str(hdri))
    world.links.new(texture.outputs["Color"], world.nodes["Background"].inputs["Color"])
    for name in ("Light", "Plane"):
        bpy.data.objects.remove(bpy.data.objects[name])
    startup.render.engine, startup.cycles.max_bounces, startup.cycles.samples = "CYCLES", 0, 128
    startup.cycles.use_adaptive_sampling = False
    startup.render.image_settings.file_format = "OPEN_EXR"  # Blender fills in what goes with it
    startup.relume.split_samples, startup.relume.same_seed = False, True
    bpy.data.objects["Cube"].active_material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (
        *(0.5, 0.5, 0.5),
        1.0,
    )
    before = dump()
    plain = rgb_render(startup, tmp_path)
    setup.set_up(startup, bases.fitted(6))
    image = render.render(startup, tmp_path).image
    lit = render.picture(image, {row.name: row.light() for row in startup.relume.light_groups})
    error = delta_E(lit, plain)
    assert np.median(error) < 0.01, "the sky itself"
    assert error.mean() < 0.3
    setup.remove(startup)
    assert changes(before) == []


ASSETS = sorted((HERE / "assets").rglob("*.blend")) + sorted(
    Path(bpy.utils.resource_path("LOCAL")).rglob("startup.blend")
)


@pytest.mark.parametrize("path", ASSETS, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_blenders_own_files_are_set_up_rendered_and_given_back(path, tmp_path):
    bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
    scene = bpy.context.scene
    for material in bpy.data.materials:
        if not material.is_grease_pencil:
            mesh = bpy.data.meshes.new(material.name)
            mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
            mesh.materials.append(material)
            scene.collection.objects.link(bpy.data.objects.new(material.name, mesh))
    if scene.camera is None:
        scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        scene.camera.location.z = 5.0
        scene.collection.objects.link(scene.camera)
    lamp = bpy.data.objects.new("lamp", bpy.data.lights.new("lamp", "SUN"))
    scene.collection.objects.link(lamp)
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.cycles.samples = 1
    scene.render.image_settings.file_format = "OPEN_EXR"  # Blender fills in what goes with it
    bpy.context.view_layer.update()
    before = dump()
    setup.set_up(scene, bases.fitted(6))
    image = render.render(scene, tmp_path).image
    assert np.isfinite(sum(image.groups.values())).all()
    setup.remove(scene)
    assert changes(before) == []
