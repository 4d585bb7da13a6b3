"""Surfaces of measured spectra: painted, mixed by a noise, of metal, of glass."""

import bpy

from ..addon.graph import nodes, spectra
from ..core.spectra import library

__all__ = ["between", "bump", "clear", "height", "metal", "mixed", "new", "noise", "painted", "product", "spectrum"]

_SODIUM_D = 589.3  # nm
_GLASS_SHADOW = 0.85  # what light that passes a glass keeps on its way to a shadow


def spectrum(name: str):
    tree = bpy.data.node_groups.get(name.split(": ")[-1])
    return tree or spectra.new_reflectance(library.reflectance(name), name.split(": ")[-1])


def new(name: str):
    """A new material, its nodes, and the Principled node among them."""
    material = bpy.data.materials.new(name)
    return material, material.node_tree, material.node_tree.nodes["Principled BSDF"]


def painted(name: str, *reflectances: str, roughness=0.5, scale=6.0, contrast=(0.35, 0.65), **inputs):
    """A Principled surface of one reflectance, or of two that a noise mixes."""
    material, tree, principled = new(name)
    principled.inputs["Roughness"].default_value = roughness
    for key, value in inputs.items():
        principled.inputs[key.replace("_", " ")].default_value = value
    if len(reflectances) == 1:
        spectra.assign(material, principled.inputs["Base Color"], spectrum(reflectances[0]))
    else:
        factor = noise(tree, scale, contrast)
        mixed(material, principled.inputs["Base Color"], factor, *reflectances)
    return material


def noise(tree, scale, contrast, stretch=(1.0, 1.0, 1.0), detail=6.0):
    """A noise in the object's coordinates, its contrast stretched -> socket."""
    place, mapping = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeMapping")
    mapping.inputs["Scale"].default_value = stretch
    noise = tree.nodes.new("ShaderNodeTexNoise")
    noise.inputs["Scale"].default_value, noise.inputs["Detail"].default_value = scale, detail
    tree.links.new(place.outputs["Object"], mapping.inputs[0])
    tree.links.new(mapping.outputs[0], noise.inputs["Vector"])
    return between(tree, noise.outputs["Factor" if "Factor" in noise.outputs else "Fac"], *contrast)


def between(tree, socket, low, high):
    span = tree.nodes.new("ShaderNodeMapRange")
    span.interpolation_type = "SMOOTHSTEP"
    span.inputs["From Min"].default_value, span.inputs["From Max"].default_value = low, high
    tree.links.new(socket, span.inputs["Value"])
    return span.outputs["Result"]


def height(tree, low, high):
    """From 0 to 1 between two heights of the object -> socket."""
    place, parts = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeSeparateXYZ")
    tree.links.new(place.outputs["Object"], parts.inputs[0])
    return between(tree, parts.outputs["Z"], low, high)


def product(tree, a, b, operation="MULTIPLY"):
    node = tree.nodes.new("ShaderNodeMath")
    node.operation, node.use_clamp = operation, True
    tree.links.new(a, node.inputs[0])
    tree.links.new(b, node.inputs[1])
    return node.outputs[0]


def mixed(material, socket, factor, first, second):
    """Mix two spectra (names, or a socket as the first) into a colour socket; exact, for a mix of spectra is linear."""
    tree = material.node_tree
    mix = tree.nodes.new("ShaderNodeMix")
    mix.data_type = "RGBA"
    tree.links.new(factor, mix.inputs["Factor"])
    for name, source in (("A", first), ("B", second)):
        if isinstance(source, str):
            spectra.assign(material, nodes.mixed(mix, name), spectrum(source))
        else:
            tree.links.new(source, nodes.mixed(mix, name))
    out = next(output for output in mix.outputs if output.type == "RGBA")
    if socket is not None:
        tree.links.new(out, socket)
    return out


def bump(material, socket, distance, strength=1.0):
    tree = material.node_tree
    bump = tree.nodes.new("ShaderNodeBump")
    bump.inputs["Distance"].default_value, bump.inputs["Strength"].default_value = distance, strength
    tree.links.new(socket, bump.inputs["Height"])
    for node in list(tree.nodes):
        if "Normal" in node.inputs and node.bl_idname.startswith("ShaderNodeBsdf"):
            tree.links.new(bump.outputs[0], node.inputs["Normal"])


def metal(name: str, conductor: str, roughness: float):
    material, tree, principled = new(name)
    tree.nodes.remove(principled)
    metal = tree.nodes.new("ShaderNodeBsdfMetallic")
    metal.fresnel_type = "PHYSICAL_CONDUCTOR"
    metal.inputs["Roughness"].default_value = roughness
    group = bpy.data.node_groups.get(conductor) or spectra.new_conductor(conductor, *library.conductor(conductor))
    for socket in ("IOR", "Extinction"):
        spectra.assign(material, metal.inputs[socket], group, socket)
    tree.links.new(metal.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    return material


def clear(name: str, index: str, colour: str = "", shadow: str = ""):
    """A glass or a liquid of one measured index; its shadow is lit without caustics, which would be noise.

    Vessels have many surfaces one behind the other: with dispersion each would take two thirds of the rays.
    """
    material, tree, principled = new(name)
    tree.nodes.remove(principled)
    closure = tree.nodes.new("ShaderNodeBsdfGlass")
    closure.inputs["Roughness"].default_value = 0.0
    closure.inputs["IOR"].default_value = float(library.glass(index).sampled([_SODIUM_D])[0])
    if colour:
        spectra.assign(material, closure.inputs["Color"], spectrum(colour))
    path, through, mix = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("LightPath", "BsdfTransparent", "MixShader"))
    through.inputs["Color"].default_value = (_GLASS_SHADOW,) * 3 + (1.0,)
    if shadow:
        spectra.assign(material, through.inputs["Color"], spectrum(shadow))
    aside = tree.nodes.new("ShaderNodeMath")
    aside.operation = "MAXIMUM"
    tree.links.new(path.outputs["Is Shadow Ray"], aside.inputs[0])
    tree.links.new(path.outputs["Is Diffuse Ray"], aside.inputs[1])
    tree.links.new(aside.outputs[0], mix.inputs[0])
    tree.links.new(closure.outputs[0], mix.inputs[1])
    tree.links.new(through.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    return material
