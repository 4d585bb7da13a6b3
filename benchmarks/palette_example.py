"""The worked example of Bergner, Möller and Drew (2004), their figures 2 to 5, as four designs in `assets/palettes`.

`python -m relume.benchmarks.palette_example`

For each step: how far the targets are missed, by how much full spectra and the model of seven channels differ under
each light, the lowest and highest value of the spectrum, and its roughness, the mean size of second differences.
"""

from pathlib import Path

import numpy as np

from ..core import palette

DESIGNS = Path(__file__).resolve().parents[1] / "assets/palettes"
FIGURES = {"1_colours": 2, "2_model_error": 3, "3_smooth": 4, "4_unbounded": 5}


def main():
    print("| step | figure | targets missed by | full and model differ by | spectrum | roughness |")
    print("| --- | --- | --- | --- | --- | --- |")
    for name, figure in FIGURES.items():
        solution = palette.create(palette.read(DESIGNS / f"{name}.toml"))
        cells = palette.report(solution).cells
        spectrum = solution.state.reflectances[0]
        missed = max(cell.error for cell in cells)
        apart = ", ".join(f"{cell.model_error:.2f}" for cell in cells)
        values = f"{spectrum.min():.2f} .. {spectrum.max():.2f}"
        rough = np.abs(np.diff(spectrum, 2)).mean()
        print(f"| {name} | {figure} | ΔE {missed:.2f} | {apart} | {values} | {rough:.2f} |")


if __name__ == "__main__":
    main()
