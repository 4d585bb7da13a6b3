"""Every shot of a folder under every lamp of a list, in one go: python examples/relight_a_batch.py FOLDER OUT LAMP ...

For a folder on the command line alone, `relume relight` does it; this is for programs that go on with the pictures.
"""

import sys
from pathlib import Path

import numpy as np

from relume.core import Light, coefficients, library, recombination, spaces

folder, out, *names = sys.argv[1:]
lamps = {name: library.illuminant(name) for name in names}
Path(out).mkdir(parents=True, exist_ok=True)
for path in sorted(Path(folder).glob("*.exr")):
    image = coefficients.read(path)
    for name, lamp in lamps.items():
        mix = image.mix({group: Light(lamp) for group in image.groups}, white_balance=0.0)
        matrices = recombination.recombination_matrices(image.model, mix)
        picture = coefficients.recombine(list(image.groups.values()), matrices)
        np.save(Path(out) / f"{path.stem}_{name}.npy", np.uint8(255 * spaces.srgb_encoded(picture) + 0.5))
        print(f"{path.stem} under {name}: mean {picture.mean():.3f}")
