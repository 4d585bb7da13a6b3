"""What a scene says about its renders: for `relume describe`, `relume relight --scene`and for sidecars."""

from dataclasses import replace

import bpy

from ...core.errors import SetupError
from ...core.picture.description import Description
from . import baking, content, note, render, view_layers

__all__ = ["description_of", "of_open_file"]


def description_of(scene) -> Description:
    """The description of a scene that is set up, with its mix at the current frame. Raises RelumeError."""
    from ...core.picture.note import mix_of

    layers = view_layers.pass_layers(scene)
    if not layers:
        raise SetupError(f"scene {scene.name!r} is not set up for spectral rendering")
    image = replace(render.described(scene), shows=content.content_of(scene))
    animated = baking.is_animated(scene)
    found, _ = note.made(scene, image, animated)
    names = {source: tuple(layer.name for layer in each) for source, each in layers.items()}
    return Description(image, names, mix_of(found), animated)


def of_open_file() -> Description:
    """The description of the current scene, or of the first that is set up. Raises RelumeError."""
    scenes = [bpy.context.scene, *bpy.data.scenes]
    ready = next((scene for scene in scenes if scene.relume.is_set_up and view_layers.pass_layers(scene)), None)
    if ready is None:
        raise SetupError(f"{bpy.path.basename(bpy.data.filepath)}: no scene is set up for spectral rendering")
    return description_of(ready)
