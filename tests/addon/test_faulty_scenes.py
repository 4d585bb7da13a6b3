"""Scenes with something wrong: they are rendered as Blender renders them, or one sentence says what is wrong."""

from pathlib import Path

import bpy
import pytest

from relume.addon.scene import render, setup
from relume.addon.store import remarks


@pytest.fixture
def small(startup):
    startup.render.resolution_x = startup.render.resolution_y = 8
    startup.cycles.samples = 1
    startup.relume.channels = "auto"
    return startup


@pytest.fixture
def with_library(small, tmp_path):
    """link(**names): data-blocks of a library that is then deleted, in a file that is opened again."""

    def link(gone: bool, **names):
        library, path = tmp_path / "library.blend", tmp_path / "scene.blend"
        bpy.ops.wm.save_as_mainfile(filepath=str(library), copy=True)
        for name in names.get("objects", ()):
            bpy.data.objects.remove(bpy.data.objects[name])
        with bpy.data.libraries.load(str(library), link=True) as (_, wanted):
            for kind, chosen in names.items():
                setattr(wanted, kind, chosen)
        scene = bpy.context.scene
        for thing in wanted.objects:
            scene.collection.objects.link(thing)
        scene.camera = bpy.data.objects["Camera"]
        bpy.ops.wm.save_as_mainfile(filepath=str(path))
        if gone:
            library.unlink()
        try:
            bpy.ops.wm.open_mainfile(filepath=str(path))
        except RuntimeError:
            assert gone, "Blender says that a library is missing, and opens the file"
        return bpy.context.scene

    return link


def sentences(scene) -> list[str]:
    return [str(remark) for remark in remarks.of(scene)]


def rendered(scene, folder: Path):
    setup.set_up(scene)
    return next(iter(render.render(scene, folder).image.groups.values()))


@pytest.mark.parametrize("expression", ["nobody_knows_this", "1/0", "3 +"])
def test_a_broken_driver_is_told(small, tmp_path, expression):
    bpy.data.lights["Light"].driver_add("energy").driver.expression = expression
    bpy.context.view_layer.update()
    assert rendered(small, tmp_path).max() > 0
    assert [words for words in sentences(small) if words.startswith("Light, energy: its driver cannot be worked out")]


def test_a_driver_that_looks_at_nothing_is_told(small, tmp_path):
    driver = small.driver_add("cycles.seed").driver
    variable = driver.variables.new()
    driver.expression = variable.name
    bpy.context.view_layer.update()
    assert rendered(small, tmp_path).max() > 0
    assert [words for words in sentences(small) if words.startswith("Scene, cycles.seed: its driver")]


def test_things_of_a_library_that_is_gone_are_told(with_library, tmp_path):
    scene = with_library(True, objects=["Cube", "Light"])
    assert rendered(scene, tmp_path).max() > 0, "the world shines"
    assert {words.partition(":")[0] for words in sentences(scene) if "library.blend cannot be found" in words} >= {
        "Cube",
        "Light",
    }


def test_a_camera_of_a_library_that_is_gone_is_refused(with_library):
    scene = with_library(True, objects=["Camera"])
    with pytest.raises(setup.SetupError, match=r"camera 'Camera': its library .*library.blend cannot be found"):
        setup.set_up(scene)


def test_a_linked_camera_is_looked_through(with_library, tmp_path):
    scene = with_library(False, objects=["Camera"])
    assert scene.camera.library is not None
    assert rendered(scene, tmp_path).max() > 0


def test_a_lamp_may_be_looked_through_and_a_mesh_is_refused(small, tmp_path):
    small.camera = bpy.data.objects["Light"]
    assert rendered(small, tmp_path).max() > 0
    setup.remove(small)
    small.camera = bpy.data.objects["Cube"]
    with pytest.raises(setup.SetupError, match="'Cube', which is neither a camera nor a lamp"):
        setup.set_up(small)


def test_a_scene_without_a_world(small, tmp_path):
    small.world = None
    assert rendered(small, tmp_path).max() > 0
    bpy.data.objects.remove(bpy.data.objects["Light"])
    with pytest.raises(setup.SetupError, match="has no light"):
        setup.set_up(small)


def test_a_view_layer_without_collections_is_told(small, tmp_path):
    for collection in small.view_layers[0].layer_collection.children:
        collection.exclude = True
    small.view_layers[0].name = "empty"
    for thing in list(small.collection.objects):
        thing.hide_render = True
    assert rendered(small, tmp_path).max() > 0, "the world shines"
    assert [words for words in sentences(small) if words.startswith("empty: no object is in this view layer")]


def test_several_views_are_refused_before_the_render(small, tmp_path):
    small.render.use_multiview = True
    with pytest.raises(render.RenderError, match="several views"):
        rendered(small, tmp_path)
    assert list(tmp_path.iterdir()) == []
