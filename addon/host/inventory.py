"""What a scene renders: every data-block that it reaches, and which objects show which materials."""

from collections.abc import Generator

import bpy

from .steps import finished

__all__ = ["Inventory", "is_foreign", "take", "taking"]


class Inventory:
    """The data-blocks that a scene reaches, in the order of its objects.

    blocks: all of them, the scene first.
    objects: those of the scene, then those that collections, Geometry Nodes and particles bring in.
    materials: {material: the first object that shows it, or None}.
    animated: the data-blocks that use an action, all those of the file.
    """

    def __init__(self, scene, uses: dict, animated: set) -> None:
        reached = _reached(scene, uses)
        own = list(scene.objects)
        known = set(own)
        self.blocks = list(reached)
        self.objects = own + [block for block in reached if isinstance(block, bpy.types.Object) and block not in known]
        self.world = scene.world
        self.animated = animated
        self._uses = uses
        self.materials = {}
        for thing in self.objects:
            for material in self.materials_of(thing):
                self.materials.setdefault(material, thing)
        for block in reached:
            if isinstance(block, bpy.types.Material):
                self.materials.setdefault(block, None)

    @property
    def lights(self) -> dict:
        """{light: the first object that uses it}."""
        found = {}
        for thing in self.objects:
            if thing.type == "LIGHT":
                found.setdefault(thing.data, thing)
        return found

    def materials_of(self, thing) -> list:
        """Materials in the slots of an object, and those that its Geometry Nodes may give it."""
        found = {slot.material: None for slot in thing.material_slots if slot.material}
        for modifier in thing.modifiers:
            if modifier.type == "NODES" and modifier.node_group:
                found |= dict.fromkeys(self._materials_behind(modifier.node_group))
                found |= dict.fromkeys(b for b in self._uses.get(thing, ()) if isinstance(b, bpy.types.Material))
        return list(found)

    def _materials_behind(self, start):
        visited, waiting = {start}, [start]
        while waiting:
            for block in self._uses.get(waiting.pop(), ()):
                if isinstance(block, bpy.types.Material):
                    yield block
                elif block not in visited and isinstance(block, bpy.types.GeometryNodeTree):
                    visited.add(block)
                    waiting.append(block)


def is_foreign(block) -> bool:
    """Whether a data-block is linked or overrides linked data: Blender keeps its nodes from changes."""
    return block.library is not None or block.override_library is not None


def take(scene) -> Inventory:
    """The inventory of a scene; takes a walk over all data-blocks of the file, about 20 µs each."""
    return finished(taking(scene))


def taking(scene) -> Generator[None, None, Inventory]:
    """`take`, with pauses."""
    uses, animated = {}, set()
    kinds = {kind.identifier for kind in bpy.types.ID.bl_rna.properties["id_type"].enum_items}
    # Materials take longest to ask, for all that their nodes may use
    for asked in ({"MATERIAL"}, kinds - {"MATERIAL"}):
        for block, users in bpy.data.user_map(value_types=asked).items():
            for user in users:
                uses.setdefault(user, []).append(block)
            if isinstance(block, bpy.types.Action):
                animated |= users
        yield
    return Inventory(scene, uses, animated)


def _reached(scene, uses: dict) -> dict:
    """Everything that a scene and its background set use, directly or not; not what other scenes use."""
    reached, waiting = {scene: None}, [scene]
    while waiting:
        block = waiting.pop()
        for used in uses.get(block, ()):
            if used not in reached and not (isinstance(used, bpy.types.Scene) and used != scene.background_set):
                reached[used] = None
                waiting.append(used)
    return reached
