"""What a camera makes of two metamers that the eye takes for one: python examples/see_through_a_camera.py"""

import numpy as np

from relume.core import Light, Mix, Spectrum, bases, library, palette, recombination, spaces

grey = Spectrum(np.array([380.0, 780.0]), np.array([0.4, 0.4]), "grey")
daylight = library.illuminant("D65")
pair = [grey, palette.metamer(grey, library.reflectance("ColorChecker: red"), [daylight])]

model = bases.fitted(12)
for observer in ("CIE 1931 2°", "Nikon 5100 (NPL)"):
    mix = Mix({"sun": Light(daylight)}, observer=observer)
    xyz = [recombination.color_of(model, mix, [model.coefficients(each)]) for each in pair]
    first, second = (spaces.srgb_encoded(spaces.xyz_to_rgb() @ each) for each in xyz)
    print(f"{observer:<18} {np.round(255 * first)} and {np.round(255 * second)}")
