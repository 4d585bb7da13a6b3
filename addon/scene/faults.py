"""What is wrong with the artist's scene itself, and what a spectral render of it goes without, said beforehand."""

import bpy

from ...core.errors import SetupError
from ..graph import lights
from ..host import animation, denoising, inventory
from ..store.remarks import Remark
from . import rows, view_layers

__all__ = ["check", "remarks_on"]

_UNLIT = "nothing shines in this light group: its row keeps what was chosen until you remove groups without lights"
_NO_DENOISER = "this Blender has no denoiser: the picture keeps its noise"
_BROKEN = "its driver cannot be worked out: the value stays what it was last"
_MISSING = "its library {} cannot be found: nothing of it is rendered"
_BARE = "no object is in this view layer: its collections are excluded, or hidden in renders"


def check(scene, shines: bool | None = None) -> None:
    """Raises SetupError where a scene cannot be rendered, with one sentence that says why.

    shines: whether anything does, where that is known.
    """
    camera = scene.camera
    if scene.library is not None:
        raise SetupError(f"scene {scene.name!r} is linked from {scene.library.filepath}: set it up in its own file")
    if scene.relume.exr:
        raise SetupError(f"scene {scene.name!r} relights {scene.relume.exr}: set up the scene that was rendered")
    if camera is None:
        raise SetupError(f"scene {scene.name!r} has no camera")
    if camera.is_missing:
        raise SetupError(f"camera {camera.name!r}: its library {camera.library.filepath} cannot be found")
    if camera.type not in {"CAMERA", "LIGHT"}:
        raise SetupError(f"scene {scene.name!r} looks through {camera.name!r}, which is neither a camera nor a lamp")
    if not (lights.has_emitters(scene) if shines is None else shines):
        raise SetupError(f"scene {scene.name!r} has no light: add a lamp, a shining material or a world")
    if not any(layer.use for layer in scene.view_layers) and not scene.relume.is_set_up:
        raise SetupError(f"scene {scene.name!r} has no view layer that is rendered")


def remarks_on(scene, found: inventory.Inventory) -> list[Remark]:
    """What a scene whose inventory is `found` goes without."""
    faulty = []
    if scene.cycles.use_denoising and not denoising.available():
        faulty.append(Remark("Render Properties", "Denoise", _NO_DENOISER))
    for layer in view_layers.sources(scene):
        # None: an object that a script removed, until Blender looks at the layer again
        if all(t is None or t.hide_render or t.type == "CAMERA" for t in layer.objects):
            faulty.append(Remark(layer.name, "", _BARE))
    for block in found.blocks:
        if block.is_missing:
            faulty.append(Remark(block.name, "", _MISSING.format(block.library.filepath)))
    for block in [*found.blocks, *_embedded(found.blocks)]:
        faulty += [Remark(block.name, path, _BROKEN) for path in animation.broken(block)]
    named = sorted({thing.lightgroup for thing in found.objects})
    faulty += [Remark(name, "", why) for name in named if (why := lights.why_unusable(name))]
    return faulty + [Remark(name, "", _UNLIT) for name in rows.unlit(scene)]


def _embedded(blocks) -> list:
    """The node trees that are no data-blocks of their own."""
    trees = (getattr(block, "node_tree", None) for block in blocks)
    return [tree for tree in trees if isinstance(tree, bpy.types.NodeTree) and tree.is_embedded_data]
