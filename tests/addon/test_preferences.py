"""What a user prefers: of new scenes, of the search, and set-ups kept as Blender's presets."""

import time
import types
from pathlib import Path

import bpy
import pytest

from relume.addon.store import preferred
from relume.addon.ui import illuminants, own_spectra
from relume.addon.ui.preferences import PresetsMenu, RelumePreferences
from relume.core.spectra import library


@pytest.fixture
def prefers(relume, monkeypatch, tmp_path):
    """Sets preferences, as a Blender with a window has them."""
    chosen = types.SimpleNamespace(
        channels="auto", tolerance=1.0, lamp_folder="", paint_folder="", favourites="", bl_rna=RelumePreferences.bl_rna
    )
    monkeypatch.setattr(preferred, "of", lambda: chosen)

    def choose(**values):
        vars(chosen).update(values)

    return choose


def test_a_scene_that_says_nothing_has_the_preferred_channels_and_keeps_them(startup, prefers):
    startup.relume.property_unset("channels")
    prefers(channels="6", tolerance=0.5)
    assert (startup.relume.channels, startup.relume.tolerance) == ("6", 0.5)
    assert not startup.relume.is_property_set("channels")
    assert bpy.ops.relume.set_up() == {"FINISHED"}
    assert startup.relume.model().channels == 6 and startup.relume.is_property_set("channels")
    prefers(channels="9", tolerance=2.0)
    assert (startup.relume.channels, startup.relume.tolerance) == ("6", 0.5), "another user's file stays as it is"
    other = bpy.data.scenes.new("other")
    assert other.relume.channels == "9"
    other.relume.channels = "auto"
    assert other.relume.channels == "auto"


def test_without_a_window_preferences_change_nothing(startup):
    assert preferred.of() is None
    startup.relume.property_unset("channels")
    assert startup.relume.channels == "auto" and startup.relume.tolerance == 1.0


def test_folders_of_the_user_stand_in_the_searches(startup, prefers, tmp_path):
    lamps, paints = tmp_path / "lamps", tmp_path / "paints"
    for folder in (lamps, paints):
        folder.mkdir()
    (lamps / "My lamp.csv").write_text("nm,power\n400,1\n700,2\n")
    (lamps / "notes.pdf").write_text("no spectrum")
    (paints / "Ochre.csv").write_text("nm,Ochre\n400,0.1\n700,0.6\n")
    prefers(lamp_folder=str(lamps), paint_folder=str(paints))
    assert own_spectra.listed(own_spectra.LAMPS) == [(str(lamps / "My lamp.csv"), "My lamp")]
    bpy.ops.relume.set_up()
    row = startup.relume.light_groups[0]
    lamp = str(lamps / "My lamp.csv")
    assert bpy.ops.relume.choose_illuminant(group=0, illuminant=lamp) == {"FINISHED"}
    assert row.source == "FILE" and row.label == "My lamp.csv" and row.spectrum().values.tolist() == [1.0, 2.0]
    row.source = "BLEND"
    assert bpy.ops.relume.choose_illuminant(group=0, part=1, illuminant=lamp) == {"FINISHED"}
    assert row.blend[1].illuminant == "My lamp" and row.blend[1].spectrum().values.tolist() == [1.0, 2.0]
    assert bpy.ops.relume.choose_illuminant(group=0, illuminant="FL2") == {"FINISHED"}
    assert row.label == "FL2"
    bpy.context.view_layer.objects.active = bpy.data.objects["Cube"]
    place = {"node": "Principled BSDF", "socket": "Base Color", "takes": "reflectance"}
    assert bpy.ops.relume.assign_spectrum(**place, spectrum=str(paints / "Ochre.csv")) == {"FINISHED"}
    assert "Ochre" in {tree.name for tree in bpy.data.node_groups}
    time.sleep(0.01)
    (lamps / "Another.spd").write_text("400 1\n700 2\n")
    assert [name for _, name in own_spectra.listed(own_spectra.LAMPS)] == ["Another", "My lamp"]
    prefers(lamp_folder=str(tmp_path / "gone"))
    assert own_spectra.listed(own_spectra.LAMPS) == []


def test_favourites_come_first_in_the_search(startup, prefers):
    every = [name for names in library.illuminants().values() for name in names]
    assert [item[0] for item in illuminants._illuminants()] == every
    bpy.ops.relume.set_up()
    for name in ("HP1", "A"):
        assert bpy.ops.relume.favourite(name=name) == {"FINISHED"}
    offered = illuminants._illuminants()
    assert [item[0] for item in offered[:2]] == ["HP1", "A"] and offered[0][1].startswith("★")
    assert sorted(item[0] for item in offered) == sorted(every), "each once"
    assert len({item[4] for item in offered}) == len(offered)
    assert bpy.ops.relume.choose_illuminant(group=0, illuminant="A") == {"FINISHED"}
    assert startup.relume.light_groups[0].illuminant == "A"
    bpy.ops.relume.favourite(name="HP1")
    assert [item[0] for item in illuminants._illuminants()[:2]] == ["A", every[0]]
    bpy.ops.relume.favourite(name="A")


def test_without_preferences_there_are_no_favourites(startup):
    with pytest.raises(RuntimeError, match="enabled in a window"):
        bpy.ops.relume.favourite(name="A")


def test_the_menu_has_every_family():
    assert tuple(library.illuminants()) == illuminants.FAMILIES


@pytest.fixture
def titled(monkeypatch):
    """Blender gives the menu the name of the preset that was chosen."""
    monkeypatch.setattr(PresetsMenu, "bl_label", PresetsMenu.bl_label)


def test_a_set_up_is_kept_as_a_preset(startup, tmp_path, monkeypatch, titled):
    monkeypatch.setattr(bpy.utils, "user_resource", lambda kind, path="", create=False: _folder(tmp_path / path))
    settings = startup.relume
    settings.channels, settings.tolerance, settings.grouping = "6", 0.25, "COLLECTION"
    assert bpy.ops.relume.preset_add(name="Stills") == {"FINISHED"}
    (kept,) = tmp_path.rglob("*.py")
    settings.channels, settings.tolerance, settings.grouping = "auto", 2.0, "KEEP"
    bpy.ops.script.execute_preset(filepath=str(kept), menu_idname="RELUME_MT_presets")
    assert (settings.channels, settings.tolerance, settings.grouping) == ("6", 0.25, "COLLECTION")


def test_presets_that_ship_can_be_applied(startup, titled):
    shipped = [Path(path) for path in bpy.utils.preset_paths("relume/set_up")]
    presets = sorted(path for folder in shipped for path in folder.glob("*.py"))
    assert [path.stem for path in presets] == ["measurement", "quick_look", "still_picture"]
    channels = []
    for path in presets:
        assert bpy.ops.script.execute_preset(filepath=str(path), menu_idname="RELUME_MT_presets") == {"FINISHED"}
        channels.append(startup.relume.channels)
    assert channels == ["24", "3", "auto"]


def _folder(path):
    path.mkdir(parents=True, exist_ok=True)
    return str(path)


def test_no_field_of_a_path_is_red_for_being_relative(startup):
    """Blender shows a path in red that begins with // where the property does not say that it may."""
    row = startup.relume.light_groups.add()
    for known in (row.bl_rna.properties["path"], startup.relume.bl_rna.properties["observer_path"]):
        assert known.is_path_supports_blend_relative
    folder = bpy.ops.relume.report.get_rna_type().properties["folder"]
    assert folder.is_path_supports_blend_relative and folder.is_path_output, "it need not be there before"
