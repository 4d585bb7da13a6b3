"""The asset library: what its assets say of themselves, and what they do in scenes that are set up and in others."""

from pathlib import Path

import bpy
import numpy as np
import pytest

from relume.addon.graph import nodes, spectra
from relume.addon.host import asset_library
from relume.addon.scene import follower, render, setup
from relume.assets import library as assets
from relume.assets import library_ground
from relume.core.colour import differences, spaces
from relume.core.model import bases, relight
from relume.core.spectra import library
from relume.core.spectra.spectrum import WAVELENGTHS, Spectrum

RED, SODIUM = "Red (ColorChecker)", "Street lamp, sodium"


def append(kind: str, name: str):
    with bpy.data.libraries.load(str(assets.PATH), link=False, assets_only=True) as (_, wanted):
        setattr(wanted, kind, [name])
    (found,) = getattr(wanted, kind)
    return found


def put_on_cube(material):
    bpy.data.objects["Cube"].material_slots[0].material = material


def spectrum_in(material):
    return next(node.node_tree for node in material.node_tree.nodes if nodes.role(node) == "spectrum")


def test_every_asset_says_where_it_comes_from(startup):
    listed = (assets.PATH.with_name(assets.CATALOGUES)).read_text(encoding="utf-8")
    with bpy.data.libraries.load(str(assets.PATH), link=True, assets_only=True) as (there, wanted):
        kinds = ("materials", "objects", "collections", "node_groups")
        for kind in kinds:
            setattr(wanted, kind, getattr(there, kind))
    found = [thing for kind in kinds for thing in getattr(wanted, kind)]
    assert len(found) > 200
    for thing in found:
        said = thing.asset_data
        assert said.license and said.copyright.startswith("Source: ") and said.description, thing.name
        assert f"{said.catalog_id}:Relume/" in listed, thing.name
        shown = np.array(thing.preview.image_pixels_float).reshape(*thing.preview.image_size, 4)
        assert shown.shape == (128, 128, 4) and shown[..., :3][shown[..., 3] > 0].std() > 0.01, thing.name


def test_the_library_holds_what_its_script_makes(startup):
    with bpy.data.libraries.load(str(assets.PATH), link=True, assets_only=True) as (there, _):
        held = {*there.materials, *there.objects, *there.collections, *there.node_groups}
    made = {asset.thing.name: (asset.licence, f"Source: {asset.source}") for asset in assets.build()}
    assert held == made.keys()
    bpy.ops.wm.open_mainfile(filepath=str(assets.PATH), load_ui=False)
    kinds = (bpy.data.materials, bpy.data.objects, bpy.data.collections, bpy.data.node_groups)
    said = {thing.name: thing.asset_data for kind in kinds for thing in kind if thing.asset_data}
    assert {name: (data.license, data.copyright) for name, data in said.items()} == made


def test_a_paint_shows_its_colour_in_a_scene_that_is_not_set_up(startup):
    put_on_cube(append("materials", RED))
    tree = spectrum_in(bpy.data.materials[RED])
    colour = next(node for node in tree.nodes if node.type == "RGB").outputs[0].default_value[:3]
    assert colour == pytest.approx(spaces.daylight_rgb(library.reflectance("ColorChecker: red")), abs=1e-6)
    assert bpy.data.materials[RED].diffuse_color[:3] == pytest.approx(colour, abs=1e-6), "the solid viewport too"


def test_a_paint_is_spectral_in_a_scene_that_is_set_up(startup):
    setup.set_up(startup, bases.fitted(6))
    put_on_cube(append("materials", RED))
    follower.settle(startup)
    tree = spectrum_in(bpy.data.materials[RED])
    assert tree[spectra.FILLED] == spectra.filled_for(tree, startup.relume.model())
    assert len([node for node in tree.nodes if node.type == "VECT_MATH"]) == 6


def test_a_glass_gets_the_indices_of_the_channels(startup):
    setup.set_up(startup, bases.fitted(6))
    put_on_cube(append("materials", "Glass SF10"))
    follower.settle(startup)
    (node,) = [node for node in bpy.data.materials["Glass SF10"].node_tree.nodes if nodes.role(node) == "glass"]
    assert node.node_tree[spectra.FILLED] == spectra.filled_for(node.node_tree, startup.relume.model())


@pytest.mark.parametrize("before", [False, True])
def test_a_lamp_brings_its_illuminant(startup, before):
    if before:
        setup.set_up(startup, bases.fitted(6))
    lamp = append("objects", SODIUM)
    startup.collection.objects.link(lamp)
    assert lamp.data.use_temperature, "without Relume it has a colour"
    if before:
        follower.settle(startup)
    else:
        setup.set_up(startup, bases.fitted(6))
    assert startup.relume.light_groups[SODIUM].illuminant == "Sodium (low pressure)"
    assert startup.relume.light_groups[SODIUM].spectrum().name == "Sodium (low pressure)"
    startup.relume.light_groups[SODIUM].illuminant = "FL2"
    follower.settle(startup)
    assert startup.relume.light_groups[SODIUM].illuminant == "FL2", "what the artist chose stays"
    setup.remove(startup)
    assert lamp.data.use_temperature


def test_two_lamps_that_differ_in_one_group_leave_it_daylight(startup):
    for name in (SODIUM, "Candle"):
        lamp = append("objects", name)
        lamp.lightgroup = "both"
        startup.collection.objects.link(lamp)
    setup.set_up(startup, bases.fitted(6))
    assert startup.relume.light_groups["both"].illuminant == "D65"


def test_a_lamp_whose_light_group_has_other_light_leaves_it_daylight(startup):
    """Its own black body is then relative to daylight: with its illuminant in the mixer it would count twice."""
    lamp = append("objects", "Candle")
    startup.collection.objects.link(lamp)
    shining = bpy.data.objects["Cube"]
    shining.active_material.node_tree.nodes["Principled BSDF"].inputs["Emission Strength"].default_value = 1.0
    shining.lightgroup = lamp.lightgroup
    setup.set_up(startup, bases.fitted(6))
    assert startup.relume.light_groups["Candle"].illuminant == "D65"


def test_a_booth_has_four_lights(startup):
    startup.collection.children.link(append("collections", "Light booth"))
    setup.set_up(startup, bases.fitted(6))
    lit = {row.name: row.illuminant for row in startup.relume.lit if row.name.startswith("Booth")}
    assert lit == {"Booth D65": "D65", "Booth A": "A", "Booth TL84": "FL11", "Booth CWF": "FL2"}


def test_colours_are_spectral_before_a_mix_of_spectra(startup):
    setup.set_up(startup, bases.fitted(6))
    material = bpy.data.objects["Cube"].active_material
    tree = material.node_tree
    mix = tree.nodes.new("ShaderNodeGroup")
    mix.node_tree = append("node_groups", "Spectral Mix")
    spectra.assign(material, mix.inputs["First"], spectra.new_reflectance(library.reflectance("CES 10")))
    mix.inputs["Second"].default_value = (0.1, 0.2, 0.7, 1.0)
    base = tree.nodes["Principled BSDF"].inputs["Base Color"]
    tree.links.new(mix.outputs["Color"], nodes.holder(base))
    follower.settle(startup)
    assert base.links[0].from_node == mix, "what comes out of the mix is spectral already"
    assert nodes.role(mix.inputs["First"].links[0].from_node) == "spectrum"
    mixes = [node for node in mix.node_tree.nodes if node.type == "MIX"]
    assert nodes.role(nodes.mixed(mixes[0], "B").links[0].from_node) == "upsample"
    assert nodes.role(nodes.mixed(mixes[0], "A").links[0].from_node) == ""


def test_water_absorbs_as_beer_and_lambert_say(tmp_path):
    """Five metres of water before a white sky, in all channels: exp(-αd) of each."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_plane_add(size=10)
    material = bpy.data.materials.new("water")
    bpy.context.object.data.materials.append(material)
    scene.world = bpy.data.worlds.new("sky")
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    bpy.ops.object.camera_add(location=(0, 0, 5))
    scene.camera, scene.render.engine = bpy.context.object, "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = 4
    scene.cycles.samples, scene.cycles.use_denoising = 6, False
    tree = material.node_tree
    water = tree.nodes.new("ShaderNodeGroup")
    water.node_tree = append("node_groups", "Water by Thickness")
    water.inputs["Thickness"].default_value = 5.0
    clear = tree.nodes.new("ShaderNodeBsdfTransparent")
    tree.links.new(water.outputs["Color"], clear.inputs["Color"])
    tree.links.new(clear.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    setup.set_up(scene, bases.fitted(6))
    (seen,) = render.render(scene, tmp_path).image.groups.values()
    k = library.extinction("Water")
    alpha = 4 * np.pi * k.sampled() / (WAVELENGTHS * 1e-9)
    expected = np.exp(
        -5.0 * alpha.max() * scene.relume.model().coefficients(Spectrum(WAVELENGTHS, alpha / alpha.max()))
    )
    assert seen[2, 2] == pytest.approx(expected, rel=2e-3)
    assert expected.min() < 0.3 and expected.max() > 0.8


def test_a_thin_film_reflects_as_airy_says(tmp_path):
    """From above, of each thickness: the colour of the formula at every wavelength, but for what nobody sees."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    bpy.ops.object.camera_add(location=(0, 0, 5))
    scene.camera, scene.render.engine = bpy.context.object, "CYCLES"
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 4.0
    scene.render.resolution_x = scene.render.resolution_y = 4
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.pixel_filter_type = 6, False, "BOX"
    group, thicknesses = append("node_groups", "Thin Film"), (120.0, 250.0, 400.0, 600.0)
    for place, thickness in enumerate(thicknesses):
        bpy.ops.mesh.primitive_plane_add(size=1, location=(place - 1.5, 0, 0))
        bpy.context.object.scale.y = 4.0
        material = bpy.data.materials.new("film")
        bpy.context.object.data.materials.append(material)
        tree = material.node_tree
        film, shine = tree.nodes.new("ShaderNodeGroup"), tree.nodes.new("ShaderNodeEmission")
        film.node_tree, film.inputs["Thickness"].default_value = group, thickness
        shine.inputs["Strength"].default_value = 10.0
        tree.links.new(film.outputs["Color"], shine.inputs["Color"])
        tree.links.new(shine.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    setup.set_up(scene, bases.fitted(12))
    rendered = render.render(scene, tmp_path).image
    (seen,) = rendered.groups.values()
    reflected = ((1.33 - 1) / (1.33 + 1)) ** 2
    finesse = 4 * reflected / (1 - reflected) ** 2
    weights = relight.power_weights(library.illuminant("D65").sampled(), library.observer())
    white = weights.sum(axis=0)
    for place, thickness in enumerate(thicknesses):
        wave = finesse * np.sin(2 * np.pi * 1.33 * thickness / WAVELENGTHS) ** 2
        truth = (10 * wave / (1 + wave)) @ weights
        shown = rendered.model.relight(library.illuminant("D65")) @ seen[2, place]
        assert differences.delta_E_2000(shown, truth, white) < 1, thickness


def test_a_laser_shines_in_one_wavelength_and_has_its_colour_before(startup):
    laser = append("objects", "Laser, green (532 nm)")
    startup.collection.objects.link(laser)
    red, green, blue = laser.data.color
    assert green > 0.9 and red < 0.1 and blue < 0.1, "without Relume it is green"
    setup.set_up(startup, bases.fitted(6))
    row = startup.relume.light_groups[laser.lightgroup]
    assert row.illuminant == "532 nm" and row.spectrum().wavelengths.tolist() == [532.0]


def test_what_was_measured_outdoors_is_what_the_file_says(startup):
    brick = spectra.spectra_of(spectrum_in(append("materials", "Brick, red")))["Color"]
    table = np.genfromtxt(library_ground.PATH, delimiter=",", names=True, deletechars="")
    assert brick.values == pytest.approx(table["mobrmg.003-"], abs=1e-6)
    assert brick.wavelengths.tolist() == table["nm"].tolist() == list(np.arange(400.0, 801.0, 10.0))


def test_every_kind_of_surface_has_a_catalogue(startup):
    listed = assets.PATH.with_name(assets.CATALOGUES).read_text(encoding="utf-8")
    for kind in ("Skin", "Nature", "Textiles", "Plastics", "Ground", "Wood", "Building", "Paints/Red", "Metals"):
        assert f":Relume/Materials/{kind}:" in listed


@pytest.mark.parametrize(("paint", "light"), [("Neutral 5", "D65"), ("Blue flower", "A"), ("Light skin", "FL2")])
def test_metamers_match_under_their_light_and_part_elsewhere(startup, paint, light):
    pair = [append("materials", f"{paint}, {which} ({light})") for which in ("as measured", "its double")]
    reflected = [spectra.spectra_of(spectrum_in(material))["Color"].sampled() for material in pair]
    apart = {}
    for name in ("D65", "A", "FL2"):
        weights = relight.power_weights(library.illuminant(name).sampled(), library.observer())
        white = weights.sum(axis=0)
        apart[name] = differences.delta_E_2000(*(each @ weights / white[1] for each in reflected), white / white[1])
    assert apart.pop(light) < 0.05
    assert min(apart.values()) > 5


@pytest.fixture
def folder(tmp_path):
    yield tmp_path
    asset_library.withdraw("Relume", tmp_path)


def test_the_library_is_offered_once_and_taken_back(folder):
    preferences = bpy.context.preferences
    libraries = preferences.filepaths.asset_libraries
    before, preferences.is_dirty = [entry.name for entry in libraries], False
    for _ in range(2):
        asset_library.offer("Relume", folder)
    assert [Path(entry.path) for entry in libraries if entry.name == "Relume"] == [folder]
    assert libraries["Relume"].import_method == "APPEND", "what is linked cannot become spectral"
    asset_library.withdraw("Relume", folder)
    assert [entry.name for entry in libraries] == before
    assert not preferences.is_dirty


def test_a_library_of_the_users_own_stays(folder):
    libraries = bpy.context.preferences.filepaths.asset_libraries
    own = libraries.new(name="mine", directory=str(folder))
    asset_library.offer("Relume", folder)
    asset_library.withdraw("Relume", folder)
    assert [entry.name for entry in libraries if Path(entry.path) == folder] == ["mine"]
    libraries.remove(own)
