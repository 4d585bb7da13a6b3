"""The scene's own render settings that coefficient passes change: noted, changed, given back."""

import bpy

from ...core.picture import sampling
from ..host import animation
from . import view_layers

__all__ = ["SUBSET", "change_engines", "compare", "drive", "give_back", "is_previewing", "keep", "stop_noise"]

SUBSET = ("use_sample_subset", "sample_offset", "sample_subset_length")
_ADAPTIVE = ("adaptive_threshold", "adaptive_min_samples")
_BEFORE = "relume_before"  # on a scene: what its own settings were
_SOON = 0.1  # seconds
_waiting = {}  # scene's session_uid: the engine it is to get


def _changed(scene) -> list[tuple]:
    """(owner, its name in the note, property, value for coefficient passes) of each setting that set-up changes."""
    return [
        (scene.render, "render", "engine", "CYCLES"),
        (scene.render, "render", "use_persistent_data", True),
        (scene.render, "render", "use_compositing", True),
        (scene.render, "render", "compositor_precision", "FULL"),
        (scene.cycles, "cycles", "use_layer_samples", "USE"),
        *((scene.cycles, "cycles", name, getattr(scene.cycles, name)) for name in ("seed", *SUBSET, *_ADAPTIVE)),
    ]


def keep(scene) -> None:
    """Note the scene's own settings and put those that coefficient passes need."""
    own_engine = _waiting.pop(scene.session_uid, scene.render.engine)
    scene[_BEFORE] = {
        f"{owner}.{name}": getattr(struct, name)
        for struct, owner, name, _ in _changed(scene)
        if owner == "render" or struct.is_property_set(name)
    }
    scene[_BEFORE]["render.engine"] = own_engine
    scene[_BEFORE]["driven"] = ""
    scene[_BEFORE]["had_animation"] = scene.animation_data is not None
    for struct, _, name, value in _changed(scene):
        _put(struct, name, value)


def drive(scene, otherwise: dict[str, int]) -> None:
    """Have settings of Cycles follow the pass that is rendered: {its name: the value outside of passes}."""
    scene[_BEFORE]["driven"] = " ".join(otherwise)
    for name, value in otherwise.items():
        view_layers.drive(scene, name, value)
    if "sample_offset" in otherwise:
        scene.cycles.use_sample_subset = True


def compare(scene) -> None:
    """Let renders of a scene for several models differ by the models alone, and not by their noise.

    One seed for all passes; and Cycles ends paths and leaves out lamps with a probability that depends on a channel's
    own brightness, unless it is told not to. Before set-up, in a scene that nobody saves.
    """
    scene.relume.same_seed, scene.relume.split_samples = True, False
    scene.cycles.min_light_bounces, scene.cycles.light_sampling_threshold = scene.cycles.max_bounces, 0.0


def stop_noise(scene, count: int) -> None:
    """Let adaptive sampling stop each of `count` passes where the picture of all is as clean as the artist asked."""
    own = (getattr(scene.cycles, name) for name in (*_ADAPTIVE, "samples"))
    for name, value in zip(_ADAPTIVE, sampling.adaptive(*own, count), strict=True):
        setattr(scene.cycles, name, value)


def give_back(scene) -> None:
    """Put the settings back that `keep` noted; does nothing where there are none."""
    if _BEFORE not in scene:
        return
    before = scene[_BEFORE].to_dict()
    for name in before["driven"].split():
        scene.driver_remove(f"cycles.{name}")
    if before["driven"] and not before["had_animation"] and not animation.has_any(scene):
        scene.animation_data_clear()
    for struct, owner, name, _ in reversed(_changed(scene)):
        value = before.get(f"{owner}.{name}")
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
