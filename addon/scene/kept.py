"""What the compositing of the last render in a window denoised, kept in a file that it reads until the next.

Blender's compositor keeps nothing that its nodes made: at every change of light it would denoise each light group of
each pass again. So a render in a window also writes what it denoised, and what comes after the denoisers reads that.
Every render and every saved file has the denoisers in their place: nothing of this gets into a .blend.
"""

import shutil
from dataclasses import dataclass
from pathlib import Path

import bpy

from ..graph import nodes
from ..host.console import LOG
from .compositing_nodes import ADDED, PART, belongs

__all__ = [
    "KEPT",
    "begin",
    "end",
    "forget",
    "hold",
    "is_due",
    "is_pending",
    "next_frame",
    "put",
    "source_of",
    "take_out",
]

KEPT = "relume_kept"  # on the nodes that write and read the file
_MOST = 4 * 2**30  # bytes that the file may have: Blender holds all of it in memory


@dataclass
class _Kept:
    """scene: its session_uid. denoised: what each part of the file was made of. folder: which has the file alone.
    is_new: since it was read."""

    scene: int
    denoised: dict[str, list]
    folder: Path
    is_new: bool = True

    def path(self) -> Path | None:
        return next(self.folder.glob("*.exr"), None)  # Blender may put the number of the frame into its name


_writing: _Kept | None = None
_kept: _Kept | None = None
_is_due = _held = False


def begin(scene) -> None:
    """Have the render that begins write what it denoises; none without a window, where no image is ready for it."""
    global _writing
    tree, settings = scene.compositing_node_group, scene.render
    denoisers = _denoisers(tree, scene) if tree and settings.use_compositing else {}
    pixels = settings.resolution_x * settings.resolution_y * (settings.resolution_percentage / 100) ** 2
    if not denoisers or pixels * 16 * len(denoisers) > _MOST or nodes.kept_image() is None:
        return
    _writing = _Kept(scene.session_uid, _made_of(denoisers), Path(bpy.app.tempdir) / "relume_denoised")
    shutil.rmtree(_writing.folder, ignore_errors=True)
    writer = tree.nodes.new("CompositorNodeOutputFile")
    writer[ADDED] = writer[KEPT] = True
    writer.directory, writer.file_name = str(_writing.folder), "denoised"
    form = writer.format
    form.media_type, form.file_format = "MULTI_LAYER_IMAGE", "OPEN_EXR_MULTILAYER"
    form.color_depth, form.exr_codec = "32", "NONE"
    for number, (part, node) in enumerate(denoisers.items()):
        writer.file_output_items.new("RGBA", part)
        tree.links.new(node.outputs["Image"], writer.inputs[number])


def next_frame() -> None:
    """Before each frame of a render: an animation keeps none but its first, and that one only until it has ended."""
    global _writing
    if _writing is not None and _writing.path():
        _writing = None
        for scene in bpy.data.scenes:
            for node in _own(scene, "OUTPUT_FILE"):
                node.mute = True


def end(finished: bool) -> None:
    """The render has come to its end, or was cancelled: what it wrote is `put` to use when the artist is followed."""
    global _writing, _kept, _is_due
    if finished and _writing is not None:
        _kept = _writing
    _writing, _is_due = None, True


def is_pending() -> bool:
    """Whether a render is writing a file."""
    return _writing is not None


def is_due() -> bool:
    """Whether a render has ended since this was asked last."""
    global _is_due
    due, _is_due = _is_due, False
    return due


def forget() -> None:
    """Another render begins, or another file is open."""
    global _writing, _kept
    if _kept is not None:
        shutil.rmtree(_kept.folder, ignore_errors=True)
    _writing = _kept = None


def hold(held: bool = True) -> None:
    """While a file is saved, `put` takes out."""
    global _held
    _held = held


def put(scene) -> None:
    """Have the compositing read what was kept, where that is what it would denoise; otherwise denoise."""
    tree = scene.compositing_node_group
    denoisers = _denoisers(tree, scene) if tree else {}
    if not denoisers or not _is_of(scene, denoisers):
        take_out(scene)
        return
    for writer in _own(scene, "OUTPUT_FILE"):
        tree.nodes.remove(writer)
    image, readers = nodes.kept_image(), _own(scene, "IMAGE")
    _show_file(image)
    if not readers:
        readers = [tree.nodes.new("CompositorNodeImage")]
        readers[0][ADDED] = readers[0][KEPT] = True
        readers[0].location = next(iter(denoisers.values())).location
    reader = readers[0]
    if reader.image != image:
        reader.image = image
    if not set(denoisers) <= set(reader.outputs.keys()):
        LOG.warning("scene %r: %s cannot be read: each change of light denoises again", scene.name, _kept.path())
        take_out(scene)
        forget()
        return
    for part, node in denoisers.items():
        _move(tree, node.outputs["Image"], reader.outputs[part])


def take_out(scene) -> None:
    """Have the denoisers in their place."""
    tree = scene.compositing_node_group
    if tree is None:
        return
    for reader in _own(scene, "IMAGE"):
        for part, node in _denoisers(tree, scene).items():
            if part in reader.outputs:
                _move(tree, reader.outputs[part], node.outputs["Image"])
    for node in _own(scene, "IMAGE", "OUTPUT_FILE"):
        tree.nodes.remove(node)


def source_of(link):
    """The output that a link comes from where the denoisers are in their place."""
    if KEPT not in link.from_node:
        return link.from_socket
    denoisers = (node for node in link.id_data.nodes if node.get(PART) == link.from_socket.name)
    return next((node.outputs["Image"] for node in denoisers), link.from_socket)


def _is_of(scene, denoisers: dict) -> bool:
    if _kept is None or _held or _kept.scene != scene.session_uid or _kept.denoised != _made_of(denoisers):
        return False
    return _kept.path() is not None and nodes.kept_image() is not None


def _made_of(denoisers: dict) -> dict[str, list]:
    """For each part, what is denoised, with which guides and how."""
    return {
        part: [*map(_origin, node.inputs), node.inputs["Prefilter"].default_value] for part, node in denoisers.items()
    }


def _origin(socket) -> list[str]:
    if not socket.is_linked:
        return []
    link = socket.links[0]
    return [getattr(link.from_node, "layer", link.from_node.name), link.from_socket.name]


def _show_file(image) -> None:
    """Have the image show the file, which undo may have taken from it."""
    path = str(_kept.path())
    if _kept.is_new or image.filepath != path or image.source != "FILE":
        image.source, image.filepath = "FILE", path
        image.reload()
        image.colorspace_settings.name = "Non-Color"
        _kept.is_new = False


def _own(scene, *kinds: str) -> list:
    tree = scene.compositing_node_group
    return [node for node in tree.nodes if KEPT in node and node.type in kinds] if tree else []


def _denoisers(tree, scene) -> dict:
    """{part: node} of those that denoise one light group of one pass of a scene."""
    return {node[PART]: node for node in tree.nodes if PART in node and ADDED in node and belongs(node, scene)}


def _move(tree, before, after) -> None:
    """Give all that an output feeds to another, but for the file."""
    for link in list(before.links):
        if link.to_node.type != "OUTPUT_FILE":
            tree.links.new(after, link.to_socket)
