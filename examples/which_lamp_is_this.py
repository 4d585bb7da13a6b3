"""Which lamps of the library come nearest to one that was measured: python examples/which_lamp_is_this.py LAMP.csv"""

import sys
from pathlib import Path

import numpy as np

from relume.core import files, library, measure

paints = np.stack([paint.sampled() for paint in library.reflectances("colorchecker")])
cmfs = library.observer()


def seen(lamp):
    """(24, 3) XYZ of the ColorChecker in a lamp's light, and its white."""
    power = lamp.sampled()
    weights = power[:, None] * cmfs / (power @ cmfs[:, 1])
    return paints @ weights, weights.sum(axis=0)


measured = files.illuminant(Path(sys.argv[1]))
colours, white = seen(measured)
apart = {}
for name in {name for family in library.illuminants().values() for name in family}:
    apart[name] = float(np.mean(measure.delta_E_2000(seen(library.illuminant(name))[0], colours, white)))
print(f"nearest to {measured.name}, by the mean CIEDE2000 of the ColorChecker:")
for name in sorted(apart, key=apart.__getitem__)[:5]:
    print(f"{apart[name]:6.2f}  {name}")
