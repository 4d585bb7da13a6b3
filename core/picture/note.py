"""The note in a scene's renders, by which they can be relit wherever they were rendered. Import it late, as `header`.

Blender writes 511 bytes of *Note* metadata into every EXR. Behind the artist's own note stands `relume1 {...}`: the
model, the view layers of the coefficient passes, and the mix. A mix that does not fit, or that needs a spectrum which
the library has not, is replaced by a checksum, and comes from the scene or from a sidecar.
"""

import hashlib
import json
import re
from functools import lru_cache
from typing import Annotated

import msgspec
import numpy as np
from msgspec import Meta, Struct

from ..errors import CoefficientImageError, RelumeError
from ..model import bases, channel_order
from ..model.factor_model import FactorModel
from ..spectra import library
from ..spectra.library import OBSERVER
from . import header, mixing
from .coefficient_image import EVERYTHING_ELSE, CoefficientImage

__all__ = [
    "LONGEST",
    "Light",
    "Note",
    "image_of",
    "joined",
    "missing",
    "mix_of",
    "model_checksum",
    "read",
    "reference",
    "without",
]

LONGEST = 511  # bytes that arrive in an EXR
VERSION = 1
_FOUND = re.compile(r" ?\brelume(\d{1,9}) (\{.*)", re.DOTALL)


class Light(Struct, array_like=True):
    """What shines in a light group: the name of an illuminant, or the names and weights of a blend."""

    group: header.Name
    illuminant: (
        header.Name
        | Annotated[list[tuple[header.Name, header.Degree | header.Gain]], Meta(min_length=1, max_length=100)]
    )
    gain: header.Gain = 1.0


class View(Struct, array_like=True, frozen=True):
    """How Blender shows the picture."""

    display_device: header.Name = "sRGB"
    view_transform: header.Name = "AgX"
    look: header.Name = "None"
    exposure: header.Exposure = 0.0
    gamma: header.Gamma = 1.0


class Note(Struct):
    """What a note says. `lights` is empty where `mix` stands for them, for white and for observer.

    model: name, channels, checksum. layers: the artist's view layers; each a name, or a list of a name and the names of
    its coefficient passes where they have others than set-up gave them. animated: the mix is that of one frame.
    """

    model: tuple[header.Name, Annotated[int, Meta(ge=1, le=1000)], header.Name]
    layers: Annotated[
        list[header.Name | Annotated[list[header.Name], Meta(min_length=1, max_length=100)]], Meta(min_length=1)
    ]
    lights: Annotated[list[Light], Meta(max_length=1000)] = []
    mix: header.Name = ""
    degree: header.Degree = 0.0
    method: header.Name = "bradford"
    white: header.White | None = None
    observer: header.Name = OBSERVER
    space: header.Name = "Linear Rec.709"
    view: View = View()
    animated: bool = False


@lru_cache(maxsize=64)
def model_checksum(model: FactorModel) -> str:
    """Ten digits that stand for a model, the same for one that another machine made with last bits of its own."""
    described = model.to_dict()
    digest = hashlib.sha256()
    for name, value in sorted((name, value) for name, value in described.items() if value is not None):
        digest.update(name.encode())
        digest.update(value.encode() if isinstance(value, str) else (np.rint(np.array(value) * 1e6) + 0.0).tobytes())
    return digest.hexdigest()[:10]


@lru_cache(maxsize=16)
def _shipped(name: str, channels: int, wanted: str) -> FactorModel | None:
    """The model of this checksum, if it is one that every Relume has."""
    try:
        model = bases.named(name, channels)
    except RelumeError:
        return None
    return next((m for m in (channel_order.balanced(model), model) if model_checksum(m) == wanted), None)


def reference(text: str) -> str:
    """What stands in a mix for spectra that only the scene has, kept there as this text."""
    return "#" + hashlib.sha256(text.encode()).hexdigest()[:10]


def _json(note: Note) -> str:
    return json.dumps(_short(note), separators=(",", ":"), ensure_ascii=False)


def _short(value):
    """A Struct as JSON has it, without what it would have anyway."""
    if isinstance(value, list):
        return [_short(each) for each in value]
    if not isinstance(value, Struct):
        return value
    fields = [(field.name, getattr(value, field.name), field.default) for field in msgspec.structs.fields(value)]
    if value.__struct_config__.array_like:
        while fields and fields[-1][1] == fields[-1][2]:
            fields.pop()
        return [_short(each) for _, each, _ in fields]
    return {name: _short(each) for name, each, default in fields if each not in (default, [], View())}


def mix_of(note: Note) -> str:
    """Ten digits that stand for what the mixer says: for everything in a note but its layers."""
    return hashlib.sha256(_json(msgspec.structs.replace(note, layers=[])).encode()).hexdigest()[:10]


def joined(own: str, note: Note, needs_spectra: bool = False) -> str:
    """The artist's own note followed by Relume's: whole, or with a checksum of the mix, or the artist's alone.

    needs_spectra: the note names spectra by checksums, which only a sidecar can resolve.
    """
    short = Note(model=note.model, layers=note.layers, mix=mix_of(note), animated=note.animated)
    for each in [short] if needs_spectra else [note, short]:
        text = f"{own}{' ' if own else ''}relume{VERSION} {_json(each)}"
        if len(text.encode()) <= LONGEST:
            return text
    return own


def without(text: str) -> str:
    """The artist's own part of a note."""
    return _FOUND.sub("", text)


@lru_cache(maxsize=64)
def read(text: str) -> Note | None:
    """What Relume wrote into a note, None where it wrote nothing. Raises CoefficientImageError that names the field."""
    found = _FOUND.search(text)
    if not found:
        return None
    if int(found[1]) > VERSION:
        raise CoefficientImageError(f"the note was written by a newer Relume (format {found[1]})")
    try:
        return header.decoded(Note, found[2].rstrip())
    except CoefficientImageError as error:
        raise CoefficientImageError(f"the Relume note is damaged: {error}") from None


@lru_cache(maxsize=64)
def _image(text: str, model: FactorModel) -> CoefficientImage:
    note = read(text)
    # A render's combined pass stands for what no group holds: it comes last
    lights = sorted(note.lights, key=lambda light: light.group == EVERYTHING_ELSE)
    groups = [light.group for light in lights]
    if len(set(groups)) < len(groups):
        raise CoefficientImageError("the Relume note is damaged: a light group stands there twice")
    try:
        illuminants = {light.group: _illuminant(light.illuminant) for light in lights}
    except RelumeError as error:
        raise CoefficientImageError(f"the Relume note is damaged: lights: {error}") from None
    described = CoefficientImage(
        model=model,
        groups={},
        illuminants=illuminants,
        alpha=np.empty((0, 0), np.float32),
        space=note.space,
        white_balance=note.degree,
        white_balance_method=note.method,
        view=msgspec.structs.asdict(note.view),
        gains={light.group: light.gain for light in lights},
        white=None if note.white is None else tuple(note.white),
        observer=note.observer,
    )
    header.check(described)
    return described


def _illuminant(named):
    if isinstance(named, str):
        return library.illuminant(named)
    return mixing.blend(tuple((library.illuminant(name), weight) for name, weight in named))


def missing(note: Note, given=None) -> str:
    """What a note has only a checksum of, and the `Description` of a sidecar, if `given`, does not have: in words."""
    name, channels, wanted = note.model
    given_model = given is not None and model_checksum(given.image.model) == wanted
    if not given_model and _shipped(name, channels, wanted) is None:
        return f"the scene's own model of {channels} channels"
    if not note.lights and (given is None or given.mix != note.mix):
        return "the mix, which does not fit into the note"
    return ""


def image_of(text: str, given=None) -> CoefficientImage:
    """The image, without pixels, that a note describes, of which nothing is `missing`. Raises CoefficientImageError."""
    note = read(text)
    model = _shipped(*note.model) or given.image.model
    return _image(text, model) if note.lights else given.image
