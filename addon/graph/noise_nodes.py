"""The compositor groups between a render's passes and the recombination: `core.picture.noise` in Blender's own nodes.

Each takes an image for every light group and pass, with what guides the denoiser in each pass, and gives the images
anew. Where the last light group is everything that no other holds, the renderer's image is of all light: the others are
taken off it first and added again.
"""

from collections.abc import Callable, Sequence

import bpy
import numpy as np

from ...core.picture import noise
from ...core.picture.coefficients import EVERYTHING_ELSE
from . import nodes

__all__ = ["NOISE", "denoising_group", "estimating_group"]

NOISE = "noise"  # the role of these groups
_HIGH = 1e30


class _Nodes:
    """Adds nodes to a tree, each below the one before, and links their inputs: sockets, or numbers to be set."""

    def __init__(self, tree) -> None:
        self.tree, self.row = tree, 0

    def add(self, kind: str, *operands, **settings):
        self.row += 1
        node = nodes.add(self.tree, kind, 1 + self.row % 12, self.row // 12, **settings)
        for socket, operand in zip(node.inputs, operands, strict=False):
            if isinstance(operand, bpy.types.NodeSocket):
                self.tree.links.new(operand, socket)
            elif operand is not None:
                socket.default_value = operand
        return node

    def vector(self, operation: str, *operands):
        """Numbers stand for vectors of them; scalar sockets do as well."""
        vectors = [(each,) * 3 if isinstance(each, float | int) else each for each in operands]
        return self.add("ShaderNodeVectorMath", *vectors, operation=operation).outputs[0]

    def scaled(self, vector, factor):
        return self.add("ShaderNodeVectorMath", vector, None, None, factor, operation="SCALE").outputs[0]

    def dot(self, a, b: Sequence[float]):
        return self.add("ShaderNodeVectorMath", a, tuple(map(float, b)), operation="DOT_PRODUCT").outputs["Value"]

    def number(self, operation: str, *operands):
        return self.add("ShaderNodeMath", *operands, operation=operation).outputs[0]

    def separate(self, vector) -> list:
        return list(self.add("ShaderNodeSeparateXYZ", vector).outputs)

    def combine(self, *numbers):
        return self.add("ShaderNodeCombineXYZ", *numbers).outputs[0]

    def total(self, sockets: Sequence, operation: Callable):
        """The sum of sockets; `operation` adds two of them."""
        found = sockets[0]
        for socket in sockets[1:]:
            found = operation("ADD", found, socket)
        return found


def _group(name: str, groups: Sequence[str], passes: int, guides: Sequence[str], inside: Callable):
    """A group with the sockets of all; `inside(tools, images, guides)` gives a light group's images anew."""
    tree = nodes.new_tree(name, "CompositorNodeTree", NOISE)
    for group in groups:
        for k in range(passes):
            nodes.add_socket(tree, f"{group} {k + 1}", "Color", output=False, default=(0.0, 0.0, 0.0, 1.0))
            nodes.add_socket(tree, f"{group} {k + 1}", "Color", output=True)
    for guide in guides:
        for k in range(passes):
            nodes.add_socket(tree, f"{guide} {k + 1}", "Vector", output=False)
    tools = _Nodes(tree)
    source, output = nodes.add(tree, "NodeGroupInput", 0), nodes.add(tree, "NodeGroupOutput", 14)
    images = {group: [source.outputs[f"{group} {k + 1}"] for k in range(passes)] for group in groups}
    others = [group for group in groups if group != EVERYTHING_ELSE]
    rest = len(others) < len(groups) and others
    if rest:
        of_others = [tools.total([images[group][k] for group in others], tools.vector) for k in range(passes)]
        images[EVERYTHING_ELSE] = [
            tools.vector("SUBTRACT", image, off) for image, off in zip(images[EVERYTHING_ELSE], of_others, strict=True)
        ]
    shown = [{guide: source.outputs[f"{guide} {k + 1}"] for guide in guides} for k in range(passes)]
    made = inside(tools, images, shown)
    if rest:
        made[EVERYTHING_ELSE] = [
            tools.total([image, *(made[group][k] for group in others)], tools.vector)
            for k, image in enumerate(made[EVERYTHING_ELSE])
        ]
    for group, sockets in made.items():
        for k, socket in enumerate(sockets):
            tree.links.new(socket, output.inputs[f"{group} {k + 1}"])
    return tree


def estimating_group(name: str, groups: Sequence[str], channels: int):
    """`noise.estimated` in nodes."""
    passes = -(-channels // 3)
    counts = [min(channels - 3 * k, 3) for k in range(passes)]
    means = [(1 / count,) * count + (0.0,) * (3 - count) for count in counts]

    def inside(tools: _Nodes, images: dict[str, list], guides: list[dict]) -> dict[str, list]:
        albedo = [
            tools.number("ADD", tools.dot(guide["Albedo"], mean), noise.LEAST_ALBEDO)
            for guide, mean in zip(guides, means, strict=True)
        ]
        normal = tools.add("ShaderNodeVectorMath", guides[0]["Normal"], operation="LENGTH").outputs["Value"]
        surface = tools.number("MINIMUM", tools.number("MULTIPLY", normal, noise.SURE), 1.0)
        return {group: _estimated(tools, each, means, albedo, surface) for group, each in images.items()}

    return _group(name, groups, passes, ["Albedo", "Normal"], inside)


def _estimated(tools: _Nodes, images: list, means: list, albedo: list, surface) -> list:
    """The images of a light group. Three passes at a time are worked on as one vector."""
    passes = len(images)
    brightness = [
        tools.number("MAXIMUM", tools.number("DIVIDE", tools.dot(image, mean), below), 0.0)
        for image, mean, below in zip(images, means, albedo, strict=True)
    ]
    threes = [tools.combine(*brightness[k : k + 3]) for k in range(0, passes, 3)]

    def over_mean(vectors: list) -> list:
        mean = tools.total([tools.dot(each, (1 / passes,) * 3) for each in vectors], tools.number)
        return [tools.vector("DIVIDE", each, mean) for each in vectors]

    parts = over_mean(threes)
    wanted = over_mean([_blurred(tools, each) for each in threes])
    agreed = over_mean([_agreed(tools, part, wish, surface) for part, wish in zip(parts, wanted, strict=True)])
    factors = []
    for part, number in zip(parts, agreed, strict=True):
        scale = tools.vector("MINIMUM", tools.vector("DIVIDE", number, part), noise.MOST)
        dark = tools.vector("SUBTRACT", 1.0, tools.vector("CEIL", tools.vector("MINIMUM", part, 1.0)))
        factors += tools.separate(tools.vector("ADD", scale, dark))
    return [tools.scaled(image, factor) for image, factor in zip(images, factors, strict=False)]


def _agreed(tools: _Nodes, part, wanted, surface):
    """The parts of three passes, brought towards what is wanted as far as the noise around goes."""
    difference = part
    for size in ((1, 0), (0, 1)):
        difference = tools.vector("SUBTRACT", difference, _blurred(tools, difference, size, "Flat"))
    spread = _blurred(tools, tools.vector("ABSOLUTE", difference))
    least = [
        tools.add("CompositorNodeDilateErode", each, -noise.EROSION, "Steps").outputs[0]
        for each in tools.separate(spread)
    ]
    limit = tools.vector("MULTIPLY", tools.combine(*least), noise.AGREED * noise.TO_NOISE)
    limit = tools.scaled(limit, surface)
    step = tools.vector("MINIMUM", tools.vector("SUBTRACT", wanted, part), limit)
    step = tools.vector("MAXIMUM", step, tools.vector("MULTIPLY", limit, -1.0))
    return tools.vector("ADD", part, step)


def _blurred(tools: _Nodes, image, size: tuple[int, int] = (noise.BLUR, noise.BLUR), kind: str = "Gaussian"):
    return tools.add("CompositorNodeBlur", image, size, kind).outputs[0]


def denoising_group(
    name: str,
    groups: Sequence[str],
    passes: int,
    matrices: tuple[np.ndarray, np.ndarray],
    guides: Sequence[str],
    prefilter: str,
):
    """`noise.denoised` in nodes, with Blender's denoiser. matrices: as `noise.to_picture` gives them."""

    def inside(tools: _Nodes, images: dict[str, list], seen: list[dict]) -> dict[str, list]:
        turned = [_turned(tools, guide, noise.mirrored(k)) for k, guide in enumerate(seen)]
        joint = _joint(tools, seen, matrices[0]) if passes > 1 else {}
        found = {}
        for group, each in images.items():
            apart = [_clean(tools, i, turned[k], prefilter, noise.mirrored(k)) for k, i in enumerate(each)]
            if passes > 1:
                picture = _clean(tools, _weighed(tools, each, matrices[0]), joint, prefilter)
                apart = _held(tools, apart, picture, matrices)
            found[group] = apart
        return found

    return _group(name, groups, passes, guides, inside)


def _turned(tools: _Nodes, guide: dict, mirror: tuple[bool, bool]) -> dict:
    return {name: tools.add("CompositorNodeFlip", each, *mirror).outputs[0] for name, each in guide.items()}


def _clean(tools: _Nodes, image, guide: dict, prefilter: str, mirror: tuple[bool, bool] = (False, False)):
    """An image without noise; negative numbers, which the denoiser does not know, stay."""
    positive = tools.vector("MAXIMUM", image, 0.0)
    if any(mirror):
        positive = tools.add("CompositorNodeFlip", positive, *mirror).outputs[0]
    node = tools.add("CompositorNodeDenoise", positive)
    for name, socket in guide.items():
        tools.tree.links.new(socket, node.inputs[name])
    node.inputs["Prefilter"].default_value = prefilter
    clean = node.outputs[0]
    if any(mirror):
        clean = tools.add("CompositorNodeFlip", clean, *mirror).outputs[0]
    return tools.vector("ADD", clean, tools.vector("MINIMUM", image, 0.0))


def _joint(tools: _Nodes, guides: list[dict], together: np.ndarray) -> dict:
    """What guides the denoiser of the picture of all passes."""
    found = {}
    if "Albedo" in guides[0]:
        albedo = _weighed(tools, [guide["Albedo"] for guide in guides], together)
        found["Albedo"] = tools.vector("MINIMUM", tools.vector("MAXIMUM", albedo, 0.0), 1.0)
    if "Normal" in guides[0]:
        normals = tools.total([guide["Normal"] for guide in guides], tools.vector)
        found["Normal"] = tools.scaled(normals, 1 / len(guides))
    return found


def _weighed(tools: _Nodes, images: list, matrix: np.ndarray):
    """A (3, p) matrix times the coefficients of images."""
    rows = [
        tools.total([tools.dot(image, _three(row, k)) for k, image in enumerate(images)], tools.number)
        for row in matrix
    ]
    return tools.combine(*rows)


def _held(tools: _Nodes, apart: list, picture, matrices: tuple[np.ndarray, np.ndarray]) -> list:
    """Passes with a share of what the picture denoised as one differs by."""
    together, to_passes = matrices
    missing = tools.scaled(tools.vector("SUBTRACT", picture, _weighed(tools, apart, together)), noise.SHARE)
    rows = np.concatenate([to_passes, np.repeat(to_passes[-1:], -len(to_passes) % 3, axis=0)])
    return [
        tools.vector("ADD", image, tools.combine(*(tools.dot(missing, row) for row in rows[3 * k : 3 * k + 3])))
        for k, image in enumerate(apart)
    ]


def _three(row: np.ndarray, k: int) -> np.ndarray:
    """What a row of a matrix has for the channels of pass k; a pass that the model does not fill repeats its last."""
    found = row[3 * k : 3 * k + 3]
    return np.concatenate([found, np.zeros(3 - len(found))])
