"""What each input of Blender's shader nodes is to light: spectral, the same at all wavelengths, or neither.

The table is by node type and input identifier. A test walks the node types of the Blender that runs it and fails on
an input that is missing here.
"""

import os
from collections.abc import Collection
from enum import StrEnum

import bpy

from . import nodes

__all__ = [
    "CANNOT",
    "NOT_SPECTRAL",
    "SPECTRAL",
    "Bounds",
    "Kind",
    "bounds_of",
    "decides",
    "in_use",
    "is_animated",
    "is_missing",
    "is_shader",
    "kind_of",
    "reasons",
    "spectral_sockets",
]


class Kind(StrEnum):
    """What a spectral input holds, channel by channel."""

    COLOUR = "colour"  # light is multiplied by it
    EMISSION = "emission"  # light is sent out
    VECTOR = "vector"  # a length, a coefficient of a volume, n or k of a metal


class Bounds(StrEnum):
    """The bounds that Cycles holds a colour's RGB to before it multiplies light by it."""

    NONE = ""
    POSITIVE = "positive"  # what is below 0 counts as 0
    UNIT = "unit"  # the same, and what is above 1 counts as 1


_COLOUR = {"Color": Kind.COLOUR}
_EMISSION = {"Color": Kind.EMISSION}

SPECTRAL = {
    "ShaderNodeBackground": _EMISSION,
    "ShaderNodeBsdfAnisotropic": _COLOUR,  # Glossy
    "ShaderNodeBsdfDiffuse": _COLOUR,
    "ShaderNodeBsdfGlass": _COLOUR,
    "ShaderNodeBsdfHair": _COLOUR,
    "ShaderNodeBsdfHairPrincipled": {
        "Color": Kind.COLOUR,
        "Tint": Kind.COLOUR,
        "Absorption Coefficient": Kind.VECTOR,
    },
    "ShaderNodeBsdfMetallic": {
        "Base Color": Kind.COLOUR,
        "Edge Tint": Kind.COLOUR,
        "IOR": Kind.VECTOR,
        "Extinction": Kind.VECTOR,
    },
    "ShaderNodeBsdfPrincipled": {
        "Base Color": Kind.COLOUR,
        "Subsurface Radius": Kind.VECTOR,
        "Specular Tint": Kind.COLOUR,
        "Coat Tint": Kind.COLOUR,
        "Sheen Tint": Kind.COLOUR,
        "Emission Color": Kind.EMISSION,
    },
    "ShaderNodeBsdfRayPortal": _COLOUR,
    "ShaderNodeBsdfRefraction": _COLOUR,
    "ShaderNodeBsdfSheen": _COLOUR,
    "ShaderNodeBsdfToon": _COLOUR,
    "ShaderNodeBsdfTranslucent": _COLOUR,
    "ShaderNodeBsdfTransparent": _COLOUR,
    "ShaderNodeEeveeSpecular": {
        "Base Color": Kind.COLOUR,
        "Specular": Kind.COLOUR,
        "Emissive Color": Kind.EMISSION,
    },
    "ShaderNodeEmission": _EMISSION,
    "ShaderNodeSubsurfaceScattering": {"Color": Kind.COLOUR, "Radius": Kind.VECTOR},
    "ShaderNodeVolumeAbsorption": _COLOUR,
    "ShaderNodeVolumeCoefficients": {
        "Absorption Coefficients": Kind.VECTOR,
        "Scatter Coefficients": Kind.VECTOR,
        "Emission Coefficients": Kind.EMISSION,
    },
    "ShaderNodeVolumePrincipled": {
        "Color": Kind.COLOUR,
        "Absorption Color": Kind.COLOUR,
        "Emission Color": Kind.EMISSION,
    },
    "ShaderNodeVolumeScatter": _COLOUR,
}

# Inputs that act on all wavelengths alike, whatever the node
# fmt: off
NOT_SPECTRAL = frozenset({
    "Alpha", "Anisotropic", "Anisotropic Rotation", "Anisotropy", "Aspect Ratio", "Backscatter", "Clear Coat",
    "Clear Coat Normal", "Clear Coat Roughness", "Coat", "Coat IOR", "Coat Normal", "Coat Roughness",
    "Coat Weight", "Color Attribute", "Density", "Density Attribute", "Diameter", "Diffuse Roughness",
    "Direction", "Emission Strength", "Fac", "IOR", "Metallic", "Normal", "Offset", "Position", "R lobe",
    "Radial Roughness", "Random", "Random Color", "Random Roughness", "Rotation", "Roughness", "RoughnessU",
    "RoughnessV", "Scale", "Shader", "Shader_001", "Sheen Roughness", "Sheen Weight", "Size", "Smooth",
    "Specular IOR Level", "Strength", "Subsurface Anisotropy", "Subsurface IOR", "Subsurface Scale",
    "Subsurface Weight", "TRT lobe", "TT lobe", "Tangent", "Temperature Attribute", "Thin Wall",
    "Transmission Weight", "Transparency", "Weight",
})
# fmt: on

# Inputs from which Cycles makes a colour in RGB by itself, with no place to step in: {input: words for it}
CANNOT = {
    "Melanin": "melanin",
    "Melanin Redness": "melanin",
    "Thin Film Thickness": "thin film",
    "Thin Film IOR": "thin film",
    "Temperature": "fire",
    "Blackbody Intensity": "fire",
    "Blackbody Tint": "fire",
}

# An input that does nothing while another one is zero: {node type: {input: the other}}
_WEIGHTS = {
    "ShaderNodeBackground": {"Color": "Strength"},
    "ShaderNodeBsdfPrincipled": {
        "Subsurface Radius": "Subsurface Weight",
        "Coat Tint": "Coat Weight",
        "Sheen Tint": "Sheen Weight",
        "Emission Color": "Emission Strength",
    },
    "ShaderNodeEmission": {"Color": "Strength"},
    "ShaderNodeVolumePrincipled": {"Emission Color": "Emission Strength"},
}

# Closures that keep a negative colour
_UNBOUNDED = {
    "ShaderNodeBsdfRayPortal",
    "ShaderNodeBsdfTransparent",
    "ShaderNodeVolumeAbsorption",
    "ShaderNodeVolumePrincipled",
    "ShaderNodeVolumeScatter",
}
# What a Principled surface is wholly made of where it has no diffuse part, whose colour may be above 1
_NOT_DIFFUSE = {"Base Color": ("Metallic", "Transmission Weight", "Subsurface Weight"), "Specular Tint": ("Metallic",)}

# Numbers that say whether other inputs are seen, how they are bounded, and what cannot be made spectral
_DECIDING = {weight for weights in _WEIGHTS.values() for weight in weights.values()}
_DECIDING |= {part for parts in _NOT_DIFFUSE.values() for part in parts}
_DECIDING |= {"Blackbody Intensity", "Thin Film Thickness"}

# Textures whose colours Cycles computes in RGB
_RGB_TEXTURES = {
    "ShaderNodeTexSky": "the sky is computed in RGB: it takes part as RGB, upsampled on D65",
    "ShaderNodeBlackbody": "this blackbody is mixed with other colours: it takes part as RGB, upsampled on D65",
    "ShaderNodeWavelength": "the colour of a wavelength is computed in RGB: it takes part as RGB, upsampled on D65",
}
_THIN_FILM = "the interference of a thin film is computed in RGB: red, green and blue stand for thirds of the spectrum"
_MELANIN = "melanin is computed in RGB: red, green and blue stand for thirds of the spectrum"
_FIRE = "the glow of this fire is computed in RGB: red, green and blue stand for thirds of the spectrum"
_SCRIPT = "a script (OSL) can make colours of its own: those stay RGB"
_UNKNOWN = "this version of Relume does not know {}: taken as a colour"


# Nodes that join shaders, or pass them on
_JOINTS = {"GROUP", "CUSTOM GROUP", "MIX_SHADER", "ADD_SHADER", "HOLDOUT", "SCRIPT"}


_unknown = {}  # by kind of node: whether it is a shader that is not in the table


def _is_unknown_shader(node) -> bool:
    kind = node.bl_idname
    if kind not in _unknown:
        _unknown[kind] = (
            kind.startswith("ShaderNode")
            and kind not in SPECTRAL
            and node.type not in _JOINTS
            and any(socket.type == "SHADER" for socket in node.outputs)
        )
    return _unknown[kind]


def kind_of(socket) -> Kind | None:
    """What an input of a shader node holds; None for one that is not spectral.

    Colours of shaders that this version does not know count as colours.
    """
    node = socket.node
    if nodes.role(node) == "glass":
        return Kind.COLOUR if socket.identifier == node.inputs["Color"].identifier else None
    known = SPECTRAL.get(node.bl_idname)
    if known is not None and (socket.identifier in known or socket.identifier in CANNOT):
        return known.get(socket.identifier)
    if socket.type == "RGBA" and (known is not None or _is_unknown_shader(node)):
        return Kind.COLOUR
    return None


def is_shader(node) -> bool:
    """Whether a node is a closure, known or not."""
    return node.bl_idname in SPECTRAL or _is_unknown_shader(node)


def decides(socket) -> bool:
    """Whether the value of an input of a closure, where nothing is linked, says what should be before any of them."""
    return socket.type in {"RGBA", "VECTOR"} or socket.name in _DECIDING


def spectral_sockets(node) -> list:
    """The spectral inputs of a shader node in the mode that it is in; none for a node that is no closure."""
    if not is_shader(node) and (node.bl_idname != "ShaderNodeGroup" or nodes.role(node) != "glass"):
        return []
    return [s for s in node.inputs if s.type in {"RGBA", "VECTOR"} and not s.is_unavailable and kind_of(s)]


def bounds_of(socket) -> Bounds:
    """The bounds that Cycles holds the RGB of a spectral input to, so that upsampling can do the same.

    Channels of a spectrum would be held one by one, which is another colour.
    """
    node = socket.node
    if kind_of(socket) is not Kind.COLOUR or node.bl_idname in _UNBOUNDED:
        return Bounds.NONE
    if node.bl_idname == "ShaderNodeBsdfMetallic":
        return Bounds.UNIT
    if node.bl_idname == "ShaderNodeBsdfPrincipled":
        parts = [node.inputs[name] for name in _NOT_DIFFUSE.get(socket.identifier, ())]
        if any(not part.is_linked and part.default_value >= 1.0 for part in parts):
            return Bounds.UNIT
    return Bounds.POSITIVE


def in_use(socket, animated: Collection[str] = ()) -> bool:
    """Whether a spectral input can be seen: not where the weight that goes with it is zero, nor where it emits black.

    animated: paths of the values of this tree that are animated or driven.
    """
    weight = _WEIGHTS.get(socket.node.bl_idname, {}).get(socket.identifier)
    if weight is not None and not _can_differ_from(socket.node.inputs[weight], 0.0, animated):
        return False
    if kind_of(socket) is not Kind.EMISSION:
        return True
    socket = nodes.holder(socket)
    return socket.is_linked or is_animated(socket, animated) or any(socket.default_value[:3])


def is_animated(socket, animated: Collection[str]) -> bool:
    """Whether the value of an input is among the animated paths."""
    return bool(animated) and socket.path_from_id("default_value") in animated


def _can_differ_from(socket, value: float, animated: Collection[str]) -> bool:
    return socket.is_linked or socket.default_value != value or is_animated(socket, animated)


def reasons(node) -> list[str]:
    """Why a node cannot be made spectral, in the artist's words; empty for most."""
    kind = node.bl_idname
    found = [_RGB_TEXTURES[kind]] if kind in _RGB_TEXTURES else []
    if kind == "ShaderNodeScript":
        found.append(_SCRIPT)
    elif kind == "ShaderNodeBsdfHairPrincipled":
        if node.parametrization == "MELANIN":
            found.append(_MELANIN)
    elif kind == "ShaderNodeVolumePrincipled" and _can_differ_from(node.inputs["Blackbody Intensity"], 0.0, ()):
        found.append(_FIRE)
    if kind in SPECTRAL:
        film = node.inputs.get("Thin Film Thickness")
        if film is not None and _can_differ_from(film, 0.0, ()):
            found.append(_THIN_FILM)
    elif _is_unknown_shader(node):
        found.append(_UNKNOWN.format(node.bl_label))
    elif kind in {"ShaderNodeTexImage", "ShaderNodeTexEnvironment"} and is_missing(node.image):
        found.append(f"its image {node.image.name!r} is missing: Cycles shows it pink")
    return found


def is_missing(image) -> bool:
    """Whether the file of an image cannot be read."""
    if image is None or image.source != "FILE" or image.packed_file is not None or image.has_data:
        return False
    return not os.path.isfile(bpy.path.abspath(image.filepath, library=image.library))
