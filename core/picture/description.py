"""What a scene says about its renders: enough to relight what any Blender rendered of it.

It comes from the note in the EXR, from a sidecar beside it (`NAME.relume.json` or `relume.json`), or from the scene.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from .. import results
from ..errors import CoefficientImageError
from . import exr
from .coefficient_image import EVERYTHING_ELSE, CoefficientImage

__all__ = ["Description", "of_file", "read", "to_json", "write"]

SUFFIX = ".relume.json"


@dataclass(frozen=True)
class Description:
    """A coefficient image without pixels, and where a render has them.

    layers: the artist's view layer -> the view layers of its coefficient passes. mix: checksum, see `note.mix_of`.
    animated: the mix is that of the frame at which the scene was saved.
    """

    image: CoefficientImage
    layers: Mapping[str, tuple[str, ...]]
    mix: str = ""
    animated: bool = False

    def passes(self, layer: str | None = None) -> tuple[str, ...]:
        """The view layers of the coefficient passes of one of the artist's, by default of the first."""
        if layer is None:
            return next(iter(self.layers.values()))
        if layer not in self.layers:
            raise CoefficientImageError(f"no view layer {layer!r}; there are {', '.join(self.layers)}")
        return self.layers[layer]


def to_json(description: Description) -> str:
    """A sidecar's text."""
    from . import header

    image = description.image
    described = header.to_dict(image, list(image.illuminants))
    described |= {"layers": {source: list(layers) for source, layers in description.layers.items()}}
    return json.dumps(described | {"mix": description.mix}, ensure_ascii=False) + "\n"


def from_json(text: str) -> Description:
    """The inverse of `to_json`. Raises CoefficientImageError that names the field."""
    from . import header

    image, layers, mix = header.parse(text)
    if not layers:
        raise CoefficientImageError("layers is missing")
    if EVERYTHING_ELSE in list(image.illuminants)[:-1]:
        raise CoefficientImageError(f"groups: {EVERYTHING_ELSE!r} comes last")
    for source, names in layers.items():
        if len(names) != image.model.passes:
            raise CoefficientImageError(f"layers, {source!r}: expected {image.model.passes} names, got {len(names)}")
    return Description(image, layers, mix)


def read(path: str | Path) -> Description:
    """A sidecar. Raises CoefficientImageError that names the file and the field."""
    path = Path(path)
    try:
        return from_json(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise CoefficientImageError(f"{path}: cannot be read ({error})") from error
    except CoefficientImageError as error:
        raise CoefficientImageError(f"{path}: {error}") from None


def write(path: str | Path, description: Description) -> None:
    """Write a sidecar, whole or not at all. Raises ResultError."""
    results.write_text(path, to_json(description))


def _sidecars(path: Path) -> list[Path]:
    """Where a sidecar of an EXR may be: of the file, of its sequence, of the folder."""
    stems = (path.stem, path.stem.rstrip("0123456789").rstrip("._- "))
    names = [f"{stem}{SUFFIX}" for stem in stems if stem] + [SUFFIX[1:]]
    return [found for found in (path.with_name(name) for name in dict.fromkeys(names)) if found.is_file()]


def of_file(path: str | Path, scene: Description | None = None) -> Description:
    """The description of an EXR that Blender wrote.

    scene: that of the scene which it was rendered from, instead of the mix in the note and of sidecars. A file without
    a note takes the sidecar of its name. Raises CoefficientImageError where it is another scene's, or there is none.
    """
    from . import note

    path = Path(path)
    text = exr.attribute(path, "Note") or ""
    try:
        found = note.read(text)
    except CoefficientImageError as error:
        raise CoefficientImageError(f"{path}: {error}") from None
    if scene is not None:
        if found is not None and found.model[2] != note.model_checksum(scene.image.model):
            raise CoefficientImageError(
                f"{path}: was rendered from another scene, or before it was set up as it is now"
            )
        return scene
    if found is None:
        named = [sidecar for sidecar in _sidecars(path) if sidecar.name != SUFFIX[1:]]
        if named:
            return read(named[0])
        rendered = exr.attribute(path, "File") or ""
        rendered = f" ({Path(rendered).name})" if rendered.endswith(".blend") else ""
        raise CoefficientImageError(
            f"{path}: no Relume header and no Relume note; give the scene{rendered} with --scene FILE.blend, or write "
            f"{path.stem}{SUFFIX} beside the file with relume describe"
        )
    given, missing, sidecars = None, note.missing(found), _sidecars(path)
    if missing:
        given = next((each for each in map(read, sidecars) if not note.missing(found, each)), None)
    if missing and given is None:
        beside = f"{sidecars[0].name} beside it is another scene's or of an older mix; " if sidecars else ""
        raise CoefficientImageError(
            f"{path}: needs {missing}; {beside}write a sidecar with relume describe SCENE.blend, or give "
            "--scene FILE.blend"
        )
    try:
        image = note.image_of(text, given)
        return Description(image, _layers(found, image.model.passes), found.mix, found.animated)
    except CoefficientImageError as error:
        raise CoefficientImageError(f"{path}: {error}") from None


def _layers(found, passes: int) -> dict[str, tuple[str, ...]]:
    """The artist's view layers of a note with those of their passes, which set-up calls NAME 1, NAME 2, ..."""
    layers = {}
    for each in found.layers:
        source, *names = [each] if isinstance(each, str) else each
        layers[source] = tuple(names) if names else tuple(f"{source} {k + 1}" for k in range(passes))
        if len(layers[source]) != passes:
            raise CoefficientImageError(
                f"the Relume note is damaged: view layer {source!r} needs {passes} passes, has {len(names)}"
            )
    return layers
