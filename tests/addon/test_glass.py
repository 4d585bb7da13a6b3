"""Dispersion: every channel leaves a prism at the angle that Snell's law gives its index of refraction."""

import numpy as np
import pytest
from dump import differences, dump

from relume.addon.graph import glass, nodes
from relume.addon.scene import render, setup
from relume.assets.prism import LINE_WIDTH, WIDTH, build, seen_at
from relume.core.model import bases
from relume.core.spectra import library

PIXELS = 240
PIXEL = WIDTH / PIXELS
INDEX = library.glass("SF10")


@pytest.fixture
def prism():
    """The scene of the prism, and the glass node of the prism."""
    return build(PIXELS, 4)


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
    true_spread = np.sqrt((((places[:, None] - expected) ** 2) * weights).sum(axis=0) + LINE_WIDTH**2 / 12)
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
