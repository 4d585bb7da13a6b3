"""A mix as text: a JSON file, or what is copied from one row, scene or Blender to another.

It holds what a snapshot keeps (`mixer.choices`), measured spectra with it, and the version of that.
"""

import json
import math
from collections.abc import Sequence
from pathlib import Path

from ...core import results
from ...core.errors import SetupError, UsageError
from ...core.picture import mixing
from ...core.picture.mix import Light
from . import mixer, schema, shining

__all__ = [
    "illuminant_from",
    "illuminant_text",
    "is_json",
    "lights_in",
    "mix_from",
    "mix_text",
    "read",
    "write",
]

_SHINES = (
    "source",
    "illuminant",
    "temperature",
    "cct",
    "path",
    "measured",
    "tint",
    "blend",
)  # of a row: what shines, no gain
_GAIN = ("stops", "solo", "mute")
_KIND = "relume"  # what the text holds: a mix, an illuminant


def is_json(text: str) -> bool:
    """Whether a text may be one of these, and not the words of `relume relight --mix`."""
    return text.lstrip().startswith("{")


def mix_text(settings) -> str:
    """The mix that the mixer of a scene says."""
    return json.dumps(
        {_KIND: "mix", "version": schema.VERSION, **mixer.choices(settings)}, ensure_ascii=False, indent=1
    )


def mix_from(text: str) -> dict:
    """What `mixer.choices` said when the text was made. Raises SetupError, UsageError."""
    kept = _kept(text, "mix")
    chosen = schema.snapshot(json.dumps(kept))
    groups, balance = chosen["light_groups"], chosen["balance"]
    if not isinstance(groups, dict) or not isinstance(balance, dict):
        raise UsageError("not a mix: its light_groups and balance are no objects")
    for name, row in groups.items():
        _check(row, mixer.LightGroup.bl_rna.properties, f"light group {name!r}")
    return chosen


def illuminant_text(row) -> str:
    """What shines in a row of the mixer."""
    said = mixer.choice(row)
    shines = {name: said[name] for name in _SHINES}
    return json.dumps({_KIND: "illuminant", "version": schema.VERSION, **shines}, ensure_ascii=False)


def illuminant_from(text: str) -> dict:
    """What shines, as a row says it: of `illuminant_text`. Raises SetupError, UsageError."""
    kept = _kept(text, "illuminant")
    _check(kept, mixer.LightGroup.bl_rna.properties, "the illuminant")
    return {name: kept[name] for name in _SHINES if name in kept}


def write(path: Path, settings) -> None:
    """Write the mix of a scene as a JSON file. Raises ResultError."""
    with results.replacing(path) as partial:
        partial.write_text(mix_text(settings) + "\n", encoding="utf-8")


def read(path: Path) -> str:
    """The text of a file of a mix: JSON, or the words of `relume relight --mix`. Raises UsageError."""
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise UsageError(f"{path}: cannot be read: {error.strerror or error}") from error
    except ValueError as error:
        raise UsageError(f"{path}: is not text, and so no mix") from error


def lights_in(chosen: dict, groups: Sequence[str]) -> dict[str, Light]:
    """The Light of each of these light groups that a mix knows, as `mix_from` returns it. Raises RelumeError."""
    known = mixer.LightGroup.bl_rna.properties
    usual = {name: mixer.default(known[name]) for name in (*_SHINES, *_GAIN) if name != "blend"} | {"blend": []}
    said = {name: usual | chosen["light_groups"][name] for name in groups if name in chosen["light_groups"]}
    gains = mixing.gains(*([row[name] for row in said.values()] for name in _GAIN))
    spectra = [shining.spectrum_of(row) for row in said.values()]
    return {name: Light(each, float(gain)) for name, each, gain in zip(said, spectra, gains, strict=True)}


def _kept(text: str, what: str) -> dict:
    try:
        kept = json.loads(text)
    except ValueError as error:
        raise UsageError(f"not {_a(what)}: {error}") from error
    if not isinstance(kept, dict) or kept.pop(_KIND, None) != what:
        raise UsageError(f"not {_a(what)} that Relume copied or saved")
    version = kept.get("version")
    if not isinstance(version, int):
        raise UsageError(f"not {_a(what)} that Relume copied or saved: it has no version")
    if version > schema.VERSION:
        raise SetupError(f"the {what} was written by a newer Relume (format {version}): update Relume")
    return kept


def _a(what: str) -> str:
    return f"an {what}" if what[0] in "aeiou" else f"a {what}"


def _check(row, known, where: str) -> None:
    """Raises UsageError where a row says what no row of the mixer can."""
    if not isinstance(row, dict):
        raise UsageError(f"{where}: is no object")
    for name in {*row} & {*known.keys()} - {"blend", "name"}:
        kind, value = known[name].type, row[name]
        if getattr(known[name], "is_array", False):
            if not _are_numbers(value, known[name].array_length):
                raise UsageError(f"{where}: {name} cannot be {value!r}")
            continue
        wrong = {
            "STRING": not isinstance(value, str),
            "BOOLEAN": not isinstance(value, bool),
            "FLOAT": isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value),
            "ENUM": kind == "ENUM" and value not in known[name].enum_items.keys(),
        }
        if wrong.get(kind, False):
            raise UsageError(f"{where}: {name} cannot be {value!r}")
    parts = row.get("blend", [])
    if not isinstance(parts, list) or not all(_is_part(part) for part in parts):
        raise UsageError(f"{where}: the blend is no list of illuminants and weights")


def _are_numbers(value, count: int) -> bool:
    return (
        isinstance(value, list)
        and len(value) == count
        and all(isinstance(each, int | float) and math.isfinite(each) for each in value)
    )


def _is_part(part) -> bool:
    return (
        isinstance(part, list)
        and 2 <= len(part) <= 3
        and all(isinstance(word, str) for word in (part[0], *part[2:]))
        and isinstance(part[1], int | float)
        and math.isfinite(part[1])
        and part[1] >= 0
    )
