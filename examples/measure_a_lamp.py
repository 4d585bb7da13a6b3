"""What a lamp that was measured does to paints: python examples/measure_a_lamp.py LAMP.csv OUT.csv"""

import sys
from pathlib import Path

from relume.core import bases, files, library, spaces

lamp, target = files.illuminant(Path(sys.argv[1])), Path(sys.argv[2])
matrix = spaces.xyz_to_rgb() @ bases.fitted(9).relight(lamp)

lines = ["paint,red,green,blue"]
for paint in library.reflectances("colorchecker"):
    rgb = spaces.srgb_encoded(matrix @ bases.fitted(9).coefficients(paint))
    lines.append(",".join([f'"{paint.name}"', *(f"{255 * value:.0f}" for value in rgb)]))
target.write_text("\n".join(lines) + "\n", encoding="utf-8")
print(f"{target}: {len(lines) - 1} paints under {lamp.name}")
