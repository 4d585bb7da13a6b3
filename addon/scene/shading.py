"""What shades a scene: which node trees and lamps it reaches, and what was found when they were looked at last."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass, field

import bpy

from ...core.model.factor_model import FactorModel
from ..graph import insertion, lights, nodes, sockets
from ..host import animation, inventory
from ..store import remarks
from ..store.remarks import Remark
from . import compositing, faults, rows

__all__ = ["Shown", "look", "matters"]


@dataclass
class Shown:
    """What a scene shows.

    shadings: {material, world, light or node group: how it shades}, of those that can be changed. about_scene: what the
    scene goes without. about: what was found to stay RGB, by owner.
    things: {session_uid of an object: what of it `matters`}. parts: {owner: itself and all that say what reaches it}.
    """

    shadings: dict[bpy.types.ID, sockets.Shading]
    lighting: lights.Lighting
    about_scene: list[Remark]
    things: dict[int, tuple]
    parts: dict[bpy.types.ID, list[bpy.types.ID]]
    about: dict[bpy.types.ID, list[Remark]] = field(default_factory=dict)

    def patch(self, owners: Collection, gentle: bool = False) -> int:
        """Put what should be there before the sockets of some owners' node trees; returns how many nodes changed."""
        near = self._near(owners)
        described = sockets.describe(near, self.lighting.model.channels, self.lighting.describe)
        for owner in owners:
            found = [remark for remark in described.remarks if remark.owner == self.shadings[owner].words]
            self.about[owner] = found
        return insertion.patch(described, {self.shadings[owner].tree for owner in owners}, gentle)

    def _near(self, owners: Collection) -> list[sockets.Shading]:
        """The trees that say what should be before the sockets of some: themselves, their part, the groups in them."""
        near = {other: self.shadings[other] for owner in owners for other in self.parts[owner]}
        waiting = list(near)
        while waiting:
            for inner in sockets.groups_in(self.shadings[waiting.pop()].tree):
                if inner in self.shadings and inner not in near:
                    near[inner] = self.shadings[inner]
                    waiting.append(inner)
        return list(near.values())

    def patch_all(self, gentle: bool = False) -> Iterator[int]:
        """Patch everything, a part at a time; yields how many nodes changed in each."""
        for part in {id(part): part for part in self.parts.values()}.values():
            yield self.patch(part, gentle)

    def note_remarks(self, scene) -> None:
        """Write down all that was found, and what the compositing goes without."""
        about_trees = [remark for found in self.about.values() for remark in found]
        remarks.write(scene, [*self.about_scene, *about_trees, *compositing.remarks_on(scene)])


def look(scene, model: FactorModel, groups: list[str], gentle: bool = False) -> Shown:
    """Look at all that a scene shows; takes the colours out of its lamps, so that they can stand in nodes.

    gentle: an artist is at work, as in `lights.take_colours`.
    """
    animation.count_again()
    found, numbers = inventory.take(scene), rows.numbers(scene)
    about_scene = faults.remarks_on(scene, found)
    lamps, about_lamps = lights.take_colours(found.lights, gentle)
    shadings, about_trees = sockets.shadings_of(found)
    return Shown(
        shadings={shading.owner: shading for shading in shadings},
        lighting=lights.Lighting(model, {name: numbers[name] for name in groups}, lamps, shadings),
        about_scene=[*about_scene, *about_trees, *about_lamps],
        things={thing.session_uid: matters(thing) for thing in found.objects},
        parts=_parts({shading.owner: shading for shading in shadings}),
    )


def _parts(shadings: dict) -> dict:
    """{owner: itself, and where there are spectra all that share node groups with it, directly or not}.

    A spectrum that reaches a node group from one of its users decides what the others need before it.
    """
    parts = {owner: [owner] for owner in shadings}
    if not any(tree.get(nodes.ROLE) == "spectrum" for tree in bpy.data.node_groups):
        return parts
    for owner, shading in shadings.items():
        for inner in sockets.groups_in(shading.tree):
            if inner in parts and parts[inner] is not parts[owner]:
                joined = parts[owner] + parts[inner]
                parts |= dict.fromkeys(joined, joined)
    return parts


def matters(thing) -> tuple:
    """What of an object decides how it is shaded and lit."""
    modifiers = [(m.node_group, m.show_render) for m in thing.modifiers if m.type == "NODES"]
    systems = [(p.settings, p.settings.instance_object) for p in thing.particle_systems]
    slots = [slot.material for slot in thing.material_slots]
    own = (thing.type, thing.lightgroup, thing.hide_render, thing.instance_collection, thing.animation_data is None)
    return own, thing.data, *slots, *modifiers, *systems
