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
