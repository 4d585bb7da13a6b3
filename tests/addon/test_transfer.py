"""Spectral transfer functions: ranges of a volume's values with spectra, rendered and edited."""

import bpy
import numpy as np
import pytest
from dump import differences, dump

from relume.addon.graph import spectra, transfer
from relume.addon.scene import render, setup
from relume.core.model import bases
from relume.core.picture.coefficients import to_xyz
from relume.core.picture.mix import Light
from relume.core.spectra import library
from relume.core.spectra.spectrum import WAVELENGTHS, Spectrum

NAMES = ("red", "green", "blue")


def group(name):
    spectrum = library.reflectance(f"ColorChecker: {name}")
    return spectra.existing({"Color": spectrum}) or spectra.new_reflectance(spectrum)


@pytest.fixture
def block():
    """A shining block of three slabs side by side, whose value grows from left to right; nothing else shines."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.world = None
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y, scene.cycles.samples = 12, 4, 16
    scene.cycles.use_denoising, scene.cycles.volume_biased = False, True
    bpy.ops.mesh.primitive_cube_add(size=2)
    material = bpy.data.materials.new("volume")
    bpy.context.object.data.materials.append(material)
    own = material.node_tree
    own.nodes.clear()
    place, split = own.nodes.new("ShaderNodeTexCoord"), own.nodes.new("ShaderNodeSeparateXYZ")
    own.links.new(place.outputs["Generated"], split.inputs[0])
    tree = transfer.new()
    for index, name in enumerate(NAMES):
        transfer.add_range(tree, index / 3, (index + 1) / 3, group(name), 20.0)
    transfer.attach(material, tree, split.outputs["X"])
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", 2.0
    camera.location, camera.rotation_euler = (0, -5, 0), (np.pi / 2, 0, 0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    bpy.context.view_layer.update()
    return scene


def test_each_range_has_the_colour_of_its_spectrum_under_any_light(block, tmp_path):
    setup.set_up(block, bases.fitted(9))
    image = render.render(block, tmp_path).image
    for light in ("D65", "A"):
        illuminant = library.illuminant(light)
        xyz = to_xyz(image, dict.fromkeys(image.groups, Light(illuminant)))[1:3].mean(axis=0)
        matrix = image.model.relight(illuminant)
        for index, name in enumerate(NAMES):
            expected = matrix @ image.model.coefficients(library.reflectance(f"ColorChecker: {name}"))
            seen = xyz[4 * index + 1 : 4 * index + 3].mean(axis=0)
            np.testing.assert_allclose(seen / seen.sum(), expected / expected.sum(), atol=2e-3)


def test_a_metameric_black_shines_with_its_sign(block, tmp_path):
    values = np.cos(np.linspace(0, 12, WAVELENGTHS.size))
    black = Spectrum(WAVELENGTHS, values, "black", source="designed")
    (tree,) = transfer.of(bpy.data.materials["volume"])
    transfer.ranges_of(tree)[1].spectrum.node_tree = spectra.new_reflectance(black, "black")
    setup.set_up(block, bases.fitted(9))
    image = render.render(block, tmp_path).image
    expected = image.model.coefficients(black)
    assert expected.min() < -0.05, "it is negative somewhere"
    (seen,) = (pixels[1:3, 5:7].mean(axis=(0, 1)) for pixels in image.groups.values())
    np.testing.assert_allclose(seen / np.abs(seen).max(), expected / np.abs(expected).max(), atol=2e-3)


def test_ranges_are_what_was_asked_for_and_can_be_taken_out():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    tree = transfer.new()
    for index, name in enumerate(NAMES):
        transfer.add_range(tree, 0.1 * index, 0.1 * index + 0.2, group(name), index + 1.0)
    found = transfer.ranges_of(tree)
    assert [transfer.spectrum_of(one).name for one in found] == [f"ColorChecker: {name}" for name in NAMES]
    assert [one.opacity.inputs[1].default_value for one in found] == [1.0, 2.0, 3.0]
    transfer.remove_range(tree, 1)
    output = next(node for node in tree.nodes if node.bl_idname == "NodeGroupOutput")
    top = output.inputs["Color"].links[0].from_node
    first = next(s for s in top.inputs if s.enabled and s.name == "A")
    assert first.links[0].from_node["relume_range"] == 0, "what was below takes the place of what was taken out"
    for one in transfer.ranges_of(tree):
        transfer.remove_range(tree, one.index)
    assert len(tree.nodes) == 2 and not output.inputs["Density"].is_linked


def test_remove_gives_a_volume_back(block):
    before = dump()
    setup.set_up(block)
    setup.remove(block)
    assert differences(before, dump()) == []


def test_operators_make_a_function_add_and_remove_ranges():
    bpy.ops.wm.read_factory_settings()
    material = bpy.context.object.active_material
    assert bpy.ops.relume.new_transfer() == {"FINISHED"}
    (tree,) = transfer.of(material)
    bpy.ops.relume.add_transfer_range(group=tree.name, spectrum="ColorChecker: red", low=0.2, high=0.4)
    (one,) = transfer.ranges_of(tree)
    assert transfer.spectrum_of(one).name == "ColorChecker: red"
    assert one.low.inputs[1].default_value == pytest.approx(0.2)
    bpy.ops.relume.remove_transfer_range(group=tree.name, index=one.index)
    assert transfer.ranges_of(tree) == []
