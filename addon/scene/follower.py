"""Following the artist: a scene that is set up is brought in line with every edit, while nobody waits for it.

Blender says which data-blocks changed (`notice`); once the artist pauses, `tick` looks at those alone, and only where
an edit reaches further at the whole scene, a slice at a time. `settle` looks at everything at once: before a render and
before a file is saved. Nothing here makes a step of undo: each step brings back what was there when it was made, and
following does its work again.
"""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import bpy

from ...core.errors import RelumeError
from ..graph import lights, nodes, sockets
from ..graph.memory import Memory
from ..host import animation, viewing
from ..host.console import LOG
from ..store import mixer, properties
from . import faults, passes, planning, rows, setup, shading, view_layers
from .shading import Shown, matters

__all__ = [
    "edition",
    "follow",
    "followed",
    "forget",
    "held",
    "is_at_work",
    "notice",
    "settle",
    "settle_all",
    "tick",
    "watch",
]

_PAUSE = 0.25  # seconds without an edit, after which the artist pauses
_SLICE = 0.01  # seconds of work at a time
_SHADING = (bpy.types.ShaderNodeTree, bpy.types.Material, bpy.types.World, bpy.types.Light)
# What brings objects and materials into a scene, beside objects themselves; meshes and the like say nothing of them
_BRINGING = (bpy.types.Collection, bpy.types.GeometryNodeTree, bpy.types.ParticleSettings)


@dataclass
class _Noticed:
    """What was edited and has not been followed.

    owners: of node trees. settings: of a scene or its compositing. everything: more than those. content: what a plan
    depends on may have changed since it was made. edition: grows with every edit of anything but settings. at: when the
    last edit was. work: what is under way.
    """

    owners: dict = field(default_factory=dict)
    settings: bool = False
    everything: bool = False
    content: bool = True
    edition: int = 0
    at: float = 0.0
    work: Iterator | None = None

    def is_any(self) -> bool:
        return bool(self.owners) or self.settings or self.everything or self.work is not None

    def done(self) -> None:
        self.owners, self.settings, self.everything, self.work = {}, False, False, None


_shown: dict[int, Shown] = {}  # by the scene's session_uid: what was found when it was looked at last
_memories: dict[int, Memory] = {}  # by the same
_noticed = _Noticed()
_seen: dict[int, tuple] = {}  # by a scene's session_uid: what `watch` saw last
_held = 0


def followed() -> list:
    """The scenes of the file that are set up, and can be changed now."""
    scenes = bpy.data.scenes if not _held else ()
    found = [s for s in scenes if s.relume.shades and s.is_editable and s.override_library is None]
    return sorted(found, key=lambda scene: scene.name)  # as they are in a file: what two show is as the last has it


def is_at_work() -> bool:
    """Whether scenes are being brought in line, a slice at a time."""
    return _noticed.work is not None


def forget() -> bool:
    """Look at all scenes again: what was known of them is gone after undo, or when a file was read. Returns whether
    there is anything to follow."""
    _shown.clear()
    _memories.clear()
    _noticed.done()
    _noticed.everything = _noticed.content = bool(followed())
    _noticed.edition += 1
    _noticed.at = time.monotonic()
    return _noticed.everything


def notice(scene, depsgraph) -> bool:
    """Take note of what Blender says has changed; returns whether there is anything to follow."""
    shown = _shown.get(scene.session_uid)
    known = shown.things if shown else {}
    for update in depsgraph.updates:
        block = update.id.original
        if isinstance(block, bpy.types.Scene | bpy.types.CompositorNodeTree):
            _noticed.settings = True
            continue
        _noticed.edition += 1
        if isinstance(block, _SHADING):
            _noticed.owners[block] = None
        elif isinstance(block, bpy.types.Object):
            if known.get(block.session_uid) == matters(block):
                continue
            _noticed.everything = True
        elif isinstance(block, _BRINGING):
            _noticed.everything = True
        else:
            continue
        _noticed.content = True
    if _noticed.is_any():
        animation.count_again()
        _noticed.at, _noticed.work = time.monotonic(), None
    return _noticed.is_any()


def edition() -> tuple[int, float]:
    """(number, seconds): another number once what a camera sees may have changed; how long the last edit is ago."""
    return _noticed.edition, time.monotonic() - _noticed.at


def watch(rendered: bool = False) -> bool:
    """Take note of what Blender tells nobody: view layers that came, samples that a script changed; whether any did, or
    a render has ended."""
    now = {scene.session_uid: _watched(scene) for scene in followed()}
    changed = (now != _seen or rendered) and not mixer.is_quiet()
    if changed:
        _seen.clear()
        _seen.update(now)
        _noticed.settings, _noticed.at, _noticed.work = True, time.monotonic(), None
    return changed


def _watched(scene) -> tuple:
    layers = [(layer.name, len(layer.lightgroups), len(layer.aovs)) for layer in view_layers.sources(scene)]
    return (*layers, scene.cycles.samples)


def tick() -> float | None:
    """Timer: follow what was noticed once the artist pauses; returns the seconds until it is to run again."""
    if not _noticed.is_any():
        return None
    if bpy.app.is_job_running("RENDER") or mixer.is_quiet():
        return _PAUSE
    viewing.update()  # so that Blender says what was edited until now
    waited = time.monotonic() - _noticed.at
    if waited < _PAUSE:
        return _PAUSE - waited
    return _SLICE if _work_on(time.monotonic() + _SLICE) else None


def follow() -> None:
    """Follow at once all that was noticed, as `tick` does by and by. Leaves what an artist may just be choosing."""
    viewing.update()
    if _noticed.is_any():
        _work_on(float("inf"))


def _work_on(until: float) -> bool:
    """Follow until a time is reached; whether anything is left to do."""
    try:
        with mixer.quiet(), nodes.orphans_stay():
            _noticed.work = _noticed.work or _follow()
            try:
                while next(_noticed.work, _DONE) is not _DONE:
                    if time.monotonic() > until:
                        return True
            finally:
                viewing.update()  # quietly: what was changed here is no edit
    except ReferenceError:  # a data-block went away meanwhile
        return forget()
    except Exception as error:
        _report(error)
    _noticed.done()
    return False


_DONE = object()


@contextmanager
def held() -> Iterator[None]:
    """While it is entered nothing is followed: Relume itself changes settings for a while."""
    global _held
    _held += 1
    try:
        yield
    finally:
        _held -= 1


def _report(error: Exception) -> None:
    LOG.error("following the scene failed", exc_info=error)
    for scene in followed():
        scene.relume["problem"] = f"the last edit could not be followed: {error}"


def _follow() -> Iterator[None]:
    """Bring every scene in line with what was noticed, gently, yielding where there may be a pause."""
    owners, everywhere = list(_noticed.owners), _noticed.everything
    for scene in followed():
        shown = _shown.get(scene.session_uid)
        if everywhere or shown is None or not all(_is_alone(shown, owner) for owner in owners):
            yield from _follow_all(scene)
            continue
        for owner in owners:
            shown.take_colour(owner)
            if owner in shown.shadings and shown.patch([owner], gentle=True):
                shown.note_remarks(scene)
            yield
        if _noticed.settings:
            passes.put(scene, scene.relume.model(), [row.name for row in scene.relume.lit])
            setup.relight(scene)
            yield
    nodes.keep_spares()
    viewing.redraw()


def _is_alone(shown: Shown, owner) -> bool:
    """Whether an edit of a node tree reaches no further than the tree: no node group, nothing that shines
    otherwise than before; a lamp may have another colour."""
    if owner not in shown.shadings:
        known = isinstance(owner, bpy.types.NodeTree) and owner.is_embedded_data  # as its owner
        return known or bool(owner.get(nodes.ROLE)) or owner.library is not None
    shades, lamp = shown.shadings[owner], shown.lighting.lamps.get(owner)
    if isinstance(owner, bpy.types.NodeTree) or len(shown.parts[owner]) > 1:
        return False
    if isinstance(owner, bpy.types.Light):
        now = lights.colours_of([owner]).get(owner)
        if lamp is None or now is None or now.temperature != lamp.temperature or not lights.is_taken(owner):
            return False
    known = all(group in shown.shadings for group in sockets.groups_in(shades.tree))
    return known and lights.glows_of(shades, lamp) == shown.lighting.glows[owner]


def _follow_all(scene) -> Iterator[None]:
    """Bring a scene in line, whatever was edited."""
    if not _is_carried(scene):
        setup.remove(scene)
        return
    surveyed = yield from shading.survey(scene, _memory_of(scene))
    try:
        faults.check(scene, bool(surveyed.members))
    except RelumeError as error:
        scene.relume["problem"] = str(error)
        return
    _shown[scene.session_uid] = yield from setup.bring_in_line(
        scene, scene.relume.model(), rows.members_of(scene), True, surveyed
    )


def _memory_of(scene) -> Memory:
    """What is known of the node trees of a scene; nothing where other scenes may change them too."""
    if len(followed()) > 1:
        _memories.clear()
    return _memories.setdefault(scene.session_uid, Memory())


def _is_carried(scene) -> bool:
    """Whether a scene carries what it says it does: one that was made with the settings of another has only those."""
    return bool(view_layers.preview_layers(scene) or view_layers.pass_layers(scene))


def settle_all() -> None:
    """Settle every scene, and again where one made others change: by another model, or other numbers of lights."""
    for _ in range(2):
        scenes = followed()
        before = _shared_by(scenes)
        for scene in scenes:
            settle(scene)
        if len(scenes) < 2 or before == _shared_by(scenes):
            break


def _shared_by(scenes: list) -> tuple:
    """What scenes of a file have in common: the numbers of light groups, and the model."""
    numbers = rows.numbers(scenes[0]) if scenes else {}
    return numbers, [scene.get(properties.MODEL) for scene in scenes]


def settle(scene) -> None:
    """Bring a scene in line at once and wholly, as setting it up afresh with its model would. Never raises.

    Where Relume chooses the channels, and those that it chose no longer do for what the scene shows, it gets others.
    """
    try:
        with nodes.orphans_stay():
            if _is_carried(scene):
                _noticed.work = None  # what it knows of node trees is about to change
                shown = _shown[scene.session_uid] = setup.update(scene, memory=_memory_of(scene))
                setup.release({scene.name: shown})
                _plan_again(scene)
            else:
                setup.remove(scene)
    except RelumeError as error:
        scene.relume["problem"] = str(error)
    except Exception as error:
        _report(error)


def _plan_again(scene) -> None:
    """Give a scene another model where its own is no longer within the tolerance."""
    if not (_noticed.content or bpy.app.background):
        return
    _noticed.content = False
    if revised := planning.revised(scene):
        noted, model = revised
        if model is not None:
            setup.update(scene, model)
            LOG.info("scene %r: %s", scene.name, noted["changed"])
        scene[properties.PLAN] = noted
