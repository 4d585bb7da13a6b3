"""Spectra below 0: what emission, worlds and volumes carry, and what surfaces do not."""

import bpy
import numpy as np
import pytest
from test_palette import striped

from relume.addon.graph import spectra
from relume.addon.scene import render, setup
from relume.core import Light, Spectrum, palette
from relume.core.model import bases, upsample
from relume.core.spectra import library
from relume.core.spectra.spectrum import WAVELENGTHS

LIGHT, GLOW = library.illuminant("D65"), library.illuminant("A")


@pytest.fixture(scope="module")
def black():
    """A metameric black: invisible times D65, red times A; negative in places."""
    lights = (palette.Entry("D65", LIGHT), palette.Entry("A", GLOW))
    cells = (palette.Cell(0, 0, (0, 0, 0)), palette.Cell(0, 1, (0.2, 0.12, 0.03)))
    criteria = palette.Criteria(bounded=False, model=bases.fitted(9), model_error=1.0)
    design = palette.Palette(lights, (palette.Entry("smoke", designed=True),), cells, criteria=criteria)
    spectrum = palette.create(design).palette.reflectances[0].spectrum
    assert spectrum.values.min() < -0.1 and (bases.fitted(9).coefficients(spectrum) < 0).any()
    return spectrum


def rendered(scene, folder):
    """Coefficients (p,) of the middle of the first stripe, all light groups together, and their model."""
    setup.set_up(scene, bases.fitted(9))
    image = render.render(scene, folder).image
    return sum(image.groups.values())[2:6, 2:6].mean(axis=(0, 1)), image.model


def emitting(material, spectrum):
    tree = material.node_tree
    glow, output = tree.nodes.new("ShaderNodeEmission"), tree.nodes["Material Output"]
    tree.links.new(glow.outputs[0], output.inputs["Surface"])
    spectra.assign(material, glow.inputs["Color"], spectra.new_reflectance(spectrum))


def test_emission_that_is_seen_keeps_what_is_negative(tmp_path, black):
    scene, materials = striped(1)
    emitting(materials[0], black)
    shown, model = rendered(scene, tmp_path)
    np.testing.assert_allclose(shown, model.coefficients(black), atol=1e-4)
    # So it is invisible in one light and glows in the other
    assert np.abs(model.relight(LIGHT) @ shown).max() < 1e-3
    assert (model.relight(GLOW) @ shown)[1] == pytest.approx(0.12, abs=5e-3)


def test_light_of_emission_keeps_what_is_negative(tmp_path, black):
    """What it lights is darker by it: transport is linear in what shines."""
    scene, materials = striped(1)
    mesh = bpy.data.meshes.new("lamp")
    mesh.from_pydata([(-3, -3, 2), (-3, 4, 2), (4, 4, 2), (4, -3, 2)], [], [(0, 1, 2, 3)])
    lamp = bpy.data.objects.new("lamp", mesh)
    mesh.materials.append(bpy.data.materials.new("lamp"))
    emitting(mesh.materials[0], black)
    lamp.visible_camera = False
    scene.collection.objects.link(lamp)
    bpy.data.lights["sun"].energy = 0.0
    scene.cycles.samples = 256
    shown, model = rendered(scene, tmp_path)
    wanted = model.coefficients(black)
    share = shown[np.argmax(wanted)] / wanted.max()
    assert share > 0.1
    np.testing.assert_allclose(shown / share, wanted, atol=0.05 * wanted.max())


def test_emission_of_a_volume_keeps_what_is_negative(tmp_path, black):
    scene, _ = striped(1)
    bpy.ops.mesh.primitive_cube_add(size=1.0, location=(0.5, 0.5, 0.5))
    box = bpy.context.object
    material = bpy.data.materials.new("smoke")
    tree = material.node_tree
    tree.nodes.clear()
    glow, output = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(glow.outputs[0], output.inputs["Volume"])
    box.data.materials.append(material)
    scene.camera.location.z = 3.0
    bpy.data.lights["sun"].energy = 0.0
    scene.cycles.samples = 64
    spectra.assign(material, glow.inputs["Color"], spectra.new_reflectance(black))
    shown, model = rendered(scene, tmp_path)
    wanted = model.coefficients(black)
    np.testing.assert_allclose(shown, wanted, atol=0.02 * np.abs(wanted).max())


def test_a_surface_shows_nothing_of_it_and_says_so(tmp_path, black):
    scene, materials = striped(1)
    socket = materials[0].node_tree.nodes["Diffuse BSDF"].inputs["Color"]
    spectra.assign(materials[0], socket, spectra.new_reflectance(black))
    shown, model = rendered(scene, tmp_path)
    np.testing.assert_allclose(shown, np.maximum(model.coefficients(black), 0), atol=1e-4)
    assert (model.relight(LIGHT) @ shown)[1] > 0.1, "it is plain to see where it should be black"
    assert "coefficients below 0 render as 0" in palette.beyond(black)


def test_a_spectrum_from_a_file_is_told(tmp_path, capfd):
    bpy.ops.wm.read_factory_settings()
    bpy.context.view_layer.objects.active = bpy.data.objects["Cube"]
    place = {"node": "Principled BSDF", "socket": "Base Color", "takes": "reflectance"}
    path = tmp_path / "odd.csv"
    path.write_text("400,0.1\n500,0.2\n600,1.4\n700,0.2\n")
    assert bpy.ops.relume.assign_spectrum_file(filepath=str(path), **place) == {"FINISHED"}
    assert "more than falls on it" in capfd.readouterr().out
    path.write_text("400,0.1\n500,0.2\n600,-0.3\n700,0.2\n")  # nothing that was measured is so
    with pytest.raises(RuntimeError, match="line 3: -0.3 is outside the range of reflectance"):
        bpy.ops.relume.assign_spectrum_file(filepath=str(path), **place)


def test_a_light_below_0_is_what_recombination_makes_of_it(tmp_path):
    """A light that takes red away: nothing shines like it, but the picture of it is exact."""
    scene, materials = striped(1)
    paint = library.reflectance("ColorChecker: red")
    spectra.assign(
        materials[0], materials[0].node_tree.nodes["Diffuse BSDF"].inputs["Color"], spectra.new_reflectance(paint)
    )
    power = LIGHT.sampled() / 100
    light = Spectrum(WAVELENGTHS, power - 1.3 * (WAVELENGTHS > 600), "no red", "illuminant")
    setup.set_up(scene, bases.fitted(12))
    image = render.render(scene, tmp_path).image
    rgb = render.picture(image, dict.fromkeys(image.groups, Light(light)))
    shown = rgb.reshape(8, -1, 8, 3)[2:6, :, 2:6].mean(axis=(0, 2)) @ upsample.rgb_to_xyz().T
    truth = (light.sampled() * paint.sampled()) @ library.observer() / (light.sampled() @ library.observer()[:, 1])
    np.testing.assert_allclose(shown[0] / shown[1, 1], truth, atol=0.01)
    assert "the viewport shows at least 0" in palette.beyond(light)
