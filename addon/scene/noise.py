"""What is done about the noise of a scene's passes: denoised, brought to one brightness, or left."""

import json
import zlib

from ...core.picture.noise import to_picture
from ..graph import noise_nodes
from ..host import denoising
from ..store import properties

__all__ = ["MADE", "choice", "group"]

MADE = "relume_made"  # on a node group: what it was made of


def choice(scene) -> list:
    """What is done in the compositing, and what the nodes for it are made of; empty for nothing."""
    settings = scene.relume
    if settings.denoises_passes:
        model = zlib.crc32(scene[properties.MODEL].encode())
        return ["denoised", model, denoising.guides_of(scene), denoising.prefilter_of(scene)]
    return ["estimated"] if settings.shares_brightness else []


def group(scene, name: str, groups: list[str], passes: int):
    """A node group that does it, None where nothing is to be done."""
    settings, chosen = scene.relume, choice(scene)
    if not chosen:
        return None
    if chosen[0] == "estimated":
        tree = noise_nodes.estimating_group(name, groups, settings.model().channels)
    else:
        matrices = to_picture(settings.model())
        tree = noise_nodes.denoising_group(name, groups, passes, matrices, *chosen[2:])
    tree[MADE] = json.dumps([groups, passes, *chosen])
    return tree
