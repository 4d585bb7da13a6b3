"""Dispersion: every channel leaves a prism at the angle that Snell's law gives its index of refraction."""

import bpy
import numpy as np
import pytest
from dump import differences, dump

from relume.addon import glass, nodes, render, setup
from relume.core import bases, library

APEX = np.radians(20.0)
DISTANCE = 10.0  # from the edge of the prism to the line below it
WIDTH, PIXELS = 0.6, 240  # of the picture
PIXEL = WIDTH / PIXELS
INDEX = library.glass("SF10")


def offset(n):
    """How far a ray that comes down at x = 0 is turned aside until it meets the plane of the line, for index n."""
    turned = np.arcsin(n * np.sin(APEX)) - APEX
    return (DISTANCE + np.tan(APEX)) * np.tan(turned)


LINE = offset(1.735)


def seen_at(n):
    """x at which the line is seen: a ray that comes down there meets it, for index n."""
    turned = np.tan(np.arcsin(n * np.sin(APEX)) - APEX)
    return (LINE - (DISTANCE + np.tan(APEX)) * turned) / (1 - np.tan(APEX) * turned)


@pytest.fixture
def prism():
    """An orthographic camera that looks down through a prism at a white line; the glass node of the prism."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = PIXELS, 4
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.pixel_filter_type = 128, False, "BOX"
    scene.render.engine = "CYCLES"
    run = 2.0 * np.tan(APEX)
    corners = [(x, y, z) for y in (-1, 1) for x, z in ((-1, 2), (1, 2), (1, 0), (-1, run))]
    faces = [(0, 1, 2, 3), (7, 6, 5, 4), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)]
    mesh = bpy.data.meshes.new("prism")
    mesh.from_pydata(corners, [], [face[::-1] for face in faces])
    glassy = bpy.data.materials.new("glass")
    mesh.materials.append(glassy)
    scene.collection.objects.link(bpy.data.objects.new("prism", mesh))
    tree = glassy.node_tree
    tree.nodes.remove(tree.nodes["Principled BSDF"])
    node = tree.nodes.new("ShaderNodeBsdfGlass")
    tree.links.new(node.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    line = bpy.data.meshes.new("line")
    line.from_pydata(
        [(LINE + x, y, -DISTANCE) for x, y in ((-0.01, -5), (0.01, -5), (0.01, 5), (-0.01, 5))], [], [(0, 1, 2, 3)]
    )
    shining = bpy.data.materials.new("line")
    shining.node_tree.nodes["Principled BSDF"].inputs["Emission Strength"].default_value = 1.0
    line.materials.append(shining)
    scene.collection.objects.link(bpy.data.objects.new("line", line))
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", WIDTH
    camera.location = (0, 0, 5)
    scene.collection.objects.link(camera)
    scene.camera = camera
    bpy.context.view_layer.update()
    return scene, node


def centre(row):
    """Where the light of a row of pixels (..., PIXELS) lies on average."""
    return row @ ((np.arange(PIXELS) + 0.5) * PIXEL - WIDTH / 2) / row.sum(axis=-1)


def test_each_channel_leaves_a_prism_at_its_own_angle(prism, tmp_path):
    scene, node = prism
    model = bases.fitted(9)
    glass.replace(node, INDEX)
    setup.set_up(scene, model)
    image = render.render(scene, tmp_path).image
    rows = sum(image.groups.values()).mean(axis=0).T  # (channels, pixels)
    n = image.model.coefficients(INDEX)
    assert centre(rows) == pytest.approx(seen_at(n), abs=PIXEL)
    assert np.ptp(seen_at(n)) > 40 * PIXEL, "the spectrum is spread out"


def test_the_spectrum_lies_where_that_of_all_wavelengths_does(prism, tmp_path):
    """X, Y and Z of the line in D65, against Snell's law at every 5 nm: means to two pixels, spreads to a tenth."""
    scene, node = prism
    glass.replace(node, INDEX)
    setup.set_up(scene, bases.fitted(15))
    image = render.render(scene, tmp_path).image
    rows = sum(image.groups.values()).mean(axis=0).T
    xyz = image.model.relight(library.illuminant("D65")) @ rows
    weights = library.observer() * library.illuminant("D65").sampled()[:, None]
    weights /= weights.sum(axis=0)
    places = seen_at(INDEX.sampled())
    expected = places @ weights
    assert centre(xyz) == pytest.approx(expected, abs=2 * PIXEL)
    x = (np.arange(PIXELS) + 0.5) * PIXEL - WIDTH / 2
    spread = np.sqrt((xyz * (x - centre(xyz)[:, None]) ** 2).sum(axis=1) / xyz.sum(axis=1))
    true_spread = np.sqrt((((places[:, None] - expected) ** 2) * weights).sum(axis=0) + 0.02**2 / 12)
    assert spread == pytest.approx(true_spread, rel=0.1)


def test_glass_is_filled_and_emptied_with_the_scene(prism):
    scene, node = prism
    node.inputs["Color"].default_value = (0.5, 0.9, 0.7, 1.0)
    new = glass.replace(node, INDEX)
    before = dump()
    setup.set_up(scene)
    assert nodes.role(new.inputs["Color"].links[0].from_node) == "upsample"
    setup.remove(scene)
    assert differences(before, dump()) == []
    assert tuple(new.inputs["Color"].default_value) == pytest.approx((0.5, 0.9, 0.7, 1.0))


def test_one_glass_is_one_group(prism):
    _, node = prism
    tree = node.id_data
    first = glass.replace(node, INDEX)
    second = glass.replace(tree.nodes.new("ShaderNodeBsdfGlass"), INDEX)
    other = glass.replace(second, library.glass("BK7"))
    assert first.node_tree.users == 1 and other.node_tree.name == "BK7"
    refraction = glass.replace(tree.nodes.new("ShaderNodeBsdfRefraction"), INDEX)
    assert refraction.node_tree != first.node_tree
