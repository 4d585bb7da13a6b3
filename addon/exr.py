"""Relighting a rendered coefficient EXR, or a sequence of them, in Blender's compositor, without the scene."""

import json
import re
from pathlib import Path

import bpy
from bpy.props import StringProperty
from bpy.types import Operator

from ..core import coefficients, sequences
from ..core.coefficients import CoefficientImageError
from . import mixer, nodes, properties, setup

__all__ = ["CLASSES", "current_file", "new_scene", "point_at"]


def current_file(scene) -> Path:
    """The EXR that a scene shows at its current frame."""
    path = Path(bpy.path.abspath(scene.relume.exr))
    return sequences.numbered(path, scene.frame_current) if sequences.is_pattern(path) else path


def _files(path: Path) -> dict[int, Path]:
    return sequences.files(path) if sequences.is_pattern(path) else {1: path}


def _check_alike(files: dict[int, Path]):
    """Raise CoefficientImageError where an EXR of a sequence has other groups, channels or size than the first."""
    first = None
    for path in files.values():
        found = coefficients.describe(path)
        if first is None:
            first = found
        elif (list(found.groups), found.model.channels, found.size) != (
            list(first.groups),
            first.model.channels,
            first.size,
        ):
            raise CoefficientImageError(f"{path}: other light groups, channels or size than the first of the sequence")
    return first


def new_scene(path: Path):
    """A scene whose compositor recombines an EXR or a sequence (shot.####.exr), lit as it was rendered.

    Raises CoefficientImageError, SequenceError; then there is no new scene.
    """
    files = _files(path)
    image = _check_alike(files)
    scene = bpy.data.scenes.new(f"Relight {path.stem}")
    settings = scene.relume
    scene.render.resolution_x, scene.render.resolution_y = image.size
    scene.render.resolution_percentage = 100
    scene.frame_start, scene.frame_end = min(files), max(files)
    scene[properties.MODEL] = json.dumps(image.model.to_dict())
    with mixer.quiet():
        settings.exr = str(path)
        _fill_mixer(settings, image)
    _composite(scene, files, path, image)
    setup.relight(scene)
    return scene


def point_at(scene, path: Path):
    """Point a scene that `new_scene` made at another EXR or sequence; the mixer stays.

    Raises CoefficientImageError for a file of other light groups or channels, SequenceError; the scene is then
    as it was.
    """
    files = _files(path)
    image = _check_alike(files)
    settings = scene.relume
    groups = [row.name for row in settings.lit]
    if list(image.groups) != groups:
        raise CoefficientImageError(
            f"{path}: has the light groups {', '.join(image.groups)}, the mixer has {', '.join(groups)}"
        )
    if image.model.to_dict() != settings.model().to_dict():
        raise CoefficientImageError(
            f"{path}: was rendered with {image.model.channels} channels, or for another scene; "
            f"the mixer has {settings.model().channels} of its own: open it with Relight from EXR in a new scene"
        )
    settings.exr = str(path)
    scene.render.resolution_x, scene.render.resolution_y = image.size
    scene.frame_start, scene.frame_end = min(files), max(files)
    picture = _load(files, path)
    for node in scene.compositing_node_group.nodes:
        if node.type == "IMAGE":
            _show(node, picture, files)


def _fill_mixer(settings, image):
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


def _show(node, picture, files: dict[int, Path]):
    node.image = picture
    if len(files) > 1:
        node.frame_start, node.frame_offset = min(files), min(files) - 1
        node.frame_duration = len(files)
        node.use_auto_refresh = True


def _composite(scene, files, path: Path, image):
    tree = bpy.data.node_groups.new("Relume Relight", "CompositorNodeTree")
    tree[nodes.ROLE] = "compositing"
    tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    output = tree.nodes.new("NodeGroupOutput")
    output.location = (700, 0)
    groups = list(image.groups)
    recombination = tree.nodes.new("CompositorNodeGroup")
    recombination.node_tree = nodes.recombination_group(
        f"Relume Recombination {scene.name}", groups, image.model.passes
    )
    recombination.location = (400, 0)
    picture = _load(files, path)
    for k in range(image.model.passes):
        node = tree.nodes.new("CompositorNodeImage")
        node.location = (0, -300 * k)
        _show(node, picture, files)
        node.layer = f"Coefficients {k + 1}"
        for group in groups:
            tree.links.new(node.outputs[group], recombination.inputs[f"{group} {k + 1}"])
    tree.links.new(recombination.outputs["Image"], output.inputs["Image"])
    scene.compositing_node_group = tree


class RelightExr(Operator):
    """Open a coefficient EXR that Relume rendered, or a sequence of them, in a scene of its own and choose its light"""

    bl_idname = "relume.relight_exr"
    bl_label = "Relight from EXR"
    bl_options = {"REGISTER", "UNDO"}

    filepath: StringProperty(subtype="FILE_PATH")
    filter_glob: StringProperty(default="*.exr", options={"HIDDEN"})

    def invoke(self, context, event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        settings = context.scene.relume
        try:
            path = Path(bpy.path.abspath(self.filepath))
            if settings.exr:
                point_at(context.scene, path)
            else:
                context.window.scene = new_scene(path)
        except ValueError as error:
            settings.problem = re.sub(r"\s+", " ", str(error))
            self.report({"ERROR"}, settings.problem)
            return {"CANCELLED"}
        return {"FINISHED"}


CLASSES = (RelightExr,)
