"""Difficult spectra, and what the models do with them; sections of `relume stability`."""

from collections import defaultdict
from collections.abc import Callable
from typing import Any

import numpy as np

from ..core import palette
from ..core.colour import differences
from ..core.errors import RelumeError
from ..core.model import bases
from ..core.model.relight import power_weights
from ..core.spectra import library
from ..core.spectra.arrays import Array
from ..core.spectra.spectrum import WAVELENGTHS, Spectrum
from . import experiments, reports

__all__ = [
    "CHANNELS",
    "extreme_values",
    "in_words",
    "low_rank",
    "metameric_blacks",
    "outcome",
    "single_lines",
    "wavelengths",
]

CHANNELS = (3, 6, 9, 12, 15)
# Air wavelengths in nm and rough relative strengths of the lines of a low-pressure mercury lamp.
MERCURY = {404.66: 0.4, 435.83: 1.0, 546.07: 0.9, 576.96: 0.2, 579.07: 0.2}
SODIUM = {588.995: 2.0, 589.592: 1.0}
LASERS = (405, 450, 532, 589, 650)


def outcome(function: Callable[..., Any], *arguments: Any) -> Any:
    """What a function returns, or the refusal as "Error: message"; any other exception is a fault and is raised."""
    try:
        return function(*arguments)
    except RelumeError as error:
        return f"{type(error).__name__}: {error}"


def in_words(happens: str, bound: str, limit: str) -> str:
    """The words of a section."""
    return f"**What happens.** {happens}\n\n**Bound.** {bound}\n\n**Physical limit.** {limit}"


def low_rank() -> reports.Section:
    """Data of lower rank than p."""
    greys = [Spectrum(WAVELENGTHS, np.full(81, level), f"grey {level}") for level in (0.2, 0.5, 0.8)]
    patches = library.reflectances("colorchecker")
    daylight = library.illuminant("D65")
    unseen = np.stack([spectrum.sampled() for spectrum in library.reflectances("tcs")])
    rows, elsewhere = [], []
    for words, own in (("3 greys, rank 1", greys), ("2 colours, rank 2", patches[:2]), ("the chart", patches)):
        for method in ("lagrange", "nonnegative"):
            made = outcome(bases.sharpened, 9, method, [daylight], own)
            rows.append([f"sharpened {method}", words, made if isinstance(made, str) else "made", ""])
        model = bases.scene(9, own, [daylight])
        inside = np.stack([spectrum.sampled() for spectrum in own])
        errors = [experiments.product_errors(model, s, [daylight], 2) for s in (inside, unseen)]
        elsewhere.append(errors[1].max())
        rows.append(["scene", words, f"{errors[0].max():.3f}", f"{errors[1].max():.3f}"])
    return reports.Section(
        "Data of lower rank than p",
        in_words(
            "Nine channels for data of few independent components, D65, largest CIEDE2000 of two bounces, on the data "
            "and on the 14 test colours of CIE 13.3. A scene model gives the general training set 2 % of the weight, "
            "so what the data leave open stays near the general filters.",
            "The published bases are refused beyond the components above 0.1 % of the first; a scene model is made for "
            f"any data, and errs by at most {max(elsewhere):.2f} on the test colours here.",
            "Data of rank r say nothing about colours outside their span: those come from the general set alone.",
        ),
        ("model", "data", "outcome", "test colours"),
        rows,
    )


def narrow_lights() -> dict[str, tuple[Array, dict[float, float]]]:
    """Lights of lines -> {name: (values (81,), {wavelength in nm: power})}."""
    fine = np.arange(585, 593.01, 0.1)
    band = Spectrum(fine, np.exp(-4 * np.log(2) * (fine - 589) ** 2), "589 nm, 1 nm wide", "illuminant")
    lights = {"sodium doublet": SODIUM, "mercury": MERCURY} | {f"laser {nm} nm": {nm: 1.0} for nm in LASERS}
    on_grid = {
        name: (sum(power * library.line(nm).sampled() for nm, power in lines.items()), lines)
        for name, lines in lights.items()
    }
    return on_grid | {band.name: (band.sampled(), dict(zip(band.wavelengths, band.values, strict=True)))}


def grid_shift(white: Array, lines: dict[float, float]) -> float:
    """Distance in CIE 1976 u'v' of `white` (3,) from the colour of the lines, by matching functions at 1 nm."""
    functions = library.colour_science().MSDS_CMFS[library.OBSERVERS[library.OBSERVER]]
    table = functions.values.T
    true = np.array(list(lines.values())) @ [[np.interp(nm, functions.wavelengths, c) for c in table] for nm in lines]
    u_v = [np.array([4 * x, 9 * y]) / (x + 15 * y + 3 * z) for x, y, z in (white, true)]
    return float(np.linalg.norm(u_v[0] - u_v[1]))


def single_lines(reflectances: Array) -> reports.Section:
    """Lights of single lines, seen directly and on surfaces."""
    daylight = library.illuminant("D65")
    rows, worst = [], defaultdict(list)
    for name, (light, lines) in narrow_lights().items():
        weights = power_weights(light, library.observer())
        white, truth = weights.sum(axis=0), reflectances @ weights
        for p in CHANNELS:
            model = bases.fitted(p)
            matrix = model.relight(light)
            borrowed = model.relight(daylight) @ model.emission(light, daylight)
            xyz = model.coefficients(reflectances) @ matrix.T
            difference = np.percentile(differences.delta_E_2000(truth, xyz, white), 99)
            worst[p].append(difference)
            lightness = np.abs(differences.lab(xyz, white) - differences.lab(truth, white))[:, 0]
            rows.append(
                [
                    name,
                    p,
                    f"{grid_shift(white, lines):.4f}" if p == CHANNELS[0] else "",
                    f"{differences.delta_E_2000(matrix.sum(axis=1), white, white):.1e}",
                    f"{differences.delta_E_2000(borrowed, white, white):.2f}",
                    f"{difference:.2f}",
                    f"{np.percentile(lightness, 99):.2f}",
                ]
            )
    return reports.Section(
        "Single lines",
        in_words(
            "Lights of one or a few lines. Seen directly they are exact by constraint on the 5 nm grid, which keeps a "
            "line's power and centroid; the first row of each light says how far the grid moves its chromaticity "
            "(0.004 is just noticeable). In a light group that is relit by D65 a line becomes the nearest that "
            "non-negative coefficients reach. On surfaces: 99th percentiles. Under a single line hue and chroma are "
            "right, lightness errs.",
            f"On surfaces p99 is at most {max(worst[9]):.1f} at p = 9 and {max(worst[15]):.1f} at p = 15. Directly, in "
            "its own light group: rounding. In another's group: none for lines that the channels do not span; give "
            "such a lamp its own.",
            "The width of a channel: p numbers cannot say what a reflectance is at one wavelength.",
        ),
        ("light", "p", "grid, u'v'", "direct", "direct, D65's group", "on surfaces", "lightness, on surfaces"),
        rows,
    )


def extreme_values() -> reports.Section:
    """Spectra very small, very large, zero, negative and undefined."""
    model = bases.fitted(9)
    red, light = library.reflectance("ColorChecker: red").sampled(), library.illuminant("FL11").sampled()
    coefficients, matrix = model.coefficients(red), model.relight(light)
    rows = []
    for scale in (1e-300, 1e-30, 1e30, 1e300):
        error = np.abs(model.coefficients(red * scale) / scale / coefficients - 1).max()
        rows.append([f"reflectance times {scale:g}", f"coefficients scale, relative error {error:.0e}"])
        error = np.abs(model.relight(light * scale) - matrix).max()
        rows.append([f"illuminant times {scale:g}", f"the same relight matrix within {error:.0e}"])
    dark, nothing = np.zeros(81), [np.nan] * 81
    rows.append(["reflectance of zero", f"coefficients from {model.coefficients(dark).min()} to 0.0"])
    black = palette.metameric_black(light, [library.illuminant("E")])
    partly = light - 0.05 * light.max()
    undefined = np.where(WAVELENGTHS == 500, np.nan, light)
    for words, refused in {
        "illuminant of zero": lambda: model.relight(dark),
        "illuminant that is a metameric black": lambda: model.relight(black),
        "illuminant below zero everywhere": lambda: model.relight(-light),
        "illuminant below zero in places": lambda: f"matrix finite: {np.isfinite(model.relight(partly)).all()}",
        "NaN in an array": lambda: model.coefficients(nothing),
        "NaN in a Spectrum": lambda: Spectrum(WAVELENGTHS, undefined, "measured"),
        "infinity in an illuminant": lambda: model.relight(np.where(WAVELENGTHS == 500, np.inf, light)),
        "NaN in coefficients": lambda: model.reconstruct(np.full(9, np.nan)),
        "difference under a white of zero": lambda: differences.delta_E_2000(red[:3], red[:3], dark[:3]),
        "filters with NaN": lambda: type(model)("own", WAVELENGTHS, np.full((81, 3), np.nan)),
    }.items():
        rows.append([words, outcome(refused)])
    return reports.Section(
        "Extreme values",
        in_words(
            "Scaling is exact; an illuminant's power cancels before anything is fitted.",
            "Rounding, from 1e-300 to 1e300. Beyond, a float overflows: infinity is refused like NaN.",
            "None. A light that is negative in places is taken as given; one without visible power has no colour.",
        ),
        ("input", "outcome"),
        rows,
    )


def metameric_blacks(reflectances: Array) -> reports.Section:
    """Reflectances that are invisible under D65, which are negative in places, seen under D65."""
    daylight = library.illuminant("D65")
    black = palette.metameric_black(reflectances, [daylight])
    rows, leaks, clamped = [], {}, {}
    for p in CHANNELS:
        model = bases.fitted(p)
        coefficients = model.coefficients(black)
        to_y = 100 * model.relight(daylight)[1]
        leaks[p], clamped[p] = np.abs(coefficients @ to_y), np.abs(np.maximum(coefficients, 0) @ to_y)
        rows.append([p, f"{coefficients.min():.3f}", f"{leaks[p].max():.2f}", f"{clamped[p].max():.2f}"])
    return reports.Section(
        "Negative spectra",
        in_words(
            "The metameric blacks of the reflectances under D65, which are negative in places and whose true Y is 0. "
            "The lowest coefficient, and the largest Y that leaks (white is 100), with negative coefficients kept as "
            "this library does, and set to zero as a renderer may.",
            f"Kept, Y leaks by at most {max(leaks[9]):.2f} at p = 9; set to zero, by {max(clamped[9]):.1f}.",
            "No surface reflects less than nothing: add the black to a reflectance that keeps the sum in 0..1 "
            "(`palette.metamer`).",
        ),
        ("p", "lowest coefficient", "Y leaked", "Y leaked if clamped"),
        rows,
    )


def wavelengths() -> reports.Section:
    """Wavelengths missing, irregular, reversed and outside the range."""
    model, light = bases.fitted(9), library.illuminant("FL11")
    matrix, white = model.relight(light), power_weights(light.sampled(), library.observer()).sum(axis=0)
    fine = np.arange(300.0, 1000.5, 1)
    values = 0.1 + 0.8 / (1 + np.exp((580 - fine) / 15))  # an orange
    true = matrix @ model.coefficients(Spectrum(fine, values))
    rng = np.random.default_rng(0)
    cuts = {
        "300 to 1000 nm, 1 nm": np.ones(fine.size, bool),
        "380 to 780 nm": (fine >= 380) & (fine <= 780),
        "400 to 700 nm: the ends are held": (fine >= 400) & (fine <= 700),
        "every 10 nm": fine % 10 == 0,
        "every 20 nm": fine % 20 == 0,
        "1 sample in 5, at random": rng.random(fine.size) < 0.2,
        "500 to 560 nm missing": (fine < 500) | (fine > 560),
        "560 to 620 nm missing": (fine < 560) | (fine > 620),
        "one sample: flat": fine == 580,
    }
    rows, seen_as = [], {}
    for words, kept in cuts.items():
        for order, step in (("", 1), (", reversed", -1)):
            if order and words != "every 10 nm":
                continue
            spectrum = Spectrum(fine[kept][::step], values[kept][::step], "orange")
            seen = matrix @ model.coefficients(spectrum)
            seen_as[words] = differences.delta_E_2000(true, seen, white)
            rows.append([words + order, f"CIEDE2000 {seen_as[words]:.3f}"])
    for words, samples in {
        "infrared only": (fine[fine > 800], values[fine > 800]),
        "a wavelength twice": ([400, 500, 500], [0.1, 0.2, 0.3]),
        "a wavelength of NaN": ([400, np.nan], [0.1, 0.2]),
        "a negative wavelength": ([-400, 500], [0.1, 0.2]),
        "more values than wavelengths": ([400, 500], [0.1, 0.2, 0.3]),
        "no samples": ([], []),
    }.items():
        nm, parts = (np.array(each, float) for each in samples)
        rows.append([words, outcome(lambda nm=nm, parts=parts: model.coefficients(Spectrum(nm, parts, "orange")))])
    infrared = Spectrum(np.array([900, 1000]), np.ones(2), "lamp", "illuminant")
    rows.append(["an illuminant of infrared only", outcome(lambda: model.relight(infrared))])
    rows.append(["a line at 900 nm", outcome(lambda: library.line(900))])
    return reports.Section(
        "Wavelengths",
        in_words(
            "One reflectance with an edge at 580 nm, given in parts, under FL11 at p = 9. Between samples it is "
            "interpolated linearly, beyond them it keeps its end values; an illuminant is zero beyond its own. Order "
            "does not matter.",
            f"Sampled every 10 nm: CIEDE2000 {seen_as['every 10 nm']:.2f}. A gap costs what the table says.",
            "What was not measured cannot be known: a gap over an edge, or one sample for all.",
        ),
        ("samples", "outcome"),
        rows,
    )
