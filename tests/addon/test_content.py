"""What the planner knows of a scene, and what automatic channels make of it."""

import bpy
import pytest

from relume.addon.graph import glass, spectra
from relume.addon.scene import content, setup
from relume.core.model import fresnel
from relume.core.picture import plan
from relume.core.spectra import library
from relume.studies import judges

RED = "ColorChecker: red"


@pytest.fixture
def cube(startup):
    """The scene with its cube alone, and the cube's material."""
    bpy.data.objects.remove(bpy.data.objects["Plane"])
    return bpy.data.objects["Cube"].active_material


def shares_of(scene) -> dict:
    """{name of a spectrum, or RGB colour of three digits: its share}, without greys."""
    contents = content.content_of(scene)
    colours = [tuple(colour) for colour in contents.colours.round(3).tolist()]
    found = dict(zip([spectrum.name for spectrum in contents.reflectances] + colours, contents.shares, strict=True))
    return {source: share for source, share in found.items() if isinstance(source, str) or len(set(source)) > 1}


def spectrum_in(tree, group):
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    return node


def group_in(tree, **sockets):
    """A new node group in a tree, with those inputs and outputs: (its node, its input node, its output node)."""
    group = bpy.data.node_groups.new("group", "ShaderNodeTree")
    for name, (in_out, kind) in sockets.items():
        group.interface.new_socket(name, in_out=in_out, socket_type=f"NodeSocket{kind}")
    return spectrum_in(tree, group), group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")


def metal_in(tree):
    node = tree.nodes.new("ShaderNodeBsdfMetallic")
    node.fresnel_type = "PHYSICAL_CONDUCTOR"
    return node


def surface(tree):
    return tree.nodes["Material Output"].inputs["Surface"]


def modified(thing):
    """The input and the output node of new Geometry Nodes on an object."""
    tree = bpy.data.node_groups.new("geometry", "GeometryNodeTree")
    for in_out in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=in_out, socket_type="NodeSocketGeometry")
    thing.modifiers.new("geometry", "NODES").node_group = tree
    return tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")


def red_material():
    material = bpy.data.materials.new("red")
    tree = spectra.new_reflectance(library.reflectance(RED))
    spectra.assign(material, material.node_tree.nodes["Principled BSDF"].inputs["Base Color"], tree)
    return material


def test_the_room_is_told_by_its_spectra_and_what_the_camera_sees(room):
    contents = content.content_of(room)
    shares = dict(zip([spectrum.name for spectrum in contents.reflectances], contents.shares, strict=False))
    assert contents.textures == 0.0
    assert [light.name for light in contents.lights] == ["A", "FL2"]
    assert max(shares, key=shares.get) == "ColorChecker: neutral 8 (.23 D)"
    assert shares["ColorChecker: blue flower"] < 1.0  # stands behind the camera
    assert shares["ColorChecker: red"] == pytest.approx(shares["ColorChecker: blue"], rel=0.2)


def test_textures_and_colours_are_told_apart(startup):
    contents = content.content_of(startup)
    assert contents.textures > 0.0
    assert any(colour == pytest.approx([0.7, 0.2, 0.1]) for colour in contents.colours.tolist())


def test_a_scene_that_is_set_up_is_told_as_before(startup):
    before = content.content_of(startup)
    setup.set_up(startup)
    after = content.content_of(startup)
    assert after.textures == before.textures
    assert sorted(after.colours.tolist()) == sorted(before.colours.tolist())


def test_automatic_channels_say_why_and_follow_the_tolerance(room):
    room.relume.channels = "auto"
    setup.set_up(room)
    few = room.relume.model().passes
    assert str(room.relume.model().channels) in room.relume.plan["reason"]
    assert room.relume.plan["request"] == room.relume.request
    room.relume.tolerance = 0.1
    assert room.relume.plan["request"] != room.relume.request
    setup.set_up(room)
    assert room.relume.model().passes > few
    setup.remove(room)
    assert room.relume.plan == {}


def test_greys_take_one_pass(startup):
    startup.relume.channels = "auto"
    bpy.data.lights["Light"].color = (1.0, 1.0, 1.0)
    for thing in bpy.data.objects:
        for slot in thing.material_slots:
            slot.material = None
    assert plan.choose(content.content_of(startup)).model.channels == 1
    setup.set_up(startup)
    # one pass as well, but what is made red afterwards is red
    assert startup.relume.model().passes == 1 and startup.relume.model().channels == 3


def test_a_spectrum_takes_the_place_of_the_colour(startup):
    material = bpy.data.objects["Cube"].active_material
    tree = spectra.new_reflectance(library.reflectance("ColorChecker: green"))
    spectra.assign(material, material.node_tree.nodes["Principled BSDF"].inputs["Base Color"], tree)
    assert [spectrum.name for spectrum in content.content_of(startup).reflectances] == ["ColorChecker: green"]


@pytest.mark.parametrize("in_a_group", [False, True])
def test_a_measured_metal_is_told_by_its_reflectance(startup, cube, in_a_group):
    tree = cube.node_tree
    target = surface(tree)
    if in_a_group:
        caller, _, end = group_in(tree, Shader=("OUTPUT", "Shader"))
        tree.links.new(caller.outputs[0], target)
        tree, target = caller.node_tree, end.inputs[0]
    metal = metal_in(tree)
    tree.links.new(metal.outputs[0], target)
    gold = spectrum_in(tree, spectra.new_conductor("Gold", *library.conductor("gold")))
    for name in ("IOR", "Extinction"):
        tree.links.new(gold.outputs[name], metal.inputs[name])
    contents = content.content_of(startup)
    assert [spectrum.name for spectrum in contents.reflectances] == ["Gold"]
    johnson_and_christy = pytest.approx([0.39, 0.97], abs=0.03)
    assert contents.reflectances[0].sampled([450.0, 650.0]) == johnson_and_christy
    assert shares_of(startup)["Gold"] > 100


def test_a_metal_of_rgb_numbers_is_told_as_a_colour_before_and_after_set_up(startup, cube):
    metal = metal_in(cube.node_tree)
    cube.node_tree.links.new(metal.outputs[0], surface(cube.node_tree))
    cube.node_tree.nodes.remove(cube.node_tree.nodes["Principled BSDF"])
    n, k = (metal.inputs[name].default_value[:] for name in ("IOR", "Extinction"))
    expected = tuple(fresnel.reflectance(n, k, 1.0).round(3).tolist())
    before = shares_of(startup)
    assert before[expected] > 100
    setup.set_up(startup)
    assert shares_of(startup) == before


def test_a_spectrum_is_told_that_comes_out_of_a_group(startup, cube):
    caller, _, end = group_in(cube.node_tree, Color=("OUTPUT", "Color"))
    inside = spectrum_in(caller.node_tree, spectra.new_reflectance(library.reflectance(RED)))
    caller.node_tree.links.new(inside.outputs[0], end.inputs[0])
    cube.node_tree.links.new(caller.outputs[0], cube.node_tree.nodes["Principled BSDF"].inputs["Base Color"])
    before = shares_of(startup)
    assert before[RED] > 100
    assert content.content_of(startup).textures == 0.0
    setup.set_up(startup)
    assert shares_of(startup) == before


def test_a_group_tells_each_material_of_what_that_one_puts_in(startup, cube):
    caller, source, end = group_in(cube.node_tree, Color=("INPUT", "Color"), Shader=("OUTPUT", "Shader"))
    inner = caller.node_tree
    diffuse = inner.nodes.new("ShaderNodeBsdfDiffuse")
    inner.links.new(source.outputs["Color"], diffuse.inputs["Color"])
    inner.links.new(diffuse.outputs[0], end.inputs[0])
    cube.node_tree.links.new(caller.outputs[0], surface(cube.node_tree))
    cube.node_tree.nodes.remove(cube.node_tree.nodes["Principled BSDF"])
    other = bpy.data.materials.new("other")
    bpy.data.objects["Cube"].data.materials.append(other)  # on no face
    another = spectrum_in(other.node_tree, inner)
    other.node_tree.links.new(another.outputs[0], surface(other.node_tree))
    other.node_tree.nodes.remove(other.node_tree.nodes["Principled BSDF"])
    another.inputs["Color"].default_value = (0.1, 0.6, 0.3, 1.0)
    spectra.assign(cube, caller.inputs["Color"], spectra.new_reflectance(library.reflectance(RED)))
    shares = shares_of(startup)
    assert shares[RED] > 100 and shares[(0.1, 0.6, 0.3)] == 0.5


@pytest.mark.parametrize(("kind", "is_known"), [("MIX", True), ("MULTIPLY", False)])
def test_a_mix_is_told_by_its_parts_if_it_only_mixes(startup, cube, kind, is_known):
    tree = cube.node_tree
    mix = tree.nodes.new("ShaderNodeMixRGB")
    mix.blend_type = kind
    mix.inputs["Color2"].default_value = (0.1, 0.6, 0.3, 1.0)
    red = spectrum_in(tree, spectra.new_reflectance(library.reflectance(RED)))
    tree.links.new(red.outputs[0], mix.inputs["Color1"])
    tree.links.new(mix.outputs[0], tree.nodes["Principled BSDF"].inputs["Base Color"])
    shares = shares_of(startup)
    assert shares[RED] > 100
    assert ((0.1, 0.6, 0.3) in shares) == is_known
    assert (content.content_of(startup).textures > 100) != is_known


def test_a_colour_that_is_not_used_is_not_told(startup, cube):
    principled = cube.node_tree.nodes["Principled BSDF"]
    principled.inputs["Base Color"].default_value = (0.5, 0.5, 0.5, 1.0)
    principled.inputs["Coat Tint"].default_value = (0.9, 0.2, 0.1, 1.0)
    bpy.data.lights["Light"].color = (1.0, 1.0, 1.0)
    assert shares_of(startup) == {}
    principled.inputs["Coat Weight"].default_value = 0.5
    assert set(shares_of(startup)) == {(0.9, 0.2, 0.1)}


def test_an_animated_colour_may_be_any(startup, cube):
    socket = cube.node_tree.nodes["Principled BSDF"].inputs["Base Color"]
    socket.keyframe_insert("default_value")
    assert content.content_of(startup).textures > 100
    setup.set_up(startup)
    assert content.content_of(startup).textures > 100


def test_a_material_that_geometry_nodes_give_is_seen(startup, cube):
    source, end = modified(bpy.data.objects["Cube"])
    tree = source.id_data
    give = tree.nodes.new("GeometryNodeSetMaterial")
    give.inputs["Material"].default_value = red_material()
    tree.links.new(source.outputs[0], give.inputs["Geometry"])
    tree.links.new(give.outputs[0], end.inputs[0])
    assert shares_of(startup)[RED] > 100


def test_instances_of_geometry_nodes_may_show_any_of_their_materials(startup, cube):
    """They have more faces than the object that they come from."""
    source, end = modified(bpy.data.objects["Cube"])
    tree = source.id_data
    give, sphere, spread = (
        tree.nodes.new(f"GeometryNode{kind}") for kind in ("SetMaterial", "MeshIcoSphere", "InstanceOnPoints")
    )
    give.inputs["Material"].default_value = red_material()
    sphere.inputs["Subdivisions"].default_value = 4
    for output, target in (
        (sphere.outputs[0], give.inputs["Geometry"]),
        (give.outputs[0], spread.inputs["Instance"]),
        (source.outputs[0], spread.inputs["Points"]),
        (spread.outputs[0], end.inputs[0]),
    ):
        tree.links.new(output, target)
    startup.relume.channels = "auto"
    setup.set_up(startup)
    assert shares_of(startup)[RED] > 50


def test_materials_of_an_instanced_collection_are_told(startup, cube):
    thing, collection = bpy.data.objects["Cube"], bpy.data.collections.new("instanced")
    thing.active_material = red_material()
    collection.objects.link(thing)
    startup.collection.children[0].objects.unlink(thing)
    empty = bpy.data.objects.new("empty", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", collection
    startup.collection.objects.link(empty)
    assert shares_of(startup)[RED] > 100


def test_coloured_lamps_and_worlds_are_told(startup, cube):
    background = startup.world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (0.1, 0.2, 0.8, 1.0)
    before = shares_of(startup)
    assert set(before) == {(0.7, 0.2, 0.1), (1.0, 0.8, 0.5), (0.1, 0.2, 0.8)}
    assert before[(0.1, 0.2, 0.8)] > before[(1.0, 0.8, 0.5)]  # it is seen as well
    setup.set_up(startup)
    assert shares_of(startup) == before


def test_a_coloured_lamp_on_greys_takes_more_than_one_channel(startup):
    startup.relume.channels = "auto"
    for thing in bpy.data.objects:
        for slot in thing.material_slots:
            slot.material = None
    setup.set_up(startup)
    assert startup.relume.model().channels >= 3


@pytest.mark.skipif(bpy.app.version < (5, 1), reason="before set-up its lamps have no nodes: textures")
def test_a_black_body_is_told_as_an_illuminant_before_it_is_in_the_mixer(startup, cube):
    lamp = bpy.data.lights["Light"]
    lamp.use_temperature, lamp.temperature, lamp.color = True, 3000.0, (1.0, 1.0, 1.0)
    bpy.data.objects["Light"].lightgroup = startup.view_layers[0].lightgroups.add(name="lamp").name
    expected = ["Planckian 3000 K", "D65"]
    for _ in range(2):
        contents = content.content_of(startup)
        assert [light.name for light in contents.lights] == expected and contents.textures == 0.0
        setup.set_up(startup)
    # Among daylight it has a colour
    setup.remove(startup)
    bpy.data.objects["Light"].lightgroup = ""
    contents = content.content_of(startup)
    assert [light.name for light in contents.lights] == ["D65"] and contents.textures > 0.0


def test_what_the_mixer_shines_is_told_from_wherever_it_comes(startup):
    setup.set_up(startup)
    row = startup.relume.light_groups[0]
    row.source, row.temperature = "PLANCKIAN", 2000.0
    assert [light.name for light in content.content_of(startup).lights] == [row.spectrum().name]
    row.source, row.illuminant = "LIBRARY", "no such lamp"
    assert [light.name for light in content.content_of(startup).lights] == ["D65"]


def test_a_glass_with_dispersion_takes_the_channels_that_a_spectrum_needs(startup, cube):
    startup.relume.channels = "auto"
    bpy.data.lights["Light"].color = (1.0, 1.0, 1.0)
    plain = cube.node_tree.nodes.new("ShaderNodeBsdfGlass")
    cube.node_tree.links.new(plain.outputs[0], surface(cube.node_tree))
    cube.node_tree.nodes.remove(cube.node_tree.nodes["Principled BSDF"])
    setup.set_up(startup)
    assert startup.relume.model().passes == 1
    node = glass.replace(plain, library.glass("BK7"))
    setup.set_up(startup)
    assert startup.relume.model().channels == plan.SPECTRUM
    assert "glass" in startup.relume.plan["reason"]
    narrow = spectra.new_reflectance(judges.boxes(20)[8])
    spectra.assign(cube, cube.node_tree.nodes[node.name].inputs["Color"], narrow)
    startup.relume.switching = "ANY"
    setup.set_up(startup)
    assert startup.relume.model().channels > plan.SPECTRUM  # what the colours need is more


def test_numbers_are_grey(startup, cube):
    """A number that becomes a colour at a socket, straight from a texture or through a group."""
    bpy.data.lights["Light"].color = (1.0, 1.0, 1.0)
    tree, base = cube.node_tree, cube.node_tree.nodes["Principled BSDF"].inputs["Base Color"]
    tree.links.new(tree.nodes.new("ShaderNodeTexNoise").outputs["Factor"], base)
    assert shares_of(startup) == {} and content.content_of(startup).textures == 0.0
    caller, source, end = group_in(tree, Value=("INPUT", "Float"), Color=("OUTPUT", "Color"))
    caller.node_tree.links.new(source.outputs[0], end.inputs[0])
    tree.links.new(caller.outputs[0], base)
    assert shares_of(startup) == {} and content.content_of(startup).textures == 0.0


def test_a_small_thing_keeps_its_colour(startup, cube):
    """It fills less of the picture than may miss the tolerance."""
    startup.relume.channels = "auto"
    bpy.data.lights["Light"].color = (1.0, 1.0, 1.0)
    bpy.data.objects["Cube"].scale = (0.1, 0.1, 0.1)
    assert 0.0 < shares_of(startup)[(0.7, 0.2, 0.1)] < 0.02 * 48 * 48
    setup.set_up(startup)
    assert startup.relume.model().channels >= 3


def test_a_scene_in_the_dark_is_refused(startup):
    bpy.data.objects.remove(bpy.data.objects["Light"])
    startup.world = None
    with pytest.raises(ValueError, match="needs at least one light"):
        content.content_of(startup)


def test_a_scene_is_looked_at_piece_by_piece(startup):
    for number in range(40):
        material = bpy.data.materials.new("paint")
        startup.collection.objects.link(bpy.data.objects.new("thing", bpy.data.meshes.new("thing")))
        startup.objects["thing" if not number else f"thing.{number:03}"].data.materials.append(material)
    pieces = sum(1 for _ in content.looking(startup))
    assert pieces > 2 * 40, "a pause for every material and object, so that a window goes on"


def test_roughness_and_depth_are_told(startup, cube):
    """What becomes of a colour: a rough surface reflects light again, a medium has the depth of its object."""
    tree = cube.node_tree
    tree.nodes.remove(tree.nodes["Principled BSDF"])
    diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (0.8, 0.2, 0.1, 1.0)
    diffuse.inputs["Roughness"].default_value = 1.0
    tree.links.new(diffuse.outputs[0], surface(tree))
    told = content.content_of(startup)
    assert max(told.parts_again) == pytest.approx(0.166, abs=0.01)
    assert not told.optical_depths.any()
    for link in list(surface(tree).links):
        tree.links.remove(link)
    medium = tree.nodes.new("ShaderNodeVolumeAbsorption")
    medium.inputs["Color"].default_value = (0.8, 0.2, 0.1, 1.0)
    medium.inputs["Density"].default_value = 3.0
    tree.links.new(medium.outputs[0], tree.nodes["Material Output"].inputs["Volume"])
    tree.nodes.remove(diffuse)
    thing = bpy.data.objects["Cube"]
    told = content.content_of(startup)
    depths = told.optical_depths[told.optical_depths > 0]
    assert depths == pytest.approx([3.0 * thing.dimensions.x * 2 / 3])
    thing.scale = (2, 2, 2)
    bpy.context.view_layer.update()
    assert max(content.content_of(startup).optical_depths) == pytest.approx(2 * depths[0])
    assert content.checksum(content.content_of(startup)) != content.checksum(told)


def test_light_through_a_spectrum_in_the_group_of_others_is_told(startup, cube):
    """A glowing cube whose emission is a filter: alone in its light group it needs no advice."""
    tree = cube.node_tree
    glow = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(glow.outputs[0], surface(tree))
    spectra.assign(cube, glow.inputs["Color"], spectra.new_reflectance(judges.films()[0]))
    things = [bpy.data.objects["Cube"], next(thing for thing in startup.objects if thing.type == "LIGHT")]
    for thing in things:
        thing.lightgroup = "room"
    startup.view_layers[0].lightgroups.add(name="room")
    told = content.content_of(startup).filtered
    assert [(name, group, spectrum.name) for name, group, spectrum in told] == [("Cube", "room", "film 1")]
    startup.view_layers[0].lightgroups.add(name="cube")
    things[0].lightgroup = "cube"
    assert list(content.content_of(startup).filtered) == []
