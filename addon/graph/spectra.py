"""Measured spectra in a Blender file: node groups that artists share, append and link like any other.

A spectrum group keeps its samples in the custom property `SPECTRA`, {output socket: Spectrum as a dictionary}: `Color`
for a reflectance; `IOR` and `Extinction` for the complex index of refraction of a metal. One for what absorbs has a
`DEPTH` as well, at which its channels are right.
"""

import hashlib
import json
from collections.abc import Iterator
from contextlib import contextmanager

import bpy
import numpy as np

from ...core.colour import spaces
from ...core.model import absorption, fresnel
from ...core.model.factor_model import FactorModel
from ...core.spectra.spectrum import Spectrum
from . import insertion, node_groups, nodes, sockets

__all__ = [
    "DEPTH",
    "FILLED",
    "SPECTRA",
    "assign",
    "depth_of",
    "existing",
    "filled_for",
    "for_socket",
    "mend_all",
    "new_conductor",
    "new_reflectance",
    "replace",
    "restore_all",
    "shines",
    "source_of",
    "spectra_of",
    "unassign",
    "update_all",
]

SPECTRA = "relume_spectra"
FILLED = "relume_filled"  # on a group with spectra: a checksum of them and of the model that it is filled for
DEPTH = "relume_depth"  # on a group for the colour of what absorbs: the optical depth at which it is right
_DEEPEST = 100.0
_ABSORBING = "ShaderNodeVolumeAbsorption"
_PLAIN = "relume_plain"  # on a spectrum group while it gets other nodes: its plain values


def new_reflectance(spectrum: Spectrum, name: str = "", depth: float = 0.0):
    """A node group with one output, Color, that is the reflectance `spectrum`.

    depth: for the colour of what absorbs, the optical depth at which it is right; a surface has none.
    """
    return _new(name or spectrum.name, {"Color": ("Color", spectrum)}, depth)


def for_socket(socket, spectrum: Spectrum, way: float | None = None):
    """The spectrum group of a reflectance for a shader socket: that of this file, or a new one.

    way: through what is to have it, in metres; None where nobody knows.
    """
    depth = 0.0
    if socket.node.bl_idname == _ABSORBING:
        density = socket.node.inputs["Density"]
        is_known = way is not None and not density.is_linked
        depth = absorption.depth_for(density.default_value * way) if is_known else absorption.DEPTH
    name = f"{spectrum.name}, {depth:g} deep" if depth else ""
    return existing({"Color": spectrum}, depth) or new_reflectance(spectrum, name, depth)


def new_conductor(name: str, n: Spectrum, k: Spectrum):
    """A node group with the outputs IOR and Extinction, for the Metallic BSDF of type Physical Conductor."""
    return _new(name, {"IOR": ("Vector", n), "Extinction": ("Vector", k)})


def existing(spectra: dict[str, Spectrum], depth: float = 0.0):
    """The spectrum group of this file that holds just those spectra, by output socket; None if there is none."""
    for tree in _local():
        own = spectra_of(tree)
        is_same = own.keys() == spectra.keys() and depth_of(tree) == depth
        if is_same and all(_alike(own[socket], spectra[socket]) for socket in own):
            return tree
    return None


def depth_of(tree) -> float:
    """The optical depth at which the colour of a medium is right, as whoever wrote there said; 0 for a surface."""
    depth = tree.get(DEPTH, 0.0)
    return float(depth) if isinstance(depth, (int, float)) and 0 < depth <= _DEEPEST else 0.0


def _alike(a: Spectrum, b: Spectrum) -> bool:
    return (
        a.name == b.name and a.wavelengths.tolist() == b.wavelengths.tolist() and a.values.tolist() == b.values.tolist()
    )


def _new(name: str, outputs: dict[str, tuple[str, Spectrum]], depth: float = 0.0):
    tree = nodes.new_tree(name, "ShaderNodeTree", "spectrum")
    for socket, (kind, _) in outputs.items():
        nodes.add_socket(tree, socket, kind, output=True)
    tree[SPECTRA] = {socket: spectrum.to_dict() for socket, (_, spectrum) in outputs.items()}
    if depth:
        tree[DEPTH] = depth
    _fill_as_it_is(tree)
    return tree


def replace(tree, spectrum: Spectrum):
    """Make another reflectance of a spectrum group, wherever it is used."""
    tree[SPECTRA] = {"Color": spectrum.to_dict()}
    _fill_as_it_is(tree)


def _fill_as_it_is(tree):
    _fill_plain(tree, _plain(tree))
    # Channels of the model being rendered, where there is one
    for scene in bpy.data.scenes:
        if scene.relume.shades:
            _fill(tree, scene.relume.model())
            break


def spectra_of(tree) -> dict[str, Spectrum]:
    """The measured spectra of a spectrum group, by output socket."""
    return {socket: Spectrum.from_dict(data) for socket, data in tree[SPECTRA].to_dict().items()}


def assign(material, socket, tree, output: str = "Color"):
    """Feed a shader socket of a material from an output of a spectrum group. Returns the group node.

    In a scene that is set up it takes the place of the RGB colour that was upsampled for the socket.
    """
    node_tree = material.node_tree
    for node in node_tree.nodes:
        if node.type == "GROUP" and node.node_tree == tree:
            break
    else:
        node = node_tree.nodes.new("ShaderNodeGroup")
        node.node_tree = tree
        node.location = (socket.node.location.x - 220, socket.node.location.y - 60)
    before = nodes.inserted_before(socket)
    if before is not None and nodes.role(before) == "light":
        node_groups.set_spectral(before, _channels(), True)
        socket = before.inputs["Color"]
        before = nodes.inserted_before(socket)
    while before is not None:
        insertion.take_out(node_tree, material, before)
        before = nodes.inserted_before(socket)
    old = socket.links[0].from_node if source_of(socket) else None
    node_tree.links.new(node.outputs[output], socket)
    if old is not None and old != node:
        _clear_unused(node_tree, old)
    return node


def shines(socket) -> bool:
    """Whether a shader socket is the colour of what a surface, a volume or a world emits."""
    return socket.node.bl_idname in ("ShaderNodeEmission", "ShaderNodeBackground") or "Emission" in socket.name


def _clear_unused(tree, node):
    if not any(output.is_linked for output in node.outputs):
        tree.nodes.remove(node)


def unassign(material, socket) -> None:
    """Let a shader socket of a material show its own RGB colour again, upsampled in a scene that is set up."""
    tree, before = material.node_tree, nodes.inserted_before(socket)
    if before is not None and nodes.role(before) == "light":
        node_groups.set_spectral(before, _channels(), False)
        socket = before.inputs["Color"]
    if source_of(socket) is None:
        return
    node = socket.links[0].from_node
    tree.links.remove(socket.links[0])
    _clear_unused(tree, node)
    if before is None and _channels():
        nodes.insert(tree, socket, None, sockets.upsample_group_for(socket, _channels()))


def source_of(socket):
    """The spectrum group that feeds a socket, through what set-up put in between; None if none does."""
    while (before := nodes.inserted_before(socket)) is not None:
        socket = before.inputs[0]
    node = socket.links[0].from_node if socket.is_linked else None
    return node.node_tree if node is not None and nodes.role(node) == "spectrum" else None


def _channels() -> int:
    """Channels of the model that this file renders, 0 if no scene is set up."""
    return next((scene.relume.model().channels for scene in bpy.data.scenes if scene.relume.shades), 0)


def _plain(tree) -> dict[str, tuple]:
    """What a spectrum shows in a scene without Relume: its colour in daylight; n and k at three wavelengths."""
    space = bpy.data.colorspace.working_space
    spectra = spectra_of(tree)
    if "Color" in spectra:
        return {"Color": tuple(spaces.daylight_rgb(spectra["Color"], space))}
    return {socket: tuple(spaces.display_primaries(spectrum)) for socket, spectrum in spectra.items()}


def _fill(tree, model: FactorModel) -> None:
    spectra = spectra_of(tree)
    depth = depth_of(tree)
    if "Color" in spectra:
        colour = spectra["Color"]
        coefficients = {"Color": absorption.tint(model, colour, depth) if depth else model.coefficients(colour)}
    else:
        n, k = fresnel.conductor_channels(model, spectra["IOR"], spectra["Extinction"])
        coefficients = {"IOR": n, "Extinction": k}
    _fill_with(tree, _plain_in(tree), coefficients)
    tree[FILLED] = filled_for(tree, model)


@contextmanager
def _refilling(tree, plain: dict[str, tuple]) -> Iterator[None]:
    """While a spectrum group gets other nodes: where that ends part-way, its plain values are not lost."""
    tree[_PLAIN] = plain
    if FILLED in tree:
        del tree[FILLED]
    tree.nodes.clear()
    yield
    del tree[_PLAIN]


def _fill_plain(tree, plain: dict[str, tuple]) -> None:
    """Give a spectrum group only the values that it shows in a scene without Relume: output -> three numbers."""
    with _refilling(tree, plain):
        _add_plain(tree, plain)


def _add_plain(tree, plain: dict[str, tuple]) -> None:
    output = nodes.add(tree, "NodeGroupOutput", 1)
    for row, (name, value) in enumerate(plain.items()):
        if output.inputs[name].type == "RGBA":
            node = nodes.add(tree, "ShaderNodeRGB", 0, row)
            node.outputs[0].default_value = (*value, 1.0)
        else:
            node = nodes.add(tree, "ShaderNodeCombineXYZ", 0, row)
            for socket, number in zip(node.inputs, value, strict=True):
                socket.default_value = number
        tree.links.new(node.outputs[0], output.inputs[name])


def _plain_in(tree) -> dict[str, tuple]:
    """The plain values of a spectrum group, whichever way it is filled."""
    if _PLAIN in tree:
        return {name: tuple(values) for name, values in tree[_PLAIN].to_dict().items()}
    output = next(node for node in tree.nodes if node.type == "GROUP_OUTPUT")
    found = {}
    for socket in output.inputs:
        if not socket.is_linked:
            continue
        node = socket.links[0].from_node
        if node.type == "RGB":
            found[socket.name] = tuple(node.outputs[0].default_value[:3])
        elif node.type == "COMBXYZ":
            found[socket.name] = tuple(number.default_value for number in node.inputs)
        else:
            found[socket.name] = tuple(nodes.mixed(node, "A").default_value[:3])
    return found


def _fill_with(tree, plain: dict[str, tuple], coefficients: dict[str, np.ndarray]) -> None:
    """Give a spectrum group p coefficients for each output, and the plain values for a scene without Relume."""
    with _refilling(tree, plain):
        _add_spectral(tree, plain, coefficients)


def _add_spectral(tree, plain: dict[str, tuple], coefficients: dict[str, np.ndarray]) -> None:
    channels = len(next(iter(coefficients.values())))
    output = nodes.add(tree, "NodeGroupOutput", channels + 3)
    view_node = node_groups.add_view(tree, channels)
    for row, (name, values) in enumerate(coefficients.items()):
        total = nodes.weighed(tree, view_node, values, row)
        if output.inputs[name].type == "VECTOR":
            # n and k of a metal: what the preview makes of them may not be negative
            bound = nodes.add(tree, "ShaderNodeVectorMath", channels + 1, row, operation="MAXIMUM")
            tree.links.new(total, bound.inputs[0])
            total = bound.outputs[0]
        chosen = nodes.choose(tree, channels + 2, view_node.outputs["ON"], plain[name], total)
        tree.links.new(chosen, output.inputs[name])


def _local() -> list:
    return [t for t in bpy.data.node_groups if t.get(nodes.ROLE) == "spectrum" and t.library is None and SPECTRA in t]


def update_all(model: FactorModel) -> None:
    """Give every spectrum of this file the coefficients of `model`; those that have them stay untouched."""
    for tree in _local():
        if tree.get(FILLED) != filled_for(tree, model):
            _fill(tree, model)


def filled_for(tree, model: FactorModel) -> str:
    """What a group with spectra notes as `FILLED` once it is filled for a model."""
    held = json.dumps([tree[SPECTRA].to_dict(), model.to_dict(), *([depth] if (depth := depth_of(tree)) else [])])
    return hashlib.sha256(held.encode()).hexdigest()[:16]


def mend_all(model: FactorModel) -> None:
    """Fill what an update that ended part-way left unfinished."""
    for tree in _local():
        if _PLAIN in tree:
            _fill(tree, model)


def restore_all() -> None:
    """Leave in every spectrum of this file only its plain colour."""
    for tree in _local():
        _fill_plain(tree, _plain_in(tree))
