"""Setting a scene up for spectral rendering, changing its light, and giving the scene back."""

import json
from collections.abc import Generator, Iterable, Iterator, Mapping
from contextlib import closing
from types import MappingProxyType

import bpy
import numpy as np

from ...core.errors import RelumeError, SetupError
from ...core.model import channel_order
from ...core.model.factor_model import FactorModel
from ...core.picture import drawing, recombination
from ...core.picture.mix import Light, Mix
from ..graph import glass, insertion, lamps, lights, nodes, sockets, spectra
from ..graph.memory import Memory
from ..host import interruption, viewing
from ..host.steps import finished
from ..store import mixer, mixes, properties, remarks, schema
from ..store.mixer import CURVE
from . import compositing, faults, note, passes, planning, render_settings, rows, shading, surfaces, view_layers

__all__ = [
    "SetupError",
    "bring_in_line",
    "follow",
    "lighting",
    "matrices_of",
    "relight",
    "release",
    "remove",
    "set_up",
    "setting_up",
    "update",
]


def set_up(scene, model: FactorModel | None = None) -> None:
    """Make a scene spectral: colours, lamps, passes, preview and compositing, for `model` or the scene's channels.

    A scene that is set up already is set up afresh. Whatever stops it, Ctrl-C too, leaves every scene as it was.
    Raises SetupError.
    """
    with interruption.held_back() as let_through, closing(setting_up(scene, model)) as steps:
        for _ in steps:
            let_through()


def setting_up(scene, model: FactorModel | None = None) -> Iterator[str]:
    """Do what `set_up` does piece by piece; yields what is being done. Closed on the way, it leaves all as it was."""
    faults.check(scene)
    schema.check(scene)
    chosen = {"request": ""}
    if model is None:
        model, chosen = yield from planning.chosen(scene)
    model = channel_order.balanced(model)
    # The coefficients of a spectrum are those of one model: all scenes of a file share it
    described = json.dumps(model.to_dict())
    others = _others_without(scene, described)
    for other in others:
        schema.check(other)
    scenes = [scene, *others]
    before = {s: (s[properties.MODEL], planning.plan_of(s), rows.members_of(s)) for s in scenes if s.relume.is_set_up}
    at = scene
    with mixer.quiet():
        try:
            for each in scenes:
                rows.mark(each.relume)
            for each in before:
                _take_out(each)
            for each in scenes:
                at = each
                for _ in bring_in_line(each, model, before[each][2] if each in before else {}):
                    yield f"setting up {each.name}"
                if each is scene and chosen["request"]:
                    chosen["request"] = scene.relume.request  # that of one lamp is known by the row that it now has
                each[properties.PLAN] = chosen
            for each in scenes:
                rows.settle(each.relume)
            nodes.clear_orphans()
            nodes.keep_spares()
            nodes.is_undo_unsafe(now_safe=True)
        except BaseException as error:
            lost = _give_back(scenes, before)
            if isinstance(error, SetupError) or not isinstance(error, Exception):
                raise
            if lost:
                what = f"setting up scene {at.name!r} failed, and so did setting up {lost} as before"
            else:
                what = f"scene {at.name!r} is as it was, for setting it up failed"
            raise SetupError(f"{what}: {error}") from error


def _give_back(scenes: list, before: dict) -> str:
    """Make scenes what they were before `set_up` began; returns the names of those where that failed."""
    lost = []
    for each in scenes:
        if each in before:
            _take_out(each)
        else:
            _remove(each)
        rows.put_back(each.relume)
    for each, (described, planned, members) in before.items():
        try:
            _put_in(each, FactorModel.from_dict(json.loads(described)), members)
            each[properties.PLAN] = planned
        except Exception:
            _remove(each)
            lost.append(repr(each.name))
    if before:
        nodes.keep_spares()
    return ", ".join(lost)


def _put_in(scene, model: FactorModel, members: dict) -> None:
    """Bring all that a scene carries in line at once."""
    finished(bring_in_line(scene, model, members))


def bring_in_line(
    scene, model: FactorModel, members: dict, gentle: bool = False, surveyed: shading.Survey | None = None
) -> Generator[None, None, shading.Shown]:
    """Bring all that a scene carries in line with the scene and with `model`; what is right stays untouched.

    A generator that yields where there may be a pause, and returns what the scene shows. members: what shone in each
    light group before. gentle: an artist is at work, as in `insertion.patch`. surveyed: what the scene reaches, where
    that is known.
    """
    surveyed = surveyed or (yield from shading.survey(scene, Memory(is_lasting=False)))
    groups = rows.sync(scene, members, surveyed.members)
    described = json.dumps(model.to_dict())
    if scene.get(properties.MODEL) != described:
        scene[properties.MODEL] = described
    schema.note(scene)
    yield
    spectra.update_all(model)
    glass.update_all(model)
    yield
    shown = yield from shading.look(scene, model, groups, surveyed, gentle)
    yield
    for _ in shown.patch_all(gentle):
        yield
    _give_illuminants(scene, shown.lighting.temperatures)
    passes.put(scene, model, groups)
    surfaces.follow(scene)
    shown.note_remarks(scene)
    yield
    relight(scene)
    yield
    return shown


def _give_illuminants(scene, temperatures: dict[str, float]) -> None:
    """Have the rows of the mixer show black bodies and named lamps of the scene, where the artist chose nothing."""
    before = scene[rows.GIVEN].to_dict() if rows.GIVEN in scene else {}
    given = {}
    firsts = lamps.first_illuminants(scene, [row.name for row in scene.relume.lit], temperatures)
    for row in scene.relume.lit:
        if row.is_property_set("illuminant") and row.illuminant != before.get(row.name):
            continue
        first = firsts[row.name]
        if first != row.bl_rna.properties["illuminant"].default:
            given[row.name] = first
            if row.illuminant != first:
                row["illuminant"] = first
        elif row.is_property_set("illuminant"):
            row.property_unset("illuminant")
    if before != given or rows.GIVEN not in scene:
        scene[rows.GIVEN] = given


def _take_back_illuminants(scene) -> None:
    """Unset the illuminants that set-up put into the mixer, where the artist chose no other."""
    given = scene[rows.GIVEN].to_dict() if rows.GIVEN in scene else {}
    for row in scene.relume.light_groups:
        if row.illuminant == given.get(row.name):
            row.property_unset("illuminant")
    if rows.GIVEN in scene:
        del scene[rows.GIVEN]


def lighting(scene) -> Mix:
    """The mix that a scene shows. Raises RelumeError where it cannot be shown."""
    return mixes.of(scene.relume, scene.relume.model())


def _write_lighting(scene, mix: Mix) -> bool:
    """Write a mix into the compositor and the preview: numbers only, and only those that changed; whether any did."""
    model = scene.relume.model()
    changed = compositing.write_matrices(scene, recombination.recombination_matrices(model, mix))
    layers = view_layers.preview_layers(scene)
    if layers:
        shown = recombination.preview(model, mix)
        for layer in layers:
            changed |= view_layers.write_view(scene, layer, shown)
    return changed


def _draw_swatches(scene, lights: Iterable[Light]) -> None:
    """Keep with each row what its icon shows, so that the panel has to compute nothing."""
    for row, light in zip(scene.relume.lit, lights, strict=True):
        curve = drawing.curve(light.illuminant).tolist()
        if list(row.get(CURVE, ())) != curve:
            row[CURVE] = curve
            row["swatch"] = drawing.swatch(light.illuminant).tolist()


def relight(scene) -> None:
    """Show what the mixer now says. A mix that cannot be shown changes nothing in the picture: the panel says why.

    Never raises: Blender calls it while a property changes.
    """
    settings = scene.relume
    if not settings.is_set_up:
        return
    try:
        chosen = lighting(scene)
        changed = _write_lighting(scene, chosen)
    except RelumeError as error:
        settings["problem"], changed = str(error), True
    else:
        settings["problem"] = ""
        _draw_swatches(scene, chosen.lights.values())
    if changed:
        scene.update_tag()


def matrices_of(scene, snapshot: dict) -> np.ndarray:
    """(groups, 3, p) recombination matrices of a mix that `schema.snapshot` read. Raises RelumeError."""
    model = scene.relume.model()
    return recombination.recombination_matrices(model, mixes.at(scene.relume, snapshot, model))


def follow(scene, said: dict) -> None:
    """Show what `mixer.choices` said, of a frame of an animation. Never raises."""
    try:
        groups = [row.name for row in scene.relume.lit]
        _write_lighting(scene, mixes.of_choices(said, groups, scene.relume.model()))
    except RelumeError as error:
        scene.relume["problem"] = str(error)


def update(scene, model: FactorModel | None = None, memory: Memory | None = None) -> shading.Shown:
    """Bring all that a scene carries in line with the scene, as setting it up afresh would. Changes only what differs.

    model: another one than it has; the other scenes of the file, which share it, get it too. memory: what is known of
    its node trees. Returns what the scene shows. Raises SetupError.
    """
    surveyed = finished(shading.survey(scene, memory or Memory(is_lasting=False)))
    faults.check(scene, bool(surveyed.members))
    schema.check(scene)
    model = model or scene.relume.model()
    with interruption.held_back(), mixer.quiet():
        shown = finished(bring_in_line(scene, model, rows.members_of(scene), surveyed=surveyed))
        for each in _others_without(scene, json.dumps(model.to_dict())):
            _put_in(each, model, rows.members_of(each))
    viewing.redraw()
    return shown


def _others_without(scene, described: str) -> list:
    """The other scenes of the file that are set up, but for another model than that described."""
    return [s for s in bpy.data.scenes if s != scene and s.relume.shades and s[properties.MODEL] != described]


def remove(scene) -> None:
    """Give the scene back as it was before `set_up`; does nothing to a scene that is not set up.

    An exception or Ctrl-C on the way is raised once it is done all the same. Raises SetupError.
    """
    schema.check(scene)
    with interruption.held_back(), mixer.quiet():
        try:
            _remove(scene)
        except BaseException:
            _remove(scene)  # every step of it does what is left to do
            raise


def _remove(scene) -> None:
    _take_out(scene)
    rows.forget_untouched(scene)


def _take_out(scene) -> None:
    """Take the set-up out of a scene, but for the rows of its mixer; that it is set up is forgotten last."""
    compositing.remove(scene)
    note.remove(scene)
    surfaces.remove(scene)
    view_layers.remove(scene)
    render_settings.give_back(scene)
    _take_back_illuminants(scene)
    for name in ("problem", "comparing"):
        scene.relume.property_unset(name)
    remarks.clear(scene)
    others = [other for other in bpy.data.scenes if other != scene and other.relume.shades]
    _release(others)
    if others:
        spectra.mend_all(others[0].relume.model())
        glass.mend_all(others[0].relume.model())
    else:
        spectra.restore_all()
        glass.restore_all()
    nodes.clear_orphans()
    schema.clear(scene)
    for key in (properties.PLAN, properties.MODEL):
        if key in scene:
            del scene[key]


def release(known: dict[str, shading.Shown]) -> None:
    """Take the set-up out of materials, lamps and worlds that no scene shows any more. known: what some scenes show."""
    _release([scene for scene in bpy.data.scenes if scene.relume.shades], known)


def _release(shown: list, known: Mapping = MappingProxyType({})) -> None:
    """Take the set-up out of what none of some scenes shows."""
    kept_trees = set()
    for scene in shown:
        if scene.name in known:
            kept_trees.update(each.tree for each in known[scene.name].shadings.values())
        else:
            kept_trees.update(tree for tree, _ in sockets.trees_of(scene))
    kept_lights = {thing.data for scene in shown for thing in scene.objects if thing.type == "LIGHT"}
    for light in lights.local_lights():
        if light not in kept_lights:
            lights.restore(light)
    for tree, owner in sockets.all_trees():
        if tree not in kept_trees:
            insertion.restore(tree, owner)
