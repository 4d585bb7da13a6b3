"""The version of what Relume keeps in a .blend, and the readers of what older versions kept.

1: Relume 0.1.0, which noted no version.
2: a scene that is set up knows its version and what shines in each light group; a snapshot knows its version.
"""

import json

from ...core.errors import SetupError

__all__ = ["VERSION", "check", "clear", "note", "snapshot", "snapshot_text"]

VERSION = 2
_VERSION = "relume_version"  # on a scene that is set up


def note(scene) -> None:
    """Note in a scene that what it carries is of this version."""
    if scene.get(_VERSION) != VERSION:
        scene[_VERSION] = VERSION


def check(scene) -> None:
    """Raises SetupError where a newer Relume set the scene up: this one cannot know what it left there."""
    version = scene.get(_VERSION, 1)
    if version > VERSION:
        raise SetupError(
            f"scene {scene.name!r} was set up by a newer Relume (format {version}, this one knows {VERSION}): "
            "update Relume, or remove the set-up there"
        )


def clear(scene) -> None:
    if _VERSION in scene:
        del scene[_VERSION]


def snapshot_text(choices: dict) -> str:
    """What a snapshot keeps of the mixer's `choices`."""
    return json.dumps({"version": VERSION, **choices})


def snapshot(text: str) -> dict:
    """The choices that a snapshot keeps, of this version or an older one; what they lack has its default.

    Raises SetupError for those of a newer Relume, and for text that is no snapshot.
    """
    try:
        kept = json.loads(text)
        version = kept.get("version", 1)
        groups, balance = kept["light_groups"], kept["balance"]
    except (ValueError, KeyError, AttributeError) as error:
        raise SetupError(f"the snapshot is damaged: take another ({error!r})") from error
    if version > VERSION:
        raise SetupError(f"the snapshot was taken with a newer Relume (format {version}): update Relume")
    return {"light_groups": groups, "balance": balance}
