"""Which channels a scene gets: those that its artist asked for, or as few as what it shows needs."""

import importlib
from collections.abc import Callable, Generator
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import replace

from ...core.model import bases, channel_order
from ...core.model.factor_model import FactorModel
from ...core.picture import plan
from ..store import properties
from . import content

__all__ = ["chosen", "plan_of", "revised"]

_LEAST = 3  # channels: one pass as well, and what is grey today may have a colour tomorrow


def plan_of(scene) -> dict:
    """What was noted when the channels of a scene were chosen."""
    return scene[properties.PLAN].to_dict() if properties.PLAN in scene else {}


def chosen(scene) -> Generator[str, None, tuple[FactorModel, dict]]:
    """The model that a scene's settings ask for, and what is to be noted of it; yields what is being done."""
    settings = scene.relume
    noted = {"request": settings.request}
    if settings.channels == properties.AUTO:
        yield "loading libraries"
        _load_libraries()
        yield "looking at the scene"
        shows = content.content_of(scene)
        found = yield from _meanwhile("choosing channels", _planned, shows, settings.tolerance)
        return found.model, noted | {"reason": found.reason, "content": content.checksum(shows)}
    if settings.channels == properties.PREFILTERED:
        return bases.prefiltered(content.dominant(scene), settings.rendering_space), noted
    return properties.model_for(settings.channels), noted


def revised(scene) -> tuple[dict, FactorModel | None] | None:
    """What is to be noted where another content was planned for, with another model where the scene's own is no longer
    within the tolerance; None where nothing has changed, or Relume did not choose."""
    noted, model = plan_of(scene), scene.relume.model()
    if "content" not in noted or model.is_reference:
        return None
    shows = content.content_of(scene)
    if content.checksum(shows) == noted["content"]:
        return None
    noted["content"] = content.checksum(shows)
    error, worst = plan.predict(model, shows)
    if error <= scene.relume.tolerance:
        return noted, None
    found = _planned(shows, scene.relume.tolerance)
    why = f"{worst} would have come out with ΔE {error:.2g}"
    changed = f"the scene has changed: {why}; {found.model.passes} passes now"
    return noted | {"reason": found.reason, "changed": changed}, found.model


def _planned(shows: plan.Content, tolerance: float) -> plan.Plan:
    """The plan for what a scene shows, with the channels in their order."""
    found = plan.choose(shows, tolerance, _LEAST)
    return replace(found, chosen=replace(found.chosen, model=channel_order.balanced(found.model)))


def _load_libraries() -> None:
    """Import what a thread is to work with: two threads that import SciPy, whose modules import each other, stop."""
    for name in ("colour", "scipy.interpolate", "scipy.optimize"):
        importlib.import_module(name)


def _meanwhile(words: str, work: Callable, *arguments) -> Generator[str]:
    """Have a thread do what needs nothing of Blender; yields the words until it is done, and returns the result."""
    with ThreadPoolExecutor(1) as pool:
        task = pool.submit(work, *arguments)
        while not wait([task], timeout=0.05).done:
            yield words
        return task.result()
