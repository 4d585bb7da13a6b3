"""What artists do after a scene is set up, and what it then carries. `tests/artist` plays such edits by chance."""

import bpy
import numpy as np
import pytest
from test_render import composite

from relume.addon.graph import nodes
from relume.addon.host import animation
from relume.addon.scene import compositing_nodes, follower, light_groups, render_settings, setup, view_layers
from relume.addon.store import remarks
from relume.core.model import bases


@pytest.fixture
def ready(startup):
    setup.set_up(startup, bases.fitted(9))
    return startup


def passes(scene) -> list:
    return view_layers.pass_layers(scene)["ViewLayer"]


def base_colour():
    return bpy.data.objects["Cube"].active_material.node_tree.nodes["Principled BSDF"].inputs["Base Color"]


def pixels(scene, path) -> np.ndarray:
    """The composited picture, as F12 renders it."""
    return composite(scene, path)


def afresh(scene, path) -> np.ndarray:
    model = scene.relume.model()
    setup.remove(scene)
    setup.set_up(scene, model)
    return composite(scene, path)


def test_samples_of_later_are_dealt_out(ready):
    ready.cycles.samples = 256
    follower.settle(ready)
    counts = [layer["relume_cycles_sample_subset_length"] for layer in passes(ready)]
    assert sum(counts) == 256 and max(counts) < 128
    ready.cycles.use_sample_subset = True
    ready.cycles.adaptive_threshold = 0.2
    setup.remove(ready)
    assert ready.cycles.samples == 256 and round(ready.cycles.adaptive_threshold, 6) == 0.2, "edits stay"


def test_a_grey_cube_made_red_and_a_red_lamp_are_red_in_that_very_render(startup, tmp_path):
    base_colour().default_value = (0.8, 0.8, 0.8, 1.0)
    setup.set_up(startup, bases.fitted(9))
    base_colour().default_value = (0.8, 0.02, 0.02, 1.0)
    light = bpy.data.lights.new("red", "POINT")
    light.color, light.energy = (1.0, 0.05, 0.05), 2000.0
    thing = bpy.data.objects.new("red", light)
    thing.location, thing.lightgroup = (3.0, -3.0, 3.0), "new"
    startup.collection.objects.link(thing)
    shown = pixels(startup, tmp_path / "a.exr")
    middle = shown[14:18, 14:18].mean(axis=(0, 1))
    assert middle[0] > 8 * middle[1] and middle[0] > 8 * middle[2]
    assert [row.name for row in startup.relume.lit] == ["new", "Everything else"]
    np.testing.assert_array_equal(shown, afresh(startup, tmp_path / "b.exr"))


def test_what_is_written_behind_a_node_counts_and_so_does_the_node(ready):
    node = base_colour().links[0].from_node
    base_colour().default_value = (0.1, 0.2, 0.9, 1.0)  # as an importer or a script does
    follower.settle(ready)
    assert node.inputs[0].default_value[:] == base_colour().default_value[:]
    node.inputs[0].default_value = (0.3, 0.9, 0.1, 1.0)  # as an artist does
    follower.settle(ready)
    setup.remove(ready)
    assert [round(v, 6) for v in base_colour().default_value] == [0.3, 0.9, 0.1, 1.0]


def test_the_colour_of_a_lamp_is_taken_over_from_wherever_it_was_chosen(ready):
    light = bpy.data.lights["Light"]
    light.color = (0.2, 0.4, 1.0)
    follower.settle(ready)
    node = next(node for node in light.node_tree.nodes if nodes.role(node) == "light")
    assert tuple(light.color) == (1.0, 1.0, 1.0)
    np.testing.assert_allclose(node.inputs["Tint"].default_value[:3], (0.2, 0.4, 1.0), rtol=1e-6)
    node.inputs["Tint"].default_value = (0.9, 0.3, 0.2, 1.0)
    setup.remove(ready)
    np.testing.assert_allclose(light.color, (0.9, 0.3, 0.2), rtol=1e-6)


def test_nothing_is_written_where_nothing_was_edited(ready, monkeypatch):
    follower.settle(ready)
    written = []
    monkeypatch.setattr(nodes, "insert", lambda *_: written.append("node"))
    monkeypatch.setattr(bpy.types.Scene, "update_tag", lambda *_: written.append("tag"), raising=False)
    before = [node.name for node in ready.compositing_node_group.nodes], len(bpy.data.node_groups)
    follower.settle(ready)
    assert written == []
    assert ([node.name for node in ready.compositing_node_group.nodes], len(bpy.data.node_groups)) == before


def test_the_same_passes_stay_when_their_settings_change(ready):
    before = {layer.name: layer.as_pointer() for layer in passes(ready)}
    source = ready.view_layers["ViewLayer"]
    source.use_pass_z = source.use_pass_diffuse_color = True
    source.layer_collection.children[0].holdout = True
    source["own"] = 0.5
    passes(ready)[0].use_pass_normal = True
    follower.settle(ready)
    assert {layer.name: layer.as_pointer() for layer in passes(ready)} == before
    for number, layer in enumerate(passes(ready)):
        assert layer.use_pass_z == (number == 0) and layer.layer_collection.children[0].holdout and layer["own"] == 0.5
    assert source.use_pass_normal, "what is turned on in a pass belongs to the artist's own view layer"


def test_a_renamed_a_copied_and_a_new_view_layer_have_their_passes(ready):
    ready.view_layers["ViewLayer"].name = "Left"
    ready.view_layers.new("Right")
    follower.settle(ready)
    found = view_layers.pass_layers(ready)
    assert {name: [layer.name for layer in layers] for name, layers in found.items()} == {
        "Left": ["Left 1", "Left 2", "Left 3"],
        "Right": ["Right 1", "Right 2", "Right 3"],
    }
    first = compositing_nodes.recombinations(ready)[0].inputs["Alpha"].links[0].from_node
    assert first.layer == "Left 1"
    ready.view_layers.remove(ready.view_layers["Left"])
    follower.settle(ready)
    assert sorted(layer.name for layer in ready.view_layers) == ["Right", "Right 1", "Right 2", "Right 3"]


def test_another_engine_renders_the_artists_own_view_layers(ready):
    ready.render.engine = "BLENDER_WORKBENCH"
    follower.settle(ready)
    assert view_layers.pass_layers(ready) == {} and ready.view_layers["ViewLayer"].use
    assert render_settings.is_suspended(ready) and ready.relume.is_set_up
    assert ready.compositing_node_group is None and not ready.render.use_persistent_data
    ready.render.engine = "CYCLES"
    follower.settle(ready)
    assert len(passes(ready)) == 3 and not ready.view_layers["ViewLayer"].use
    assert len(compositing_nodes.recombinations(ready)) == 1
    ready.render.engine = "BLENDER_WORKBENCH"
    setup.remove(ready)
    assert ready.render.engine == "BLENDER_WORKBENCH", "edits stay"


def test_each_scene_has_its_own_light(ready):
    copied = ready.copy()
    follower.settle(ready)
    follower.settle(copied)
    copied.relume.light_groups[0].illuminant = "HP1"
    setup.relight(copied)
    groups = [compositing_nodes.recombinations(scene)[0].node_tree for scene in (ready, copied)]
    assert groups[0] != groups[1]
    assert ready.relume.light_groups[0].illuminant == "D65"
    assert ready.compositing_node_group != copied.compositing_node_group


def test_a_scene_made_with_the_settings_of_another_is_no_spectral_one(ready):
    with bpy.context.temp_override(scene=ready):
        bpy.ops.scene.new(type="EMPTY")
    made = next(scene for scene in bpy.data.scenes if scene != ready)
    assert made.relume.is_set_up
    follower.settle(made)
    assert not made.relume.is_set_up and ready.relume.is_set_up


def test_a_light_groups_pass_is_relit_and_a_colour_pass_is_named(room, tmp_path):
    """The room has two lamps, in light groups: the artist composites one of them, and looks at a colour pass."""
    tree = bpy.data.node_groups.new("own", "CompositorNodeTree")
    tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    render, output, viewer = (
        tree.nodes.new(kind) for kind in ("CompositorNodeRLayers", "NodeGroupOutput", "CompositorNodeViewer")
    )
    room.compositing_node_group, room.relume.channels = tree, "9"
    layer = room.view_layers[0]
    layer.use_pass_diffuse_color = True
    for group in ("tungsten", "fluorescent"):
        if group not in layer.lightgroups:
            layer.lightgroups.add(name=group)
    render.scene, render.layer = room, layer.name
    tree.links.new(render.outputs["Combined_tungsten"], output.inputs["Image"])
    tree.links.new(render.outputs["Diffuse Color"], viewer.inputs["Image"])
    setup.set_up(room)
    alone = composite(room, tmp_path / "alone.exr")
    recombination = compositing_nodes.recombinations(room)[0]
    assert output.inputs["Image"].links[0].from_node == recombination
    assert any("Diffuse Color" in str(remark) for remark in remarks.of(room))
    room.relume.light_groups["fluorescent"].mute = True
    tree.links.new(recombination.outputs["Image"], output.inputs["Image"])
    np.testing.assert_allclose(composite(room, tmp_path / "muted.exr"), alone, rtol=1e-4, atol=1e-5)
    setup.remove(room)
    assert render.outputs["Diffuse Color"].is_linked and render.layer == layer.name


def test_groups_made_by_light_are_in_the_view_layers_list(ready):
    light_groups.regroup(ready, "LIGHT")
    assert bpy.data.objects["Light"].lightgroup in ready.view_layers["ViewLayer"].lightgroups
    setup.remove(ready)
    assert bpy.data.objects["Light"].lightgroup in ready.view_layers["ViewLayer"].lightgroups


def test_a_plan_is_made_again_when_the_scene_needs_more(startup):
    base_colour().default_value = (0.5, 0.5, 0.5, 1.0)
    bpy.data.lights["Light"].color = (1.0, 1.0, 1.0)
    startup.relume.channels, startup.relume.tolerance, startup.relume.switching = "auto", 0.3, "LIT"
    for material in bpy.data.materials:
        if material.name == "textured":
            bpy.data.materials.remove(material)
    setup.set_up(startup)
    assert startup.relume.model().passes == 1
    base_colour().default_value = (0.9, 0.05, 0.3, 1.0)
    startup.relume.light_groups[0].illuminant = "FL11"
    startup.relume.switching = "ANY"
    follower.settle(startup)
    assert startup.relume.model().passes > 1 and len(passes(startup)) == startup.relume.model().passes
    assert "passes now" in startup.relume.plan["changed"]


def test_what_follows_makes_no_data_blocks(ready):
    """An undo step that does not know them would end Blender: see `nodes.keep_spares`."""
    before = set(bpy.data.node_groups)
    light = bpy.data.lights.new("warm", "POINT")
    light.use_temperature, light.temperature = True, 2700.0
    thing = bpy.data.objects.new("warm", light)
    thing.lightgroup = "new"
    ready.collection.objects.link(thing)
    follower.forget()
    follower.follow()
    assert "new" in [row.name for row in ready.relume.lit]
    used = {tree for tree in bpy.data.node_groups if tree.users}
    assert used <= before and not nodes.is_undo_unsafe()


@pytest.fixture
def described(monkeypatch):
    """Names of the data-blocks whose sockets were looked at, and the number of inventories that were taken."""
    from relume.addon.graph import sockets
    from relume.addon.host import inventory

    found, describe_tree, taking = [], sockets._describe_tree, inventory.taking

    def counted(conversion, shading, light):
        found.append(shading.owner.name)
        describe_tree(conversion, shading, light)

    def taken(scene):
        found.append("inventory")
        return taking(scene)

    monkeypatch.setattr(sockets, "_describe_tree", counted)
    monkeypatch.setattr(inventory, "taking", taken)
    return found


def unplugged_colour():
    """The colour of a closure that nothing shows, so that Blender does not say when it changes."""
    return bpy.data.objects["Cube"].active_material.node_tree.nodes["own"].inputs["Color"]


def write_quietly():
    base_colour().default_value.foreach_set((0.1, 0.7, 0.2, 1.0))


def mute_a_link():
    base_colour().links[0].is_muted = True


def move_a_link():
    tree = base_colour().id_data
    tree.links.new(tree.nodes["own"].outputs[0], tree.nodes["Material Output"].inputs["Surface"])


EDITS = {
    "a value": lambda: setattr(base_colour(), "default_value", (0.1, 0.2, 0.9, 1.0)),
    "a value, quietly": write_quietly,
    "what nothing shows": lambda: setattr(unplugged_colour(), "default_value", (0.9, 0.2, 0.1, 1.0)),
    "a weight": lambda: setattr(base_colour().node.inputs["Metallic"], "default_value", 1.0),
    "a mode": lambda: setattr(base_colour().id_data.nodes["metal"], "fresnel_type", "PHYSICAL_CONDUCTOR"),
    "a new node": lambda: base_colour().id_data.nodes.new("ShaderNodeBsdfGlossy"),
    "a node gone": lambda: base_colour().id_data.nodes.remove(base_colour().links[0].from_node),
    "a muted link": mute_a_link,
    "a link": move_a_link,
    "a grey": lambda: setattr(nodes.holder(base_colour()), "default_value", (0.5, 0.5, 0.5, 1.0)),
}


def test_what_is_as_it_was_is_not_looked_at_again(startup, described):
    material = bpy.data.objects["Cube"].active_material
    own = material.node_tree.nodes.new("ShaderNodeBsdfDiffuse")
    own.name, own.inputs["Color"].default_value = "own", (0.2, 0.9, 0.4, 1.0)
    material.node_tree.nodes.new("ShaderNodeBsdfMetallic").name = "metal"
    base_colour().default_value = (0.8, 0.3, 0.1, 1.0)
    setup.set_up(startup, bases.fitted(9))
    follower.settle(startup)
    for name, edit in EDITS.items():
        follower.settle(startup)
        described.clear()
        follower.settle(startup)
        assert described == ["inventory"], f"nothing was edited before {name}"
        edit()
        follower.settle(startup)
        assert described == ["inventory", "inventory", material.name], name
    assert carried(material) == carried_afresh(startup, material)


def carried(material) -> list:
    """What stands before the sockets of a material, and which value it holds."""
    return sorted(
        (n.node_tree.name, link.to_node.name, link.to_socket.name, tuple(n.inputs[0].default_value))
        for n in material.node_tree.nodes
        if nodes.role(n) in nodes.INSERTED
        for link in n.outputs[0].links
    )


def carried_afresh(scene, material) -> list:
    model = scene.relume.model()
    setup.remove(scene)
    setup.set_up(scene, model)
    return carried(material)


def test_the_colour_of_a_lamp_reaches_no_further(ready, described):
    follower.follow()
    described.clear()
    bpy.data.lights["Light"].color = (0.2, 0.4, 1.0)
    follower.follow()
    assert described == ["Light"]
    bpy.data.lights["Light"].use_temperature = True  # as what its light group shows depends on
    follower.follow()
    assert "inventory" in described


def test_what_following_changes_is_no_edit(ready, described):
    follower.forget()
    follower.follow()
    bpy.data.objects["Cube"].lightgroup = "new"
    tree = bpy.data.objects["Cube"].active_material.node_tree
    tree.nodes["Principled BSDF"].inputs["Emission Strength"].default_value = 2.0
    follower.follow()
    assert "new" in [row.name for row in ready.relume.lit]
    described.clear()
    bpy.context.view_layer.update()
    follower.follow()
    assert described == []


def keyed(block, values: dict, path: str):
    for frame, value in values.items():
        setattr(*path_of(block, path), value)
        block.keyframe_insert(path, frame=frame)


def path_of(block, path: str) -> tuple:
    owner, _, name = path.rpartition(".")
    return (block.path_resolve(owner) if owner else block), name


def keys(block) -> dict:
    """{(path, index): {frame: value}} of what animates a data-block."""
    curves = animation.keyed(block, "")
    return {(c.data_path, c.array_index): {k.co.x: round(k.co.y, 4) for k in c.keyframe_points} for c in curves}


def test_a_colour_keyed_in_blenders_own_field_joins_the_keys_of_the_lamp(startup, tmp_path):
    light = bpy.data.lights["Light"]
    keyed(light, {1: (1.0, 0.2, 0.1), 10: (0.1, 0.2, 1.0)}, "color")
    setup.set_up(startup, bases.fitted(6))
    keyed(light, {5: (0.3, 0.9, 0.3)}, "color")
    startup.frame_set(5)
    shown = pixels(startup, tmp_path / "a.exr")
    np.testing.assert_array_equal(shown, afresh(startup, tmp_path / "b.exr"))
    setup.remove(startup)
    assert keys(light) == {
        ("color", 0): {1.0: 1.0, 5.0: 0.3, 10.0: 0.1},
        ("color", 1): {1.0: 0.2, 5.0: 0.9, 10.0: 0.2},
        ("color", 2): {1.0: 0.1, 5.0: 0.3, 10.0: 1.0},
    }


def test_a_lamp_whose_animation_becomes_that_of_its_copy_too_has_its_colour_back(startup, tmp_path):
    light = bpy.data.lights["Light"]
    keyed(light, {1: (1.0, 0.2, 0.1), 10: (0.1, 0.2, 1.0)}, "color")
    setup.set_up(startup, bases.fitted(6))
    copy = bpy.data.objects["Light"].copy()
    copy.data = light.copy()
    startup.collection.objects.link(copy)
    startup.frame_set(5)
    shown = pixels(startup, tmp_path / "a.exr")
    np.testing.assert_array_equal(shown, afresh(startup, tmp_path / "b.exr"))
    assert {path for path, _ in keys(light)} == {"color"}


def test_a_colour_keyed_where_relume_shows_it_stays_when_relume_goes(ready, tmp_path):
    light = bpy.data.lights["Light"]
    (node,) = [node for node in light.node_tree.nodes if nodes.role(node) == "light"]
    path = node.inputs["Tint"].path_from_id("default_value")
    keyed(light.node_tree, {1: (1.0, 0.5, 0.2, 1.0), 10: (0.2, 0.5, 1.0, 1.0)}, path)
    follower.settle(ready)
    ready.frame_set(10)
    shown = pixels(ready, tmp_path / "a.exr")
    np.testing.assert_array_equal(shown, afresh(ready, tmp_path / "b.exr"))
    setup.remove(ready)
    assert [keys(light)["color", 0], keys(light)["color", 2]] == [{1.0: 1.0, 10.0: 0.2}, {1.0: 0.2, 10.0: 1.0}]
    assert keys(light.node_tree) == {}
    ready.frame_set(1)
    np.testing.assert_allclose(light.color, (1.0, 0.5, 0.2), atol=1e-6)


def test_animation_moves_with_the_node_that_comes_anew(startup):
    tree = startup.world.node_tree
    keyed(tree, {1: (1.0, 0.2, 0.1, 1.0)}, 'nodes["Background"].inputs[0].default_value')
    setup.set_up(startup, bases.fitted(6))
    sky = tree.nodes.new("ShaderNodeTexSky")
    tree.links.new(sky.outputs[0], tree.nodes["Background"].inputs[0])
    follower.settle(startup)
    (light,) = [node for node in tree.nodes if nodes.role(node) == "light"]
    assert {path for path, _ in keys(tree)} == {light.inputs[0].path_from_id("default_value")}
