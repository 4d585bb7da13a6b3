"""Edits of the file as a whole: undo, redo, save, reload, append, link, copies of scenes, frames, and the mixer."""

import random
from pathlib import Path

import bpy

from relume.addon.scene import setup

from .kinds import edit, materials, pick

_FOLDER = {}


def keep_files_in(folder: Path):
    """Where the edits of a session save what they save."""
    _FOLDER["path"] = folder


def _library() -> Path:
    """A .blend with an object, a material and a lamp to append and link, made once in a process of its own."""
    return _FOLDER["path"].parent / "library.blend"


def _steps(*names: str) -> int:
    """Undo and redo, as far as there is something to; returns how many steps were made."""
    made = 0
    for name in names:
        operator = getattr(bpy.ops.ed, name)
        if operator.poll():
            operator()
            made += 1
    return made


@edit
def undo(chance, scene):
    return "undo" if _steps("undo") else None


@edit
def undo_twice_and_redo(chance, scene):
    return "undo, undo, redo" if _steps("undo", "undo", "redo") else None


@edit
def redo(chance, scene):
    return "redo" if _steps("redo") else None


@edit
def save(chance, scene):
    bpy.ops.wm.save_as_mainfile(filepath=str(_FOLDER["path"] / "work.blend"))
    return "saved"


@edit
def save_and_reload(chance, scene):
    path = str(_FOLDER["path"] / "work.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    return "saved and opened again"


@edit
def append_a_material(chance, scene):
    return _bring(chance, scene, link=False, kind="materials")


@edit
def link_a_material(chance, scene):
    return _bring(chance, scene, link=True, kind="materials")


@edit
def append_an_object(chance, scene):
    return _bring(chance, scene, link=False, kind="objects")


@edit
def link_an_object(chance, scene):
    return _bring(chance, scene, link=True, kind="objects")


def _bring(chance, scene, link: bool, kind: str):
    own = (o for o in scene.objects if o.type == "MESH" and not o.library and not o.data.library)
    thing = pick(chance, sorted(own, key=lambda o: o.name))
    with bpy.data.libraries.load(str(_library()), link=link) as (there, here):
        setattr(here, kind, sorted(getattr(there, kind)))
    brought = getattr(here, kind)
    if kind == "objects":
        for each in brought:
            if each.name not in scene.collection.objects:
                scene.collection.objects.link(each)
    elif thing is not None:
        thing.data.materials.clear()
        thing.data.materials.append(brought[0])
    return f"{'linked' if link else 'appended'} {[each.name for each in brought]}"


@edit
def copy_the_scene(chance, scene):
    if len(bpy.data.scenes) > 2:
        return None
    kind = chance.choice(["LINK_COPY", "FULL_COPY", "PYTHON"])
    if kind == "PYTHON":
        scene.copy().use_fake_user = True  # saving would leave it out otherwise
    else:
        bpy.ops.scene.new(type=kind)  # and this window goes on in the copy
    return f"{kind} of {scene.name}"


@edit
def delete_a_scene(chance, scene):
    other = pick(chance, sorted((s for s in bpy.data.scenes if s != scene), key=lambda s: s.name))
    if other is None:
        return None
    name = other.name
    bpy.data.scenes.remove(other)
    return f"{name} deleted"


@edit
def go_to_another_scene(chance, scene):
    other = pick(chance, sorted((s for s in bpy.data.scenes if s != scene), key=lambda s: s.name))
    if other is None:
        return None
    bpy.context.window.scene = other
    return f"in {other.name}"


@edit
def override_a_linked_object(chance, scene):
    linked = sorted((o for o in scene.objects if o.library is not None), key=lambda o: o.name)
    thing = pick(chance, linked)
    if thing is None:
        return None
    own = thing.override_create(remap_local_usages=True)
    return f"{own.name} overridden"


@edit
def rename_the_scene(chance, scene):
    scene.name = f"shot {chance.randint(1, 99)}"
    return scene.name


@edit
def go_to_a_frame(chance, scene):
    scene.frame_set(chance.choice([1, 5, 10]))
    return f"frame {scene.frame_current}"


@edit
def purge(chance, scene):
    bpy.ops.outliner.orphans_purge(do_local_ids=True, do_linked_ids=True, do_recursive=True)
    return "purged"


@edit
def make_a_material_local(chance, scene):
    linked = sorted((m for m in bpy.data.materials if m.library), key=lambda m: m.name)
    material = pick(chance, linked)
    if material is None:
        return None
    material.make_local()
    return f"{material.name} is local"


def _row(chance, scene):
    """A row of the mixer, None in a session without Relume: what is done to it counts in neither."""
    rows = sorted(scene.relume.light_groups, key=lambda row: row.name) if scene.relume.is_set_up else []
    return pick(chance, rows)


@edit
def choose_an_illuminant(chance, scene):
    row, name = _row(chance, scene), chance.choice(["A", "D65", "FL2", "FL11", "LED-B3"])
    if row is not None:
        row.illuminant = name
    return f"mixer: {row and row.name} {name}"


@edit
def change_the_gain(chance, scene):
    row, stops = _row(chance, scene), chance.choice([-1.0, 0.0, 2.0])
    if row is not None:
        row.stops = stops
    return f"mixer: {row and row.name} {stops} EV"


@edit
def mute_or_solo(chance, scene):
    row, name = _row(chance, scene), chance.choice(["mute", "solo"])
    if row is not None:
        setattr(row, name, not getattr(row, name))
    return f"mixer: {row and row.name} {name}"


@edit
def balance_the_white(chance, scene):
    scene.relume.white_balance = chance.choice([0.0, 0.5, 1.0])
    return f"white balance {scene.relume.white_balance}"


@edit
def change_how_samples_are_shared(chance, scene):
    name = chance.choice(["split_samples", "same_seed", "denoise_passes", "reduce_color_noise"])
    setattr(scene.relume, name, not getattr(scene.relume, name))
    return f"{name} {getattr(scene.relume, name)}"


@edit
def remove_relume_and_set_up_again(chance, scene):
    if scene.relume.is_set_up:
        setup.remove(scene)
        setup.set_up(scene)
    return f"mixer: {scene.name} removed and set up again"


@edit
def set_up_this_scene(chance, scene):
    if not scene.relume.is_set_up and any(other.relume.is_set_up for other in bpy.data.scenes):
        setup.set_up(scene)
    return f"mixer: {scene.name} set up"


@edit
def fake_user(chance, scene):
    material = pick(chance, materials())
    if material is None:
        return None
    material.use_fake_user = not material.use_fake_user
    return f"{material.name} fake user {material.use_fake_user}"


def make_library(path: Path):
    """Write the .blend that the edits append and link from; replaces the file that is open."""
    bpy.ops.wm.read_factory_settings()
    chance = random.Random(7)
    for number in range(2):
        material = bpy.data.materials.new(f"from library {number}")
        principled = material.node_tree.nodes["Principled BSDF"]
        principled.inputs["Base Color"].default_value = (*(chance.random() for _ in range(3)), 1.0)
        bpy.ops.mesh.primitive_cube_add(size=0.5, location=(number, 1, 1))
        bpy.context.object.name = f"library object {number}"
        bpy.context.object.data.materials.append(material)
    for thing in [o for o in bpy.data.objects if not o.name.startswith("library")]:
        bpy.data.objects.remove(thing)
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
