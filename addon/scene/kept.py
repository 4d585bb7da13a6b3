"""The passes of the last render in a window without their noise, kept in a file that the compositing reads.

Blender's compositor keeps nothing that its nodes made: at every change of light it would denoise each light group of
each pass again. So a render in a window also writes what `noise` made of them, and what comes after reads that. Every
render and every saved file has the nodes in their place: nothing of this gets into a .blend.
"""

import shutil
from dataclasses import dataclass
from pathlib import Path

import bpy

from ..graph import nodes
from ..host.console import LOG
from .compositing_nodes import ADDED, PART, belongs
from .noise import MADE

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
_ROW = 22  # units of a node editor that a socket takes
_MOST = 4 * 2**30  # bytes that the file may have: Blender holds all of it in memory


@dataclass
class _Kept:
    """scene: its session_uid. made_of: what the parts of the file were. folder: which has the file alone. is_new: since
    it was read."""

    scene: int
    made_of: dict[str, list]
    folder: Path
    is_new: bool = True

    def path(self) -> Path | None:
        return next(self.folder.glob("*.exr"), None)  # Blender may put the number of the frame into its name


_writing: _Kept | None = None
_kept: _Kept | None = None
_is_due = _held = False


def begin(scene) -> None:
    """Have the render that begins write its passes without noise; not without a window, where no image is ready."""
    global _writing
    tree, settings = scene.compositing_node_group, scene.render
    parts = _parts(tree, scene) if tree and settings.use_compositing else {}
    pixels = settings.resolution_x * settings.resolution_y * (settings.resolution_percentage / 100) ** 2
    if not parts or pixels * 16 * len(parts) > _MOST or nodes.kept_image() is None:
        return
    _writing = _Kept(scene.session_uid, _made_of(parts), Path(bpy.app.tempdir) / "relume_denoised")
    shutil.rmtree(_writing.folder, ignore_errors=True)
    writer = tree.nodes.new("CompositorNodeOutputFile")
    writer[ADDED] = writer[KEPT] = True
    writer.directory, writer.file_name = str(_writing.folder), "denoised"
    form = writer.format
    form.media_type, form.file_format = "MULTI_LAYER_IMAGE", "OPEN_EXR_MULTILAYER"
    form.color_depth, form.exr_codec = "32", "NONE"
    for number, (part, socket) in enumerate(parts.items()):
        writer.file_output_items.new("RGBA", part)
        tree.links.new(socket, writer.inputs[number])


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
    """Have the compositing read what was kept, where that is what its nodes would make; otherwise have them make it."""
    tree = scene.compositing_node_group
    parts = _parts(tree, scene) if tree else {}
    if not parts or not _is_of(scene, parts):
        take_out(scene)
        return
    for writer in _own(scene, "OUTPUT_FILE"):
        tree.nodes.remove(writer)
    image, readers = nodes.kept_image(), _own(scene, "IMAGE")
    _show_file(image)
    if not readers:
        readers = [tree.nodes.new("CompositorNodeImage")]
        readers[0][ADDED] = readers[0][KEPT] = True
        below = next(iter(parts.values())).node
        rows = len(below.inputs) + len(below.outputs) + 4
        readers[0].location = (below.location.x, below.location.y - _ROW * rows)
    reader = readers[0]
    if reader.image != image:
        reader.image = image
    if not set(parts) <= set(reader.outputs.keys()):
        LOG.warning("scene %r: %s cannot be read: each change of light makes it again", scene.name, _kept.path())
        take_out(scene)
        forget()
        return
    for part, socket in parts.items():
        _move(tree, socket, reader.outputs[part])


def take_out(scene) -> None:
    """Have the nodes in their place."""
    tree = scene.compositing_node_group
    if tree is None:
        return
    for reader in _own(scene, "IMAGE"):
        for part, socket in _parts(tree, scene).items():
            if part in reader.outputs:
                _move(tree, reader.outputs[part], socket)
    for node in _own(scene, "IMAGE", "OUTPUT_FILE"):
        tree.nodes.remove(node)


def source_of(link):
    """The output that a link comes from where the nodes are in their place."""
    if KEPT not in link.from_node:
        return link.from_socket
    found = (_outputs(node).get(link.from_socket.name) for node in link.id_data.nodes if PART in node)
    return next(filter(None, found), link.from_socket)


def _is_of(scene, parts: dict) -> bool:
    if _kept is None or _held or _kept.scene != scene.session_uid or _kept.made_of != _made_of(parts):
        return False
    return _kept.path() is not None and nodes.kept_image() is not None


def _made_of(parts: dict) -> dict[str, list]:
    """For each node that makes parts, of which passes, and how."""
    makers = {socket.node[PART]: socket.node for socket in parts.values()}
    return {part: [*map(_origin, node.inputs), node.node_tree.get(MADE)] for part, node in makers.items()}


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


def _parts(tree, scene) -> dict:
    """{part: output} of the passes of each light group of a scene, without noise."""
    makers = [node for node in tree.nodes if PART in node and ADDED in node and belongs(node, scene)]
    return {part: socket for node in makers if nodes.role(node) for part, socket in _outputs(node).items()}


def _outputs(node) -> dict:
    return {f"{node[PART]} {number}": socket for number, socket in enumerate(node.outputs, 1)}


def _move(tree, before, after) -> None:
    """Give all that an output feeds to another, but for the file."""
    for link in list(before.links):
        if link.to_node.type != "OUTPUT_FILE":
            tree.links.new(after, link.to_socket)
