"""Coefficient passes as a whole: view layers, the settings that they need, their sampling, and the compositing."""

from functools import lru_cache

from ...core.model import channel_order
from ...core.model.factor_model import FactorModel
from ...core.picture import sampling
from ...core.picture.mix import Light
from ...core.spectra import library
from . import compositing, render_settings, view_layers
from .render_settings import SUBSET

__all__ = ["put", "sampling_for"]


def put(scene, model: FactorModel, groups: list[str]) -> None:
    """Bring coefficient passes, render settings and compositing in line with the scene; none for other engines."""
    compositing.follow_names(scene, view_layers.follow_names(scene))
    if render_settings.is_suspended(scene):
        compositing.remove(scene)
        view_layers.suspend(scene)
        render_settings.suspend(scene)
        return
    chosen = sampling_for(scene, model)
    adaptive = render_settings.adaptive(scene, model.passes) if scene.relume.split_samples else None
    render_settings.patch(scene, {name: chosen.otherwise[name] for name in chosen.driven}, adaptive)
    view_layers.patch(scene, model, groups, chosen)
    compositing.patch(scene, groups)


@lru_cache(maxsize=8)
def _shares(model: FactorModel) -> tuple[float, ...]:
    """`sampling.shares` by usual lights, not by those of the mixer: what is chosen there leaves the noise as it is."""
    return tuple(sampling.shares(model, [Light(library.illuminant(name)) for name in channel_order.LIGHTS]))


def sampling_for(scene, model: FactorModel) -> sampling.Sampling:
    """How the passes of a scene are sampled: with noise that is independent, unless it is wanted the same or the
    artist's own drivers decide."""
    settings, count = scene.relume, scene.cycles.samples
    own = {name: render_settings.own_value(scene, name) for name in ("seed", *SUBSET)}
    free = {name for name in own if render_settings.is_free(scene, name)}
    if settings.split_samples and not settings.same_seed and free.issuperset(SUBSET):
        first = 0
        if own["use_sample_subset"]:
            first = own["sample_offset"]
            count = min(own["sample_subset_length"], count - first)
        return sampling.dealt(_shares(model), first, count)
    samples = -(-count // model.passes) if settings.split_samples else 0
    if settings.same_seed or "seed" not in free:
        return sampling.same(model.passes, samples)
    return sampling.independent(model.passes, samples, own["seed"])
