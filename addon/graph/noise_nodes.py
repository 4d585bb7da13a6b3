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

__all__ = ["NOISE", "denoising_group", "estimating_group", "guide_socket"]

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


def guide_socket(guide: str, index: int) -> str:
    """What the input for "Albedo" or "Normal" of a pass is called: as no light group is likely to be."""
    return f"Denoising {guide} {index + 1}"


def _group(name: str, groups: Sequence[str], passes: int, guides: Sequence[str], common: Callable, inside: Callable):
    """A group with the sockets of all light groups, and in it a node for each, of one group that they share.

    common(tools, guides) gives {name: socket} of what is the same for all of them; inside(tools, images, given), in the
    shared group, a light group's images anew. Blender looks through a tree at every node that is added: so a tree of
    thousands would take minutes.
    """
    tree = nodes.new_tree(name, "CompositorNodeTree", NOISE)
    for group in groups:
        for k in range(passes):
            nodes.add_socket(tree, f"{group} {k + 1}", "Color", output=False, default=(0.0, 0.0, 0.0, 1.0))
            nodes.add_socket(tree, f"{group} {k + 1}", "Color", output=True)
    for guide in guides:
        for k in range(passes):
            nodes.add_socket(tree, guide_socket(guide, k), "Vector", output=False)
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
    shown = [{guide: source.outputs[guide_socket(guide, k)] for guide in guides} for k in range(passes)]
    given = common(tools, shown)
    shared = _shared(f"{name} of a Light Group", passes, given, inside)
    made = {}
    for group, each in images.items():
        node = tools.add("CompositorNodeGroup", node_tree=shared)
        for socket, operand in zip(node.inputs, [*each, *given.values()], strict=True):
            tree.links.new(operand, socket)
        made[group] = list(node.outputs)
    if rest:
        made[EVERYTHING_ELSE] = [
            tools.total([image, *(made[group][k] for group in others)], tools.vector)
            for k, image in enumerate(made[EVERYTHING_ELSE])
        ]
    for group, sockets in made.items():
        for k, socket in enumerate(sockets):
            tree.links.new(socket, output.inputs[f"{group} {k + 1}"])
    return tree


def _shared(name: str, passes: int, given: dict, inside: Callable):
    """The group that works on one light group."""
    tree = nodes.new_tree(name, "CompositorNodeTree", NOISE)
    for k in range(passes):
        nodes.add_socket(tree, str(k + 1), "Color", output=False)
        nodes.add_socket(tree, str(k + 1), "Color", output=True)
    for title, socket in given.items():
        nodes.add_socket(tree, title, "Float" if socket.type == "VALUE" else "Vector", output=False)
    source, output = nodes.add(tree, "NodeGroupInput", 0), nodes.add(tree, "NodeGroupOutput", 14)
    sockets = list(source.outputs)
    held = dict(zip(given, sockets[passes:], strict=False))
    for k, socket in enumerate(inside(_Nodes(tree), sockets[:passes], held)):
        tree.links.new(socket, output.inputs[k])
    return tree


def estimating_group(name: str, groups: Sequence[str], channels: int):
    """`noise.estimated` in nodes."""
    passes = -(-channels // 3)
    counts = [min(channels - 3 * k, 3) for k in range(passes)]
    means = [(1 / count,) * count + (0.0,) * (3 - count) for count in counts]

    def common(tools: _Nodes, guides: list[dict]) -> dict:
        normal = tools.add("ShaderNodeVectorMath", guides[0]["Normal"], operation="LENGTH").outputs["Value"]
        albedo = [
            tools.number("ADD", tools.dot(guide["Albedo"], mean), noise.LEAST_ALBEDO)
            for guide, mean in zip(guides, means, strict=True)
        ]
        found = {f"Albedo {k + 1}": each for k, each in enumerate(albedo)}
        return found | {"Surface": tools.number("MINIMUM", tools.number("MULTIPLY", normal, noise.SURE), 1.0)}

    def inside(tools: _Nodes, images: list, given: dict) -> list:
        return _estimated(tools, images, means, [given[f"Albedo {k + 1}"] for k in range(passes)], given["Surface"])

    return _group(name, groups, passes, ["Albedo", "Normal"], common, inside)


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

    def common(tools: _Nodes, seen: list[dict]) -> dict:
        found = {}
        for k, guide in enumerate(seen):
            for title, socket in guide.items():
                turned = tools.add("CompositorNodeFlip", socket, *noise.mirrored(k)) if passes > 1 else None
                found[f"{title} {k + 1}"] = turned.outputs[0] if turned else socket
        return found | (_joint(tools, seen, matrices[0]) if passes > 1 else {})

    def inside(tools: _Nodes, images: list, given: dict) -> list:
        turned = [{title: given[f"{title} {k + 1}"] for title in guides} for k in range(passes)]
        if passes == 1:
            return [_clean(tools, images[0], turned[0], prefilter)]
        apart = [_clean(tools, i, turned[k], prefilter, noise.mirrored(k)) for k, i in enumerate(images)]
        picture = _clean(tools, _weighed(tools, images, matrices[0]), {t: given[t] for t in guides}, prefilter)
        return _held(tools, apart, picture, matrices)

    return _group(name, groups, passes, guides, common, inside)


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
