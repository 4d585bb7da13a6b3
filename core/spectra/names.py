"""What people call the illuminants of the library: words before the code under which they are known and stored.

What each is: CIE 15:2018, tables 5 to 12; the temperatures there are correlated colour temperatures in kelvin.
"""

__all__ = ["named", "parts"]

_NAMES = {
    "A": "Tungsten bulb",
    "B": "Direct sunlight at noon",
    "C": "Average daylight, older standard",
    "D50": "Daylight for prints, 5000 K",
    "D55": "Daylight of photography, 5500 K",
    "D60": "Daylight of cinema, 6000 K",
    "D65": "Daylight, 6500 K",
    "D75": "Northern sky, 7500 K",
    "ID65": "Daylight behind a window, 6600 K",
    "ID50": "Daylight behind a window, 5100 K",
    "E": "The same power everywhere",
    "FL1": "Fluorescent, daylight",
    "FL2": "Office fluorescent, cool white",
    "FL3": "Fluorescent, white",
    "FL4": "Fluorescent, warm white",
    "FL5": "Fluorescent, daylight, second",
    "FL6": "Fluorescent, light white",
    "FL7": "Broad-band fluorescent, imitates D65",
    "FL8": "Broad-band fluorescent, imitates D50",
    "FL9": "Broad-band fluorescent, cool white de luxe",
    "FL10": "Three-band fluorescent, 5000 K",
    "FL11": "Shop fluorescent, three-band, 4000 K",
    "FL12": "Three-band fluorescent, 3000 K",
    "FL3.1": "Plain fluorescent, 2930 K",
    "FL3.2": "Plain fluorescent, 3970 K",
    "FL3.3": "Plain fluorescent, 6280 K",
    "FL3.4": "De luxe fluorescent, 2900 K",
    "FL3.5": "De luxe fluorescent, 4090 K",
    "FL3.6": "De luxe fluorescent, 4890 K",
    "FL3.7": "Three-band fluorescent, 2980 K",
    "FL3.8": "Three-band fluorescent, 4010 K",
    "FL3.9": "Three-band fluorescent, 4850 K",
    "FL3.10": "Three-band fluorescent, 5000 K, second",
    "FL3.11": "Three-band fluorescent, 5850 K",
    "FL3.12": "Multi-band fluorescent, 2980 K",
    "FL3.13": "Multi-band fluorescent, 3900 K",
    "FL3.14": "Multi-band fluorescent, 5040 K",
    "FL3.15": "Fluorescent, imitates D65",
    "LED-B1": "LED, blue with phosphor, 2730 K",
    "LED-B2": "LED, blue with phosphor, 3000 K",
    "LED-B3": "LED, blue with phosphor, 4100 K",
    "LED-B4": "LED, blue with phosphor, 5110 K",
    "LED-B5": "LED, blue with phosphor, 6600 K",
    "LED-BH1": "LED, blue with phosphor, and red, 2850 K",
    "LED-RGB1": "LED, red, green and blue, 2840 K",
    "LED-V1": "LED, violet with phosphor, 2720 K",
    "LED-V2": "LED, violet with phosphor, 4070 K",
    "HP1": "Street lamp, high pressure sodium, 1960 K",
    "HP2": "High pressure sodium, better colours, 2510 K",
    "HP3": "Metal halide, 3140 K",
    "HP4": "Metal halide, 4000 K",
    "HP5": "Metal halide, 4040 K",
    "Planckian 2700 K": "Household bulb, black body",
    "Planckian 2856 K": "Tungsten bulb, black body",
    "Planckian 3200 K": "Studio tungsten, black body",
    "Kinoton 75P": "Cinema projector, xenon",
}
# Stored names that are words already, in the order in which people say them
_WORDS = {
    "Sodium (low pressure)": "Street lamp, sodium (LPS)",
    "Sodium (high pressure)": "Street lamp, sodium (HPS)",
    "Mercury": "Street lamp, mercury",
    "Metal halide": "Hall lamp, metal halide",
}


def named(name: str) -> str:
    """What people call the illuminant of that name, with its code; the name itself where it has no other.

    >>> named("FL2")
    'Office fluorescent, cool white (FL2)'
    >>> named("Sodium (low pressure)")
    'Street lamp, sodium (LPS)'
    >>> named("D 5600 K")
    'D 5600 K'
    """
    words, code = parts(name)
    return f"{words} ({code})" if code else words


def parts(name: str) -> tuple[str, str]:
    """What people call the illuminant of that name, and the code that follows it in brackets, "" for none."""
    return (_NAMES[name], name) if name in _NAMES else (_WORDS.get(name, name), "")
