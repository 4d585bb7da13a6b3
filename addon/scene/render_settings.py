"""The scene's own render settings that coefficient passes change: noted, changed, given back."""

import bpy

from ...core.picture import sampling
from ..host import animation
from . import view_layers

__all__ = [
    "SUBSET",
    "adaptive",
    "change_engines",
    "compare",
    "give_back",
    "is_driven",
    "is_free",
    "is_previewing",
    "is_suspended",
    "own",
    "own_value",
    "patch",
    "suspend",
    "use_cycles",
]

SUBSET = ("use_sample_subset", "sample_offset", "sample_subset_length")
_ADAPTIVE = ("adaptive_threshold", "adaptive_min_samples")
_BEFORE = "relume_before"  # on a scene: what its own settings were
_PUT = "relume_put"  # on a scene: what set-up made of them
_SUSPENDED = "relume_suspended"  # on a scene: another engine renders it for now
_SOON = 0.1  # seconds
_waiting = {}  # scene's session_uid: the engine it is to get


# (owner, setting): what set-up changes, and the value that coefficient passes need where it is always the same
_FIXED = {
    "render.engine": "CYCLES",
    "render.use_persistent_data": True,
    "render.use_compositing": True,
    "render.compositor_precision": "FULL",
    "cycles.use_layer_samples": "USE",
}
_FREE = [f"cycles.{name}" for name in ("seed", *SUBSET, *_ADAPTIVE)]


def _place(scene, path: str) -> tuple:
    owner, _, name = path.partition(".")
    return getattr(scene, owner), name


def own(scene) -> dict:
    """{"cycles.seed" and the like: the artist's own value} of all settings that set-up changes.

    What was noted, or what the artist chose since, but for settings that are the same in all set-ups. None: not set.
    """
    before, put = ((scene[key].to_dict() if key in scene else {}) for key in (_BEFORE, _PUT))
    found = {}
    for path in (*_FIXED, *_FREE):
        struct, name = _place(scene, path)
        value = getattr(struct, name)
        untouched = value == put.get(path) or animation.is_animated(scene, path)
        if before and (untouched or not put):  # Relume 0.1.0 did not note what it put
            found[path] = before.get(path)
        else:
            found[path] = value if path.startswith("render.") or struct.is_property_set(name) else None
    if engine := _waiting.get(scene.session_uid):
        found["render.engine"] = before.get("render.engine", engine)
    return found


def own_value(scene, name: str):
    """The artist's own value of a setting of Cycles that set-up changes."""
    value = own(scene)[f"cycles.{name}"]
    return scene.cycles.bl_rna.properties[name].default if value is None else value


def is_driven(scene, name: str) -> bool:
    """Whether a setting of Cycles is driven as `view_layers.drive` does."""
    curves = scene.animation_data.drivers if scene.animation_data else ()
    return any(c.data_path == f"cycles.{name}" and c.driver.expression == "own" for c in curves)


def is_free(scene, name: str) -> bool:
    """Whether nothing of the artist's own animates or drives a setting of Cycles."""
    return is_driven(scene, name) or not animation.is_animated(scene, f"cycles.{name}")


def is_suspended(scene) -> bool:
    """Whether the artist renders the scene with another engine for now: there are no coefficient passes then."""
    others = scene.render.engine != "CYCLES" and scene.session_uid not in _waiting
    return others and (_BEFORE in scene or _SUSPENDED in scene)


def suspend(scene) -> None:
    """Put the artist's own settings back while another engine renders."""
    if _BEFORE in scene or _SUSPENDED not in scene:
        give_back(scene)
        scene[_SUSPENDED] = True


def use_cycles(scene) -> None:
    """Let Cycles render a scene again."""
    _put(scene.render, "engine", "CYCLES")


def patch(scene, driven: dict[str, int], adaptive: tuple[float, int] | None) -> None:
    """Give the scene the settings that coefficient passes need, and note the artist's own, as they are now.

    driven: {setting of Cycles that follows the pass that is rendered: its value outside of passes}. adaptive: noise
    threshold and least samples of a pass; None for the artist's own.
    """
    if _SUSPENDED in scene:
        del scene[_SUSPENDED]
    kept, before = own(scene), scene[_BEFORE].to_dict() if _BEFORE in scene else {}
    was_driven = before.get("driven", "").split()
    note = {path: value for path, value in kept.items() if value is not None}
    note["driven"] = " ".join(dict.fromkeys([*driven, *was_driven]))
    note["had_animation"] = before.get("had_animation", scene.animation_data is not None) or _is_animated(scene)
    wanted = dict(_FIXED)
    wanted |= dict(zip((f"cycles.{name}" for name in _ADAPTIVE), adaptive, strict=True)) if adaptive else {}
    if "sample_offset" in driven:
        wanted["cycles.use_sample_subset"] = True
    if _note(scene, _BEFORE, note) and _PUT in scene:
        del scene[_PUT]  # until all is put: what is there then is not the artist's
    _stop_driving(scene, set(was_driven) - set(driven), note["had_animation"])
    for path, value in kept.items():
        struct, name = _place(scene, path)
        value = wanted.get(path, value)
        if name in driven or not is_free(scene, name):
            continue
        if value is None:
            if struct.is_property_set(name):
                struct.property_unset(name)
        elif getattr(struct, name) != value:
            _put(struct, name, value)
    for name, otherwise in driven.items():
        view_layers.drive(scene, name, otherwise)
    view_layers.forget_drivers(scene)
    _note(scene, _BEFORE, note | {"driven": " ".join(driven)})
    moving = {f"cycles.{name}" for name in (*driven, *SUBSET, "seed") if name in driven or not is_free(scene, name)}
    _note(scene, _PUT, {path: getattr(*_place(scene, path)) for path in kept if path not in moving})


def _is_animated(scene) -> bool:
    """Whether the artist animates anything of a scene itself."""
    data = scene.animation_data
    own = [c for c in data.drivers if not is_driven(scene, c.data_path.removeprefix("cycles."))] if data else []
    return bool(data and (data.action or data.nla_tracks or own))


def _stop_driving(scene, names, had_animation: bool) -> None:
    for name in names:
        if is_driven(scene, name):
            scene.driver_remove(f"cycles.{name}")
    if names and not had_animation and not animation.has_any(scene):
        scene.animation_data_clear()


def _note(scene, key: str, values: dict) -> bool:
    """Keep values in a scene, if they are not kept already; whether they were not."""
    if key in scene and scene[key].to_dict() == values:
        return False
    scene[key] = values
    return True


def compare(scene) -> None:
    """Let renders of a scene for several models differ by the models alone, and not by their noise.

    One seed for all passes; and Cycles ends paths and leaves out lamps with a probability that depends on a channel's
    own brightness, unless it is told not to. Before set-up, in a scene that nobody saves.
    """
    scene.relume.same_seed, scene.relume.split_samples = True, False
    scene.cycles.min_light_bounces, scene.cycles.light_sampling_threshold = scene.cycles.max_bounces, 0.0


def adaptive(scene, count: int) -> tuple[float, int]:
    """Noise threshold and least samples with which adaptive sampling stops each of `count` passes where the picture of
    all is as clean as the artist asked."""
    return sampling.adaptive(*(own_value(scene, name) for name in _ADAPTIVE), scene.cycles.samples, count)


def give_back(scene) -> None:
    """Put the artist's own settings back; does nothing where there are none noted."""
    if _SUSPENDED in scene:
        del scene[_SUSPENDED]
    if _BEFORE not in scene:
        return
    before, kept = scene[_BEFORE].to_dict(), own(scene)
    # What stops it on the way leaves what is the artist's for the next call: settings alone no longer say
    scene[_BEFORE] = before | {path: value for path, value in kept.items() if value is not None}
    for path in [path for path, value in kept.items() if value is None and path in before]:
        del scene[_BEFORE][path]
    if _PUT in scene:
        del scene[_PUT]
    _stop_driving(scene, before["driven"].split(), before["had_animation"])
    view_layers.forget_drivers(scene)
    for path, value in reversed(kept.items()):
        struct, name = _place(scene, path)
        if value is None:
            struct.property_unset(name)
        else:
            _put(struct, name, value)
    del scene[_BEFORE]


def is_previewing() -> bool:
    """Whether Blender renders the preview of a material, a world or a lamp."""
    return bpy.app.is_job_running("RENDER_PREVIEW")


def _put(struct, name: str, value) -> None:
    """Change a setting; another engine has to wait while Cycles renders the preview of a material.

    Blender ends previews before it changes the engine. It waits for them where Python cannot run, and Cycles ends in
    Python: Blender would stand still for good.
    """
    if name != "engine":
        setattr(struct, name, value)
        return
    _waiting.pop(struct.id_data.session_uid, None)
    if value != struct.engine:
        if is_previewing():
            _waiting[struct.id_data.session_uid] = value
            bpy.app.timers.register(change_engines, first_interval=_SOON)
        else:
            struct.engine = value


def change_engines() -> float | None:
    """Give scenes the engines they wait for, once no preview is rendered."""
    if _waiting and is_previewing():
        return _SOON
    for scene in bpy.data.scenes:
        if engine := _waiting.pop(scene.session_uid, None):
            scene.render.engine = engine
    _waiting.clear()
    return None
