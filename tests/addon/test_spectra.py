"""Measured spectra put where they matter, from the library and from files, before and after set-up."""

import bpy
import numpy as np
import pytest
from test_palette import striped

from relume.addon.graph import nodes, places, spectra
from relume.addon.scene import content, render, setup
from relume.core.colour import differences
from relume.core.model import absorption, bases
from relume.core.spectra import library


@pytest.fixture
def cube(startup):
    """The cube's material; the cube is active."""
    bpy.context.view_layer.objects.active = bpy.data.objects["Cube"]
    return bpy.data.objects["Cube"].active_material


def chosen(material):
    tree = material.node_tree
    return {place: places.chosen_at(tree.nodes[place[0]], *place[1:]) for place in places.of(material)}


BASE = ("Principled BSDF", "Base Color", "reflectance")
SHINE = ("Principled BSDF", "Emission Color", "reflectance")


def assign(place, name):
    assert bpy.ops.relume.assign_spectrum(node=place[0], socket=place[1], takes=place[2], spectrum=name) == {"FINISHED"}


def clear(place):
    assert bpy.ops.relume.clear_spectrum(node=place[0], socket=place[1], takes=place[2]) == {"FINISHED"}


@pytest.mark.parametrize("is_set_up", [False, True])
def test_a_reflectance_is_assigned_and_cleared(startup, cube, is_set_up):
    if is_set_up:
        setup.set_up(startup, bases.fitted(6))
    base = cube.node_tree.nodes["Principled BSDF"].inputs["Base Color"]
    assign(BASE, "ColorChecker: red")
    assert chosen(cube)[BASE] == "ColorChecker: red"
    assert nodes.role(base.links[0].from_node) == "spectrum"
    weights = [n for n in base.links[0].from_node.node_tree.nodes if n.type == "VECT_MATH"]
    assert len(weights) == (6 if is_set_up else 0)
    clear(BASE)
    assert chosen(cube)[BASE] == ""
    assert base.is_linked is is_set_up
    setup.remove(startup)
    assert not base.is_linked
    assert tuple(base.default_value) == pytest.approx((0.7, 0.2, 0.1, 1.0))


def test_the_same_spectrum_is_one_group(startup, cube):
    assign(BASE, "CES 10")
    cube.node_tree.nodes["Principled BSDF"].inputs["Coat Weight"].default_value = 1.0
    assign(("Principled BSDF", "Coat Tint", "reflectance"), "CES 10")
    assert [t.get(nodes.ROLE) for t in bpy.data.node_groups].count("spectrum") == 1


def test_a_spectrum_on_what_shines_stays_when_the_scene_is_given_back(startup, cube):
    shine = cube.node_tree.nodes["Principled BSDF"].inputs["Emission Color"]
    cube.node_tree.nodes["Principled BSDF"].inputs["Emission Strength"].default_value = 1.0
    shine.default_value = (1.0, 0.5, 0.2, 1.0)
    setup.set_up(startup, bases.fitted(6))
    assign(SHINE, "ColorChecker: red")
    light = shine.links[0].from_node
    assert nodes.role(light) == "light" and "Spectral" in light.node_tree.name
    assert chosen(cube)[SHINE] == "ColorChecker: red"
    setup.remove(startup)
    assert chosen(cube)[SHINE] == "ColorChecker: red"
    setup.set_up(startup, bases.fitted(6))
    clear(SHINE)
    assert "Spectral" not in shine.links[0].from_node.node_tree.name
    setup.remove(startup)
    assert not shine.is_linked


def test_metals_and_glasses(startup, cube):
    tree = cube.node_tree
    metal, glassy = tree.nodes.new("ShaderNodeBsdfMetallic"), tree.nodes.new("ShaderNodeBsdfGlass")
    glassy.name = "Lens"
    tree.links.new(metal.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    for name in library.conductors():
        assign(("Metallic BSDF", "", "metal"), name)
        assert chosen(cube)["Metallic BSDF", "", "metal"] == name
    for name in library.glasses():
        place = next(place for place in places.of(cube) if place[2] == "glass")
        assign(place, name)
    place = next(place for place in places.of(cube) if place[2] == "glass")
    assert chosen(cube)[place] == library.glasses()[-1]
    clear(place)
    own = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBsdfGlass")
    assert own.inputs["IOR"].default_value == pytest.approx(library.glass(library.glasses()[-1]).sampled([589.3])[0])
    clear(("Metallic BSDF", "", "metal"))
    assert not metal.inputs["IOR"].is_linked


def test_how_a_file_was_read_is_told(startup, cube, tmp_path, capfd):
    path = tmp_path / "cloth.csv"
    common = {"filepath": str(path), "node": BASE[0], "socket": BASE[1], "takes": BASE[2]}
    path.write_text("nm;a in %;b in %\n400;10,5;3\n700;90,5;4\n")
    assert bpy.ops.relume.assign_spectrum_file(**common) == {"FINISHED"}
    assert "From cloth.csv, read as per cent; the first 1 of 2 spectra" in capfd.readouterr().out
    base = cube.node_tree.nodes["Principled BSDF"].inputs["Base Color"]
    assert spectra.spectra_of(spectra.source_of(base))["Color"].values.tolist() == [0.105, 0.905]
    trees, links = len(bpy.data.node_groups), len(cube.node_tree.links)
    for text, words in (
        ("400,10.5\n700,90.5\n", "looks like per cent"),
        ("0.4,0.1\n0.7,0.9\n", "looks like µm"),
        ("800,0.1\n900,0.9\n", "nothing of the visible"),
        ("400,0.1\n500,1e200\n", "outside the range"),
    ):
        path.write_text(text)
        with pytest.raises(RuntimeError, match=words):
            bpy.ops.relume.assign_spectrum_file(**common)
    assert (trees, links) == (len(bpy.data.node_groups), len(cube.node_tree.links)), "a refused file changes nothing"


def test_spectra_from_files(startup, cube, tmp_path):
    path = tmp_path / "Ткань.csv"
    path.write_text("nm,dyed cloth\n400,0.1\n500,0.4\n600,0.8\n700,0.9\n", encoding="utf-8")
    common = {"node": BASE[0], "socket": BASE[1], "takes": BASE[2]}
    assert bpy.ops.relume.assign_spectrum_file(filepath=str(path), **common) == {"FINISHED"}
    base = cube.node_tree.nodes["Principled BSDF"].inputs["Base Color"]
    assert spectra.spectra_of(spectra.source_of(base))["Color"].sampled([500.0]) == pytest.approx([0.4])
    path.write_text("400,0.1\n400,0.2\n")
    with pytest.raises(RuntimeError, match="400 nm occurs more than once"):
        bpy.ops.relume.assign_spectrum_file(filepath=str(path), **common)
    assert spectra.spectra_of(spectra.source_of(base))["Color"].name == "dyed cloth"
    path.write_text("400,0.1\n500,0.2\n")
    with pytest.raises(RuntimeError, match="n and k"):
        cube.node_tree.nodes.new("ShaderNodeBsdfMetallic")
        bpy.ops.relume.assign_spectrum_file(filepath=str(path), node="Metallic BSDF", takes="metal")


def test_a_medium_has_its_colour_at_depth(tmp_path):
    """A slab of optical depth 4 before white: full spectra by brute force, the colour that is assigned, the mean."""
    assert spectra.depth_of({}) == spectra.depth_of({spectra.DEPTH: "x"}) == spectra.depth_of({spectra.DEPTH: -1}) == 0
    lamp, paint = library.illuminant("D65"), library.reflectance("ColorChecker: orange")
    weights = lamp.sampled()[:, None] * library.observer() / (lamp.sampled() @ library.observer()[:, 1])
    truth = np.exp(-4.0 * (1 - paint.sampled())) @ weights
    errors = []
    for of_surfaces in (False, True):
        scene, materials = striped(1)
        tree = materials[0].node_tree
        glow = tree.nodes.new("ShaderNodeEmission")
        glow.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
        tree.links.new(glow.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
        bpy.ops.mesh.primitive_cube_add(size=1.0, location=(0.5, 0.5, 1.0))
        slab = bpy.context.object
        slab.scale = (8, 8, 1)
        bpy.context.view_layer.update()
        material = bpy.data.materials.new("ink")
        tree = material.node_tree
        tree.nodes.clear()
        medium, output = tree.nodes.new("ShaderNodeVolumeAbsorption"), tree.nodes.new("ShaderNodeOutputMaterial")
        medium.inputs["Density"].default_value = 4.0
        tree.links.new(medium.outputs[0], output.inputs["Volume"])
        slab.data.materials.append(material)
        scene.camera.location.z = 3.0
        bpy.data.lights["sun"].energy = 0.0
        if of_surfaces:
            spectra.assign(material, medium.inputs["Color"], spectra.new_reflectance(paint))
        else:
            bpy.context.view_layer.objects.active = slab
            assign((medium.name, "Color", "reflectance"), paint.name)
        setup.set_up(scene, bases.fitted(9))
        told = content.content_of(scene)
        assert (told.optical_depths > 0).sum() == 1
        assert told.rights.max() == (0.0 if of_surfaces else absorption.depth_for(told.optical_depths.max()))
        image = render.render(scene, tmp_path).image
        shown = sum(image.groups.values())[2:6, 2:6].mean(axis=(0, 1))
        seen = image.model.relight(lamp) @ shown
        errors.append(float(differences.delta_E_2000(truth, seen, weights.sum(axis=0))))
    assert errors[0] < 0.15
    assert errors[0] < 0.7 * errors[1]


def test_the_colour_of_a_medium_is_kept_apart_from_that_of_a_surface(startup):
    """One file with both: each socket gets its own, and another model or spectrum leaves it so."""
    paint, other = (library.reflectance(f"ColorChecker: {name}") for name in ("red", "green"))
    tree = bpy.data.materials.new("ink").node_tree
    medium, surface = (tree.nodes.new(kind) for kind in ("ShaderNodeVolumeAbsorption", "ShaderNodeBsdfDiffuse"))
    deep, plain = (spectra.for_socket(node.inputs["Color"], paint) for node in (medium, surface))
    assert deep != plain and deep.name != plain.name
    assert deep == spectra.for_socket(medium.inputs["Color"], paint)
    assert plain == spectra.for_socket(surface.inputs["Color"], paint)
    for spectrum in (paint, other):
        spectra.replace(deep, spectrum)
        for channels in (6, 9):
            model = bases.fitted(channels)
            spectra.update_all(model)
            values = sorted(node.inputs[1].default_value[0] for node in deep.nodes if node.type == "VECT_MATH")
            wanted = absorption.tint(model, spectrum)
            assert all(min(abs(value - each) for value in values) < 1e-5 for each in wanted)
    spectra.restore_all()
    assert spectra.depth_of(deep) == absorption.DEPTH
