"""Relighting a rendered coefficient EXR, or a sequence of them, in Blender's compositor, without the scene."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import bpy

from ...core.errors import CoefficientImageError, RelumeError
from ...core.picture import blender_exr, coefficients, description, sequences
from ...core.picture.blender_exr import light_pass
from ...core.picture.coefficients import CoefficientImage
from ..graph import node_groups, nodes, noise_nodes
from ..store import mixer, properties, schema
from . import setup

__all__ = ["new_scene", "point_at", "read_current"]

STOCK = properties.STOCK


def current_file(scene) -> Path:
    """The EXR that a scene shows at its current frame."""
    path = Path(bpy.path.abspath(scene.relume.exr))
    return sequences.numbered(path, scene.frame_current) if sequences.is_pattern(path) else path


def _files(path: Path) -> dict[int, Path]:
    return sequences.files(path) if sequences.is_pattern(path) else {1: path}


def _found(path: Path) -> tuple:
    """(files by frame, what their coefficient image is, the description where Blender wrote them).

    Raises CoefficientImageError, SequenceError. One file is read whole; of a sequence only where each one ends.
    """
    files = _files(path)
    first = next(iter(files.values()))
    image = coefficients.describe_all(files.values())[0]
    if len(files) == 1:
        coefficients.read(first)
    return files, image, None if coefficients.is_own(first) else description.of_file(first)


@contextmanager
def _all_or_nothing(path: Path) -> Iterator[None]:
    """While it is entered, data-blocks are made; if it fails they go again, and Blender's errors get words."""
    kept = [(collection, set(collection)) for collection in (bpy.data.scenes, bpy.data.images, bpy.data.node_groups)]
    try:
        yield
    except BaseException as error:
        for collection, before in kept:
            for block in set(collection) - before:
                collection.remove(block)
        if isinstance(error, (RuntimeError, LookupError, TypeError)) and not isinstance(error, RelumeError):
            raise CoefficientImageError(f"{path}: Blender cannot show it ({' '.join(str(error).split())})") from error
        raise


def new_scene(path: Path):
    """A scene whose compositor recombines an EXR or a sequence (shot.####.exr), lit as it was rendered.

    Raises CoefficientImageError, SequenceError; then there is no new scene.
    """
    files, image, described = _found(path)
    with _all_or_nothing(path):
        scene = bpy.data.scenes.new(f"Relight {path.stem}")
        settings = scene.relume
        scene[properties.MODEL] = json.dumps(image.model.to_dict())
        with mixer.quiet():
            _fill_mixer(settings, image)
        scene[properties.FIRST] = schema.snapshot_text(mixer.choices(settings))
        _remember(scene, files, path, image, described)
        _composite(scene, _load(files, path), files, image, described)
        setup.relight(scene)
        if settings.problem:
            raise CoefficientImageError(f"{path}: {settings.problem}")
    return scene


def _remember(scene, files: dict[int, Path], path: Path, image: CoefficientImage, described) -> None:
    scene.relume.exr = str(path)
    if described is not None:
        scene[STOCK] = description.to_json(described)
    scene.render.resolution_x, scene.render.resolution_y = image.size
    scene.render.resolution_percentage = 100
    scene.frame_start, scene.frame_end = min(files), max(files)


def point_at(scene, path: Path) -> None:
    """Point a scene that `new_scene` made at another EXR or sequence; the mixer stays.

    Raises CoefficientImageError for a file of other light groups or channels, SequenceError; the scene is then
    as it was.
    """
    from ...core.picture.note import model_checksum

    files, image, described = _found(path)
    settings = scene.relume
    groups = [row.name for row in settings.lit]
    if list(image.groups) != groups:
        raise CoefficientImageError(
            f"{path}: has the light groups {', '.join(image.groups)}, the mixer has {', '.join(groups)}"
        )
    before = description.from_json(scene[STOCK]) if STOCK in scene else None
    if model_checksum(image.model) != model_checksum(settings.model()):
        raise CoefficientImageError(
            f"{path}: was rendered with {_channels(image.model)}, or for another scene; "
            f"the mixer has {_channels(settings.model())} of its own: open it with Relight from EXR in a new scene"
        )
    if (described and described.passes()) != (before and before.passes()):
        raise CoefficientImageError(
            f"{path}: has other view layers than the file before: open it with Relight from EXR in a new scene"
        )
    tree = scene.compositing_node_group
    shown = [node for node in tree.nodes if node.type == "IMAGE" and node.image]
    guided = any(socket.is_linked for node in shown for socket in node.outputs if socket.name == "Denoising Albedo")
    if described and blender_exr.has_guides(next(iter(files.values())), described.passes()) != guided:
        raise CoefficientImageError(
            f"{path}: of this and the file before, one has what guides a denoiser in every pass and the other has not: "
            "open it with Relight from EXR in a new scene"
        )
    with _all_or_nothing(path):
        picture = _load(files, path)
    for old in {_swap(tree, node, picture, files) for node in shown}:
        if old.users == 0:
            bpy.data.images.remove(old)
    _remember(scene, files, path, image, described)


def _swap(tree, node, picture, files: dict[int, Path]):
    """Give an Image node another picture, and return the one before; layer and links stay.

    Blender keeps the number of a layer, not its name: the other file may have it elsewhere, and sockets come and go.
    """
    old, layer = node.image, node.layer
    fed = [(socket.name, link.to_socket) for socket in node.outputs for link in socket.links]
    _show(node, picture, files)
    node.layer = layer
    for name, target in fed:
        tree.links.new(node.outputs[name], target)
    return old


def read_current(scene) -> coefficients.CoefficientImage:
    """The coefficients of the EXR that a scene shows at its current frame. Raises CoefficientImageError."""
    described = description.from_json(scene[STOCK]) if STOCK in scene else None
    return coefficients.read(current_file(scene), described)


def _channels(model) -> str:
    return "1 channel" if model.channels == 1 else f"{model.channels} channels"


def _fill_mixer(settings, image: CoefficientImage) -> None:
    for group, illuminant in image.illuminants.items():
        row = settings.light_groups.add()
        row["name"] = group
        row.source = "FILE"
        row["measured"] = json.dumps(illuminant.to_dict())
        row["path"] = illuminant.name
        row.gain = image.gains.get(group, 1.0)
    settings.white_balance = image.white_balance
    settings.white_balance_method = image.white_balance_method
    if isinstance(image.observer, str):
        settings.observer = image.observer
    else:
        settings["observer_measured"] = json.dumps([one.to_dict() for one in image.observer])
        settings.observer = properties.FILE


def _load(files: dict[int, Path], path: Path):
    picture = bpy.data.images.load(str(next(iter(files.values())).resolve()), check_existing=False)
    picture.colorspace_settings.name = "Non-Color"
    if sequences.is_pattern(path):
        picture.source = "SEQUENCE"
    return picture


def _show(node, picture, files: dict[int, Path]) -> None:
    node.image = picture
    if len(files) > 1:
        node.frame_start, node.frame_offset = min(files), min(files) - 1
        node.frame_duration = len(files)
        node.use_auto_refresh = True


def _composite(scene, picture, files, image: CoefficientImage, described) -> None:
    tree = bpy.data.node_groups.new("Relume Relight", "CompositorNodeTree")
    tree[nodes.ROLE] = "compositing"
    tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    output = tree.nodes.new("NodeGroupOutput")
    output.location = (700, 0)
    groups = list(image.groups)
    layers = described.passes() if described else [f"Coefficients {k + 1}" for k in range(image.model.passes)]
    recombination = tree.nodes.new("CompositorNodeGroup")
    recombination.node_tree = node_groups.recombination_group(
        f"Relume Recombination {scene.name}", groups, image.model.passes
    )
    recombination.location = (400, 0)
    target = recombination
    if described and blender_exr.has_guides(next(iter(files.values())), layers):
        target = tree.nodes.new("CompositorNodeGroup")
        target.node_tree = noise_nodes.estimating_group(f"Relume Noise {scene.name}", groups, image.model.channels)
        target.location = (200, 0)
        for socket in target.outputs:
            tree.links.new(socket, recombination.inputs[socket.name])
    for k, layer in enumerate(layers):
        node = tree.nodes.new("CompositorNodeImage")
        node.location = (0, -300 * k)
        _show(node, picture, files)
        node.layer = layer
        for group in groups:
            output_name = light_pass(group) if described else group
            tree.links.new(node.outputs[output_name], target.inputs[f"{group} {k + 1}"])
        for guide in ("Albedo", "Normal") if target != recombination else ():
            tree.links.new(node.outputs[f"Denoising {guide}"], target.inputs[noise_nodes.guide_socket(guide, k)])
    tree.links.new(recombination.outputs["Image"], output.inputs["Image"])
    scene.compositing_node_group = tree
