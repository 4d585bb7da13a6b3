"""The scenes in which the scripted artist works: {name: function that builds it in a factory file}, small to render."""

import bpy

from relume.addon.graph import glass, spectra
from relume.core.spectra import library

from .kinds import add_node

__all__ = ["SCENES", "build"]

SCENES = {}


def _scene(function):
    SCENES[function.__name__] = function
    return function


def build(name: str, channels: str):
    """Build a scene in the file that is open, to be set up with `channels`; returns it."""
    bpy.ops.wm.read_factory_settings()
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = 64, 36
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = 2, False, False
    scene.cycles.max_bounces = 2
    SCENES[name](scene)
    scene.frame_set(scene.frame_current)
    for each in bpy.data.scenes:
        each.relume.channels = channels
    bpy.context.view_layer.update()
    return scene


def _principled(material):
    return material.node_tree.nodes["Principled BSDF"]


def _material(name: str, colour=(0.8, 0.8, 0.8)):
    material = bpy.data.materials.new(name)
    _principled(material).inputs["Base Color"].default_value = (*colour, 1.0)
    return material


def _mesh(shape: str, material, location=(0.0, 0.0, 0.0), **settings):
    getattr(bpy.ops.mesh, f"primitive_{shape}_add")(location=location, **settings)
    thing = bpy.context.object
    thing.data.materials.append(material)
    return thing


def _lamp(kind: str, colour, location, group=""):
    bpy.ops.object.light_add(type=kind, location=location)
    lamp = bpy.context.object
    lamp.data.color, lamp.data.energy = colour, 3.0 if kind == "SUN" else 200.0
    _put_into(lamp, group)
    return lamp


def _put_into(thing, group: str):
    for layer in bpy.context.scene.view_layers:
        if group and group not in layer.lightgroups:
            layer.lightgroups.add(name=group)
    thing.lightgroup = group


def _link(tree, kind: str, socket, output="Color", **settings):
    node = add_node(tree, kind)
    for name, value in settings.items():
        setattr(node, name, value)
    tree.links.new(node.outputs[output], socket)
    return node


def _cube_material():
    return bpy.data.objects["Cube"].active_material


@_scene
def lamp_and_cube(scene):
    """Blender's start-up scene, coloured."""
    _principled(_cube_material()).inputs["Base Color"].default_value = (0.7, 0.2, 0.1, 1.0)
    bpy.data.lights["Light"].color = (1.0, 0.8, 0.5)


@_scene
def room(scene):
    """Several light groups, one of which is a mesh that shines; one lamp has a temperature."""
    lamp_and_cube(scene)
    _mesh("plane", _material("floor", (0.3, 0.5, 0.2)), (0, 0, -1), size=10)
    _mesh("plane", _material("wall", (0.8, 0.1, 0.1)), (-3, 0, 1), size=6, rotation=(0, 1.57, 0))
    _put_into(bpy.data.objects["Light"], "key")
    _lamp("AREA", (0.4, 0.6, 1.0), (-2, -3, 4), "fill")
    tungsten = _lamp("SPOT", (1.0, 1.0, 1.0), (2, 2, 5), "key")
    tungsten.data.use_temperature, tungsten.data.temperature = True, 2856.0
    _lamp("SUN", (1.0, 0.9, 0.8), (0, 0, 5))
    panel = _material("panel")
    _principled(panel).inputs["Emission Color"].default_value = (0.2, 1.0, 0.4, 1.0)
    _principled(panel).inputs["Emission Strength"].default_value = 2.0
    _put_into(_mesh("cube", panel, (2, 0, 1), size=0.5), "panel")


@_scene
def groups_of_nodes(scene):
    """Node groups that materials share, one inside the other, with closures and with colours."""
    inner = bpy.data.node_groups.new("colours", "ShaderNodeTree")
    inner.interface.new_socket("Color", in_out="OUTPUT", socket_type="NodeSocketColor")
    source, end = add_node(inner, "ShaderNodeRGB"), add_node(inner, "NodeGroupOutput")
    source.outputs[0].default_value = (0.2, 0.4, 0.9, 1.0)
    inner.links.new(source.outputs[0], end.inputs[0])
    outer = bpy.data.node_groups.new("paint", "ShaderNodeTree")
    outer.interface.new_socket("Tint", in_out="INPUT", socket_type="NodeSocketColor")
    outer.interface.new_socket("BSDF", in_out="OUTPUT", socket_type="NodeSocketShader")
    begin, end, mix = (add_node(outer, k) for k in ("NodeGroupInput", "NodeGroupOutput", "ShaderNodeMixShader"))
    flat, shiny = add_node(outer, "ShaderNodeBsdfDiffuse"), add_node(outer, "ShaderNodeBsdfAnisotropic")
    _link(outer, "ShaderNodeGroup", shiny.inputs["Color"], 0, node_tree=inner)
    outer.links.new(begin.outputs["Tint"], flat.inputs["Color"])
    outer.links.new(flat.outputs[0], mix.inputs[1])
    outer.links.new(shiny.outputs[0], mix.inputs[2])
    outer.links.new(mix.outputs[0], end.inputs[0])
    for red, material in ((0.1, _cube_material()), (0.9, _material("second"))):
        surface = material.node_tree.nodes["Material Output"].inputs["Surface"]
        node = _link(material.node_tree, "ShaderNodeGroup", surface, 0, node_tree=outer)
        node.inputs["Tint"].default_value = (red, 0.3, 0.1, 1.0)
    _mesh("cone", material, (2, 0, 0), vertices=6)


@_scene
def textures(scene):
    """Images, procedural textures, ramps and mixes; one closure is fed by another's colour."""
    image = bpy.data.images.new("grid", 16, 16)
    image.generated_type = "COLOR_GRID"
    floor = _material("floor")
    _link(floor.node_tree, "ShaderNodeTexImage", _principled(floor).inputs["Base Color"], image=image)
    _mesh("plane", floor, (0, 0, -1), size=10)
    material = _cube_material()
    mix = _link(material.node_tree, "ShaderNodeMix", _principled(material).inputs["Base Color"], 2, data_type="RGBA")
    _link(material.node_tree, "ShaderNodeTexNoise", mix.inputs[6])
    ramp = _link(material.node_tree, "ShaderNodeValToRGB", mix.inputs[7])
    ramp.color_ramp.elements[0].color = (0.9, 0.1, 0.2, 1.0)
    _link(material.node_tree, "ShaderNodeTexChecker", ramp.inputs[0], 1)
    bpy.data.lights["Light"].color = (0.9, 0.9, 1.0)


@_scene
def measured(scene):
    """Measured reflectances, also behind a mix; a metal and a glass."""
    reflectance = "ColorChecker: red"
    group = spectra.new_reflectance(library.reflectance(reflectance), "measured")
    material = _cube_material()
    spectra.assign(material, _principled(material).inputs["Base Color"], group)
    mixed = _material("mixed")
    mix = _link(mixed.node_tree, "ShaderNodeMix", _principled(mixed).inputs["Base Color"], 2, data_type="RGBA")
    mix.inputs[6].default_value = (0.9, 0.2, 0.1, 1.0)
    spectra.assign(mixed, mix.inputs[7], group)
    _mesh("plane", mixed, (0, 0, -1), size=10)
    metal, clear = _material("metal"), _material("clear")
    surface = metal.node_tree.nodes["Material Output"].inputs["Surface"]
    closure = _link(metal.node_tree, "ShaderNodeBsdfMetallic", surface, 0, fresnel_type="PHYSICAL_CONDUCTOR")
    name = library.conductors()[0]
    conductor = spectra.new_conductor(name, *library.conductor(name))
    for socket in ("IOR", "Extinction"):
        spectra.assign(metal, closure.inputs[socket], conductor, socket)
    _mesh("cone", metal, (2, 0, 0), vertices=6)
    surface = clear.node_tree.nodes["Material Output"].inputs["Surface"]
    glass.replace(_link(clear.node_tree, "ShaderNodeBsdfGlass", surface, 0), library.glass("SF10"))
    _mesh("cone", clear, (-2, 0, 0), vertices=6)


@_scene
def air_and_sky(scene):
    """Volumes, and a world with a picture of the surroundings."""
    smoke, sky = _material("smoke"), scene.world.node_tree
    tree = smoke.node_tree
    tree.nodes.remove(_principled(smoke))
    closure = _link(tree, "ShaderNodeVolumePrincipled", tree.nodes["Material Output"].inputs["Volume"], 0)
    closure.inputs["Color"].default_value = (0.3, 0.5, 0.9, 1.0)
    _mesh("cube", smoke, (2, 0, 0), size=1)
    tree = _cube_material().node_tree
    absorbing = _link(tree, "ShaderNodeVolumeAbsorption", tree.nodes["Material Output"].inputs["Volume"], 0)
    absorbing.inputs["Color"].default_value = (0.9, 0.2, 0.2, 1.0)
    scene.world.cycles.sampling_method, scene.world.cycles.sample_map_resolution = "MANUAL", 16  # quick
    image = bpy.data.images.new("surroundings", 16, 8, float_buffer=True)
    image.generated_type = "COLOR_GRID"
    _link(sky, "ShaderNodeTexEnvironment", sky.nodes["Background"].inputs["Color"], image=image)


@_scene
def instances(scene):
    """Materials that come in through particles, collection instances and Geometry Nodes; object slots."""
    hidden, leaf = bpy.data.collections.new("hidden"), _mesh("plane", _material("leaf", (0.1, 0.6, 0.2)), size=0.3)
    for collection in leaf.users_collection:
        collection.objects.unlink(leaf)
    hidden.objects.link(leaf)
    empty = bpy.data.objects.new("instances", None)
    empty.instance_type, empty.instance_collection, empty.location = "COLLECTION", hidden, (2, 0, 0)
    scene.collection.objects.link(empty)
    ground = _mesh("plane", _material("ground", (0.5, 0.3, 0.1)), (0, 0, -1), size=6)
    ground.modifiers.new("grass", "PARTICLE_SYSTEM")
    settings = ground.particle_systems[0].settings
    settings.count, settings.type, settings.render_type, settings.instance_object = 5, "HAIR", "OBJECT", leaf
    tree = bpy.data.node_groups.new("painted", "GeometryNodeTree")
    for side in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=side, socket_type="NodeSocketGeometry")
    begin, paint, end = (tree.nodes.new(k) for k in ("NodeGroupInput", "GeometryNodeSetMaterial", "NodeGroupOutput"))
    paint.inputs["Material"].default_value = _material("by nodes", (0.6, 0.1, 0.6))
    tree.links.new(begin.outputs[0], paint.inputs[0])
    tree.links.new(paint.outputs[0], end.inputs[0])
    bpy.data.objects["Cube"].modifiers.new("paint", "NODES").node_group = tree
    other = _mesh("cube", _material("of the mesh"), (-2, 0, 0), size=1)
    other.material_slots[0].link = "OBJECT"
    other.material_slots[0].material = _material("of the object", (0.2, 0.2, 0.8))


@_scene
def moving(scene):
    """Colours with keys and with drivers, of materials, a lamp and the world; a driven render setting."""
    lamp_and_cube(scene)
    base = _principled(_cube_material()).inputs["Base Color"]
    lamp, sky = bpy.data.lights["Light"], scene.world.node_tree.nodes["Background"].inputs["Color"]
    for frame, red in ((1, 0.1), (10, 0.9)):
        base.default_value, sky.default_value, lamp.color = (red, 0.3, 0.1, 1), (0.1, red, 0.1, 1), (1, red, 0.5)
        base.keyframe_insert("default_value", frame=frame)
        sky.keyframe_insert("default_value", frame=frame)
        lamp.keyframe_insert("color", frame=frame)
    driven = _material("driven", (0.2, 0.2, 0.9))
    driven.node_tree.driver_add('nodes["Principled BSDF"].inputs[0].default_value', 0).driver.expression = "frame / 20"
    _mesh("plane", driven, (0, 0, -1), size=10)
    scene.driver_add("cycles.seed").driver.expression = "frame * 3"


@_scene
def layers(scene):
    """Two view layers, collections that are excluded, held out and only indirectly seen, and compositing."""
    room(scene)
    second = scene.view_layers.new("second")
    for number, name in enumerate(("Cube", "Plane", "Plane.001")):
        collection = bpy.data.collections.new(f"set {number + 1}")
        scene.collection.children.link(collection)
        collection.objects.link(bpy.data.objects[name])
        for other in [c for c in bpy.data.objects[name].users_collection if c != collection]:
            other.objects.unlink(bpy.data.objects[name])
    first = scene.view_layers[0]
    second.layer_collection.children["set 1"].exclude = True
    first.layer_collection.children["set 2"].holdout = True
    second.layer_collection.children["set 3"].indirect_only = True
    second.material_override = _material("clay", (0.6, 0.4, 0.3))
    first.use_pass_diffuse_color = first.use_pass_z = True
    tree = bpy.data.node_groups.new("compositing", "CompositorNodeTree")
    tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    scene.compositing_node_group = tree
    shown = [add_node(tree, "CompositorNodeRLayers") for _ in range(2)]
    shown[0].layer, shown[1].layer = first.name, second.name
    over, end = add_node(tree, "CompositorNodeAlphaOver"), add_node(tree, "NodeGroupOutput")
    tree.links.new(shown[1].outputs["Image"], next(s for s in over.inputs if s.type == "RGBA"))
    tree.links.new(shown[0].outputs["Image"], [s for s in over.inputs if s.type == "RGBA"][1])
    tree.links.new(over.outputs[0], end.inputs[0])


@_scene
def two_scenes(scene):
    """Two scenes with objects of their own that share materials, a lamp's data and the world."""
    lamp_and_cube(scene)
    shared = _material("shared", (0.2, 0.7, 0.3))
    _principled(shared).inputs["Emission Strength"].default_value = 0.5
    _principled(shared).inputs["Emission Color"].default_value = (1.0, 0.3, 0.1, 1.0)
    _put_into(_mesh("plane", shared, (0, 0, -1), size=6), "glow")
    bpy.ops.scene.new(type="EMPTY")
    second = bpy.context.scene
    second.name, second.world = "second scene", scene.world
    second.render.engine, second.cycles.samples, second.cycles.use_denoising = "CYCLES", 2, False
    second.render.resolution_x, second.render.resolution_y = 64, 36
    second.camera = scene.camera.copy()
    second.collection.objects.link(second.camera)
    _mesh("cube", shared, size=1)
    lamp = bpy.data.objects.new("same lamp", bpy.data.lights["Light"])
    lamp.location = (3, -2, 4)
    second.collection.objects.link(lamp)
    _put_into(lamp, "other")
    bpy.context.window.scene = scene
