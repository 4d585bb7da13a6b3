"""What artists do to a file while it is set up: undo, save, append, link, copy, rename, delete. Failures part-way."""

import bpy
import pytest
from dump import differences, dump

from relume.addon.graph import nodes
from relume.addon.scene import setup, view_layers
from relume.addon.store import remarks
from relume.core.model import bases

lamps_without_nodes = pytest.mark.skipif(
    bpy.app.version < (5, 1, 0), reason="Blender 5.0 cannot take back a lamp's node tree: it stays, unused"
)


def traces() -> list[str]:
    """What Relume has left in the file: its own node groups, custom properties of scenes, layers and nodes."""
    found = [tree.name for tree in bpy.data.node_groups if tree.get(nodes.ROLE) not in {None, "spectrum"}]
    for scene in bpy.data.scenes:
        found += [key for key in scene.keys() if key.startswith("relume_")]
        found += [key for layer in scene.view_layers for key in layer.keys() if key.startswith("relume_")]
    for owner in (*bpy.data.materials, *bpy.data.worlds, *bpy.data.lights):
        found += [f"{owner.name}: {key}" for key in owner.keys() if key.startswith("relume_")]
        tree = owner.node_tree  # a lamp of Blender 5.0 may have none
        found += [f"{owner.name}: {n.name}" for n in (tree.nodes if tree else ()) if nodes.role(n) in nodes.INSERTED]
    return found


@lamps_without_nodes
@pytest.mark.parametrize(
    ("function", "call"),
    [
        ("graph.spectra.update_all", 1),
        ("graph.lights.take_colours", 1),
        ("graph.sockets.shadings_of", 1),
        ("graph.nodes.insert", 1),
        ("graph.nodes.insert", 3),
        ("graph.node_groups.light_group", 1),
        ("store.remarks.write", 1),
        ("scene.view_layers.drive", 1),
        ("scene.view_layers.write_view", 2),
        ("graph.node_groups.recombination_group", 1),
        ("scene.compositing._feed", 1),
        ("scene.compositing.write_matrices", 1),
    ],
)
def test_a_failure_at_any_point_gives_the_scene_back(startup, monkeypatch, function, call):
    import importlib

    module_name, _, name = function.rpartition(".")
    module = importlib.import_module(f"relume.addon.{module_name}")
    real, calls = getattr(module, name), []

    def fail(*arguments, **named):
        calls.append(1)
        if len(calls) == call:
            raise KeyError("injected")
        return real(*arguments, **named)

    before = dump()
    monkeypatch.setattr(module, name, fail)
    with pytest.raises(setup.SetupError, match=r"is as it was.*injected"):
        setup.set_up(startup)
    assert differences(before, dump()) == []


def test_undo_and_redo(startup):
    bpy.ops.ed.undo_push(message="before")
    assert bpy.ops.relume.set_up() == {"FINISHED"}
    bpy.ops.ed.undo_push(message="set up")
    bpy.ops.ed.undo()
    assert not bpy.context.scene.relume.is_set_up and traces() == []
    bpy.ops.ed.redo()
    scene = bpy.context.scene
    assert scene.relume.is_set_up and view_layers.pass_layers(scene)
    setup.remove(scene)
    assert traces() == []


@lamps_without_nodes
def test_save_and_load_between(startup, tmp_path):
    path = str(tmp_path / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    before = dump()
    setup.set_up(bpy.context.scene)
    noted = remarks.of(bpy.context.scene)
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    scene = bpy.context.scene
    assert scene.relume.is_set_up and remarks.of(scene) == noted
    setup.remove(scene)
    assert [d for d in differences(before, dump()) if "filepath" not in d] == []


def test_a_material_that_is_appended_brings_no_light_of_its_own(startup, tmp_path):
    path = str(tmp_path / "source.blend")
    setup.set_up(startup)
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_factory_settings()
    with bpy.data.libraries.load(path) as (_, wanted):
        wanted.materials = ["textured"]
    material = wanted.materials[0]
    bpy.data.objects["Cube"].material_slots[0].material = material
    scene = bpy.context.scene
    setup.set_up(scene, bases.fitted(12))
    base = material.node_tree.nodes["Principled BSDF"].inputs["Base Color"]
    assert nodes.role(base.links[0].from_node) == "upsample"
    assert nodes.role(base.links[0].from_node.inputs[0].links[0].from_node) == "", "not twice"
    setup.remove(scene)
    assert base.links[0].from_node.type == "TEX_IMAGE"
    assert traces() == []


def test_a_linked_material_that_is_spectral_already_is_no_remark(startup, tmp_path):
    path = str(tmp_path / "source.blend")
    setup.set_up(startup)
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_factory_settings()
    with bpy.data.libraries.load(path, link=True) as (_, wanted):
        wanted.materials = ["textured"]
    bpy.data.objects["Cube"].material_slots[0].material = wanted.materials[0]
    scene = bpy.context.scene
    setup.set_up(scene)
    assert not any("textured" in str(remark) for remark in remarks.of(scene))
    setup.remove(scene)
    assert not any(tree.get(nodes.ROLE) and tree.library is None for tree in bpy.data.node_groups)


def test_copies_made_while_set_up_are_restored_too(startup):
    setup.set_up(startup)
    copied = bpy.data.objects["Cube"].active_material.copy()
    bpy.data.objects["Cube"].data.materials.append(copied)
    lamp = bpy.data.objects.new("second", bpy.data.lights["Light"].copy())
    startup.collection.objects.link(lamp)
    scene = startup.copy()
    setup.remove(startup)
    setup.remove(scene)
    assert tuple(copied.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value) == pytest.approx(
        (0.7, 0.2, 0.1, 1.0)
    )
    assert tuple(lamp.data.color) == pytest.approx((1.0, 0.8, 0.5))
    assert traces() == []


def test_renamed_and_deleted_parts_are_no_hindrance(startup):
    setup.set_up(startup)
    for block in (*bpy.data.node_groups, *bpy.data.materials, *bpy.data.lights, *bpy.data.objects):
        block.name = f"renamed {block.name}"
    for layer in startup.view_layers:
        layer.name = f"Ebene {layer.name}"
    setup.set_up(startup)
    assert len(view_layers.pass_layers(startup)) == 1
    bpy.data.objects.remove(bpy.data.objects["renamed Cube"])
    bpy.data.materials.remove(bpy.data.materials["renamed textured"])
    startup.view_layers.remove(next(iter(view_layers.pass_layers(startup).values()))[-1])
    bpy.data.node_groups.remove(next(t for t in bpy.data.node_groups if t.get(nodes.ROLE) == "upsample"))
    setup.remove(startup)
    assert traces() == []
    assert [layer.use for layer in startup.view_layers] == [True]


@pytest.mark.parametrize("gone", ["recombination", "view", "light", "compositing"])
def test_a_group_that_was_deleted_is_no_hindrance(startup, gone):
    setup.set_up(startup)
    bpy.data.node_groups.remove(next(t for t in bpy.data.node_groups if t.get(nodes.ROLE) == gone))
    setup.remove(startup)
    assert traces() == []
    setup.set_up(startup)
    assert startup.relume.is_set_up


@lamps_without_nodes
def test_several_view_layers_keep_what_they_have(startup):
    first = startup.view_layers[0]
    second = startup.view_layers.new("second")
    unused = startup.view_layers.new("unused")
    unused.use = False
    second.samples, second.use_pass_z = 3, True
    second.layer_collection.children[0].holdout = True
    override = bpy.data.materials.new("override")
    second.material_override = override
    before = dump()
    setup.set_up(startup)
    layers = view_layers.pass_layers(startup)
    assert set(layers) == {first.name, "second"}
    for copy in layers["second"]:
        assert copy.material_override == override
        assert copy.layer_collection.children[0].holdout
    setup.remove(startup)
    assert differences(before, dump()) == []


def test_the_operators_tell_what_is_wrong(startup):
    startup.camera = None
    with pytest.raises(RuntimeError, match="no camera"):
        bpy.ops.relume.set_up()
    assert traces() == []
