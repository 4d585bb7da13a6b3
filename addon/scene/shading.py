"""What shades a scene: which node trees and lamps it reaches, and what was found when they were looked at last."""

from collections.abc import Callable, Collection, Generator, Iterator
from dataclasses import dataclass, field

import bpy

from ...core.model.factor_model import FactorModel
from ..graph import insertion, lights, sockets
from ..graph.memory import Memory
from ..host import animation, inventory
from ..store import remarks
from ..store.remarks import Remark
from . import compositing, faults, rows

__all__ = ["Shown", "Survey", "look", "matters", "survey"]


@dataclass
class Survey:
    """What a scene reaches, before any of it is changed. members: what shines in each light group."""

    found: inventory.Inventory
    members: dict[str, list[str]]
    memory: Memory


def survey(scene, memory: Memory) -> Generator[None, None, Survey]:
    """Find out what a scene reaches; `memory` then knows its node trees as they are now."""
    memory.look_again()
    found = yield from inventory.taking(scene)
    yield
    for owner in [*found.materials, *found.lights, *([found.world] if found.world else [])]:
        if owner.node_tree is not None:
            memory.emits(owner.node_tree)
            yield
    return Survey(found, lights.members_of(scene, found, memory), memory)


@dataclass
class Shown:
    """What a scene shows.

    shadings: {material, world, light or node group: how it shades}, of those that can be changed. about_scene: what the
    scene goes without. about: what was found to stay RGB, by owner.
    things: {session_uid of an object: what of it `matters`}. parts: {owner: itself and all that say what reaches it}.
    memory: what is known of node trees, whatever was shown when.
    """

    shadings: dict[bpy.types.ID, sockets.Shading]
    lighting: lights.Lighting
    about_scene: list[Remark]
    things: dict[int, tuple]
    parts: dict[bpy.types.ID, list[bpy.types.ID]]
    memory: Memory
    about: dict[bpy.types.ID, list[Remark]] = field(default_factory=dict)

    def take_colour(self, owner) -> None:
        """Take the colour out of a lamp that has another than before, but is of the same temperature."""
        if owner in self.lighting.lamps:
            self.lighting.lamps |= lights.take_colours([owner], gentle=True)[0]

    def patch(self, owners: Collection, gentle: bool = False) -> int:
        return self._patch(owners, self._near(owners, sockets.groups_in), gentle)[0]

    def _patch(self, owners: Collection, near: list[sockets.Shading], gentle: bool) -> tuple[int, bool]:
        """How many nodes changed, and whether what is there now is what should be, with nothing that only may stay."""
        described = sockets.describe(near, self.lighting.model.channels, self.lighting.describe)
        for owner in owners:
            found = [remark for remark in described.remarks if remark.owner == self.shadings[owner].words]
            self.about[owner] = found
        trees = {self.shadings[owner].tree for owner in owners}
        changes = insertion.patch(described, trees, gentle)
        stays = gentle and any(described.wiring.inserted(s) for s in described.neutral if s.id_data in trees)
        return changes, not stays

    def _near(self, owners: Collection, groups_in: Callable) -> list[sockets.Shading]:
        """The trees that say what should be before the sockets of some: themselves, their part, the groups in them."""
        near = {other: self.shadings[other] for owner in owners for other in self.parts[owner]}
        waiting = list(near)
        while waiting:
            for inner in groups_in(self.shadings[waiting.pop()].tree):
                if inner in self.shadings and inner not in near:
                    near[inner] = self.shadings[inner]
                    waiting.append(inner)
        return list(near.values())

    def patch_all(self, gentle: bool = False) -> Iterator[int]:
        """Patch everything, a part at a time, but what is known to be as it should; yields how many nodes changed."""
        under = self.lighting.model, sockets.has_spectra(), bpy.data.colorspace.working_space
        for part in {id(part): part for part in self.parts.values()}.values():
            near = self._near(part, self.memory.groups_in)
            saying = tuple(map(self._saying, near))
            found = self.memory.in_line(part[0], under, saying)
            if found is not None:
                self.about |= dict(found)
                yield 0
                continue
            changes, is_in_line = self._patch(part, near, gentle)
            if changes:
                for owner in part:
                    self.memory.forget(self.shadings[owner].tree)
            elif is_in_line:
                self.memory.note_in_line(part[0], under, saying, [(owner, self.about[owner]) for owner in part])
            yield changes

    def _saying(self, shading: sockets.Shading) -> tuple:
        """All that says what should be before the sockets of a tree."""
        owner, lighting = shading.owner, self.lighting
        group = lights.group_of(shading, lighting.groups)
        light = group, lighting.numbers[group], group in lighting.temperatures, lighting.lamps.get(owner)
        moving = animation.shared(shading.tree), animation.shared(owner), animation.paths(shading.tree, owner)
        if owner != shading.tree:
            moving += (animation.paths(owner, owner),)
        return self.memory.facts(shading.tree), owner.name, light, moving

    def note_remarks(self, scene) -> None:
        """Write down all that was found, and what the compositing goes without."""
        about_trees = [remark for found in self.about.values() for remark in found]
        remarks.write(scene, [*self.about_scene, *about_trees, *compositing.remarks_on(scene)])


def look(
    scene, model: FactorModel, groups: list[str], surveyed: Survey, gentle: bool = False
) -> Generator[None, None, Shown]:
    """Look at all that a scene shows; takes the colours out of its lamps, so that they can stand in nodes.

    gentle: an artist is at work, as in `lights.take_colours`.
    """
    found, memory, numbers = surveyed.found, surveyed.memory, rows.numbers(scene)
    animation.count_again(found.animated)
    about_scene = faults.remarks_on(scene, found)
    yield
    lamps, about_lamps = lights.take_colours(found.lights, gentle)
    for light in lamps:
        memory.forget(light.node_tree)
    yield
    things = {}
    for thing in found.objects:
        things[thing.session_uid] = matters(thing)
        yield
    shadings, about_trees = sockets.shadings_of(found, memory.groups_in)
    yield
    glows = {}
    for shading in shadings:
        glows[shading] = memory.glows_of(shading, lamps.get(shading.owner))
        yield
    return Shown(
        shadings={shading.owner: shading for shading in shadings},
        lighting=lights.Lighting(model, {name: numbers[name] for name in groups}, lamps, glows),
        about_scene=[*about_scene, *about_trees, *about_lamps],
        things=things,
        parts=_parts({shading.owner: shading for shading in shadings}, memory),
        memory=memory,
    )


def _parts(shadings: dict, memory: Memory) -> dict:
    """{owner: itself, and where there are spectra all that share node groups with it, directly or not}.

    A spectrum that reaches a node group from one of its users decides what the others need before it.
    """
    parts = {owner: [owner] for owner in shadings}
    if not sockets.has_spectra():
        return parts
    for owner, shading in shadings.items():
        for inner in memory.groups_in(shading.tree):
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
