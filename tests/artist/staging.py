"""Edits of objects, collections, light groups, view layers, render settings and compositing."""

import bpy

from .kinds import active_layer, edit, lamps, meshes, own_layers, pick, things

_SETTINGS = {
    "samples": [2, 3, 8],
    "seed": [0, 1, 77],
    "use_adaptive_sampling": [False, True],
    "adaptive_threshold": [0.01, 0.1],
    "time_limit": [0.0, 100.0],
    "use_denoising": [False, True],
    "max_bounces": [0, 2, 12],
    "sample_clamp_indirect": [0.0, 10.0],
    "use_animated_seed": [False, True],
}


@edit
def add_a_mesh(chance, scene):
    shape = chance.choice(["cube", "plane", "cone"])
    getattr(bpy.ops.mesh, f"primitive_{shape}_add")(location=[chance.uniform(-2, 2) for _ in range(3)])
    return f"a {shape}"


@edit
def add_a_lamp(chance, scene):
    kind = chance.choice(["POINT", "SUN", "AREA", "SPOT"])
    chosen = [chance.random() for _ in range(3)]
    bpy.ops.object.light_add(type=kind, location=[chance.uniform(-3, 3) for _ in range(3)])
    lamp = bpy.context.object
    lamp.data.color, lamp.data.energy = chosen, 1.0 if kind == "SUN" else 100.0
    return f"{lamp.name} {chosen}"


@edit
def delete_a_mesh(chance, scene):
    thing = pick(chance, meshes(scene))
    if thing is None or len(meshes(scene)) < 2:
        return None
    name = thing.name
    bpy.data.objects.remove(thing)
    return f"{name} deleted"


@edit
def delete_a_lamp(chance, scene):
    lamp = pick(chance, lamps(scene))
    if lamp is None or len(lamps(scene)) < 2:
        return None
    name = lamp.name
    bpy.data.objects.remove(lamp)
    return f"{name} deleted"


@edit
def duplicate_an_object(chance, scene):
    thing, linked = pick(chance, meshes(scene) + lamps(scene)), chance.random() < 0.5
    if thing is None:
        return None
    copy = thing.copy()
    if not linked:
        copy.data = thing.data.copy()
    scene.collection.objects.link(copy)
    return f"{copy.name} of {thing.name}{' linked' if linked else ''}"


@edit
def move_an_object(chance, scene):
    thing, place = pick(chance, meshes(scene) + lamps(scene)), [chance.uniform(-2, 2) for _ in range(3)]
    if thing is None:
        return None
    thing.location = place
    return f"{thing.name} moved"


@edit
def rename_an_object(chance, scene):
    thing, number = pick(chance, meshes(scene) + lamps(scene)), chance.randint(1, 999)
    if thing is None:
        return None
    thing.name = f"thing {number}"
    return f"renamed {thing.name}"


@edit
def hide_in_render(chance, scene):
    thing = pick(chance, meshes(scene) + lamps(scene))
    if thing is None:
        return None
    thing.hide_render = not thing.hide_render
    return f"{thing.name} {'hidden' if thing.hide_render else 'shown'}"


@edit
def put_into_a_collection(chance, scene):
    thing, number = pick(chance, meshes(scene)), chance.randint(1, 3)
    if thing is None:
        return None
    name = f"set {number}"
    collection = bpy.data.collections.get(name) or bpy.data.collections.new(name)
    if collection.name not in scene.collection.children:
        scene.collection.children.link(collection)
    if thing.name not in collection.objects:
        collection.objects.link(thing)
    return f"{thing.name} in {name}"


def _collection_of(chance, layer):
    return pick(chance, sorted(layer.layer_collection.children, key=lambda c: c.name))


@edit
def exclude_a_collection(chance, scene):
    found = _collection_of(chance, active_layer(scene))
    if found is None:
        return None
    found.exclude = not found.exclude
    return f"{found.name} {'excluded' if found.exclude else 'included'}"


@edit
def hold_a_collection_out(chance, scene):
    found = _collection_of(chance, active_layer(scene))
    if found is None or found.exclude:
        return None
    found.holdout = not found.holdout
    return f"{found.name} holdout {found.holdout}"


@edit
def light_only_indirectly(chance, scene):
    found = _collection_of(chance, active_layer(scene))
    if found is None or found.exclude:
        return None
    found.indirect_only = not found.indirect_only
    return f"{found.name} indirect only {found.indirect_only}"


@edit
def override_materials(chance, scene):
    layer = active_layer(scene)
    material = pick(chance, things(bpy.data.materials))
    layer.material_override = None if layer.material_override else material
    return f"override {layer.material_override and layer.material_override.name}"


@edit
def toggle_a_pass(chance, scene):
    name = chance.choice(["z", "normal", "diffuse_color", "emit", "ambient_occlusion", "cryptomatte_object", "mist"])
    layer = active_layer(scene)
    setattr(layer, f"use_pass_{name}", not getattr(layer, f"use_pass_{name}"))
    return f"pass {name} {getattr(layer, f'use_pass_{name}')}"


@edit
def add_an_aov(chance, scene):
    layer, number = active_layer(scene), chance.randint(1, 3)
    if f"aov {number}" in layer.aovs:
        layer.aovs.remove(layer.aovs[f"aov {number}"])
        return f"aov {number} removed"
    layer.aovs.add().name = f"aov {number}"
    return f"aov {number}"


@edit
def add_a_view_layer(chance, scene):
    layer = scene.view_layers.new(f"own {chance.randint(1, 99)}")
    layer.use = chance.random() < 0.7
    return f"layer {layer.name}{'' if layer.use else ', not rendered'}"


@edit
def rename_a_view_layer(chance, scene):
    layer, number = active_layer(scene), chance.randint(1, 99)
    layer.name = f"layer {number}"
    return f"layer {layer.name}"


@edit
def delete_a_view_layer(chance, scene):
    layer = pick(chance, own_layers(scene)[1:])
    if layer is None:
        return None
    name = layer.name
    scene.view_layers.remove(layer)
    return f"layer {name} deleted"


@edit
def change_a_render_setting(chance, scene):
    name = chance.choice(sorted(_SETTINGS))
    value = chance.choice(_SETTINGS[name])
    if name == "seed" and not (scene.relume.split_samples or scene.relume.same_seed):
        return None  # each pass has a seed of its own by a driver: Blender lets nobody type into it
    setattr(scene.cycles, name, value)
    return f"{name} {value}"


@edit
def change_the_resolution(chance, scene):
    scene.render.resolution_x, scene.render.resolution_y = chance.choice([(16, 12), (20, 10), (12, 16)])
    return f"{scene.render.resolution_x} by {scene.render.resolution_y}"


@edit
def render_a_border(chance, scene):
    scene.render.use_border = not scene.render.use_border
    return f"border {scene.render.use_border}"


@edit
def make_the_film_transparent(chance, scene):
    scene.render.film_transparent = not scene.render.film_transparent
    return f"transparent {scene.render.film_transparent}"


@edit
def switch_the_engine(chance, scene):
    scene.render.engine = chance.choice(["CYCLES", "BLENDER_EEVEE", "BLENDER_WORKBENCH"])
    return scene.render.engine


@edit
def choose_another_camera(chance, scene):
    camera = bpy.data.objects.new("another camera", bpy.data.cameras.new("another camera"))
    camera.location = (chance.uniform(3, 6), -5.0, 4.0)
    camera.rotation_euler = (1.0, 0.0, 0.6)
    scene.collection.objects.link(camera)
    scene.camera = camera
    return "another camera"


@edit
def samples_of_a_layer(chance, scene):
    layer = pick(chance, own_layers(scene))
    layer.samples = chance.choice([0, 1, 4])
    return f"layer {layer.name}: {layer.samples} samples"


@edit
def drive_a_render_setting(chance, scene):
    name = chance.choice(["samples", "seed"])
    curve = scene.driver_add(f"cycles.{name}")
    curve.driver.expression = "frame + 1"
    return f"{name} driven"
