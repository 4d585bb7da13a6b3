"""The lamps and objects of the asset library."""

import math

import bpy

from ..addon.graph import lamps
from ..core.colour import spaces
from ..core.picture import drawing
from ..core.spectra import library
from . import library_terms as terms
from .library_materials import Asset

__all__ = ["build"]

_CARDS = f"{terms.MADE}; reflectances: {terms.CHART}"
# Name: (catalogue, illuminant, kelvin that comes nearest or 0 where none does, shape, size in metres, Blender's watts)
LAMPS = {
    "Candle": ("Flames", "Planckian 1900 K", 1900, "POINT", 0.01, 1.2),
    "Oil lamp": ("Flames", "Planckian 2000 K", 2000, "POINT", 0.02, 3.0),
    "Light bulb, 60 W": ("Household", "Planckian 2700 K", 2700, "POINT", 0.03, 9.0),
    "Light bulb, soft white": ("Household", "60 A/W (Soft White)", 2750, "POINT", 0.03, 9.0),
    "Light bulb, neodymium": ("Household", "Neodimium Incandescent", 2750, "POINT", 0.03, 8.0),
    "Halogen spot": ("Household", "Planckian 3000 K", 3000, "SPOT", 0.03, 30.0),
    "LED bulb, warm": ("Household", "LED-B1", 2733, "POINT", 0.03, 9.0),
    "LED bulb, neutral": ("Household", "LED-B3", 4103, "POINT", 0.03, 10.0),
    "LED panel, cool": ("Household", "LED-B5", 6598, "AREA", 0.6, 35.0),
    "LED panel, high fidelity": ("Household", "LED-V2", 4070, "AREA", 0.6, 35.0),
    "LED, red green blue": ("Household", "LED-RGB1", 2840, "AREA", 0.3, 20.0),
    "Office tube, cool white (FL2)": ("Office", "FL2", 4230, "TUBE", 1.2, 36.0),
    "Office tube, daylight (FL1)": ("Office", "FL1", 6430, "TUBE", 1.2, 36.0),
    "Office tube, broad-band (FL7)": ("Office", "FL7", 6500, "TUBE", 1.2, 36.0),
    "Shop tube, three-band (FL11)": ("Office", "FL11", 4000, "TUBE", 1.2, 40.0),
    "Shop tube, warm three-band (FL12)": ("Office", "FL12", 3000, "TUBE", 1.2, 40.0),
    "Street lamp, sodium": ("Streets and halls", "Sodium (low pressure)", 1750, "AREA", 0.4, 120.0),
    "Street lamp, sodium, high pressure": ("Streets and halls", "Sodium (high pressure)", 2000, "AREA", 0.25, 120.0),
    "Street lamp, mercury": ("Streets and halls", "Mercury", 6000, "AREA", 0.25, 90.0),
    "Stadium, metal halide": ("Streets and halls", "Metal halide", 4200, "SPOT", 0.4, 900.0),
    "Cinema projector, xenon": ("Stage and film", "Kinoton 75P", 6000, "SPOT", 0.05, 300.0),
    "Stage head, tungsten": ("Stage and film", "Planckian 3200 K", 3200, "SPOT", 0.15, 250.0),
    "Stage head, LED": ("Stage and film", "4-LED-1 (461/526/576/624)", 3300, "SPOT", 0.15, 250.0),
    "Softbox, daylight LED": ("Stage and film", "LED-B4", 5109, "AREA", 1.0, 120.0),
    "Laser, violet (405 nm)": ("Lasers", "405 nm", 0, "LASER", 0.002, 20.0),
    "Laser, blue (450 nm)": ("Lasers", "450 nm", 0, "LASER", 0.002, 20.0),
    "Laser, cyan (488 nm)": ("Lasers", "488 nm", 0, "LASER", 0.002, 20.0),
    "Laser, green (532 nm)": ("Lasers", "532 nm", 0, "LASER", 0.002, 20.0),
    "Laser, yellow (589 nm)": ("Lasers", "589 nm", 0, "LASER", 0.002, 20.0),
    "Laser, red (633 nm)": ("Lasers", "633 nm", 0, "LASER", 0.002, 20.0),
    "Laser, deep red (660 nm)": ("Lasers", "660 nm", 0, "LASER", 0.002, 20.0),
    "North window": ("Daylight", "D75", 7500, "AREA", 1.4, 120.0),
    "Overcast window": ("Daylight", "D65", 6504, "AREA", 1.4, 150.0),
    "Sun at noon": ("Daylight", "D55", 5500, "SUN", 0.0093, 4.0),
    "Sun in the morning": ("Daylight", "D50", 5003, "SUN", 0.0093, 2.5),
    "Setting sun": ("Daylight", "Planckian 2400 K", 2400, "SUN", 0.0093, 1.2),
}
_BOOTH = {"D65": ("D65", 6504), "A": ("A", 2856), "TL84": ("FL11", 4000), "CWF": ("FL2", 4230)}


def build(paints: dict) -> list[Asset]:
    """Lamps and objects. paints: {reflectance: material} for the objects."""
    return [*(_lamp(name, *row) for name, row in LAMPS.items()), *_cards(paints), _booth(paints)]


def _light(name, illuminant, kelvin, shape, size, watts):
    """A light object that says which illuminant it is.

    Without Relume it has the colour of the nearest black body, and a laser that of its line: where all light is of one
    wavelength, a coloured lamp is only dimmer.
    """
    light = bpy.data.lights.new(name, {"TUBE": "AREA", "LASER": "SPOT"}.get(shape, shape))
    light.energy = watts
    if kelvin:
        light.use_temperature, light.temperature = True, kelvin
    else:
        light.color = spaces.srgb_decoded(drawing.swatch(library.illuminant(illuminant)))
    if shape == "AREA":
        light.shape, light.size = "SQUARE", size
    elif shape == "TUBE":
        light.shape, light.size, light.size_y = "RECTANGLE", size, 0.03
    elif shape == "LASER":
        light.shadow_soft_size, light.spot_size, light.spot_blend = size, math.radians(0.5), 0.0
    elif shape == "SUN":
        light.angle = size
    else:
        light.shadow_soft_size = size
    light[lamps.ILLUMINANT] = illuminant
    thing = bpy.data.objects.new(name, light)
    thing.lightgroup = name.replace(".", " ")
    return thing


def _lamp(name, family, illuminant, kelvin, shape, size, watts) -> Asset:
    words = f"{name}: its light group starts with the illuminant “{illuminant}”."
    source, licence = terms.of_lamp(illuminant)
    thing = _light(name, illuminant, kelvin, shape, size, watts)
    return Asset(thing, f"Lamps/{family}", words, source, licence, ("lamp", family.lower()))


def _flat(corners, faces, name, materials):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(corners, [], [face for face, _ in faces])
    for material in materials:
        mesh.materials.append(material)
    for polygon, (_, index) in zip(mesh.polygons, faces, strict=True):
        polygon.material_index = index
    return bpy.data.objects.new(name, mesh)


def _rectangle(corners, faces, left, right, low, high, index, height=0.0):
    first = len(corners)
    corners += [(left, low, height), (right, low, height), (right, high, height), (left, high, height)]
    faces.append(((first, first + 1, first + 2, first + 3), index))


def _cards(paints) -> list[Asset]:
    grey, white = paints["ColorChecker: neutral 5 (.70 D)"], paints["ColorChecker: white 9.5 (.05 D)"]
    black = paints["ColorChecker: black 2 (1.5 D)"]
    found = []
    for name, material, words in (
        ("Grey card", grey, "A card of the measured grey “neutral 5”, which reflects a fifth: for exposure."),
        ("White card", white, "A card of the measured white of the ColorChecker: for white balance."),
    ):
        corners, faces = [], []
        _rectangle(corners, faces, -0.1, 0.1, -0.127, 0.127, 0)
        found.append(Asset(_flat(corners, faces, name, [material]), "Objects", words, "BabelColor average", _CARDS))
    chart = [paints[spectrum.name] for spectrum in library.reflectances("colorchecker")]
    corners, faces = [], []
    _rectangle(corners, faces, -0.145, 0.145, -0.1, 0.1, 24)
    for k in range(24):
        x, y = -0.1375 + 0.0467 * (k % 6), 0.0475 - 0.0467 * (k // 6)
        _rectangle(corners, faces, x, x + 0.041, y, y + 0.041, k, 0.0005)
    thing = _flat(corners, faces, "ColorChecker chart", [*chart, black])
    words = "The 24 patches of the ColorChecker in their measured reflectances."
    return [*found, Asset(thing, "Objects", words, "BabelColor average", _CARDS, ("chart",))]


def _booth(paints) -> Asset:
    """A light booth: an open box of neutral grey with four lamps in its ceiling, each in a light group of its own."""
    collection = bpy.data.collections.new("Light booth")
    wide, deep, high = 0.35, 0.25, 0.55
    corners = [(x, y, z) for z in (0, high) for x, y in ((-wide, -deep), (wide, -deep), (wide, deep), (-wide, deep))]
    faces = [((0, 1, 2, 3), 0), ((7, 6, 5, 4), 0), ((3, 2, 6, 7), 0), ((0, 3, 7, 4), 0), ((2, 1, 5, 6), 0)]
    box = _flat(corners, faces, "Light booth", [paints["ColorChecker: neutral 6.5 (.44 D)"]])
    collection.objects.link(box)
    for k, (name, (illuminant, kelvin)) in enumerate(_BOOTH.items()):
        lamp = _light(f"Booth {name}", illuminant, kelvin, "TUBE", 0.55, 6.0)
        lamp.location = (0.0, -0.12 + 0.08 * k, high - 0.01)
        lamp.parent = box
        collection.objects.link(lamp)
    words = "A light booth with four lamps, D65, A, TL84 and cool white: mute and solo them in the mixer."
    return Asset(collection, "Objects", words, "BabelColor average; CIE 15", _CARDS, ("booth",))
