"""The node groups of the asset library: Blender's own nodes, that spectra pass channel by channel."""

import bpy
import numpy as np

from ..addon.graph import nodes, spectra
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
        _gel(): "A filter in front of a colour or a lamp; a thickness of 2 is two sheets of it.",
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


def _power(tree, column, base, exponent):
    """base ** exponent, number by number; each is a socket, or three equal numbers."""
    node = nodes.add(tree, "ShaderNodeVectorMath", column, operation="POWER")
    for socket, operand in zip(node.inputs, (base, exponent), strict=False):
        if isinstance(operand, bpy.types.NodeSocket):
            tree.links.new(operand, socket)
        else:
            socket.default_value = (operand,) * 3
    return node.outputs[0]


def _scaled(tree, column, vector, factor):
    node = nodes.add(tree, "ShaderNodeVectorMath", column, operation="SCALE")
    tree.links.new(vector, node.inputs[0])
    tree.links.new(factor, node.inputs["Scale"])
    return node.outputs[0]


def _product(tree, column, first, second: float):
    node = nodes.add(tree, "ShaderNodeMath", column, 1, operation="MULTIPLY")
    tree.links.new(first, node.inputs[0])
    if isinstance(second, bpy.types.NodeSocket):
        tree.links.new(second, node.inputs[1])
    else:
        node.inputs[1].default_value = second
    return node.outputs[0]


def _absorption(name: str, substance: Spectrum | None, density: float):
    """exp(-absorption · thickness) (Beer, Lambert); of a spectrum in 0..1 times a density, or of an input."""
    inputs = (("Thickness", "Float", 1.0),)
    if substance is None:
        inputs = (("Absorption", "Color", (0.2, 0.5, 0.8, 1.0)), ("Density", "Float", 1.0), *inputs)
    tree, source, output = _group(name, inputs)
    nodes.add_socket(tree, "Color", "Color", output=True)
    if substance is None:
        depth = _product(tree, 1, source.outputs["Thickness"], source.outputs["Density"])
        absorbed = source.outputs["Absorption"]
    else:
        depth = _product(tree, 1, source.outputs["Thickness"], density)
        held = nodes.add(tree, "ShaderNodeGroup", 1, node_tree=spectra.new_reflectance(substance))
        absorbed = held.outputs["Color"]
    negative = _product(tree, 2, depth, -1.0)
    left = _power(tree, 4, float(np.e), _scaled(tree, 3, absorbed, negative))
    tree.links.new(left, output.inputs["Color"])
    return tree


def _water() -> tuple[Spectrum, float]:
    """The absorption coefficient of water, 4πk/λ, as a spectrum whose greatest value is 1, and that value in 1/m."""
    k = library.extinction("Water")
    absorbed = 4 * np.pi * k.sampled() / (WAVELENGTHS * 1e-9)
    greatest = float(absorbed.max())
    return Spectrum(WAVELENGTHS, absorbed / greatest, "absorption of water", "reflectance", k.source), greatest


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
    passed = _power(tree, 2, source.outputs["Transmittance"], sheets.outputs[0])
    product = nodes.add(tree, "ShaderNodeVectorMath", 3, operation="MULTIPLY")
    tree.links.new(source.outputs["Color"], product.inputs[0])
    tree.links.new(passed, product.inputs[1])
    tree.links.new(product.outputs[0], output.inputs["Color"])
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
