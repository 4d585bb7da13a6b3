"""Edits of lamps and the world: colour, temperature, power, nodes, animation, light groups."""

import bpy

from relume.addon.graph import nodes

from .kinds import active_layer, add_node, artists_nodes, colour, edit, lamps, meshes, own_socket, pick


def _tints(lamp) -> list:
    """Where the artist finds the colour of a lamp while it is set up, besides the lamp itself."""
    tree = lamp.data.node_tree
    return [node for node in tree.nodes if nodes.role(node) == "light"] if tree else []


@edit
def colour_a_lamp(chance, scene):
    lamp, chosen = pick(chance, lamps(scene)), colour(chance)
    if lamp is None:
        return None
    # Blender's own field is white meanwhile: there nobody can choose white
    inserted, in_nodes = _tints(lamp), chance.random() < 0.7 or chosen == (1.0, 1.0, 1.0)
    if inserted and in_nodes:
        inserted[0].inputs["Tint"].default_value = (*chosen, 1.0)
    else:
        lamp.data.color = chosen
    return f"{lamp.name} {chosen}"


@edit
def change_the_power(chance, scene):
    lamp, power = pick(chance, lamps(scene)), chance.choice([5.0, 50.0, 500.0])
    if lamp is None:
        return None
    lamp.data.energy = power
    return f"{lamp.name} {power} W"


@edit
def colour_the_world(chance, scene):
    chosen, strength = colour(chance), chance.choice([0.0, 0.3, 1.0])
    background = artists_nodes(scene.world.node_tree, "ShaderNodeBackground") if scene.world else []
    if not background:
        return None
    socket = own_socket(background[0].inputs["Color"])
    if not socket.is_linked:  # Blender shows no colour to choose where one comes from elsewhere
        socket.default_value = (*chosen, 1.0)
    background[0].inputs["Strength"].default_value = strength
    return f"world {chosen} {strength}"


@edit
def another_world(chance, scene):
    chosen = colour(chance)
    if chance.random() < 0.3:
        scene.world = None
        return "no world"
    scene.world = bpy.data.worlds.new("sky")
    background = scene.world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (*chosen, 1.0)
    return f"a world {chosen}"


@edit
def sky_in_the_world(chance, scene):
    background = artists_nodes(scene.world.node_tree, "ShaderNodeBackground") if scene.world else []
    if not background:
        return None
    texture = add_node(scene.world.node_tree, "ShaderNodeTexEnvironment")
    texture.image = bpy.data.images.new("surroundings", 16, 8)
    texture.image.generated_type = "COLOR_GRID"
    socket = background[0].inputs["Color"]
    scene.world.node_tree.links.new(texture.outputs["Color"], own_socket(socket) if chance.random() < 0.5 else socket)
    return "an environment texture"


@edit
def put_into_a_light_group(chance, scene):
    thing, group = pick(chance, lamps(scene) + meshes(scene)), chance.choice(["", "warm", "cold", "a.b"])
    if thing is None:
        return None
    layer = active_layer(scene)
    if group and group not in layer.lightgroups:
        layer.lightgroups.add(name=group)
    thing.lightgroup = group
    return f"{thing.name} in {group or 'no group'}"


@edit
def rename_a_light_group(chance, scene):
    layer = active_layer(scene)
    group, number = pick(chance, sorted(layer.lightgroups, key=lambda g: g.name)), chance.randint(1, 99)
    if group is None:
        return None
    before, group.name = group.name, f"group {number}"
    return f"{before} is {group.name}"


@edit
def remove_a_light_group(chance, scene):
    layer = active_layer(scene)
    group = pick(chance, sorted(layer.lightgroups, key=lambda g: g.name))
    if group is None:
        return None
    name = group.name
    layer.lightgroups.remove(group)
    return f"{name} removed"


@edit
def give_a_lamp_a_temperature(chance, scene):
    lamp, kelvin = pick(chance, lamps(scene)), chance.choice([2700.0, 4000.0, 9000.0])
    if lamp is None:
        return None
    lamp.data.use_temperature, lamp.data.temperature = True, kelvin
    return f"{lamp.name} {kelvin} K"


@edit
def animate_a_lamp(chance, scene):
    lamp, name, chosen = pick(chance, lamps(scene)), chance.choice(["color", "energy"]), colour(chance)
    if lamp is None:
        return None
    for frame, value in ((1, chosen), (10, chosen[::-1])):
        setattr(lamp.data, name, value if name == "color" else 100.0 * value[0])
        lamp.data.keyframe_insert(name, frame=frame)
    return f"{lamp.name}: {name} animated"


@edit
def black_body_in_a_lamp(chance, scene):
    lamp, kelvin = pick(chance, lamps(scene)), chance.choice([2000.0, 3200.0, 6500.0])
    emission = artists_nodes(lamp.data.node_tree, "ShaderNodeEmission") if lamp and lamp.data.node_tree else []
    if not emission:
        return None
    body = add_node(lamp.data.node_tree, "ShaderNodeBlackbody")
    body.inputs["Temperature"].default_value = kelvin
    lamp.data.node_tree.links.new(body.outputs[0], own_socket(emission[0].inputs["Color"]))
    return f"{lamp.name}: a black body of {kelvin} K"


@edit
def put_the_world_into_a_light_group(chance, scene):
    group = chance.choice(["", "sky", "warm"])
    if scene.world is None:
        return None
    if group and group not in active_layer(scene).lightgroups:
        active_layer(scene).lightgroups.add(name=group)
    scene.world.lightgroup = group
    return f"world in {group or 'no group'}"


@edit
def change_the_kind_of_a_lamp(chance, scene):
    lamp, kind = pick(chance, lamps(scene)), chance.choice(["POINT", "SUN", "AREA", "SPOT"])
    if lamp is None:
        return None
    lamp.data.type = kind
    return f"{lamp.name} is a {kind}"
