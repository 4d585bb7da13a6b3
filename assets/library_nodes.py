"""The node groups of the asset library: Blender's own nodes, that spectra pass channel by channel."""

import bpy
import numpy as np

from ..addon.graph import nodes, spectra, transfer
from ..core.spectra import library
from ..core.spectra.spectrum import WAVELENGTHS, Spectrum

__all__ = ["build"]

_STEPS = (("Start", 0.0), ("Middle", 0.5), ("End", 1.0))


def build() -> dict:
    """The node groups -> {group: what it is for}."""
    water, greatest = _water()
    return {
        _mix(): "Mixes two spectra by a factor, exactly: for paints that are blended, worn or printed.",
        _ramp(): "Three spectra along a factor from 0 to 1, for what a colour ramp does with RGB.",
        _absorption(
            "Beer–Lambert Absorption", None, 1.0
        ): "What light is left of by a thickness (m) of a substance of a density (1/m) that absorbs by a spectrum.",
        _absorption(
            "Water by Thickness", water, greatest
        ): "What is left of light by a thickness (m) of pure water, by its measured absorption.",
        _thin_film(): "What a film of a few waves (thickness in nm) reflects, as soap does: the colour of a Glossy.",
        _gel(): "A filter in front of a colour or a lamp; a thickness of 2 is two sheets of it.",
        _transfer(): "Ranges of a volume's values, each with a spectrum and a density: the material panel edits them.",
        _black_body(): "Shines as a black body of the temperature in the attribute “kelvin” of its surface.",
    }


def _group(name: str, inputs: tuple):
    tree = bpy.data.node_groups.new(name, "ShaderNodeTree")
    for title, kind, default in inputs:
        nodes.add_socket(tree, title, kind, output=False, default=default)
    return tree, nodes.add(tree, "NodeGroupInput", 0), nodes.add(tree, "NodeGroupOutput", 6)


def _mixing(tree, column, factor, first, second):
    mix = nodes.add(tree, "ShaderNodeMix", column, data_type="RGBA")
    tree.links.new(factor, mix.inputs["Factor"])
    tree.links.new(first, nodes.mixed(mix, "A"))
    tree.links.new(second, nodes.mixed(mix, "B"))
    return next(output for output in mix.outputs if output.type == "RGBA")


def _mix():
    white = (0.8, 0.8, 0.8, 1.0)
    tree, source, output = _group(
        "Spectral Mix", (("Factor", "Float", 0.5), ("First", "Color", white), ("Second", "Color", white))
    )
    nodes.add_socket(tree, "Color", "Color", output=True)
    mixed = _mixing(tree, 2, *(source.outputs[name] for name in ("Factor", "First", "Second")))
    tree.links.new(mixed, output.inputs["Color"])
    return tree


def _ramp():
    colours = [(name, "Color", (0.8, 0.8, 0.8, 1.0)) for name, _ in _STEPS]
    tree, source, output = _group("Spectral Ramp", (("Factor", "Float", 0.5), *colours))
    nodes.add_socket(tree, "Color", "Color", output=True)
    total = source.outputs["Start"]
    for column, ((_, low), (name, high)) in enumerate(zip(_STEPS, _STEPS[1:], strict=False)):
        part = nodes.add(tree, "ShaderNodeMapRange", 2 * column + 1, 1)
        part.inputs["From Min"].default_value, part.inputs["From Max"].default_value = low, high
        tree.links.new(source.outputs["Factor"], part.inputs["Value"])
        total = _mixing(tree, 2 * column + 2, part.outputs["Result"], total, source.outputs[name])
    tree.links.new(total, output.inputs["Color"])
    return tree


def _fed(tree, node, operands):
    """The output of a node whose inputs are sockets, or numbers."""
    for socket, operand in zip(node.inputs, operands, strict=False):
        if isinstance(operand, bpy.types.NodeSocket):
            tree.links.new(operand, socket)
        else:
            socket.default_value = (operand,) * 3 if socket.type == "VECTOR" else operand
    return node.outputs[0]


def _number(tree, column, row, operation, *operands):
    return _fed(tree, nodes.add(tree, "ShaderNodeMath", column, row, operation=operation), operands)


def _vector(tree, column, operation, *operands):
    """An operation channel by channel; each operand is a socket, or three equal numbers."""
    return _fed(tree, nodes.add(tree, "ShaderNodeVectorMath", column, operation=operation), operands)


def _scaled(tree, column, vector, factor):
    node = nodes.add(tree, "ShaderNodeVectorMath", column, operation="SCALE")
    tree.links.new(vector, node.inputs[0])
    tree.links.new(factor, node.inputs["Scale"])
    return node.outputs[0]


def _absorption(name: str, substance: Spectrum | None, density: float):
    """exp(-absorption · thickness) (Beer, Lambert); of a spectrum in 0..1 times a density, or of an input."""
    inputs = (("Thickness", "Float", 1.0),)
    if substance is None:
        inputs = (("Absorption", "Color", (0.2, 0.5, 0.8, 1.0)), ("Density", "Float", 1.0), *inputs)
    tree, source, output = _group(name, inputs)
    nodes.add_socket(tree, "Color", "Color", output=True)
    if substance is None:
        depth = _number(tree, 1, 1, "MULTIPLY", source.outputs["Thickness"], source.outputs["Density"])
        absorbed = source.outputs["Absorption"]
    else:
        depth = _number(tree, 1, 1, "MULTIPLY", source.outputs["Thickness"], density)
        held = nodes.add(tree, "ShaderNodeGroup", 1, node_tree=spectra.new_reflectance(substance))
        absorbed = held.outputs["Color"]
    negative = _number(tree, 2, 1, "MULTIPLY", depth, -1.0)
    left = _vector(tree, 4, "POWER", float(np.e), _scaled(tree, 3, absorbed, negative))
    tree.links.new(left, output.inputs["Color"])
    return tree


def _water() -> tuple[Spectrum, float]:
    """The absorption coefficient of water, 4πk/λ, as a spectrum whose greatest value is 1, and that value in 1/m."""
    k = library.extinction("Water")
    absorbed = 4 * np.pi * k.sampled() / (WAVELENGTHS * 1e-9)
    greatest = float(absorbed.max())
    return Spectrum(WAVELENGTHS, absorbed / greatest, "absorption of water", "reflectance", k.source), greatest


def _transfer():
    tree = transfer.new()
    for k, name in enumerate(("blue", "green", "yellow", "red")):
        spectrum = library.reflectance(f"ColorChecker: {name}")
        group = spectra.existing({"Color": spectrum}) or spectra.new_reflectance(spectrum)
        transfer.add_range(tree, 0.25 * k, 0.25 * (k + 1), group)
    return tree


def _waves() -> Spectrum:
    """380 nm by wavelength: how many waves fit into a length, as a spectrum whose greatest value is 1."""
    return Spectrum(WAVELENGTHS, WAVELENGTHS[0] / WAVELENGTHS, "waves per 380 nm", "reflectance", "1/λ")


def _thin_film():
    """Airy's formula for a film with the same on both sides: R = F sin²(δ/2) / (1 + F sin²(δ/2)), F = 4r / (1 - r)².

    δ/2 = 2π n d cos θ / λ, channel by channel, with cos² θ = 1 - (1 - cos² i) / n²; r: Fresnel's, unpolarised.
    """
    tree, source, output = _group("Thin Film", (("Thickness", "Float", 400.0), ("IOR", "Float", 1.33)))
    nodes.add_socket(tree, "Color", "Color", output=True)
    index, output.location.x = source.outputs["IOR"], output.location.x + 800
    place = nodes.add(tree, "ShaderNodeNewGeometry", 0, 1)
    facing = nodes.add(tree, "ShaderNodeVectorMath", 1, 1, operation="DOT_PRODUCT")
    for socket, name in zip(facing.inputs, ("Incoming", "Normal"), strict=False):
        tree.links.new(place.outputs[name], socket)
    cosine = facing.outputs["Value"]
    sine = _number(tree, 3, 1, "SUBTRACT", 1.0, _number(tree, 2, 1, "MULTIPLY", cosine, cosine))
    bent = _number(tree, 4, 1, "DIVIDE", sine, _number(tree, 2, 2, "MULTIPLY", index, index))
    way = _number(tree, 6, 1, "SQRT", _number(tree, 5, 1, "SUBTRACT", 1.0, bent))
    way = _number(tree, 7, 1, "MULTIPLY", way, _number(tree, 6, 2, "MULTIPLY", index, source.outputs["Thickness"]))
    fresnel = nodes.add(tree, "ShaderNodeFresnel", 2, 3)
    tree.links.new(index, fresnel.inputs["IOR"])
    through = _number(tree, 3, 3, "SUBTRACT", 1.0, fresnel.outputs[0])
    finesse = _number(tree, 5, 3, "DIVIDE", fresnel.outputs[0], _number(tree, 4, 3, "MULTIPLY", through, through))
    held = nodes.add(tree, "ShaderNodeGroup", 7, node_tree=spectra.new_reflectance(_waves()))
    phase = _number(tree, 8, 1, "MULTIPLY", way, 2 * np.pi / WAVELENGTHS[0])
    wave = _vector(tree, 10, "SINE", _scaled(tree, 9, held.outputs["Color"], phase))
    strength = _scaled(
        tree, 12, _vector(tree, 11, "MULTIPLY", wave, wave), _number(tree, 6, 3, "MULTIPLY", finesse, 4.0)
    )
    reflected = _vector(tree, 14, "DIVIDE", strength, _vector(tree, 13, "ADD", strength, 1.0))
    tree.links.new(reflected, output.inputs["Color"])
    return tree


def _gel():
    tree, source, output = _group(
        "Gel",
        (
            ("Color", "Color", (1.0, 1.0, 1.0, 1.0)),
            ("Transmittance", "Color", (0.9, 0.5, 0.2, 1.0)),
            ("Thickness", "Float", 1.0),
        ),
    )
    nodes.add_socket(tree, "Color", "Color", output=True)
    sheets = nodes.add(tree, "ShaderNodeCombineXYZ", 1, 1)
    for socket in sheets.inputs:
        tree.links.new(source.outputs["Thickness"], socket)
    passed = _vector(tree, 2, "POWER", source.outputs["Transmittance"], sheets.outputs[0])
    tree.links.new(_vector(tree, 3, "MULTIPLY", source.outputs["Color"], passed), output.inputs["Color"])
    return tree


def _black_body():
    tree, source, output = _group("Black Body by Attribute", (("Strength", "Float", 1.0),))
    nodes.add_socket(tree, "Emission", "Shader", output=True)
    attribute = nodes.add(tree, "ShaderNodeAttribute", 1, attribute_name="kelvin")
    colour, emission = nodes.add(tree, "ShaderNodeBlackbody", 2), nodes.add(tree, "ShaderNodeEmission", 3)
    tree.links.new(attribute.outputs["Factor" if "Factor" in attribute.outputs else "Fac"], colour.inputs[0])
    tree.links.new(colour.outputs[0], emission.inputs["Color"])
    tree.links.new(source.outputs["Strength"], emission.inputs["Strength"])
    tree.links.new(emission.outputs[0], output.inputs["Emission"])
    return tree
