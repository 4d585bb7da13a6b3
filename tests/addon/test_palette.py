"""Palettes in a file and in a render: what was designed is what Cycles shows."""

from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np
import pytest

from relume.addon.graph import spectra
from relume.addon.scene import render, setup
from relume.addon.store import palette as palettes
from relume.addon.store import palette_tables
from relume.core import Light, palette
from relume.core.colour import differences
from relume.core.model import bases, upsample
from relume.core.spectra import library

DESIGNS = Path(__file__).resolve().parents[2] / "assets/palettes"
MODELS = {"nine channels": lambda: bases.fitted(9), "reference": lambda: bases.named("bands", 36)}


def striped(count):
    """A scene of so many flat stripes, and a white one, straight under the sun, seen from above, without bounces."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = 8 * (count + 1), 8
    scene.cycles.samples, scene.cycles.max_bounces, scene.cycles.use_denoising = 4, 0, False
    scene.relume.split_samples = False
    materials = []
    for index in range(count + 1):
        mesh = bpy.data.meshes.new(f"stripe {index}")
        mesh.from_pydata([(index, 0, 0), (index + 1, 0, 0), (index + 1, 1, 0), (index, 1, 0)], [], [(0, 1, 2, 3)])
        material = bpy.data.materials.new(f"stripe {index}")
        tree = material.node_tree
        tree.nodes.clear()
        surface, output = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeOutputMaterial")
        surface.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
        tree.links.new(surface.outputs[0], output.inputs["Surface"])
        mesh.materials.append(material)
        scene.collection.objects.link(bpy.data.objects.new(f"stripe {index}", mesh))
        materials.append(material)
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.data.angle = np.pi, 0.0
    scene.collection.objects.link(sun)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", count + 1
    camera.location = ((count + 1) / 2, 0.5, 1.0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    return scene, materials


def assigned(name, **criteria):
    """A design solved by the editor's own buttons, its reflectances on stripes -> scene, Solution."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    rows = len(palette.read(DESIGNS / f"{name}.toml").reflectances)
    scene, materials = striped(rows)
    assert bpy.ops.relume.palette_new(example=name) == {"FINISHED"}
    design = palettes.active(scene)
    for key, value in criteria.items():
        setattr(design, key, value)
    assert bpy.ops.relume.palette_create() == {"FINISHED"}
    for row, material in zip(design.reflectances, materials, strict=False):
        row.material = material
    assert bpy.ops.relume.palette_assign() == {"FINISHED"}
    return scene, design


def seen(scene, model, folder, lights, white_balance=0.0):
    """XYZ of each stripe under each light, that of the white stripe at Y = 1: (lights, stripes, 3)."""
    setup.set_up(scene, model)
    image = render.render(scene, folder).image
    found = []
    for name in lights:
        mix = {group: Light(library.illuminant(name)) for group in image.groups}
        rgb = render.picture(image, mix, white_balance)
        stripes = rgb.reshape(8, -1, 8, 3)[2:6, :, 2:6].mean(axis=(0, 2))
        xyz = stripes @ upsample.rgb_to_xyz().T
        found.append(xyz / xyz[-1, 1])
    return np.array(found)


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_three_metamers_match_in_daylight_and_part_under_tungsten(tmp_path, model):
    scene, design = assigned("three_metamers", channels="9", model_error=1.0)
    made = palette_tables.design_of(design)
    truth = palette.patches(made)[0]  # (r, l, 3) of full spectra
    daylight, tungsten = seen(scene, model(), tmp_path, ["D65", "A"])
    pairs = ((0, 1), (0, 2), (1, 2))
    for a, b in pairs:
        assert differences.delta_E_2000(daylight[a], daylight[b], daylight[-1]) < 0.5
        split = differences.delta_E_2000(tungsten[a], tungsten[b], tungsten[-1])
        wanted = differences.delta_E_2000(truth[a, 1], truth[b, 1], tungsten[-1])
        assert wanted > 9.9 and split == pytest.approx(wanted, rel=0.1)


def test_a_colour_that_stays_in_the_adapted_picture(tmp_path):
    scene, _ = assigned("stays", channels="9", model_error=1.0)
    shown = seen(scene, bases.fitted(9), tmp_path, ["D65", "A", "FL11"], white_balance=1.0)
    white = upsample.rgb_to_xyz().sum(axis=1)
    colors = shown[:, 0]
    largest = max(differences.delta_E_2000(a, b, white) for a in colors for b in colors)
    assert largest < 1.0


def test_a_palette_survives_the_file(tmp_path):
    bpy.ops.wm.read_factory_settings()
    for example in ("three_metamers", "stays", "appears"):
        assert bpy.ops.relume.palette_new(example=example) == {"FINISHED"}
    design = palettes.active(bpy.context.scene)
    before = palette_tables.table_of(design)
    first = palette.read(DESIGNS / "appears.toml")
    again = palette_tables.design_of(design)
    assert [entry.name for entry in again.lights] == [entry.name for entry in first.lights]
    cells = [{(cell.reflectance, cell.light): cell for cell in one.cells} for one in (again, first)]
    assert cells[0].keys() == cells[1].keys()
    for place in cells[0]:
        one, other = (each[place] for each in cells)
        assert one.free == other.free
        np.testing.assert_allclose(one.target or 0, other.target or 0, atol=1e-6)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "saved.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "saved.blend"))
    assert len(bpy.context.scene.relume_palettes) == 3
    assert palette_tables.table_of(palettes.active(bpy.context.scene)) == before


WHOLE = """
version = 1
[criteria]
channels = 7
model = "sharpened"
[[lights]]
spectrum = "D65"
[[lights]]
spectrum = "A"
[[lights]]
name = "lamp"
designed = true
bounds = [0.1, 2.0]
[[reflectances]]
name = "left"
designed = true
bounds = [0.05, 0.95]
near = "CES 30"
near_weight = 0.02
span = "ces"
span_weight = 0.03
[[reflectances]]
spectrum = "CES 12"
name = "given"
[[cells]]
reflectance = "left"
light = "D65"
free = "B"
[[free_colours]]
name = "B"
lower = [0.1, 0.2, 0.1]
[[constancies]]
reflectance = "left"
lights = ["D65", "A"]
"""


def test_the_editor_loses_nothing_of_a_file(tmp_path):
    bpy.ops.wm.read_factory_settings()
    path = tmp_path / "whole.toml"
    path.write_text(WHOLE)
    assert bpy.ops.relume.palette_open(filepath=str(path)) == {"FINISHED"}
    design = palettes.active(bpy.context.scene)
    first, again = (palette.to_dict(one) for one in (palette.read(path), palette_tables.design_of(design)))
    for table in (first, again):
        table["title"] = ""
    assert str(_rounded(again)) == str(_rounded(first))
    design.lights[1].name = "tungsten"
    design.lights[2].name = "bulb"
    assert palette_tables.table_of(design)["constancies"][0]["lights"] == ["D65", "tungsten"]


def _rounded(value):
    """Numbers of the interface are of single precision."""
    if isinstance(value, dict):
        return {key: _rounded(value[key]) for key in sorted(value)}
    if isinstance(value, (list, tuple)):
        return [_rounded(each) for each in value]
    return round(value, 5) + 0.0 if isinstance(value, float) else value


def test_limits_and_demands_from_the_panel():
    bpy.ops.wm.read_factory_settings()
    bpy.ops.relume.palette_new(example="stays")
    design = palettes.active(bpy.context.scene)
    name = design.lights[0].name
    assert bpy.ops.relume.palette_leave_out(index=0, light=name) == {"FINISHED"}
    assert name not in palette_tables.table_of(design)["constancies"][0]["lights"]
    bpy.ops.relume.palette_leave_out(index=0, light=name)
    assert name in palette_tables.table_of(design)["constancies"][0]["lights"]
    with pytest.raises(RuntimeError, match="no spectrum yet"):
        bpy.ops.relume.palette_near(way="NOW")
    bpy.ops.relume.palette_near(way="LIBRARY", spectrum="CES 30")
    row = design.reflectances[0]
    row.near_weight, row.span = 10.0, "ces"
    bpy.ops.relume.palette_create()
    made = palette_tables.design_of(design).reflectances[0].spectrum.sampled()
    assert np.abs(made - library.reflectance("CES 30").sampled()).mean() < 0.05
    bpy.ops.relume.palette_near(way="NONE")
    assert "near" not in palette_tables.table_of(design)["reflectances"][0]
    design.cells[0].use, design.cells[0].free = "FREE", "C"
    bpy.ops.relume.palette_bound_free(letter="C")
    design.free_colours[0].lower = design.free_colours[0].upper = (0.3, 0.2, 0.1)
    design.free_colours[0].lower = (0.9, 0.9, 0.9)
    with pytest.raises(RuntimeError, match="free colour 'C': its lower bounds"):
        bpy.ops.relume.palette_create()
    bpy.ops.relume.palette_bound_free(letter="C")
    assert not design.free_colours
    bpy.ops.relume.palette_select(row=0, column=1)
    assert bpy.ops.relume.palette_black() == {"FINISHED"}
    assert (row.own_bounds, row.lower, row.upper) == (True, -1.0, 1.0)


def test_patches_follow_the_view():
    bpy.ops.wm.read_factory_settings()
    scene = bpy.context.scene
    scene.view_settings.view_transform = "Standard"
    bpy.ops.relume.palette_new(example="1_colours")
    bpy.ops.relume.palette_create()
    design = palettes.active(scene)
    plain = tuple(design.cells[0].full)
    design.shown = "VIEW"
    np.testing.assert_allclose(design.cells[0].full, plain, atol=0.01)
    before = scene.render.image_settings.file_format, scene.render.dither_intensity
    for name, value in (("view_transform", "AgX"), ("exposure", 1.5)):
        last = tuple(design.cells[0].full)
        setattr(scene.view_settings, name, value)
        palette_tables.show(design)
        assert np.abs(np.array(design.cells[0].full) - last).max() > 0.01
    assert (scene.render.image_settings.file_format, scene.render.dither_intensity) == before
    assert not [image for image in bpy.data.images if image.name.startswith("Relume")]


def test_the_same_row_keeps_its_spectrum_group():
    scene, design = assigned("stays")
    (material,) = (row.material for row in design.reflectances)
    source = spectra.source_of(material.node_tree.nodes["Diffuse BSDF"].inputs["Color"])
    design.cells[0].target = (0.1, 0.2, 0.3)
    assert bpy.ops.relume.palette_create() == {"FINISHED"}
    assert bpy.ops.relume.palette_assign(asset=True) == {"FINISHED"}
    again = spectra.source_of(material.node_tree.nodes["Diffuse BSDF"].inputs["Color"])
    assert again == source and again.asset_data is not None
    assert len([tree for tree in bpy.data.node_groups if spectra.SPECTRA in tree]) == 1
    kept = spectra.spectra_of(again)["Color"].values
    assert kept.tolist() == palette_tables.design_of(design).reflectances[0].spectrum.values.tolist()


def test_designed_lights_on_the_light_dial():
    scene, design = assigned("appears")
    with pytest.raises(RuntimeError, match="not set up"):
        bpy.ops.relume.palette_assign_lights()
    setup.set_up(scene, bases.fitted(6))
    group = scene.relume.light_groups[0]
    bpy.ops.relume.palette_select(column=1)
    assert bpy.ops.relume.palette_assign_lights(group=group.name) == {"FINISHED"}
    assert [(part.illuminant, part.weight) for part in group.blend] == [("daylight", 0.0), ("lamp", 1.0)]
    assert group.gain == pytest.approx(design.lights[1].luminance)
    lamp = palette_tables.design_of(design).lights[1].spectrum.sampled()
    shining = group.spectrum().sampled()
    np.testing.assert_allclose(shining / shining.max(), lamp / lamp.max(), atol=1e-9)
    assert bpy.ops.relume.take_snapshot() == {"FINISHED"}
    group.source = "LIBRARY"
    group.blend.clear()
    assert bpy.ops.relume.apply_snapshot() == {"FINISHED"}
    np.testing.assert_allclose(group.spectrum().sampled(), shining)
    assert bpy.ops.relume.palette_assign_lights(group=group.name, dial=False) == {"FINISHED"}
    assert group.label == "lamp" and scene.relume.problem == ""


def test_rows_and_columns_come_and_go_with_what_is_said_of_them():
    bpy.ops.wm.read_factory_settings()
    scene = bpy.context.scene
    bpy.ops.relume.palette_new(example="three_metamers")
    design = palettes.active(scene)
    design.reflectances[1].name = "cloth"
    assert {one.second for one in design.differences} == {"cloth", "third"}
    bpy.ops.relume.palette_add_named(kind="LIGHT", spectrum="FL11")
    assert design.column == 2 and len(design.cells) == 9 and design.cells[0].use == "TARGET"
    bpy.ops.relume.palette_select(row=1, column=0)
    bpy.ops.relume.palette_take_out(kind="REFLECTANCE")
    assert (
        len(design.cells) == 6 and [(one.first, one.second) for one in design.differences] == [("first", "third")] * 2
    )
    bpy.ops.relume.palette_add_materials()
    assert design.reflectances[-1].material == bpy.data.objects["Cube"].active_material
    color = (
        bpy.data.objects["Cube"].active_material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value
    )
    xyz = palette.patches(palette_tables.design_of(design))[0][-1, 0]
    assert differences.delta_E_2000(upsample.rgb_to_xyz() @ color[:3], xyz, upsample.rgb_to_xyz().sum(axis=1)) < 0.5
    assert bpy.ops.relume.palette_create() == {"FINISHED"}
    bpy.ops.relume.palette_select(column=2)
    bpy.ops.relume.palette_normalise(kind="LIGHT", way="LUMINANCE", scale=2.0)
    assert design.lights[2].luminance == pytest.approx(2.0)
    bpy.ops.relume.palette_fit(everywhere=True)
    assert {cell.use for cell in design.cells} == {"TARGET"}
    bpy.ops.relume.palette_remove()
    assert palettes.active(scene) is None


BAD = {
    "no targets": lambda d: [cell.__setattr__("use", "NONE") for cell in d.cells] + [d.differences.clear()],
    "nothing is to be designed": lambda d: [row.__setattr__("designed", False) for row in d.reflectances],
    "two lights are named": lambda d: d.lights[1].__setattr__("name", "D65"),
}


@pytest.mark.parametrize("words", BAD)
def test_what_cannot_be_done_is_told_and_changes_nothing(words):
    bpy.ops.wm.read_factory_settings()
    bpy.ops.relume.palette_new(example="three_metamers")
    bpy.ops.relume.palette_create()
    design = palettes.active(bpy.context.scene)
    BAD[words](design)
    before = palette_tables.table_of(design)
    with pytest.raises(RuntimeError, match=words):
        bpy.ops.relume.palette_create()
    assert palette_tables.table_of(design) == before


def test_files_that_are_no_spectra_for_a_palette(tmp_path):
    bpy.ops.wm.read_factory_settings()
    bpy.ops.relume.palette_new(example="stays")
    design = palettes.active(bpy.context.scene)
    for text, kind, words in (
        ("400,0.1\n500,0.2\n600,0.3\n", "REFLECTANCE", "3 samples"),
        ("800,1\n900,1\n", "LIGHT", "no power"),
        ("hello\n", "LIGHT", "does not begin with a wavelength"),
    ):
        path = tmp_path / "bad.csv"
        path.write_text(text)
        before = palette_tables.table_of(design)
        with pytest.raises(RuntimeError, match=words):
            bpy.ops.relume.palette_add_file(kind=kind, filepath=str(path))
        assert palette_tables.table_of(design) == before


def test_spectra_outside_their_range_are_told(capfd):
    assigned("black")
    assert "coefficients below 0 render as 0" in capfd.readouterr().out


def test_the_reference_of_the_design_is_the_render(tmp_path):
    """Colours of a given paint under two lights, in the matrix and in Cycles at nine channels."""
    scene, materials = striped(1)
    red = library.reflectance("ColorChecker: red")
    spectra.assign(
        materials[0], materials[0].node_tree.nodes["Diffuse BSDF"].inputs["Color"], spectra.new_reflectance(red)
    )
    lights = tuple(palette.Entry(name, library.illuminant(name)) for name in ("D65", "A"))
    matrix = palette.patches(palette.Palette(lights, (replace(palette.Entry("red"), spectrum=red),)))[0][0]
    shown = seen(scene, bases.fitted(9), tmp_path, ["D65", "A"])
    for light in range(2):
        assert differences.delta_E_2000(shown[light, 0], matrix[light], shown[light, -1]) < 0.3
