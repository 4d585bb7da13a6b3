"""What every model does with difficult input: `relume stability`.

Each section says what happens, its bound, and where the limit is physical. Nothing may come back as NaN, nothing is
clamped without a word, and what cannot be done is refused by a named error.
"""

import sys
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from ..core.colour import differences
from ..core.model import bases
from ..core.model.factor_model import FactorModel
from ..core.model.relight import power_weights
from ..core.spectra import library
from ..core.spectra.arrays import Array
from ..core.spectra.spectrum import Spectrum
from . import edges, experiments, figures, hazards, reports
from .hazards import in_words, outcome

__all__ = ["main"]

CHANNELS = (3, 6, 9, 12, 15, 18, 21)


def models(channels: int) -> dict[str, FactorModel | str]:
    """{name: FactorModel, or the words with which it is refused}, for every family of models that takes a number p."""
    makers = {
        "fitted": lambda: bases.fitted(channels),
        "eq. 11": lambda: bases.sharpened(channels, "lagrange"),
        "eq. 12": lambda: bases.sharpened(channels, "nonnegative"),
        "block": lambda: bases.block(channels),
    }
    return {name: outcome(make) for name, make in makers.items()}


def stretched(reflectances: Array, albedo: float = 0.99) -> Array:
    """Reflectances (m, 81) scaled so that each reaches `albedo`."""
    return reflectances * (albedo / reflectances.max(axis=1, keepdims=True))


def exposed_difference(xyz: Array, truth: Array, white: Array) -> Array:
    """CIEDE2000 with both exposed so that the truth has half the luminance of white."""
    exposure = 0.5 * white[1] / truth[..., 1:2]
    return differences.delta_E_2000(truth * exposure, xyz * exposure, white)


def conditioning() -> reports.Section:
    """Condition numbers, and how much a matrix amplifies errors of coefficients."""
    lights = [library.illuminant(name) for family in library.cie_illuminants().values() for name in family]
    rows, gains = [], defaultdict(list)
    everything = [(p, name, model) for p in CHANNELS for name, model in models(p).items()]
    everything += [(3, "rgb", bases.rgb()), (3, "prefiltered", bases.prefiltered(library.illuminant("D65")))]
    everything += [(p, "bands", bases.bands(p)) for p in (36, 81)]
    for p, name, model in everything:
        if isinstance(model, str):
            rows.append([p, name, model, "", "", ""])
            continue
        matrices = np.stack([model.relight(light) for light in lights])
        whites = np.maximum(matrices.sum(axis=2), 1e-6)
        gain = np.linalg.norm(matrices, axis=2) / whites
        gains[name].append(gain[:, 1].max())
        rows.append(
            [
                p,
                name,
                f"{np.linalg.cond(model.filters) ** 2:.3g}",
                f"{model.filters.min() / model.filters.max():.3f}",
                f"{np.median(gain[:, 1]):.2f}",
                f"{gain[:, 1].max():.2f}",
            ]
        )
    return reports.Section(
        "Conditioning",
        in_words(
            "Relight matrices of `fitted` are fitted, so the condition of F^T F does not enter them; those of the "
            "published models pass through a pseudo-inverse, where it does. The gain is the length of the matrix's Y "
            "row: what 1 % of independent noise in every coefficient of a white becomes, in percent of Y, median and "
            "largest of the 52 CIE illuminants. The fourth column is the most negative value of the filters as a part "
            "of the largest.",
            f"No fitted model turns 1 % of noise into more than {max(gains['fitted']):.2f} % of Y; eq. 12 reaches "
            f"{max(gains['eq. 12']):.2f} %.",
            "None: noise of p channels that all carry luminance averages out as 1 / sqrt(p) at best.",
        ),
        ("p", "model", "cond(F^T F)", "lowest / highest", "gain, median", "gain, largest"),
        rows,
    )


def high_albedo(reflectances: Array) -> reports.Section:
    """Albedo 0.99 over many bounces."""
    light = library.illuminant("D65")
    weights = power_weights(light.sampled(), library.observer())
    white, values = weights.sum(axis=0), stretched(reflectances)
    sums = {
        "50 bounces": lambda s: (1 - s**50) / (1 - s) * s,
        "infinitely many": lambda s: s / (1 - s),
    }
    rows, highest = [], 0.0
    everything = [(p, name, model) for p in CHANNELS for name, model in models(p).items()]
    for p, name, model in [*everything, (36, "bands", bases.bands(36)), (81, "bands", bases.bands(81))]:
        if isinstance(model, str):
            continue
        coefficients, matrix = model.coefficients(values), model.relight(light)
        flat = model.coefficients(np.full(81, 0.99))
        row = [p, name, f"{np.abs(sums['infinitely many'](flat) / 99 - 1).max():.0e}", f"{coefficients.max():.4f}"]
        highest = max(highest, coefficients.max() if name == "fitted" else 0)
        for words, total in sums.items():
            if words == "infinitely many" and coefficients.max() >= 1:
                row.append("diverges")
                continue
            difference = exposed_difference(total(coefficients) @ matrix.T, total(values) @ weights, white)
            row.append(f"{np.median(difference):.2f} / {np.percentile(difference, 90):.2f}")
        rows.append(row)
    return reports.Section(
        "Albedo 0.99",
        in_words(
            "Reflectances stretched to a peak of 0.99: the sum of 50 bounces and of infinitely many, D65, exposed to "
            "half of white; CIEDE2000, median / 90th percentile. A flat 0.99 is exact (relative error).",
            f"Filters that are nowhere negative keep coefficients at or below 0.99 ({highest:.4f} is the highest of "
            "`fitted`), so series converge for any p. Above 1, as eq. 11 allows, a series diverges in a renderer.",
            "The width of a channel: with every bounce the peak within it decides more, and only more channels help.",
        ),
        ("p", "model", "flat 0.99", "highest coefficient", *sums),
        rows,
    )


def half_floats(reflectances: Array) -> reports.Section:
    """Coefficients kept in half precision, as an EXR may."""
    rows, worst_at = [], dict.fromkeys((1.0, 1e-2, 1e-4, 1e-6), 0.0)
    lights = [library.illuminant(name) for name in ("A", "D65", "FL11", "LED-B3")]
    for p in hazards.CHANNELS:
        model = bases.fitted(p)
        coefficients = model.coefficients(reflectances)
        row = [str(p)]
        for exposure in worst_at:
            stored = (coefficients * exposure).astype(np.float16).astype(np.float64) / exposure
            worst = 0.0
            for light in lights:
                matrix = model.relight(light)
                true, seen = (c @ matrix.T for c in (coefficients, stored))
                worst = max(worst, float(differences.delta_E_2000(true, seen, matrix.sum(axis=1)).max()))
            worst_at[exposure] = max(worst_at[exposure], worst)
            row.append(f"{worst:.3f}")
        rows.append(row)
    return reports.Section(
        "Half-precision coefficients",
        in_words(
            "Largest CIEDE2000 under A, D65, FL11 and LED-B3 when the coefficients of the reflectances were rounded to "
            "half floats, with white at 1, 0.01, 0.0001 and 0.000001 of the file's unit and the picture exposed back. "
            "Above 65504 a half is infinite, and such a file is refused by name (`core.coefficients`).",
            f"{worst_at[1.0]:.3f} with white at 1, {worst_at[1e-4]:.2f} at 0.0001.",
            "A half keeps 11 bits down to 0.00006 and steps of 0.00000006 below. Relume itself writes 32-bit floats.",
        ),
        ("p", "white 1", "white 0.01", "white 0.0001", "white 0.000001"),
        rows,
    )


def clamps() -> reports.Section:
    """What is clamped, where, and why."""
    return reports.Section(
        "What is clamped",
        "Coefficients, relight matrices and recombined pictures never are. These are, and their documentation says so: "
        "pictures for the display (0..1) and the RGB colour that a material shows without Relume (`core.spaces`); "
        "lamps of the preview, whose colour may lie outside the display's primaries (at 0); n and k of a conductor per "
        "channel, fitted to reflectances within 0..1 (`core.fresnel`); the coefficients of a lamp in another's light "
        "group, fitted as non-negative numbers (`FactorModel.emission`).",
    )


def sections(spectra: list[Spectrum], source: str) -> Iterator[reports.Section]:
    """Every hazard, on the surfaces of the spectra where it looks at surfaces."""
    reflectances = np.stack([spectrum.sampled() for spectrum in spectra])
    yield conditioning()
    yield hazards.low_rank()
    yield hazards.single_lines(reflectances)
    yield hazards.extreme_values()
    yield hazards.metameric_blacks(reflectances)
    yield high_albedo(reflectances)
    yield hazards.wavelengths()
    yield edges.narrow()
    yield edges.many_bounces()
    yield edges.absorption()
    yield half_floats(reflectances)
    yield clamps()


def draw(done: list[reports.Section], spectra: list[Spectrum], out: Path) -> None:
    """Three panels: conditioning, lines over wavelength, albedo. Raises ImportError."""
    reflectances = np.stack([spectrum.sampled() for spectrum in spectra])
    panels = []
    for name, column, title, up in (
        ("Conditioning", 2, "conditioning", "cond(F^T F)"),
        ("Albedo 0.99", 5, "albedo 0.99, infinitely many bounces", "median CIEDE2000"),
    ):
        points = defaultdict(list)
        for row in next(section for section in done if section.name == name).rows:
            if row[1] in ("fitted", "eq. 11", "eq. 12", "block") and row[column][0].isdigit():
                points[row[1]].append((row[0], float(row[column].split(" / ")[0])))
        lines = [(label, *zip(*each, strict=True)) for label, each in points.items()]
        panels.append(figures.Panel("p", lines, up, title, "y", CHANNELS))
    nm = np.arange(400, 701, 5)
    lights = [library.line(float(one)) for one in nm]
    lines = []
    for p in hazards.CHANNELS:
        errors = experiments.product_errors(bases.fitted(p), reflectances, lights)
        lines.append((f"fitted, p = {p}", nm, np.percentile(errors, 99, axis=1), "-"))
    panels.insert(1, figures.Panel("nm", lines, "99th percentile of CIEDE2000", "surfaces under one line"))
    figures.curves(out / "stability.png", panels)


def main(argv: Sequence[str] | None = None) -> int:
    """The command `relume stability` -> exit status."""
    words = "What every model does with difficult input."
    return reports.run("stability", words, "surfaces to look at", sections, draw, argv)


if __name__ == "__main__":
    sys.exit(main())
