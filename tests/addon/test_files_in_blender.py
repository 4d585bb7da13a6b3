"""Files of spectra as Blender takes them: dropped, imported, exported; and what its menus offer."""

import types

import bpy
import pytest

from relume.addon.graph import places
from relume.addon.scene import setup
from relume.addon.ui import spectrum_files
from relume.core.model import bases
from relume.core.spectra import files


@pytest.fixture
def paint(tmp_path):
    path = tmp_path / "paint.csv"
    path.write_text("nm,Ochre\n400,0.1\n550,0.4\n700,0.6\n")
    return path


@pytest.fixture
def lamp(tmp_path):
    path = tmp_path / "lamp.csv"
    path.write_text("nm,power\n400,1\n700,2\n")
    return path


@pytest.fixture
def ready(startup):
    """The start-up scene set up; the cube is active. Returns the scene."""
    bpy.context.view_layer.objects.active = bpy.data.objects["Cube"]
    setup.set_up(startup, bases.fitted(3))
    return startup


def base_of(material):
    return places.chosen_at(material.node_tree.nodes["Principled BSDF"], "Base Color", places.REFLECTANCE)


def test_a_spectrum_becomes_that_of_the_active_material(startup, paint, tmp_path):
    bpy.context.view_layer.objects.active = bpy.data.objects["Cube"]
    material = bpy.data.objects["Cube"].active_material
    assert bpy.ops.relume.import_spectrum(filepath=str(paint), use="MATERIAL") == {"FINISHED"}
    assert base_of(material) == "Ochre"
    out = tmp_path / "out.csv"
    assert bpy.ops.relume.export_spectrum(filepath=str(out), use="MATERIAL") == {"FINISHED"}
    (written,) = files.read(out)
    assert written.name == "Ochre" and written.values.tolist() == [0.1, 0.4, 0.6]


def test_a_spectrum_becomes_that_of_another_material(startup, paint):
    bpy.context.view_layer.objects.active = bpy.data.objects["Cube"]
    other = bpy.data.materials["textured"]
    assert bpy.ops.relume.import_spectrum(filepath=str(paint), use="MATERIAL", material="textured") == {"FINISHED"}
    assert base_of(other) == "Ochre" and base_of(bpy.data.objects["Cube"].active_material) == ""


def test_a_spectrum_becomes_that_of_a_lamp(ready, lamp, tmp_path):
    row = ready.relume.light_groups[0]
    assert bpy.ops.relume.import_spectrum(filepath=str(lamp), use="LIGHT", group=row.name) == {"FINISHED"}
    assert row.source == "FILE" and row.label == "lamp.csv" and row.spectrum().values.tolist() == [1.0, 2.0]
    out = tmp_path / "out.csv"
    assert bpy.ops.relume.export_spectrum(filepath=str(out), use="LIGHT", group=row.name) == {"FINISHED"}
    assert files.illuminant(out).values.tolist() == [1.0, 2.0]


def test_three_sensitivities_become_the_observer(ready, tmp_path):
    path = tmp_path / "camera.csv"
    path.write_text("nm,r,g,b\n400,0.1,0.2,0.9\n550,0.2,0.9,0.2\n700,0.9,0.2,0.1\n")
    assert bpy.ops.relume.import_spectrum(filepath=str(path), use="OBSERVER") == {"FINISHED"}
    assert ready.relume.observer == "FILE" and ready.relume.observer_origin == "camera.csv"
    assert ready.relume.problem == ""


@pytest.mark.parametrize(
    ("use", "words"),
    [
        ("LIGHT", "needs a scene that is set up"),
        ("OBSERVER", "holds 1 spectra; an observer or camera has three"),
        ("MATERIAL", "no material to give a spectrum to"),
    ],
)
def test_what_cannot_be_done_with_a_file_is_said(startup, paint, use, words):
    bpy.context.view_layer.objects.active = bpy.data.objects["Camera"]
    with pytest.raises(RuntimeError, match=words):
        bpy.ops.relume.import_spectrum(filepath=str(paint), use=use)
    assert startup.relume.observer == "CIE 1931 2°"


def test_what_is_under_the_cursor_takes_a_dropped_file(ready, paint, monkeypatch):
    """`_meant` by itself: a bpy without a window has no 3D view to drop on."""
    row, said = ready.relume.light_groups[0], types.SimpleNamespace(filepath=str(paint), material="", group="")
    meant = spectrum_files.ImportSpectrum._meant
    under = {"lamp": bpy.data.objects["Light"], "material": bpy.data.materials["textured"]}
    monkeypatch.setattr(spectrum_files.under_cursor, "lamp_at", lambda *_: under["lamp"])
    monkeypatch.setattr(spectrum_files.under_cursor, "material_at", lambda *_: under["material"])
    assert meant(said, bpy.context, None) == "LIGHT" and said.group == row.name
    under["lamp"] = None
    assert meant(said, bpy.context, None) == "MATERIAL" and said.material == "textured"
    under["material"] = None
    assert meant(said, bpy.context, None) == "MATERIAL", "the active material"
    bpy.context.view_layer.objects.active = bpy.data.objects["Light"]
    assert meant(said, bpy.context, None) == "LIGHT"


def test_files_are_taken_where_they_are_dropped(relume):
    for handler in (spectrum_files.SpectrumDrop, spectrum_files.ExrDrop):
        for area, taken in (("VIEW_3D", True), ("IMAGE_EDITOR", True), ("TEXT_EDITOR", False)):
            assert handler.poll_drop(types.SimpleNamespace(area=types.SimpleNamespace(type=area))) is taken
        assert not handler.poll_drop(types.SimpleNamespace(area=None))
        for name in filter(None, (handler.bl_import_operator, getattr(handler, "bl_export_operator", ""))):
            assert name.removeprefix("relume.") in dir(bpy.ops.relume), name


class Layout:
    """Notes what a menu draws."""

    def __init__(self):
        self.drawn = []

    def __getattr__(self, name):
        def called(what="", *_, **options):
            self.drawn.append(what)
            return types.SimpleNamespace()

        return called


def draw(function, **context):
    layout = Layout()
    function(types.SimpleNamespace(layout=layout), types.SimpleNamespace(**{"scene": bpy.context.scene} | context))
    return {name for name in layout.drawn if "." in name}


def test_menus_of_materials_and_lights_offer_spectra(ready):
    from relume.addon.ui import menus

    cube, light = bpy.data.objects["Cube"], bpy.data.objects["Light"]
    of_material = {"relume.assign_spectrum", "relume.assign_spectrum_file"}
    assert draw(menus._object_menu, object=cube) == of_material
    assert draw(menus._object_menu, object=light) == {"relume.choose_illuminant", "relume.import_spectrum"}
    assert draw(menus._object_menu, object=bpy.data.objects["Camera"]) == set()
    bpy.context.view_layer.objects.active = cube
    bpy.ops.relume.assign_spectrum(
        node="Principled BSDF", socket="Base Color", takes="reflectance", spectrum="ColorChecker: red"
    )
    assert draw(menus._material_menu, object=cube) == of_material | {"relume.clear_spectrum"}
    socket = cube.active_material.node_tree.nodes["Principled BSDF"].inputs["Base Color"]
    assert draw(menus._button_menu, object=cube, button_pointer=socket) == of_material | {"relume.clear_spectrum"}
    roughness = cube.active_material.node_tree.nodes["Principled BSDF"].inputs["Roughness"]
    assert draw(menus._button_menu, object=cube, button_pointer=roughness) == set()
    assert draw(menus._button_menu, object=cube, button_pointer=None) == set()


def test_every_command_is_in_a_menu_so_that_f3_finds_it(ready):
    """All but those of a row of a list, and of a place in a panel."""
    from relume.addon.ui import menus

    of_rows = "expected add_transfer_range remove_transfer_range add_lights change_blend light_dial forget_snapshot"
    of_rows += " stop_report preset_add assign_spectrum assign_spectrum_file clear_spectrum favourite move_group"
    there = {f"relume.{name}" for name in dir(bpy.ops.relume) if not name.startswith("palette_")}
    drawn = draw(menus.CommandsMenu.draw, object=bpy.data.objects["Camera"])
    drawn |= draw(menus._import_menu) | draw(menus._export_menu) | draw(menus.IlluminantsMenu.draw)
    assert there - drawn - {f"relume.{name}" for name in of_rows.split()} == set()
