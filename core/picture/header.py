"""The description of a coefficient image as text: one schema, checked once, where a file comes in.

It stands in the header of the EXRs that Relume writes, and in a sidecar beside those that Blender writes. Every version
that there ever was is read; a newer one is refused. Import it late: msgspec takes its time.
"""

import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Annotated, Any, TypeVar

import msgspec
import numpy as np
from msgspec import Meta, Struct

from ..colour.spaces import ADAPTATIONS
from ..errors import CoefficientImageError, RelumeError
from ..model.factor_model import FactorModel
from ..model.upsample import RGB_SPACES
from ..spectra import library
from ..spectra.library import OBSERVER
from ..spectra.spectrum import Spectrum
from .coefficient_image import CoefficientImage
from .content import Content, kept

__all__ = ["LARGEST_GAIN", "VERSION", "check", "decoded", "parse", "to_dict"]

VERSION = 1
LARGEST_GAIN = 1e6
_LONGEST = 64 << 20  # characters of a description; a scene model of 1,000 reflectances has 2 million

T = TypeVar("T")
Number = Annotated[float, Meta(ge=-1e12, le=1e12)]
Degree = Annotated[float, Meta(ge=0, le=1)]
Gain = Annotated[float, Meta(ge=0, le=LARGEST_GAIN)]
Name = Annotated[str, Meta(max_length=250)]
White = tuple[Number, Number, Number]
Samples = Annotated[list[Number], Meta(min_length=1, max_length=100_000)]


class SpectrumText(Struct):
    wavelengths: Samples
    values: Samples
    name: Annotated[str, Meta(max_length=10_000)] = ""
    kind: Name = "reflectance"
    source: Annotated[str, Meta(max_length=10_000)] = ""


Exposure = Annotated[float, Meta(ge=-32, le=32)]  # Blender's own limits
Gamma = Annotated[float, Meta(ge=0, le=5)]


class View(Struct):
    """How Blender shows a picture."""

    display_device: Name | None = None
    view_transform: Name | None = None
    look: Name | None = None
    exposure: Exposure | None = None
    gamma: Gamma | None = None


class Shows(Struct):
    """What the scene shows, as `Content` has it."""

    bounces: Annotated[int, Meta(ge=0, le=1024)]
    space: Name
    shares: Annotated[list[Gain], Meta(max_length=1000)]
    reflectances: Annotated[list[SpectrumText], Meta(max_length=1000)] = []
    colours: Annotated[list[White], Meta(max_length=1000)] = []
    textures: Gain = 0.0
    again: Annotated[list[Degree], Meta(max_length=1001)] | None = None
    depths: Annotated[list[Gain], Meta(max_length=1000)] | None = None
    right_at: Annotated[list[Gain], Meta(max_length=1000)] | None = None


class _Version(Struct):
    version: Annotated[int, Meta(ge=1, le=1_000_000)]


class _Description(Struct):
    """Version 1. `layers` and `mix` are a sidecar's; older files do not say what a scene `shows`."""

    model: dict[str, Name | list[float | list[float]]]
    groups: Annotated[list[Name], Meta(min_length=1, max_length=1000)]
    illuminants: dict[str, SpectrumText]
    space: Name
    white_balance: Degree
    white_balance_method: Name
    view: View
    gains: dict[str, Gain] = {}
    white: White | None = None
    observer: Name | Annotated[list[SpectrumText], Meta(min_length=3, max_length=3)] = OBSERVER
    layers: dict[str, list[Name]] = {}
    mix: Name = ""
    shows: Shows | None = None


def to_dict(image: CoefficientImage, groups: Iterable[str] | None = None) -> dict[str, Any]:
    """The description of an image as JSON has it. groups: its light groups, where the image has no pixels."""
    groups = list(image.groups if groups is None else groups)
    shows = {} if image.shows is None else {"shows": _shown(image.shows)}
    return {
        "version": VERSION,
        "model": image.model.to_dict(),
        "groups": groups,
        "illuminants": {group: image.illuminants[group].to_dict() for group in groups},
        "gains": dict(image.gains),
        "space": image.space,
        "white_balance": image.white_balance,
        "white_balance_method": image.white_balance_method,
        "view": dict(image.view),
        "white": image.white,
        "observer": image.observer if isinstance(image.observer, str) else [one.to_dict() for one in image.observer],
        **shows,
    }


def _shown(content: Content) -> dict[str, Any]:
    content = kept(content)
    finishes = {"again": content.parts_again, "depths": content.optical_depths, "right_at": content.rights}
    return {
        "bounces": content.bounces,
        "space": content.space,
        "shares": [round(float(share), 6) for share in content.parts],
        "reflectances": [spectrum.to_dict() for spectrum in content.reflectances],
        "colours": np.round(content.rgb, 6).tolist(),
        "textures": round(content.textures, 6),
        **{name: np.round(values, 6).tolist() for name, values in finishes.items() if values.any()},
    }


@lru_cache(maxsize=8)
def parse(text: str) -> tuple[CoefficientImage, Mapping[str, tuple[str, ...]], str]:
    """(image without pixels, a sidecar's {view layer: its coefficient passes}, its mix) of a description.

    Illuminants come in the order of the light groups. The frames of a sequence, which have one description, get one
    model. Raises CoefficientImageError that names the field.
    """
    if len(text) > _LONGEST:
        raise CoefficientImageError(f"a description of {len(text)} characters is too long")
    version = decoded(_Version, text).version
    if version > VERSION:
        raise CoefficientImageError(f"written by a newer Relume (format {version})")
    found = decoded(_Description, text)
    _check_names(found)
    image = CoefficientImage(
        model=_model(found.model),
        groups={},
        illuminants={group: _spectrum(f"illuminants, {group!r}", found.illuminants[group]) for group in found.groups},
        alpha=np.empty((0, 0), np.float32),
        space=found.space,
        white_balance=found.white_balance,
        white_balance_method=found.white_balance_method,
        view={name: value for name, value in msgspec.structs.asdict(found.view).items() if value is not None},
        gains=found.gains,
        white=found.white,
        observer=_observer(found.observer),
    )
    image = replace(image, shows=_content(found.shows, list(image.illuminants.values())))
    check(image)
    return image, {source: tuple(layers) for source, layers in found.layers.items()}, found.mix


def decoded(kind: type[T], text: str) -> T:
    """JSON text as a msgspec type. Raises CoefficientImageError that names the field in plain words."""
    try:
        return msgspec.json.decode(text, type=kind)
    except msgspec.ValidationError as error:
        raise CoefficientImageError(_plain(str(error))) from None
    except (msgspec.DecodeError, UnicodeError) as error:
        raise CoefficientImageError(str(error)) from None
    except RecursionError:
        raise CoefficientImageError("lists in lists, deeper than anything Relume writes") from None


_WORDS = {"object": "fields", "array": "a list", "float": "a number", "int": "a whole number", "str": "text"}
_WORDS |= {"null": "nothing", "bool": "true or false"}


def _plain(message: str) -> str:
    """What msgspec says of a field: the field first, types in words."""
    message, _, where = message.partition(" - at `$.")
    words = re.sub(r"`([^`]*)`", lambda found: " or ".join(_WORDS.get(w, w) for w in found[1].split(" | ")), message)
    missing = re.fullmatch(r"Object missing required field (.*)", words)
    words = f"{missing[1]} is missing" if missing else words[0].lower() + words[1:]
    where = where.rstrip("`").replace("[...]", "")
    return f"{where}: {words}" if where else words


def _check_names(found: _Description) -> None:
    repeated = sorted({group for group in found.groups if found.groups.count(group) > 1})
    if repeated:
        raise CoefficientImageError(f"groups: {repeated[0]!r} stands there twice")
    for field in ("illuminants", "gains"):
        strange = sorted(set(getattr(found, field)) - set(found.groups))
        if strange:
            raise CoefficientImageError(f"{field}: {strange[0]!r} is no light group of the file")
    dark = [group for group in found.groups if group not in found.illuminants]
    if dark:
        raise CoefficientImageError(f"illuminants: light group {dark[0]!r} has none")
    known: dict[str, Collection[str]] = {"space": RGB_SPACES, "white_balance_method": ADAPTATIONS}
    for field, names in known.items():
        if getattr(found, field) not in names:
            raise CoefficientImageError(f"{field}: expected one of {', '.join(names)}, got {getattr(found, field)!r}")


def _model(described: Mapping[str, str | list[float | list[float]]]) -> FactorModel:
    numbers = [value for value in described.values() if not isinstance(value, str)]
    if max((len(value) for value in numbers), default=0) > 10_000 or any(
        isinstance(row, list) and len(row) > 1_000 for value in numbers for row in value
    ):
        raise CoefficientImageError("model: larger than any that Relume makes")
    with np.errstate(all="ignore"):
        try:
            return FactorModel.from_dict(described)
        except (ArithmeticError, LookupError, TypeError, ValueError) as error:
            raise CoefficientImageError(f"model: {_first(error)}") from None


def _spectrum(field: str, text: SpectrumText) -> Spectrum:
    try:
        return Spectrum.from_dict(msgspec.structs.asdict(text))
    except RelumeError as error:
        raise CoefficientImageError(f"{field}: {error}") from None


def _content(text: Shows | None, lights: list[Spectrum]) -> Content | None:
    if text is None:
        return None
    if text.space not in RGB_SPACES:
        raise CoefficientImageError(f"shows, space: expected one of {', '.join(RGB_SPACES)}, got {text.space!r}")
    reflectances = [_spectrum("shows, reflectances", one) for one in text.reflectances]
    try:
        return Content(
            reflectances,
            text.colours,
            text.shares,
            text.textures,
            lights,
            bounces=text.bounces,
            space=text.space,
            again=text.again,
            depths=text.depths,
            right_at=text.right_at,
        )
    except RelumeError as error:
        raise CoefficientImageError(f"shows: {error}") from None


def _observer(text: str | list[SpectrumText]) -> str | tuple[Spectrum, Spectrum, Spectrum]:
    if isinstance(text, str):
        try:
            library.sensitivities(text)
        except RelumeError as error:
            raise CoefficientImageError(f"observer: {error}") from None
        return text
    red, green, blue = (_spectrum("observer", one) for one in text)
    return red, green, blue


def check(image: CoefficientImage) -> None:
    """Make sure that a description can be relit as it is: light group by light group, then with its white balance.

    Raises CoefficientImageError.
    """
    plain = replace(image, white_balance=0.0)
    trials = [(f"illuminants, {group!r}", replace(plain, illuminants={group: light}))
              for group, light in image.illuminants.items()]  # fmt: skip
    for field, trial in [*trials, ("white_balance", image)]:
        with np.errstate(all="ignore"):
            try:
                matrices = trial.matrices()
            except (ArithmeticError, LookupError, TypeError, ValueError) as error:
                raise CoefficientImageError(f"{field}: {_first(error)}") from None
        if not np.isfinite(matrices).all() or np.abs(matrices).max() > 1e12:
            raise CoefficientImageError(f"{field}: makes colours that are not finite numbers")


def _first(error: Exception) -> str:
    return str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
