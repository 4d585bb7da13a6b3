"""Build the asset library, with rendered previews: `python -m relume.assets.library [FOLDER [SAMPLES | keep]]`.

Materials, lamps, objects and node groups of measured spectra go into `library.blend`; their catalogues, as Blender's
Asset Browser reads them, into `blender_assets.cats.txt` beside it.
"""

import sys
import uuid
from pathlib import Path

import bpy
import numpy as np

from ..addon.host.asset_library import IMPORT_METHOD
from ..core.spectra import library
from . import library_materials, library_nodes, library_previews, library_things
from . import library_terms as terms
from .library_materials import Asset

__all__ = ["CATALOGUES", "PATH", "build", "main", "previews_in"]

PATH = Path(__file__).with_name("library.blend")
CATALOGUES = "blender_assets.cats.txt"
_ROOT = "Relume"
_NAMESPACE = uuid.UUID("6a1c1c62-2f0e-5a5e-9c53-2b4de1f3a7aa")
_HEAD = "# Catalogues of Relume's assets, for Blender's Asset Browser.\n\nVERSION 1\n\n"


def build() -> list[Asset]:
    """Empty the file and make all that the library holds, unmarked and without previews."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    materials = library_materials.build()
    patches = [asset.thing for asset in materials if asset.catalogue == "Materials/ColorChecker"]
    names = [spectrum.name for spectrum in library.reflectances("colorchecker")]
    things = library_things.build(dict(zip(names, patches, strict=True)))
    groups = [
        Asset(group, "Node groups", words, "Relume", terms.MADE, ("nodes",))
        for group, words in library_nodes.build().items()
    ]
    return [*materials, *things, *groups]


def _catalogue(path: str) -> str:
    """The identifier of a catalogue: always the same for the same path."""
    return str(uuid.uuid5(_NAMESPACE, path))


def _catalogues(assets: list[Asset]) -> str:
    """The text of the file of catalogues, with those above the ones that assets are in."""
    paths = set()
    for asset in assets:
        parts = [_ROOT, *asset.catalogue.split("/")]
        paths |= {"/".join(parts[: k + 1]) for k in range(len(parts))}
    lines = [f"{_catalogue(path)}:{path}:{path.replace('/', '-')}" for path in sorted(paths)]
    return _HEAD + "\n".join(lines) + "\n"


def _mark(asset: Asset, preview: np.ndarray | None) -> None:
    asset.thing.asset_mark()
    data = asset.thing.asset_data
    data.catalog_id = _catalogue(f"{_ROOT}/{asset.catalogue}")
    data.author, data.license = "The Relume authors", asset.licence
    if hasattr(data, "preferred_import_method"):  # Blender 5.2
        data.use_preferred_import_method, data.preferred_import_method = True, IMPORT_METHOD
    data.description, data.copyright = asset.description, f"Source: {asset.source}"
    for tag in ("spectral", *asset.tags):
        data.tags.new(tag, skip_if_exists=True)
    if preview is not None:
        image = asset.thing.preview_ensure()
        image.image_size = preview.shape[1], preview.shape[0]
        image.image_pixels_float.foreach_set(preview[::-1].astype(np.float32).ravel())


def previews_in(path: Path) -> dict[str, np.ndarray]:
    """The previews in a library that is there, by name, as `library_previews.render_all` returns them."""
    kinds = ("materials", "objects", "collections", "node_groups")
    with bpy.data.libraries.load(str(path), link=True, assets_only=True) as (there, wanted):
        for kind in kinds:
            setattr(wanted, kind, getattr(there, kind))
    found = {}
    for thing in [thing for kind in kinds for thing in getattr(wanted, kind) if thing.preview is not None]:
        pixels = np.array(thing.preview.image_pixels_float, dtype=np.float32)
        found[thing.name] = pixels.reshape(*thing.preview.image_size[::-1], 4)[::-1]
    return found


def main(arguments=None):
    """Build the library into a folder, that of this file by default.

    With 0 samples it has no previews, with `keep` those that it has already.
    """
    from .. import register

    if not hasattr(bpy.types.Scene, "relume"):
        register()
    arguments = sys.argv[1:] if arguments is None else arguments
    folder = Path(arguments[0]) if arguments else PATH.parent
    path, keep = (folder / PATH.name).resolve(), arguments[1:] == ["keep"]
    samples = [] if keep else [int(number) for number in arguments[1:]]
    previews = previews_in(path) if keep else {}
    if not keep and samples != [0]:
        previews = library_previews.render_all([asset.thing for asset in build()], *samples)
    assets = build()  # anew: set-up has changed the file that the sheet was rendered in
    for asset in assets:
        _mark(asset, previews.get(asset.thing.name))
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=True)
    (folder / CATALOGUES).write_text(_catalogues(assets), encoding="utf-8")
    print(f"{path}: {len(assets)} assets")


if __name__ == "__main__":
    main()
