"""The mix that the mixer says, as a value: as it is now, at a frame of an animation, or as a snapshot keeps it.

Each is made of what `mixer.choices` says; nothing in the scene is changed for it.
"""

import json
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import bpy

from ...core.errors import UsageError
from ...core.model.factor_model import FactorModel
from ...core.picture import mixing, recombination
from ...core.picture.mix import Light, Mix
from ...core.spectra.arrays import Array
from ...core.spectra.spectrum import Spectrum, SpectrumError
from . import mixer, shining

__all__ = ["FILE", "at", "of", "of_choices", "stored_observer"]

FILE = "FILE"  # the observer that was read from one


@lru_cache(maxsize=8)
def stored_observer(text: str) -> tuple[Spectrum, Spectrum, Spectrum]:
    """The three Spectrum that a property holds as JSON. Raises SpectrumError."""
    if not text:
        raise SpectrumError("no file of an observer or camera has been read yet: choose one")
    return tuple(Spectrum.from_dict(one) for one in json.loads(text))


def of(settings, model: FactorModel | None = None) -> Mix:
    """The `core` Mix that the mixer of a scene says. Raises RelumeError where it cannot be shown.

    settings: the scene's own, or as evaluated at a frame. model: what the white of a pixel or group is computed with.
    """
    return of_choices(mixer.choices(settings), [row.name for row in settings.lit], model)


def at(settings, snapshot: dict, model: FactorModel) -> Mix:
    """The Mix that the mixer would say if a snapshot were applied. Raises RelumeError."""
    now, rows = mixer.choices(settings), {}
    for row in settings.light_groups:
        kept = snapshot["light_groups"].get(row.name)
        rows[row.name] = now["light_groups"][row.name] if kept is None else mixer.filled(row, kept)
    balance = mixer.filled(settings, snapshot["balance"]) if snapshot["balance"] else now["balance"]
    said = {"light_groups": rows, "balance": balance}
    return of_choices(said, [row.name for row in settings.lit], model)


def of_choices(said: dict, groups: Sequence[str], model: FactorModel | None = None) -> Mix:
    """The Mix of the light groups of that name in what `mixer.choices` said. Raises RelumeError."""
    rows, balance = [said["light_groups"][name] for name in groups], said["balance"]
    gains = mixing.gains(*([row[name] for row in rows] for name in ("stops", "solo", "mute")))
    lights = [Light(shining.spectrum_of(row), float(gain)) for row, gain in zip(rows, gains, strict=True)]
    observed = balance["observer"]
    mix = Mix(
        dict(zip(groups, lights, strict=True)),
        white_balance=balance["white_balance"],
        method=balance["white_balance_method"],
        space=bpy.data.colorspace.working_space,
        observer=stored_observer(balance["observer_measured"]) if observed == FILE else observed,
    )
    needs_white = model is not None and mix.white_balance > 0.0
    return replace(mix, white=_white(balance, mix, model)) if needs_white else mix


def _white(balance: dict, mix: Mix, model: FactorModel) -> Array | None:
    """(3,) XYZ of what becomes white, None for the white of the mix. Raises UsageError."""
    group = balance["white_group"]
    if balance["white_source"] == "GROUP":
        if group not in mix.lights:
            raise UsageError(f"white balance: no light group {group!r}; choose one")
        return recombination.mixed_white(model, replace(mix, lights={group: Light(mix.lights[group].illuminant)}))
    if balance["white_source"] == "PIXEL":
        picked = json.loads(balance["white_pixel"] or "{}")
        if set(picked) != set(mix.lights) or any(len(c) != model.channels for c in picked.values()):
            raise UsageError("white balance: no pixel of this render has been picked; pick one in the picture")
        return recombination.color_of(model, mix, [picked[name] for name in mix.lights])
    return None
