"""The dots of the mixer: how far from full spectra each light's picture, and the picture of the mix, is expected to be.

Panels only draw; what they lack is worked out once the artist pauses. Nothing of it is kept in the file.
"""

import json
import time
from collections.abc import Generator
from contextlib import suppress

import bpy
from bpy.app.handlers import persistent
from bpy.props import StringProperty
from bpy.types import Operator

from ...core.errors import RelumeError
from ...core.picture import coefficients, description, expectation
from ...core.picture.content import Content
from ..host import viewing
from ..host.steps import finished
from ..scene import content, follower, setup
from ..scene.exr import current_file
from ..store import mixer, properties
from . import icons
from .translation import said
from .wrapping import is_narrow, words

__all__ = ["CLASSES", "draw_dot", "draw_mix", "register", "unregister", "work_out"]

_PAUSE = 0.4  # seconds without an edit, after which a scene is looked at again
_WAIT = 0.01  # seconds: Blender draws first
_SLICE = 0.01  # seconds of work at a time
_MOST = 500  # expectations that are kept

_shown: dict[int, tuple[int, Content | None]] = {}  # by the scene's session_uid: the edition it is of, what it shows
_found: dict[tuple, expectation.Expectation | str] = {}  # by `_key`: what is expected, or why nothing is
_last: dict[tuple, expectation.Expectation | str] = {}  # by scene and row: what was shown last, until there is better
_advice: dict[tuple, str] = {}  # by `_of_mix`: what would help
_advising: dict[str, tuple | None] = {"key": None}
_waiting: set[str] = set()  # names of scenes that are about to be looked at


def _key(settings, said: str) -> tuple:
    scene = settings.id_data
    seen = settings.observer_measured if settings.observer == properties.FILE else settings.observer
    return scene.session_uid, follower.edition()[0], hash(scene[properties.MODEL]), seen, said


def _of_row(settings, row) -> tuple:
    said = mixer.choice(row)
    return _key(settings, json.dumps({name: said[name] for name in said if name not in ("stops", "solo", "mute")}))


def _of_mix(settings) -> tuple:
    return _key(settings, json.dumps(mixer.choices(settings)["light_groups"]))


def work_out(scene) -> None:
    """Work out what every light of a scene, and its mix, is expected to be."""
    finished(_working_out(scene))


def _working_out(scene) -> Generator[None, None, None]:
    """`work_out`, with pauses."""
    settings = scene.relume
    shows = yield from _content(scene)
    model = settings.model()
    if len(_found) > _MOST:
        _found.clear()
    try:
        mix = setup.lighting(scene)
    except RelumeError as error:
        for key in (_of_mix(settings), *(_of_row(settings, row) for row in settings.lit)):
            _found[key] = str(error)
        return
    for key, light in [(_of_row(settings, row), mix.lights[row.name]) for row in settings.lit]:
        if key not in _found:
            _found[key] = _or_why(expectation.expected_of, model, shows, light, mix.observer)
            yield
    _found[_of_mix(settings)] = _or_why(expectation.expected, model, shows, mix)


def _or_why(expected, *arguments) -> expectation.Expectation | str:
    try:
        return expected(*arguments)
    except RelumeError as error:
        return str(error)


def _content(scene) -> Generator[None, None, Content | None]:
    """What a scene shows, as it was at the last edit; None for an EXR that does not say."""
    edition, _ = follower.edition()
    kept = _shown.get(scene.session_uid)
    if kept is None or kept[0] != edition:
        shows = _kept_in_file(scene) if scene.relume.exr else (yield from content.looking(scene))
        kept = _shown[scene.session_uid] = edition, shows
    return kept[1]


def _kept_in_file(scene) -> Content | None:
    described = description.from_json(scene[properties.STOCK]) if properties.STOCK in scene else None
    try:
        return coefficients.describe(current_file(scene), described).shows
    except RelumeError:
        return None


def _soon(name: str) -> None:
    """Work it out once Blender has drawn and the artist pauses, a slice at a time: a panel may not compute anything."""
    if name in _waiting:
        return
    _waiting.add(name)
    steps, begun = None, None

    def work() -> float | None:
        nonlocal steps, begun
        scene = bpy.data.scenes.get(name)
        edition, ago = follower.edition()
        if bpy.app.is_job_running("RENDER") or ago < _PAUSE:
            return _PAUSE
        try:
            if scene is not None and scene.relume.is_set_up:
                if begun != edition:
                    steps, begun = _working_out(scene), edition
                if not _is_worked_off(steps):
                    return _WAIT
        except ReferenceError:  # a data-block went away meanwhile
            begun = None
            return _PAUSE
        _waiting.discard(name)
        viewing.redraw()
        return None

    bpy.app.timers.register(work, first_interval=_WAIT)


def _is_worked_off(steps: Generator) -> bool:
    """Work for a slice; whether all is done."""
    until = time.monotonic() + _SLICE
    try:
        while time.monotonic() < until:
            next(steps)
    except StopIteration:
        return True
    return False


def _known(settings, key: tuple, name: str) -> expectation.Expectation | str | None:
    scene = settings.id_data
    if key in _found:
        _last[scene.session_uid, name] = _found[key]
    else:
        _soon(scene.name)
    return _last.get((scene.session_uid, name))


def draw_dot(layout, settings, row) -> None:
    """The dot of a row of the mixer, with its figures in the tooltip."""
    found = _known(settings, _of_row(settings, row), row.name) if row.is_lit else None
    icon = icons.dot(found.level) if isinstance(found, expectation.Expectation) else 0
    shown = {"icon_value": icon} if icon else {"icon": "RADIOBUT_OFF"}
    dot = layout.operator("relume.expected", text="", emboss=False, **shown)
    dot.words = _words(found) if row.is_lit else "nothing shines in this light group"


def draw_mix(layout, settings) -> None:
    """The expectation of the whole mix, in a line."""
    found = _known(settings, _of_mix(settings), "")
    line = layout.row(align=True)
    icon = icons.dot(found.level) if isinstance(found, expectation.Expectation) else 0
    shown = {"icon_value": icon} if icon else {"icon": "RADIOBUT_OFF"}
    figures = isinstance(found, expectation.Expectation)
    text = said("Expected error …")
    if figures:
        text = said("ΔE {median:.2f} expected, 98 %: {p98:.2f}", median=found.median, p98=found.p98)
        if is_narrow():
            text = said("98 %: ΔE {p98:.2f}", p98=found.p98)
    dot = line.operator("relume.expected", text=text, emboss=False, **shown)
    dot.words = _words(found)
    if figures and found.level == expectation.LEVELS[-1]:
        better = _better(settings)
        if better:
            words(layout, better, icon="LIGHT")


def _better(settings) -> str:
    """What would help the mix; worked out once the artist leaves it for a moment, as that takes longer."""
    key, name, steps = _of_mix(settings), settings.id_data.name, None
    if key not in _advice and _advising["key"] != key:
        _advising["key"] = key

        def advise() -> float | None:
            nonlocal steps
            scene = bpy.data.scenes.get(name)
            if scene is None or not scene.relume.is_set_up or _of_mix(scene.relume) != key:
                _advising["key"] = None
                return None
            steps = steps or _finding_advice(scene, key)
            with suppress(RelumeError, ReferenceError):
                if not _is_worked_off(steps):
                    return _WAIT
            viewing.redraw()
            return None

        bpy.app.timers.register(advise, first_interval=2 * _PAUSE)
    return _advice.get(key, "")


def _finding_advice(scene, key: tuple) -> Generator[None, None, None]:
    shows = yield from _content(scene)
    better = yield from expectation.advising(scene.relume.model(), shows, setup.lighting(scene))
    _advice.clear()
    _advice[key] = better


def _words(found: expectation.Expectation | str | None) -> str:
    if found is None:
        return "being worked out"
    if isinstance(found, str):
        return found
    seen = {"green": "nobody sees it", "yellow": "seen side by side", "red": "seen at once"}[found.level]
    return f"ΔE2000 to full spectra: {found.median:.2f} median, 98 % of the picture below {found.p98:.2f}: {seen}"


class Expected(Operator):
    """How far from full spectra this is expected to be. Click to be told what would help"""

    bl_idname = "relume.expected"
    bl_label = "Expected Error"
    bl_options = {"INTERNAL"}

    words: StringProperty(options={"SKIP_SAVE"})

    @classmethod
    def description(cls, context, properties) -> str:
        return f"{properties.words}. Click to be told what would help"

    @classmethod
    def poll(cls, context) -> bool:
        return context.scene.relume.is_set_up

    def execute(self, context) -> set[str]:
        scene = context.scene
        try:
            mix = setup.lighting(scene)
            better = finished(expectation.advising(scene.relume.model(), finished(_content(scene)), mix))
        except RelumeError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"What would help: {better}" if better else "Nothing needs help")
        return {"FINISHED"}


@persistent
def _forget(*_) -> None:
    for known in (_shown, _found, _last, _advice, _waiting):
        known.clear()
    _advising["key"] = None


CLASSES = (Expected,)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.app.handlers.load_post.append(_forget)


def unregister() -> None:
    bpy.app.handlers.load_post.remove(_forget)
    _forget()
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
