"""What Relume does when Blender changes, renders or saves a scene: what is set up follows the artist."""

from collections.abc import Callable

import bpy
from bpy.app.handlers import persistent

from ..core.errors import RelumeError
from .graph import nodes
from .scene import baking, comparison, follower, kept, light_groups, note, render, setup, view_layers
from .store import changes, mixer

__all__ = ["register", "unregister"]

_own_undo = {}  # preferences of the user's while undo is another
_followed = {}  # scene's session id: the mix that its sockets show


def _mix(settings) -> tuple:
    """All animatable values of the mixer, to see whether they changed."""
    rows = tuple(
        (
            *(row.source, row.temperature, row.cct, row.stops, row.solo, row.mute, tuple(row.tint)),
            *(part.weight for part in row.blend),
        )
        for row in settings.light_groups
    )
    balance = (settings.white_balance, settings.white_balance_method, settings.white_source, settings.observer)
    return rows, balance, settings.wipe


def _follow(scene, depsgraph) -> None:
    if mixer.is_quiet() or not scene.relume.is_set_up or not baking.is_animated(scene) or follower.is_at_work():
        return  # there may be rows that the compositing does not have yet
    settings = scene.evaluated_get(depsgraph).relume
    mix = _mix(settings)
    if _followed.get(scene.session_uid) == mix:
        return
    _followed[scene.session_uid] = mix
    setup.follow(scene, mixer.choices(settings))
    comparison.move_wipe(scene, settings.wipe)


@persistent
def _frame_changed(scene, depsgraph) -> None:
    _followed.pop(scene.session_uid, None)
    _follow(scene, depsgraph)


@persistent
def _depsgraph_updated(scene, depsgraph) -> None:
    _follow(scene, depsgraph)
    if not mixer.is_quiet() and follower.followed() and not _is_playing() and follower.notice(scene, depsgraph):
        _soon()


def _is_playing() -> bool:
    return any(window.screen.is_animation_playing for window in bpy.context.window_manager.windows)


def _soon() -> None:
    """Follow once the artist pauses. Scripts without a window follow when they render or save."""
    if not bpy.app.background and not bpy.app.timers.is_registered(follower.tick):
        bpy.app.timers.register(follower.tick, first_interval=0.25)


def _watch() -> float:
    """Timer in a window."""
    if not _is_playing() and follower.watch(kept.is_due()):
        _soon()
    return 0.25 if kept.is_pending() else 1.0


@persistent
def _look_again(*_) -> None:
    """After undo, redo, reading a file and playing, anything may be different."""
    if follower.forget():
        _soon()


@persistent
def _before_undo(*_) -> None:
    """Have undo read the whole file, where it would otherwise meet a node group that it does not know: see
    `nodes.keep_spares`."""
    preferences = bpy.context.preferences
    if nodes.is_undo_unsafe() and follower.followed() and not preferences.experimental.use_undo_legacy:
        _own_undo.update(developer=preferences.view.show_developer_ui, dirty=preferences.is_dirty)
        preferences.view.show_developer_ui = preferences.experimental.use_undo_legacy = True


@persistent
def _after_undo(*_) -> None:
    preferences = bpy.context.preferences
    if _own_undo:
        preferences.experimental.use_undo_legacy = False
        preferences.view.show_developer_ui, preferences.is_dirty = _own_undo["developer"], _own_undo["dirty"]
        _own_undo.clear()
    _look_again()


@persistent
def _loaded(*_) -> None:
    """Clean up while no step of undo knows the file yet."""
    nodes.clear_orphans()
    if follower.followed():
        nodes.keep_spares()
    nodes.is_undo_unsafe(now_safe=True)
    _look_again()


@persistent
def _bake(scene, *_) -> None:
    if scene.relume.is_set_up and baking.is_animated(scene):
        baking.bake(scene)


@persistent
def _forget(scene, *_) -> None:
    baking.forget(scene)


@persistent
def _note(scene, *_) -> None:
    """Have the scene's renders say how they are relit; a mix that cannot be shown leaves what they said before."""
    if scene.relume.is_set_up and view_layers.pass_layers(scene) and scene.is_editable:
        animated = baking.is_animated(scene)
        if note.is_current(scene, animated):
            return
        try:
            note.write(scene, render.described(scene), animated)
        except RelumeError as error:
            scene.relume["problem"] = str(error)


@persistent
def _denoise_again(scene, *_) -> None:
    if scene in follower.followed():  # Relume's own renders, of a report or to denoise, leave what the artist's kept
        kept.forget()


@persistent
def _keep_denoised(scene, *_) -> None:
    if scene in follower.followed():
        kept.begin(scene)


@persistent
def _put_kept(*_, held: bool = False) -> None:
    kept.hold(held)
    for scene in follower.followed():
        kept.put(scene)


@persistent
def _before_saving(*_) -> None:
    for scene in bpy.data.scenes:
        _bake(scene)
        _note(scene)


@persistent
def _forget_all(*_) -> None:
    _followed.clear()
    for scene in bpy.data.scenes:
        _forget(scene)


def _calling(function: Callable, *arguments) -> Callable:
    """A handler that calls a function with the same, whatever Blender says."""
    return persistent(lambda *_: function(*arguments))


_HANDLERS = (
    ("frame_change_post", _frame_changed),
    ("depsgraph_update_post", _depsgraph_updated),
    ("undo_pre", _before_undo),
    ("redo_pre", _before_undo),
    ("undo_post", _after_undo),
    ("redo_post", _after_undo),
    ("animation_playback_post", _look_again),
    ("render_init", _denoise_again),
    ("render_init", _calling(follower.settle_all)),
    ("render_init", _bake),
    ("render_init", _note),
    ("render_init", _keep_denoised),
    ("render_pre", _calling(kept.next_frame)),
    ("render_complete", _forget),
    ("render_complete", _calling(kept.end, True)),
    ("render_cancel", _forget),
    ("render_cancel", _calling(kept.end, False)),
    ("save_pre", _calling(kept.hold)),
    ("save_pre", _calling(follower.settle_all)),
    ("save_pre", _before_saving),
    ("save_post", _forget_all),
    ("save_post", _put_kept),
    ("save_post_fail", _put_kept),
    ("load_post", _calling(kept.forget)),
    ("load_post", _forget_all),
    ("load_post", _loaded),
)
_CHANGES = {
    changes.MIX: setup.relight,
    changes.LIGHT_GROUP_RENAMED: light_groups.rename,
    changes.PASSES: setup.update,
    changes.WIPE: comparison.move_wipe,
}


def register() -> None:
    kept.hold(False)
    for change, function in _CHANGES.items():
        changes.follow(change, function)
    for name, function in _HANDLERS:
        getattr(bpy.app.handlers, name).append(function)
    if not bpy.app.background:
        bpy.app.timers.register(_watch, persistent=True)


def unregister() -> None:
    for timer in (follower.tick, _watch):
        if bpy.app.timers.is_registered(timer):
            bpy.app.timers.unregister(timer)
    changes.forget()
    _put_kept(held=True)
    for name, function in _HANDLERS:
        getattr(bpy.app.handlers, name).remove(function)
