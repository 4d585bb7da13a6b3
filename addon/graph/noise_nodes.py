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
_KINDS = {"Albedo": "Color", "Normal": "Vector"}  # of what the denoiser takes


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


def _group(name: str, groups: Sequence[str], passes: int, guides: Sequence[str], common: Callable, work: Callable):
    """A group with the sockets of all light groups.

    common(tools, guides) gives {name: socket} of what is the same for all of them; work(tools, images, given) a light
    group's images anew. Blender looks through a tree at every node that is added: so a tree of thousands would take
    minutes, and most of the work is in groups that all light groups share (`_shared`).
    """
    tree = nodes.new_tree(name, "CompositorNodeTree", NOISE)
    for group in groups:
        for k in range(passes):
            nodes.add_socket(tree, f"{group} {k + 1}", "Color", output=False, default=(0.0, 0.0, 0.0, 1.0))
            nodes.add_socket(tree, f"{group} {k + 1}", "Color", output=True)
    for guide in guides:
        for k in range(passes):
            nodes.add_socket(tree, guide_socket(guide, k), _KINDS[guide], output=False)
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
    made = {group: work(tools, each, given) for group, each in images.items()}
    if rest:
        made[EVERYTHING_ELSE] = [
            tools.total([image, *(made[group][k] for group in others)], tools.vector)
            for k, image in enumerate(made[EVERYTHING_ELSE])
        ]
    for group, sockets in made.items():
        for k, socket in enumerate(sockets):
            tree.links.new(socket, output.inputs[f"{group} {k + 1}"])
    return tree


def _shared(name: str, kinds: Sequence[str], count: int, inside: Callable):
    """A group of sockets of those kinds in and `count` colours out: inside(tools, inputs) gives them."""
    tree = nodes.new_tree(name, "CompositorNodeTree", NOISE)
    for k, kind in enumerate(kinds):
        nodes.add_socket(tree, f"{k + 1}", kind, output=False)
    for k in range(count):
        nodes.add_socket(tree, f"{k + 1}", "Color", output=True)
    source, output = nodes.add(tree, "NodeGroupInput", 0), nodes.add(tree, "NodeGroupOutput", 14)
    for k, socket in enumerate(inside(_Nodes(tree), list(source.outputs)[: len(kinds)])):
        tree.links.new(socket, output.inputs[k])
    return tree


def _used(tools: _Nodes, group, operands: Sequence) -> list:
    """The outputs of a node of a shared group."""
    node = tools.add("CompositorNodeGroup", node_tree=group)
    for socket, operand in zip(node.inputs, operands, strict=True):
        tools.tree.links.new(operand, socket)
    return list(node.outputs)


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

    def inside(tools: _Nodes, inputs: list) -> list:
        return _estimated(tools, inputs[:passes], means, inputs[passes:-1], inputs[-1])

    shared = _shared(f"{name} of a Light Group", ["Color"] * passes + ["Float"] * (passes + 1), passes, inside)

    def work(tools: _Nodes, images: list, given: dict) -> list:
        return _used(tools, shared, [*images, *given.values()])

    return _group(name, groups, passes, ["Albedo", "Normal"], common, work)


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
                turned = (
                    tools.add("CompositorNodeFlip", socket, *noise.mirrored(k)).outputs[0] if passes > 1 else socket
                )
                found[f"{title} {k + 1}"] = _as_denoised(tools, title, turned)
        return found | (_joint(tools, seen, matrices[0]) if passes > 1 else {})

    def before(tools: _Nodes, images: list) -> list:
        seen = [_positive(tools, image, noise.mirrored(k) if passes > 1 else ()) for k, image in enumerate(images)]
        return seen + ([_positive(tools, _weighed(tools, images, matrices[0]))] if passes > 1 else [])

    def after(tools: _Nodes, inputs: list) -> list:
        images, clean = inputs[:passes], inputs[passes:]
        turned = [
            _with_negative(tools, image, each, noise.mirrored(k) if passes > 1 else ())
            for k, (image, each) in enumerate(zip(images, clean, strict=False))
        ]
        if passes == 1:
            return turned
        picture = _with_negative(tools, _weighed(tools, images, matrices[0]), clean[-1])
        return _held(tools, turned, picture, matrices)

    denoised = passes + (passes > 1)  # the passes, and the picture of all
    first = _shared(f"{name} before the Denoiser", ["Color"] * passes, denoised, before)
    second = _shared(f"{name} after the Denoiser", ["Color"] * (passes + denoised), passes, after)

    def work(tools: _Nodes, images: list, given: dict) -> list:
        # Not in a shared group: a guide that several denoisers get from one output is cleaned once for them all
        clean = []
        for k, socket in enumerate(_used(tools, first, images)):
            node = tools.add("CompositorNodeDenoise", socket)
            for title in guides:
                tools.tree.links.new(given[f"{title} {k + 1}" if k < passes else title], node.inputs[title])
            node.inputs["Prefilter"].default_value = prefilter
            clean.append(node.outputs[0])
        return _used(tools, second, [*images, *clean])

    return _group(name, groups, passes, guides, common, work)


def _as_denoised(tools: _Nodes, title: str, guide):
    """A guide of the kind that the denoiser takes: converted by each of them, it would be cleaned by each of them."""
    if _KINDS[title] == "Vector":
        return tools.vector("ADD", guide, 0.0) if guide.type != "VECTOR" else guide
    return guide if guide.type == "RGBA" else tools.add("CompositorNodeSetAlpha", guide).outputs[0]


def _positive(tools: _Nodes, image, mirror: tuple[bool, ...] = ()):
    """What a denoiser is to see of an image: it knows no negative numbers."""
    positive = tools.vector("MAXIMUM", image, 0.0)
    return tools.add("CompositorNodeFlip", positive, *mirror).outputs[0] if any(mirror) else positive


def _with_negative(tools: _Nodes, image, clean, mirror: tuple[bool, ...] = ()):
    """A denoised image as it was turned before, with the negative numbers that it had."""
    turned = tools.add("CompositorNodeFlip", clean, *mirror).outputs[0] if any(mirror) else clean
    return tools.vector("ADD", turned, tools.vector("MINIMUM", image, 0.0))


def _joint(tools: _Nodes, guides: list[dict], together: np.ndarray) -> dict:
    """What guides the denoiser of the picture of all passes."""
    found = {}
    if "Albedo" in guides[0]:
        albedo = _weighed(tools, [guide["Albedo"] for guide in guides], together)
        limited = tools.vector("MINIMUM", tools.vector("MAXIMUM", albedo, 0.0), 1.0)
        found["Albedo"] = _as_denoised(tools, "Albedo", limited)
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
