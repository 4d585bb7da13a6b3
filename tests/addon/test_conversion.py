"""Every colour of a scene takes part, wherever it comes from, and is given back; what cannot is reported."""

import bpy
import pytest
from dump import changes, differences, dump

from relume.addon.graph import closures, nodes, sockets, spectra
from relume.addon.host import animation
from relume.addon.scene import render, setup, view_layers
from relume.addon.store import remarks
from relume.core.model import bases
from relume.core.spectra import library
from relume.core.spectra.spectrum import Spectrum

CLOSURES = sorted(closures.SPECTRAL)
MODES = {
    "ShaderNodeBsdfMetallic": {"fresnel_type": "PHYSICAL_CONDUCTOR"},
    "ShaderNodeBsdfHairPrincipled": {"parametrization": "ABSORPTION"},
}


def material_on_cube(name="test"):
    """A material with an empty tree on the cube of the start-up scene: its nodes, its links."""
    material = bpy.data.materials.new(name)
    tree = material.node_tree
    tree.nodes.clear()
    bpy.data.objects["Cube"].material_slots[0].material = material
    return material, tree


def shader_in(tree, kind, **settings):
    """A shader node that goes to a new material output."""
    node, output = tree.nodes.new(kind), tree.nodes.new("ShaderNodeOutputMaterial")
    for name, value in settings.items():
        setattr(node, name, value)
    tree.links.new(node.outputs[0], output.inputs["Volume" if "Volume" in kind else "Surface"])
    return node


def feeding(socket):
    """The node that feeds a socket, None if none does."""
    return socket.links[0].from_node if socket.is_linked else None


def upsampled(socket) -> bool:
    return socket.is_linked and nodes.role(feeding(socket)) in nodes.INSERTED


@pytest.mark.parametrize(
    ("kind", "other_mode"), [*((kind, False) for kind in CLOSURES), *((kind, True) for kind in MODES)]
)
def test_every_spectral_socket_of_every_closure_is_upsampled_and_given_back(startup, kind, other_mode):
    _, tree = material_on_cube()
    node = shader_in(tree, kind, **(MODES[kind] if other_mode else {}))
    for name in ("Subsurface Weight", "Coat Weight", "Sheen Weight", "Emission Strength"):
        if name in node.inputs:
            node.inputs[name].default_value = 0.5
    bpy.context.view_layer.update()
    for socket in sockets.spectral_sockets(node):
        socket.default_value[:3] = (0.6, 0.3, 0.1)
    before = dump()
    setup.set_up(startup)
    found = sockets.spectral_sockets(node)
    assert found and all(upsampled(socket) for socket in found)
    emission = [s for s in found if nodes.role(feeding(s)) == "light"]
    assert [closures.kind_of(s) for s in emission] == [closures.Kind.EMISSION] * len(emission)
    setup.remove(startup)
    assert changes(before) == []


def test_weights_of_zero_leave_their_colours_alone(startup):
    _, tree = material_on_cube()
    node = shader_in(tree, "ShaderNodeBsdfPrincipled")
    node.inputs["Base Color"].default_value = (0.1, 0.2, 0.3, 1.0)
    setup.set_up(startup)
    assert [s.name for s in node.inputs if s.is_linked] == ["Base Color"]


def test_a_shared_group_is_converted_once(startup):
    group = bpy.data.node_groups.new("shared", "ShaderNodeTree")
    group.interface.new_socket("Color", in_out="INPUT", socket_type="NodeSocketColor")
    group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    source, diffuse, sink = (
        group.nodes.new(kind) for kind in ("NodeGroupInput", "ShaderNodeBsdfDiffuse", "NodeGroupOutput")
    )
    group.links.new(source.outputs["Color"], diffuse.inputs["Color"])
    group.links.new(diffuse.outputs[0], sink.inputs["Shader"])
    for index in range(3):
        material = bpy.data.materials.new(f"user {index}")
        user = material.node_tree.nodes.new("ShaderNodeGroup")
        user.node_tree = group
        bpy.data.objects["Cube"].data.materials.append(material)
    before = dump()
    setup.set_up(startup)
    assert [nodes.role(node) for node in group.nodes].count("upsample") == 1
    assert feeding(feeding(diffuse.inputs["Color"]).inputs[0]) == source
    setup.remove(startup)
    assert changes(before) == []


def spectrum_node(tree, name="ColorChecker: red"):
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = spectra.new_reflectance(library.reflectance(name))
    return node


def test_what_a_spectrum_is_mixed_with_is_upsampled_before_the_mix(startup):
    _, tree = material_on_cube()
    diffuse = shader_in(tree, "ShaderNodeBsdfDiffuse")
    mix, reroute, texture = (tree.nodes.new(kind) for kind in ("ShaderNodeMix", "NodeReroute", "ShaderNodeTexChecker"))
    mix.data_type = "RGBA"
    a, b = (nodes.mixed(mix, name) for name in "AB")
    tree.links.new(spectrum_node(tree).outputs[0], reroute.inputs[0])
    tree.links.new(reroute.outputs[0], a)
    tree.links.new(texture.outputs["Color"], b)
    tree.links.new(next(s for s in mix.outputs if s.type == "RGBA"), diffuse.inputs["Color"])
    setup.set_up(startup)
    assert feeding(diffuse.inputs["Color"]) == mix
    assert feeding(a) == reroute
    assert nodes.role(feeding(b)) == "upsample"
    setup.remove(startup)
    assert feeding(b) == texture


def test_a_spectrum_goes_into_a_group_that_others_use_with_colours(startup):
    group = bpy.data.node_groups.new("paint", "ShaderNodeTree")
    group.interface.new_socket("Paint", in_out="INPUT", socket_type="NodeSocketColor")
    group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    source, diffuse, sink = (
        group.nodes.new(kind) for kind in ("NodeGroupInput", "ShaderNodeBsdfDiffuse", "NodeGroupOutput")
    )
    group.links.new(source.outputs["Paint"], diffuse.inputs["Color"])
    group.links.new(diffuse.outputs[0], sink.inputs["Shader"])
    users = []
    for index in range(2):
        material = bpy.data.materials.new(f"user {index}")
        users.append(material.node_tree.nodes.new("ShaderNodeGroup"))
        users[-1].node_tree = group
        bpy.data.objects["Cube"].data.materials.append(material)
    users[0].inputs["Paint"].default_value = (0.5, 0.2, 0.1, 1.0)
    spectral = spectrum_node(users[1].id_data)
    users[1].id_data.links.new(spectral.outputs[0], users[1].inputs["Paint"])
    before = dump()
    setup.set_up(startup)
    assert feeding(diffuse.inputs["Color"]) == source
    assert upsampled(users[0].inputs["Paint"])
    assert feeding(users[1].inputs["Paint"]) == spectral
    setup.remove(startup)
    assert changes(before) == []


def test_a_spectrum_that_becomes_a_number_is_none(startup):
    group = bpy.data.node_groups.new("grey", "ShaderNodeTree")
    group.interface.new_socket("Value", in_out="INPUT", socket_type="NodeSocketFloat")
    group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    source, diffuse, sink, mix = (
        group.nodes.new(kind)
        for kind in ("NodeGroupInput", "ShaderNodeBsdfDiffuse", "NodeGroupOutput", "ShaderNodeMixRGB")
    )
    group.links.new(source.outputs["Value"], mix.inputs["Color1"])
    group.links.new(spectrum_node(group).outputs[0], mix.inputs["Color2"])
    group.links.new(mix.outputs[0], diffuse.inputs["Color"])
    group.links.new(diffuse.outputs[0], sink.inputs["Shader"])
    callers = []
    for index in range(2):
        material = bpy.data.materials.new(f"user {index}")
        bpy.data.objects["Cube"].data.materials.append(material)
        callers.append(material.node_tree.nodes.new("ShaderNodeGroup"))
        callers[-1].node_tree = group
    spectral = spectrum_node(callers[1].id_data)
    callers[1].id_data.links.new(spectral.outputs[0], callers[1].inputs["Value"])
    before = dump()
    setup.set_up(startup)
    assert upsampled(mix.inputs["Color1"])
    assert feeding(callers[1].inputs["Value"]) == spectral
    setup.remove(startup)
    assert changes(before) == []


def test_geometry_nodes_and_instances_bring_their_materials_and_lamps(startup):
    made = bpy.data.materials.new("made by nodes")
    made.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.9, 0.1, 0.2, 1.0)
    tree = bpy.data.node_groups.new("nodes", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    tree.nodes.new("GeometryNodeSetMaterial").inputs["Material"].default_value = made
    bpy.data.objects["Cube"].modifiers.new("nodes", "NODES").node_group = tree
    hidden = bpy.data.collections.new("instanced")
    lamp = bpy.data.objects.new("inner lamp", bpy.data.lights.new("inner lamp", "SPOT"))
    lamp.data.color = (0.2, 0.5, 1.0)
    lamp.lightgroup = "inner"
    hidden.objects.link(lamp)
    instance = bpy.data.objects.new("instance", None)
    instance.instance_type, instance.instance_collection = "COLLECTION", hidden
    startup.collection.objects.link(instance)
    setup.set_up(startup)
    assert upsampled(made.node_tree.nodes["Principled BSDF"].inputs["Base Color"])
    assert upsampled(lamp.data.node_tree.nodes["Emission"].inputs["Color"])
    assert "inner" in startup.relume.light_groups


def test_editing_a_colour_while_set_up_lasts(startup):
    base = bpy.data.objects["Cube"].active_material.node_tree.nodes["Principled BSDF"].inputs["Base Color"]
    setup.set_up(startup)
    feeding(base).inputs["Color"].default_value = (0.1, 0.5, 0.1, 1.0)
    setup.remove(startup)
    assert tuple(base.default_value) == pytest.approx((0.1, 0.5, 0.1, 1.0))


@pytest.mark.parametrize("through_owner", [False, True])
def test_animation_of_a_colour_goes_on(startup, through_owner):
    material = bpy.data.objects["Cube"].active_material
    base = material.node_tree.nodes["Principled BSDF"].inputs["Base Color"]
    path = base.path_from_id("default_value")
    for frame, color in ((1, (1.0, 0.0, 0.0, 1.0)), (11, (0.0, 0.0, 1.0, 1.0))):
        if through_owner:
            material.diffuse_color = color
            material.keyframe_insert("diffuse_color", frame=frame)
        else:
            base.default_value = color
            material.node_tree.keyframe_insert(path, frame=frame)
    if through_owner:
        animation.move(material, "diffuse_color", f"node_tree.{path}")
    startup.frame_set(1)
    before = dump()
    setup.set_up(startup)
    for frame, color in ((11, (0.0, 0.0, 1.0)), (6, (0.5, 0.0, 0.5)), (1, (1.0, 0.0, 0.0))):
        startup.frame_set(frame)
        shown = material.evaluated_get(bpy.context.evaluated_depsgraph_get()).node_tree
        node = next(n for n in shown.nodes if nodes.role(n) == "upsample")
        assert tuple(node.inputs[0].default_value)[:3] == pytest.approx(color)
    setup.remove(startup)
    assert changes(before) == []


def test_animation_of_a_lamps_colour_goes_on(startup):
    light = bpy.data.lights["Light"]
    for frame, color in ((1, (1.0, 0.0, 0.0)), (11, (0.0, 0.0, 1.0))):
        light.color = color
        light.keyframe_insert("color", frame=frame)
    startup.frame_set(1)
    before = dump()
    setup.set_up(startup)
    startup.frame_set(11)
    shown = light.evaluated_get(bpy.context.evaluated_depsgraph_get())
    tint = next(n for n in shown.node_tree.nodes if nodes.role(n) == "light").inputs["Tint"]
    assert tuple(tint.default_value)[:3] == pytest.approx((0.0, 0.0, 1.0))
    assert tuple(shown.color) == (1.0, 1.0, 1.0)
    startup.frame_set(1)
    setup.remove(startup)
    assert changes(before) == []


def test_a_lamp_of_one_temperature_is_a_planckian_illuminant(startup):
    light = bpy.data.lights["Light"]
    light.color, light.use_temperature, light.temperature = (1.0, 1.0, 1.0), True, 3200.0
    startup.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.0
    before = dump()
    setup.set_up(startup, bases.fitted(9))
    assert [row.illuminant for row in startup.relume.light_groups] == ["Planckian 3200 K"]
    emitter = next(tree for tree in bpy.data.node_groups if tree.get(nodes.ROLE) == "emitter")
    weights = [n.inputs[1].default_value[0] for n in emitter.nodes if n.type == "VECT_MATH"]
    assert weights == [1.0] * 9, "the illuminant comes with the light group, not with the lamp"
    setup.remove(startup)
    assert changes(before) == []


def test_black_bodies_among_other_lights_have_their_own_spectra(startup):
    light = bpy.data.lights["Light"]
    light.color, light.use_temperature, light.temperature = (1.0, 1.0, 1.0), True, 3200.0
    world = startup.world.node_tree
    blackbody = world.nodes.new("ShaderNodeBlackbody")
    blackbody.inputs[0].default_value = 9000.0
    world.links.new(blackbody.outputs[0], world.nodes["Background"].inputs["Color"])
    before = dump()
    setup.set_up(startup)
    assert [row.illuminant for row in startup.relume.light_groups] == ["D65"]
    names = sorted(tree.name for tree in bpy.data.node_groups if tree.get(nodes.ROLE) == "emitter")
    assert names == ["Relume 3200 K on D65", "Relume 9000 K on D65"]
    setup.remove(startup)
    assert feeding(world.nodes["Background"].inputs["Color"]) == blackbody
    assert changes(before) == []


def test_an_illuminant_that_the_artist_chose_stays(startup):
    light = bpy.data.lights["Light"]
    light.use_temperature, light.temperature = True, 3200.0
    startup.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.0
    setup.set_up(startup)
    startup.relume.light_groups[0].illuminant = "FL11"
    setup.remove(startup)
    setup.set_up(startup)
    assert startup.relume.light_groups[0].illuminant == "FL11"


def words(scene):
    return [str(remark) for remark in remarks.of(scene)]


def test_what_cannot_be_spectral_is_told(startup):
    _, tree = material_on_cube("Сукно")
    film = shader_in(tree, "ShaderNodeBsdfGlass")
    film.inputs["Thin Film Thickness"].default_value = 300.0
    hair = shader_in(tree, "ShaderNodeBsdfHairPrincipled", parametrization="MELANIN")
    shader_in(tree, "ShaderNodeVolumePrincipled").inputs["Blackbody Intensity"].default_value = 1.0
    tree.nodes.new("ShaderNodeTexSky")
    image = bpy.data.images.new("gone", 4, 4)
    image.source, image.filepath = "FILE", "/nowhere/gone.png"
    tree.nodes.new("ShaderNodeTexImage").image = image
    bpy.data.materials.new("bare").node_tree.nodes.clear()
    bpy.data.objects["Cube"].data.materials.append(bpy.data.materials["bare"])
    setup.set_up(startup)
    said = "\n".join(words(startup))
    for word in ("thin film", "melanin", "glow of this fire", "sky", "'gone' is missing", "bare: it has no output"):
        assert word in said, word
    assert f"Сукно, {hair.name}: melanin" in said
    setup.remove(startup)
    assert words(startup) == []


def test_linked_data_is_told_and_left_alone(startup, tmp_path):
    lib = tmp_path / "lib.blend"
    bpy.data.materials["Material"].name = "from a library"
    bpy.data.libraries.write(str(lib), {bpy.data.materials["from a library"], bpy.data.lights["Light"]})
    with bpy.data.libraries.load(str(lib), link=True) as (_, linked):
        linked.materials, linked.lights = ["from a library"], ["Light"]
    bpy.data.objects["Cube"].material_slots[0].material = linked.materials[0]
    bpy.data.objects["Light"].data = linked.lights[0]
    before = dump()
    setup.set_up(startup)
    assert any(line.startswith("from a library: linked from") for line in words(startup))
    assert any(line.startswith("Light: linked from") for line in words(startup))
    setup.remove(startup)
    assert differences(before, dump()) == []


def test_odd_trees_are_set_up_and_given_back(startup):
    group = bpy.data.node_groups.new("empty", "ShaderNodeTree")
    bpy.data.node_groups.new("unused " + "ж" * 24, "ShaderNodeTree").use_fake_user = True
    material, tree = material_on_cube("素材 " + "x" * 55)
    diffuse = shader_in(tree, "ShaderNodeBsdfDiffuse")
    texture, user = tree.nodes.new("ShaderNodeTexChecker"), tree.nodes.new("ShaderNodeGroup")
    user.node_tree = group
    tree.nodes.new("ShaderNodeGroup")  # of no tree
    tree.nodes.new("ShaderNodeTexImage")  # of no image
    diffuse.inputs["Color"].default_value = (0.1, 0.4, 0.2, 1.0)
    tree.links.new(texture.outputs["Color"], diffuse.inputs["Color"]).is_muted = True
    bpy.data.objects["Cube"].data.materials.append(None)
    before = dump()
    setup.set_up(startup)
    assert diffuse.inputs["Color"].default_value[:] == feeding(diffuse.inputs["Color"]).inputs[0].default_value[:]
    setup.remove(startup)
    assert changes(before) == []


def test_a_driven_colour_stays_driven(startup):
    material, tree = material_on_cube()
    diffuse = shader_in(tree, "ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (0.1, 0.4, 0.2, 1.0)
    driven = diffuse.inputs["Color"].driver_add("default_value", 1)
    driven.driver.expression = "0.25 + frame * 0.01"
    before = dump()
    setup.set_up(startup)
    startup.frame_set(25)
    evaluated = material.evaluated_get(bpy.context.evaluated_depsgraph_get()).node_tree
    shown = feeding(evaluated.nodes[diffuse.name].inputs["Color"]).inputs[0].default_value
    assert shown[:3] == pytest.approx((0.1, 0.5, 0.2))
    startup.frame_set(1)
    setup.remove(startup)
    assert [line for line in changes(before) if "default_value" not in line] == []  # the driver wrote those


def test_a_missing_image_is_as_missing_as_before(startup, tmp_path):
    _, tree = material_on_cube()
    diffuse = shader_in(tree, "ShaderNodeBsdfDiffuse")
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = bpy.data.images.new("gone", 4, 4)
    texture.image.source, texture.image.filepath = "FILE", "//nowhere/gone.png"
    tree.links.new(texture.outputs["Color"], diffuse.inputs["Color"])
    startup.render.image_settings.file_format = "OPEN_EXR"  # Blender fills in what goes with it
    before = dump()
    setup.set_up(startup, bases.fitted(6))
    image = render.render(startup, tmp_path).image
    assert max(values.max() for values in image.groups.values()) > 0.01
    setup.remove(startup)
    assert changes(before) == []


def test_names_of_64_characters(startup):
    startup.view_layers[0].name = "層" * 21
    bpy.data.objects["Light"].lightgroup = "g" * 60
    startup.view_layers[0].lightgroups.add(name="g" * 60)
    before = dump()
    setup.set_up(startup, bases.fitted(9))
    layers = [layer for copies in view_layers.pass_layers(startup).values() for layer in copies]
    assert len(layers) == 3 and len({layer.name for layer in layers}) == 3
    setup.remove(startup)
    assert changes(before) == []


def test_a_spectrum_of_one_sample_is_flat(startup):
    _, tree = material_on_cube()
    diffuse = shader_in(tree, "ShaderNodeBsdfDiffuse")
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = spectra.new_reflectance(Spectrum([550.0], [0.3], "one sample"))
    tree.links.new(node.outputs[0], diffuse.inputs["Color"])
    setup.set_up(startup, bases.fitted(9))
    weights = [n.inputs[1].default_value[0] for n in node.node_tree.nodes if n.type == "VECT_MATH"]
    assert weights == pytest.approx([0.3] * 9)


@pytest.mark.parametrize(("length", "fits"), [(18, True), (19, False)])
def test_a_light_group_with_a_long_name_is_rendered_or_told(room, tmp_path, length, fits):
    name = "灯" * length  # three bytes each
    bpy.data.objects["tungsten"].lightgroup = name
    setup.set_up(room)
    image = render.render(room, tmp_path).image
    assert image.groups[name if fits else "Everything else"].mean() > 0.01
    assert any("name of this light group" in line for line in words(room)) is not fits
