"""AOVs that carry what each pixel sees first, negatives and all, and are left out where nobody asks."""

import bpy
import numpy as np
import pytest
from test_palette import striped

from relume.addon.graph import spectra
from relume.addon.scene import render, setup, surfaces
from relume.core import Spectrum, palette
from relume.core.errors import CoefficientImageError
from relume.core.model import bases
from relume.core.picture import coefficients
from relume.core.spectra import library
from relume.core.spectra.spectrum import WAVELENGTHS

RED = library.reflectance("ColorChecker: red")
BLACK = Spectrum(WAVELENGTHS, np.sin(WAVELENGTHS / 40) - 0.2, "black")


@pytest.fixture
def scene():
    """A red stripe, one below 0, and a white one."""
    scene, materials = striped(2)
    for material, spectrum in zip(materials, (RED, BLACK), strict=False):
        socket = material.node_tree.nodes["Diffuse BSDF"].inputs["Color"]
        spectra.assign(material, socket, spectra.new_reflectance(spectrum))
    setup.set_up(scene, bases.fitted(9))
    return scene


def stripe(values, index):
    return values.reshape(8, -1, 8, values.shape[-1])[2:6, index, 2:6].mean(axis=(0, 1))


def test_surfaces_are_carried_with_what_is_negative(scene, tmp_path):
    assert render.render(scene, tmp_path).surface is None
    assert surfaces.add(scene) == []
    done = render.render(scene, tmp_path)
    model = done.image.model
    np.testing.assert_allclose(stripe(done.surface, 0), model.coefficients(RED), atol=1e-5)
    np.testing.assert_allclose(stripe(done.surface, 1), model.coefficients(BLACK), atol=1e-5)
    assert stripe(done.surface, 1).min() < -0.5
    np.testing.assert_allclose(stripe(done.surface, 2), 1, atol=1e-5)


def test_a_reflectance_is_tried_on_as_it_renders(scene, tmp_path):
    surfaces.add(scene)
    done = render.render(scene, tmp_path)
    green, model = library.reflectance("ColorChecker: green"), done.image.model
    light = sum(done.image.groups.values())
    tried = palette.try_on(light, done.surface, model.coefficients(RED), model.coefficients(green))
    tree = next(tree for tree in bpy.data.node_groups if tree.name.startswith(RED.name))
    spectra.replace(tree, green)
    truth = sum(render.render(scene, tmp_path).image.groups.values())
    np.testing.assert_allclose(stripe(tried.coefficients, 0), stripe(truth, 0), rtol=1e-3)


def test_they_are_taken_away_again(scene, tmp_path):
    def traces():
        nodes = [node.bl_idname for material in bpy.data.materials for node in material.node_tree.nodes]
        return [layer.name for layer in scene.view_layers if len(layer.aovs)], nodes.count("ShaderNodeOutputAOV")

    surfaces.add(scene)
    surfaces.add(scene)
    assert traces() == (["ViewLayer 1", "ViewLayer 2", "ViewLayer 3"], 3), "once each"
    surfaces.remove(scene)
    assert traces() == ([], 0)
    surfaces.add(scene)
    setup.remove(scene)
    assert traces() == ([], 0), "and with the set-up"
    setup.set_up(scene, bases.fitted(6))
    with pytest.raises(CoefficientImageError, match="no such file"):
        surfaces.read(tmp_path / "passes.exr", scene)


def test_a_principled_surface_is_carried_with_its_own_colour(tmp_path):
    """And not with the radius of a subsurface that it does not have, which set-up converts too."""
    scene, materials = striped(1)
    tree = materials[0].node_tree
    principled = tree.nodes.new("ShaderNodeBsdfPrincipled")
    tree.links.new(principled.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    setup.set_up(scene, bases.fitted(9))
    surfaces.add(scene)
    np.testing.assert_allclose(stripe(render.render(scene, tmp_path).surface, 0), 0.8, atol=1e-5)
    assert surfaces.mirrors(materials[0]) and not surfaces.mirrors(materials[1])


def test_a_cryptomatte_says_which_material(scene, tmp_path):
    assert surfaces.ask(scene, True) == [] and surfaces.carried(scene)
    width, height = scene.render.resolution_x, scene.render.resolution_y
    assert surfaces.cost(scene) == 16 * width * height * 4, "three AOVs and a Cryptomatte"
    bpy.context.scene.render.filepath = str(tmp_path / "render.exr")
    output = scene.render.image_settings
    output.media_type, output.file_format = "MULTI_LAYER_IMAGE", "OPEN_EXR_MULTILAYER"
    bpy.ops.render.render(write_still=True)
    found = surfaces.read_materials(tmp_path / "render.exr", scene)
    assert set(found) == {"stripe 0", "stripe 1", "stripe 2"}
    for index in range(3):
        part = found[f"stripe {index}"][..., None]
        assert stripe(part, index).min() == 1 and stripe(part, (index + 1) % 3).max() == 0
    setup.remove(scene)
    setup.set_up(scene, bases.fitted(6))
    assert surfaces.asked(scene) and surfaces.carried(scene), "what was asked for is there again"
    surfaces.ask(scene, False)
    assert not surfaces.carried(scene) and not surfaces.asked(scene)
    layers = [layer for layer in scene.view_layers if layer.use]
    assert not any(layer.use_pass_cryptomatte_material for layer in layers)
    with pytest.raises(CoefficientImageError, match="no Cryptomatte"):
        coefficients.read_materials(tmp_path / "render.exr", "ViewLayer 7")


def test_a_set_up_that_follows_the_scene_keeps_them(scene):
    artists = scene.view_layers[0]
    surfaces.ask(scene, True)
    bpy.data.objects["stripe 2"].data.materials[0] = bpy.data.materials.new("new")
    setup.update(scene)
    surfaces.follow(scene)
    first = next(layer for layer in scene.view_layers if layer.use)
    assert surfaces.carried(scene) and first.use_pass_cryptomatte_material
    nodes = bpy.data.materials["new"].node_tree.nodes
    assert [node.aov_name for node in nodes if node.type == "OUTPUT_AOV"] == [surfaces.AOV]
    surfaces.ask(scene, False)
    setup.update(scene)
    assert not surfaces.carried(scene)
    setup.remove(scene)
    assert not artists.use_pass_cryptomatte_material and not len(artists.aovs) and artists.use
