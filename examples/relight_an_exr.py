"""Relight a coefficient EXR from Python: python examples/relight_an_exr.py ROOM.exr EVENING.exr

The file is what `relume render` wrote, or a multilayer EXR of any Blender that rendered a scene which is set up.
"""

import sys
from pathlib import Path

import numpy as np
import OpenImageIO as oiio

from relume.core import Light, coefficients, library, recombination

source, target = map(Path, sys.argv[1:])
image = coefficients.read(source)

# As it was lit, but for the first light group: that shines as a low-pressure sodium lamp of half the brightness
lights = dict(image.mix().lights)
first = next(iter(lights))
lights[first] = Light(library.illuminant("Sodium (low pressure)"), gain=0.5)

matrices = recombination.recombination_matrices(image.model, image.mix(lights, white_balance=0.0))
picture = coefficients.recombine(list(image.groups.values()), matrices)  # (height, width, 3), linear

width, height = image.size
out = oiio.ImageOutput.create(str(target))
out.open(str(target), oiio.ImageSpec(width, height, 3, "float"))
out.write_image(np.ascontiguousarray(picture))
out.close()
print(f"{target}: {first} under sodium")
