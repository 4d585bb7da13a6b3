"""Setting a scene up for spectral rendering, changing its light, and giving the scene back."""

import json

import bpy

from ..core import drawing, grouping, plan, sampling, view
from ..core.errors import SetupError
from ..core.factor_model import FactorModel
from ..core.library import LibraryError
from . import (
    compositing,
    content,
    denoise,
    glass,
    inventory,
    lights,
    mixer,
    nodes,
    passes,
    properties,
    remarks,
    render_settings,
    sockets,
    spectra,
    surfaces,
)
from .icons import CURVE
from .render_settings import SUBSET

__all__ = [
    "SetupError",
    "follow",
    "lighting",
    "matrices_of",
    "relight",
    "remove",
    "sampling_for",
    "set_up",
    "set_up_afresh",
]

_GIVEN = "relume_given"  # illuminants that set-up itself put into the mixer, by light group
_LONG_NAME = "the name of this light group is too long for a render pass: its lamps belong to everything else"
_NO_DENOISER = "this Blender has no denoiser: the picture keeps its noise"


def set_up(scene, model: FactorModel | None = None):
    """Make a scene spectral: colours, lamps, passes, preview and compositing, for `model` or the scene's channels.

    A scene that is set up already is set up afresh. On any failure the scene is given back as it was.
    """
    if scene.library is not None:
        raise SetupError(f"scene {scene.name!r} is linked from {scene.library.filepath}: set it up in its own file")
    if scene.camera is None:
        raise SetupError(f"scene {scene.name!r} has no camera")
    if not lights.has_emitters(scene):
        raise SetupError(f"scene {scene.name!r} has no light: add a lamp, a shining material or a world")
    if not any(layer.use for layer in scene.view_layers) and not scene.relume.is_set_up:
        raise SetupError(f"scene {scene.name!r} has no view layer that is rendered")
    chosen = {"request": "" if model else scene.relume.request}
    if model is None and scene.relume.channels == properties.AUTO:
        found = plan.choose(content.content_of(scene), scene.relume.tolerance)
        model, chosen["reason"] = found.model, found.reason
    model = grouping.balanced(model or properties.model_for(scene.relume.channels))
    # The coefficients of a spectrum are those of one model: all scenes of a file share it
    described = json.dumps(model.to_dict())
    others = [s for s in bpy.data.scenes if s != scene and s.get(properties.MODEL, described) != described]
    for done in [s for s in [scene, *others] if s.relume.is_set_up]:
        remove(done)
    for each in [scene, *others]:
        try:
            with mixer.quiet():
                _set_up(each, model)
            each[properties.PLAN] = chosen
        except Exception as error:
            remove(each)
            if isinstance(error, SetupError):
                raise
            raise SetupError(f"scene {each.name!r} is as it was, for setting it up failed: {error}") from error


def _set_up(scene, model: FactorModel):
    groups = _sync_light_groups(scene)
    render_settings.keep(scene)
    scene[properties.MODEL] = json.dumps(model.to_dict())
    spectra.update_all(model)
    glass.update_all(model)
    _convert_colors(scene, groups, model)
    passes.add(scene, model, groups, _share_samples(scene, model))
    compositing.add(scene, groups)
    relight(scene)


def _sync_light_groups(scene) -> list[str]:
    """Rows of the mixer for the light groups that shine; what the artist chose for them stays."""
    settings, names = scene.relume, lights.light_groups_of(scene)
    for name in names:
        if name not in settings.light_groups:
            settings.light_groups.add()["name"] = name
    for index in reversed(range(len(settings.light_groups))):
        if settings.light_groups[index].name not in names:
            settings.light_groups.remove(index)
    for position, name in enumerate(names):
        settings.light_groups.move(settings.light_groups.find(name), position)
    return names


def _forget_untouched_rows(settings):
    """Drop the rows of the mixer in which the artist chose nothing; what was chosen is there when set up again."""
    rows = settings.light_groups
    for index in reversed(range(len(rows))):
        rows[index].property_unset("swatch")
        rows[index].property_unset("is_open")
        if CURVE in rows[index]:
            del rows[index][CURVE]
        if not mixer.is_touched(rows[index]):
            rows.remove(index)
    if not rows:
        settings.property_unset("light_groups")


def _share_samples(scene, model: FactorModel) -> sampling.Sampling:
    """Choose what Cycles samples in each pass, and have the scene's settings follow the pass that is rendered."""
    chosen = sampling_for(scene, model)
    render_settings.drive(scene, {name: chosen.otherwise[name] for name in chosen.driven})
    if scene.relume.split_samples:
        render_settings.stop_noise(scene, model.passes)
    return chosen


def sampling_for(scene, model: FactorModel) -> sampling.Sampling:
    """How the passes of a scene are sampled: with noise that is independent, unless it is wanted the same or the
    artist's own drivers decide."""
    settings, cycles = scene.relume, scene.cycles
    free = {name for name in ("seed", *SUBSET) if not passes.is_driven_or_animated(scene, f"cycles.{name}")}
    if settings.split_samples and not settings.same_seed and free.issuperset(SUBSET):
        first, count = 0, cycles.samples
        if cycles.use_sample_subset:
            first = cycles.sample_offset
            count = min(cycles.sample_subset_length, cycles.samples - first)
        return sampling.dealt(sampling.shares(model, settings.lights()), first, count)
    samples = -(-cycles.samples // model.passes) if settings.split_samples else 0
    if settings.same_seed or "seed" not in free:
        return sampling.same(model.passes, samples)
    return sampling.independent(model.passes, samples, cycles.seed)


def _convert_colors(scene, groups: list[str], model: FactorModel):
    """Colours, lamps and black bodies; the mixer starts with the illuminants that the scene says."""
    found = inventory.take(scene)
    lamps, about_lamps = lights.take_colors(found.lights)
    shadings, about_trees = sockets.shadings_of(found)
    shining = lights.Lighting(model, groups, lamps, shadings)
    about_colors = sockets.convert(shadings, model.channels, shining.convert)
    long_names = {name for name in (thing.lightgroup for thing in found.objects) if lights.is_too_long(name)}
    about_groups = [remarks.Remark(name, "", _LONG_NAME) for name in sorted(long_names)]
    noisy = scene.cycles.use_denoising and not denoise.available()
    about_noise = [remarks.Remark("Render Properties", "Denoise", _NO_DENOISER)] if noisy else []
    remarks.write(scene, [*about_noise, *about_trees, *about_lamps, *about_groups, *about_colors])
    given = {}
    for row in scene.relume.light_groups:
        first = lights.first_illuminant(shining.temperatures, row.name)
        if not row.is_property_set("illuminant") and first != row.illuminant:
            row["illuminant"] = given[row.name] = first
    scene[_GIVEN] = given


def _take_back_illuminants(scene):
    """Unset the illuminants that set-up put into the mixer, where the artist chose no other."""
    given = scene[_GIVEN].to_dict() if _GIVEN in scene else {}
    for row in scene.relume.light_groups:
        if row.illuminant == given.get(row.name):
            row.property_unset("illuminant")
    if _GIVEN in scene:
        del scene[_GIVEN]


def lighting(scene, settings=None) -> dict:
    """The keyword arguments that the functions of `core.view` take from a scene.

    settings: those of the scene as evaluated at a frame, if not the scene's own.
    """
    settings = settings or scene.relume
    lights = settings.lights()
    return {
        "lights": lights,
        "white_balance": settings.white_balance,
        "method": settings.white_balance_method,
        "space": bpy.data.colorspace.working_space,
        "white": settings.white(scene.relume.model(), lights) if settings.white_balance > 0.0 else None,
        "observer": settings.seen_by(),
    }


def _write_lighting(scene, settings=None):
    """Write the chosen illuminants into the compositor and the preview: numbers only, and only those that changed."""
    model, chosen = scene.relume.model(), lighting(scene, settings)
    compositing.write_matrices(scene, view.recombination_matrices(model, **chosen))
    layers = passes.preview_layers(scene)
    if layers:
        shown = view.preview(model, **chosen)
        for layer in layers:
            passes.write_view(layer, shown)
    return chosen


def _draw_swatches(scene, lights):
    """Keep with each row what its icon shows, so that the panel has to compute nothing."""
    for row, light in zip(scene.relume.light_groups, lights, strict=True):
        curve = drawing.curve(light.illuminant).tolist()
        if list(row.get(CURVE, ())) != curve:
            row[CURVE] = curve
            row["swatch"] = drawing.swatch(light.illuminant).tolist()


def relight(scene):
    """Show what the mixer now says. A mix that cannot be shown changes nothing in the picture and is told.

    Never raises: Blender calls it while a property changes.
    """
    settings = scene.relume
    if not settings.is_set_up:
        return
    try:
        chosen = _write_lighting(scene)
    except (LibraryError, ValueError) as error:
        settings["problem"] = str(error)
    else:
        settings["problem"] = ""
        _draw_swatches(scene, chosen["lights"])
    scene.update_tag()


def matrices_of(scene, chosen: dict):
    """(groups, 3, p) recombination matrices of a mix that `mixer.choices` kept. The mixer stays as it is.

    Raises ValueError where the mix cannot be shown.
    """
    settings = scene.relume
    now = mixer.choices(settings)
    with mixer.quiet():
        try:
            mixer.apply(settings, chosen)
            return view.recombination_matrices(settings.model(), **lighting(scene))
        except LibraryError as error:
            raise ValueError(str(error)) from error
        finally:
            mixer.apply(settings, now)


def follow(scene, settings):
    """Show the mix of `settings`, the scene's own as a frame of an animation evaluates them. Never raises."""
    try:
        _write_lighting(scene, settings)
    except (LibraryError, ValueError) as error:
        scene.relume["problem"] = str(error)


def set_up_afresh(scene):
    """Set a scene up again after its light groups changed: with the model that it has."""
    chosen = scene[properties.PLAN].to_dict() if properties.PLAN in scene else {}
    set_up(scene, scene.relume.model())
    scene[properties.PLAN] = chosen


def remove(scene):
    """Give the scene back as it was before `set_up`; does nothing to a scene that is not set up."""
    compositing.remove(scene)
    surfaces.remove(scene)
    passes.remove(scene)
    render_settings.give_back(scene)
    _take_back_illuminants(scene)
    _forget_untouched_rows(scene.relume)
    for name in ("problem", "comparing"):
        scene.relume.property_unset(name)
    remarks.clear(scene)
    for key in (properties.MODEL, properties.PLAN):
        if key in scene:
            del scene[key]
    others = [other for other in bpy.data.scenes if other.relume.is_set_up]
    kept_trees = {tree for other in others for tree, _ in sockets.trees_of(other)}
    kept_lights = {thing.data for other in others for thing in other.objects if thing.type == "LIGHT"}
    for light in lights.local_lights():
        if light not in kept_lights:
            lights.restore(light)
    for tree, owner in sockets.all_trees():
        if tree not in kept_trees:
            sockets.restore(tree, owner)
    if not others:
        spectra.restore_all()
        glass.restore_all()
    nodes.clear_orphans()
