"""The materials of the asset library: measured metals, glasses and liquids, paints, and metamers."""

from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

from ..addon.graph import glass, spectra
from ..core import palette
from ..core.colour import differences, spaces
from ..core.model import fresnel
from ..core.spectra import library
from ..core.spectra.spectrum import Spectrum
from . import library_ground
from . import library_terms as terms

__all__ = ["Asset", "build", "colour_words"]

_LIQUIDS = ("Water", "Ethanol", "Glycerol")
_CRYSTALS = ("Diamond", "Sapphire", "Fused silica")
_METAMERS = {"three_metamers": "Alike in D65, apart under A"}
_PAIRS = (
    ("ColorChecker: neutral 5 (.70 D)", "ColorChecker: red", "D65"),
    ("ColorChecker: foliage", "ColorChecker: magenta", "D65"),
    ("ColorChecker: blue flower", "ColorChecker: orange", "A"),
    ("ColorChecker: light skin", "ColorChecker: cyan", "FL2"),
)
# What the 99 surfaces of CIE 224 are, where that is not a paint, a print or a chip of a colour system: catalogue, the
# word before the colour, roughness, specular level, and their numbers (after TM-30-15, as luxpy, GPL-3.0, lists them)
_KINDS = (
    ("Nature", "Plant", 0.6, 0.3, (3, 4, 12, 25, 27, 30, 36, 37, 38, 77, 81, 85, 89, 91, 92, 95, 96)),
    ("Skin", "Skin", 0.45, 0.4, (15, 18)),
    ("Textiles", "Cloth", 1.0, 0.0, (1, 2, 6, 11, 16, 17, 26, 29, 32, 41, 43, 47, 57, 62, 74, 79, 82, 83, 86, 94, 98)),
    ("Plastics", "Plastic", 0.2, 0.5, (7, 14, 19, 24, 46, 53, 59, 64, 66, 67, 90, 99)),
)
# Hue in degrees of CIELAB at which each family begins
_HUES = (
    ("Pink", 345),
    ("Red", 15),
    ("Orange", 48),
    ("Yellow", 78),
    ("Green", 108),
    ("Teal", 172),
    ("Blue", 222),
    ("Purple", 290),
    ("Pink", 330),
)


@dataclass(frozen=True)
class Asset:
    """Something of the library: where it is listed, what it is, where its data come from and under which licence."""

    thing: bpy.types.ID
    catalogue: str
    description: str
    source: str
    licence: str
    tags: tuple[str, ...] = ()


def build() -> list[Asset]:
    """All materials, in an empty file."""
    return [*_metals(), *_clear(), *_chart(), *_ces(), *_ground(), *_metamers()]


def _material(name: str):
    material = bpy.data.materials.new(name)
    return material, material.node_tree, material.node_tree.nodes["Principled BSDF"]


def _metals() -> list[Asset]:
    found = []
    for name in library.conductors():
        n, k = library.conductor(name)
        material, tree, principled = _material(f"{name}, polished")
        tree.nodes.remove(principled)
        metal = tree.nodes.new("ShaderNodeBsdfMetallic")
        metal.fresnel_type = "PHYSICAL_CONDUCTOR"
        metal.inputs["Roughness"].default_value = 0.12
        group = spectra.new_conductor(name, n, k)
        for socket in ("IOR", "Extinction"):
            spectra.assign(material, metal.inputs[socket], group, socket)
        tree.links.new(metal.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
        _show(material, fresnel.normal_reflectance(n, k))
        material.metallic = 1.0
        words = f"{name} by its measured complex index of refraction; Roughness is yours to choose."
        found.append(Asset(material, "Materials/Metals", words, n.source, terms.DATABASE, ("metal", name.lower())))
    return found


def _clear() -> list[Asset]:
    found = []
    for name in library.glasses():
        index = library.glass(name)
        material, tree, principled = _material(name if name in _LIQUIDS + _CRYSTALS else f"Glass {name}")
        tree.nodes.remove(principled)
        node = tree.nodes.new("ShaderNodeGroup")
        node.node_tree = glass.new_glass(name, index)
        tree.links.new(node.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
        kind = "Liquids" if name in _LIQUIDS else "Crystals" if name in _CRYSTALS else "Glasses"
        words = f"{material.name} with its measured dispersion: white light splits at its edges."
        found.append(
            Asset(material, f"Materials/{kind}", words, index.source, terms.DATABASE, ("glass", kind.lower()[:-1]))
        )
    return found


def _show(material, reflectance: Spectrum) -> None:
    """Have the solid viewport show the colour too, which knows nothing of nodes."""
    material.diffuse_color = (*np.clip(spaces.daylight_rgb(reflectance), 0.0, 1.0), 1.0)


def _painted(name: str, spectrum: Spectrum, roughness: float, specular: float = 0.5):
    material, _, principled = _material(name)
    principled.inputs["Roughness"].default_value = roughness
    principled.inputs["Specular IOR Level"].default_value = specular
    _show(material, spectrum)
    spectra.assign(material, principled.inputs["Base Color"], spectra.new_reflectance(spectrum))
    return material


def _chart() -> list[Asset]:
    found = []
    for spectrum in library.reflectances("colorchecker"):
        name = spectrum.name.split(": ")[1].split(" (")[0].capitalize()
        material = _painted(f"{name} (ColorChecker)", spectrum, 0.9, 0.0)
        words = f"The patch “{name.lower()}” of the ColorChecker, matte."
        found.append(
            Asset(material, "Materials/ColorChecker", words, spectrum.source, terms.CHART, ("colorchecker", "matte"))
        )
    return found


def colour_words(spectrum: Spectrum) -> tuple[str, str]:
    """(family, name) of what a reflectance looks like in D65, by CIELAB: ("Red", "Deep red")."""
    xyz = spaces.rgb_to_xyz() @ spaces.daylight_rgb(spectrum)
    lightness, a, b = differences.lab(xyz, spaces.D65_WHITE)
    chroma, hue = np.hypot(a, b), np.degrees(np.arctan2(b, a)) % 360
    if chroma < 9:
        tone = "White" if lightness > 88 else "Light" if lightness > 65 else "Mid" if lightness > 35 else "Dark"
        return "Grey", "White" if tone == "White" else f"{tone} grey"
    family = next((name for name, start in sorted(_HUES, key=lambda pair: -pair[1]) if hue >= start), "Pink")
    if hue < 120 and lightness < 52 and chroma < 45 and family != "Pink":
        family = "Brown" if hue < 85 else "Olive"
    return family, f"{_tone(lightness, chroma)} {family.lower()}".strip().capitalize()


def _tone(lightness: float, chroma: float) -> str:
    if chroma > 55:
        return "vivid" if lightness > 42 else "deep"
    if lightness > 72:
        return "pale" if chroma < 35 else "light"
    if lightness < 42:
        return "dark"
    return "muted" if chroma < 28 else ""


def _ces() -> list[Asset]:
    kinds = {f"CES {number:02d}": kind for *kind, numbers in _KINDS for number in numbers}
    found = []
    for spectrum in library.reflectances("ces"):
        family, words = colour_words(spectrum)
        catalogue, kind, roughness, specular = kinds.get(spectrum.name, (f"Paints/{family}", "", 0.4, 0.5))
        name = f"{kind}, {words.lower()}" if kind else words
        material = _painted(f"{name} ({spectrum.name})", spectrum, roughness, specular)
        said = f"A measured surface, {words.lower()} in daylight: {spectrum.name} of the 99 colour evaluation samples."
        tags = (family.lower(), "ces", *([kind.lower()] if kind else []))
        found.append(Asset(material, f"Materials/{catalogue}", said, spectrum.source, terms.CES, tags))
    return found


def _ground() -> list[Asset]:
    found = []
    for code, spectrum in library_ground.spectra().items():
        catalogue, name, source = library_ground.TAKEN[code]
        own = Spectrum(spectrum.wavelengths, spectrum.values, name, source=source)
        said = f"{name}, measured outdoors ({code.rstrip('-')}), 400 to 800 nm: of one even colour, without texture."
        tags = (catalogue.lower(), *name.lower().replace(",", "").split())
        material = _painted(name, own, 1.0, 0.0)
        found.append(Asset(material, f"Materials/{catalogue}", said, source, terms.GROUND, tags))
    return found


def _metamers() -> list[Asset]:
    found = []
    for stem, words in _METAMERS.items():
        designed = palette.create(palette.read(Path(__file__).with_name("palettes") / f"{stem}.toml"))
        for entry in designed.palette.reflectances:
            material = _painted(f"{words}: {entry.spectrum.name}", entry.spectrum, 0.9, 0.0)
            said = "One of three paints that are one grey in daylight and three colours under tungsten light."
            found.append(
                Asset(material, "Materials/Metamers", said, f"palettes/{stem}.toml", terms.DESIGNED, ("metamer",))
            )
    for base, direction, light in _PAIRS:
        first = library.reflectance(base)
        other = palette.metamer(first, library.reflectance(direction), [library.illuminant(light)], 0.95)
        name = first.name.split(": ")[1].split(" (")[0].capitalize()
        for spectrum, which in ((first, "as measured"), (other, "its double")):
            own = Spectrum(spectrum.wavelengths, spectrum.values, f"{name}, {which} ({light})", source=spectrum.source)
            material = _painted(f"{name}, {which} ({light})", own, 0.9, 0.0)
            said = f"One of two paints that no eye tells apart under {light}; under other lamps they part."
            made = f"metamer of {base} under {light}, made by Relume"
            source, licence = (
                (first.source, terms.CHART)
                if which == "as measured"
                else (made, f"{terms.DESIGNED}, from: {terms.CHART}")
            )
            found.append(Asset(material, "Materials/Metamers", said, source, licence, ("metamer", light.lower())))
    return found
