"""The note that a scene's renders carry, by which they can be relit wherever they were rendered (`core.note`)."""

import hashlib
import json

import bpy

from ...core.picture.coefficients import CoefficientImage
from ..store import mixer, properties
from . import view_layers

__all__ = ["is_current", "made", "remove", "write"]

_OFF = "relume_note_off"  # on a scene: the artist's own renders carry no note
_OF = "relume_note_of"  # on a scene: a checksum of all that its note was made of


def made(scene, image: CoefficientImage, animated: bool = False) -> tuple:
    """(the `core.note.Note` of a scene that is set up, whether it needs spectra that only a sidecar has).

    image: what `render.described` says of the scene. animated: the mix is that of this frame alone.
    """
    from ...core.picture import note

    rows = scene.relume.lit
    named = {row.name: _illuminant(row) for row in rows}
    lights = [note.Light(row.name, named[row.name], image.gains[row.name]) for row in rows]
    model = (image.model.name, image.model.channels, note.model_checksum(image.model))
    measured = not isinstance(image.observer, str)
    found = note.Note(
        model=model,
        layers=[_layers(source, layers) for source, layers in view_layers.pass_layers(scene).items()],
        lights=lights,
        degree=image.white_balance,
        method=image.white_balance_method,
        white=image.white,
        observer=note.reference(scene.relume.observer_measured) if measured else image.observer,
        space=image.space,
        view=note.View(**image.view),
        animated=animated,
    )
    return found, measured or any(row.source == "FILE" for row in rows)


def _illuminant(row):
    """The illuminant of a row of the mixer, as a note names it."""
    from ...core.picture import note

    if row.source == "BLEND":
        return [(part.illuminant, part.weight) for part in row.blend]
    names = {"PLANCKIAN": f"Planckian {row.temperature:.0f} K", "DAYLIGHT": f"D {row.cct:.0f} K"}
    return note.reference(row.measured) if row.source == "FILE" else names.get(row.source, row.illuminant)


def _layers(source: str, layers) -> str | list[str]:
    """One of the artist's view layers in a note: with the names of its passes where they are not what they were."""
    names = [layer.name for layer in layers]
    return source if names == [f"{source} {k + 1}" for k in range(len(names))] else [source, *names]


def _sources(scene, animated: bool) -> str:
    said = [mixer.choices(scene.relume), scene[properties.MODEL], bpy.data.colorspace.working_space, animated]
    shown = scene.view_settings
    said += [shown.view_transform, shown.look, shown.exposure, shown.gamma]
    said += [scene.display_settings.display_device, scene.render.stamp_note_text]
    said += [scene.render.use_stamp_note, scene.render.use_stamp]
    said += [[source, *(layer.name for layer in each)] for source, each in view_layers.pass_layers(scene).items()]
    return hashlib.sha256(json.dumps(said).encode()).hexdigest()[:16]


def is_current(scene, animated: bool = False) -> bool:
    """Whether the note says what the scene is now. Quick: nothing of the colour science is imported for it."""
    return scene.get(_OF) == _sources(scene, animated)


def write(scene, image: CoefficientImage, animated: bool = False) -> None:
    """Have a scene's renders say how they are relit, behind what the artist notes. Changes only what differs.

    A scene that burns metadata into its picture gets none: it would stand there.
    """
    from ...core.picture import note

    settings, own = scene.render, note.without(scene.render.stamp_note_text)
    if not settings.use_stamp_note and _OFF not in scene:
        scene[_OFF] = True
    text = own if settings.use_stamp else note.joined(own, *made(scene, image, animated))
    for name, value in {"stamp_note_text": text, "use_stamp_note": text != own or _OFF not in scene}.items():
        if getattr(settings, name) != value:
            setattr(settings, name, value)
    scene[_OF] = _sources(scene, animated)


def remove(scene) -> None:
    """Give the artist's own note back."""
    settings = scene.render
    if "relume" in settings.stamp_note_text:
        from ...core.picture import note

        settings.stamp_note_text = note.without(settings.stamp_note_text)
    if _OFF in scene:
        settings.use_stamp_note = False
    for key in (_OFF, _OF):
        if key in scene:
            del scene[key]
