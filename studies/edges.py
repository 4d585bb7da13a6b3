"""What models do at the edges: gels, LEDs, saturated paints, narrow bands, lines, albedo, depth.

Sections of `relume stability`. Every difference is to full spectra, integrated at 1 nm, and stands beside the linear
limit: what the best relight matrices for these very spectra would leave, which no other fit of theirs can better.
"""

from collections.abc import Callable, Sequence

import numpy as np

from ..core.colour import differences
from ..core.model import bases, relight
from ..core.model.absorption import depth_for, tint
from ..core.model.factor_model import FactorModel
from ..core.model.integration import FINE, fine_weights
from ..core.spectra import library
from ..core.spectra.arrays import Array
from ..core.spectra.spectrum import WAVELENGTHS, Spectrum
from . import judges, reports
from .hazards import in_words

__all__ = ["absorption", "errors", "many_bounces", "narrow"]

CHANNELS = (6, 9, 12, 18, 24)
PERCENTILES = (50, 90, 99)
DEPTHS = (1, 3, 10)  # optical depth where a medium absorbs most
ALBEDO = 0.98
BOUNCES = 20


def errors(
    model: FactorModel,
    spectra: Sequence[Spectrum],
    lights: Sequence[Spectrum],
    made: Callable[[Array], Array] = lambda factors: factors,
    exposed: bool = False,
) -> tuple[Array, Array]:
    """CIEDE2000 of what becomes of spectra under lights -> (e, N) by the model, and (e, N) at the linear limit.

    made: what a renderer makes of the factors (m, p), and light of the spectra (m, 401), value by value -> (N, ...).
    exposed: show each at half the luminance of white.
    """
    coefficients = made(model.coefficients(list(spectra)))
    full = made(np.stack([spectrum.sampled(FINE) for spectrum in spectra]))
    weights = np.stack([relight.scaled(fine_weights(light) / np.abs(light.values).max()) for light in lights])
    true, white = full @ weights, weights.sum(axis=1)
    if exposed:
        exposure = 0.5 / true[..., 1:2]
        true = true * exposure
    found = coefficients @ np.stack([model.relight(light).T for light in lights])
    local = np.stack([_metric(each, own) for each, own in zip(true, white, strict=True)])
    scale = exposure[..., 0] if exposed else np.ones(true.shape[:2])
    rows = []
    for number in range(len(lights)):
        own = coefficients * scale[number][:, None]
        best = relight.fitted_matrices(own, true[number].T[None], local[number][None], white[number][None])[0]
        seen = found[number] * scale[number][:, None], own @ best.T
        rows.append([differences.delta_E_2000(true[number], each, white[number]) for each in seen])
    return tuple(np.array(rows).transpose(1, 0, 2))


def _metric(true: Array, white: Array) -> Array:
    """(6, N) as `relight.targets` gives it, all products counting the same."""
    jacobian = relight.local_metric(true, white)
    return np.stack([(jacobian[:, :, a] * jacobian[:, :, b]).sum(axis=1) for a, b in relight.PAIRS]) / len(true)


def _cells(values: Array) -> str:
    return " / ".join(f"{value:.2f}" for value in np.percentile(values, PERCENTILES))


def _rows(name: str, *arguments, **options) -> list[list]:  # type: ignore[no-untyped-def]
    rows = []
    models = [(str(p), bases.fitted(p)) for p in CHANNELS] + [("36 bands", bases.bands()), ("81", bases.bands(81))]
    for label, model in models:
        reached, limit = errors(model, *arguments, **options)
        rows.append([name, label, _cells(reached), "" if model.is_reference else _cells(limit)])
    return rows


_HEAD = ("data", "p", "median / p90 / p99", "linear limit")


def _cie() -> list[Spectrum]:
    return [library.illuminant(name) for names in library.cie_illuminants().values() for name in names]


def _three(count: int) -> Callable[[Array], Array]:
    chosen = np.random.default_rng(7).integers(count, size=(300, 3))
    return lambda factors: factors[chosen].prod(axis=1)


def narrow() -> reports.Section:
    """Gels, LEDs, saturated paints, boxes and lines."""
    surfaces = judges.measured()[:200]
    known = "TM-30" if judges.tm30_reflectances() else "the CES"
    some = [library.illuminant(name) for name in ("A", "D65", "FL2", "FL11", "LED-B3", "LED-V1", "HP1", "HP5")]
    films = judges.films()
    rows = _rows(f"{len(films)} gels, glasses and interference filters; 8 CIE illuminants", films, some)
    rows += _rows(f"{known} under 55 coloured LEDs", surfaces, judges.coloured_leds())
    rows += _rows(f"{known} under 53 mixtures of LEDs", surfaces, judges.led_mixtures())
    if judges.tm30_lamps():
        rows += _rows(f"{known} under TM-30's {len(judges.tm30_lamps())} mixed LEDs", surfaces, judges.tm30_lamps())
    paints = judges.saturated()
    three = _three(len(paints))
    rows += _rows(f"{len(paints)} saturated of {known}, 3 bounces; 8 CIE illuminants", paints, some, three)
    for width in (30, 20):
        for name in ("D65", "FL11"):
            rows += _rows(f"boxes of {width} nm under {name}", judges.boxes(width), [library.illuminant(name)])
    for line in (450, 530, 650):
        rows += _rows(f"{known} under a line at {line} nm", surfaces, [library.line(line)])
    p99 = {(row[0], row[1]): float(row[2].split(" / ")[2]) for row in rows}
    film, led = rows[0][0], rows[len(CHANNELS) + 2][0]
    return reports.Section(
        "Gels, LEDs and narrow bands",
        in_words(
            "Spectra made otherwise than those that filters are fitted on (`studies.judges`), against full spectra at "
            "1 nm. The linear limit is what the best relight matrices for these very products would leave.",
            f"The 99th percentile of films is {p99[film, '9']:.1f} at p = 9, {p99[film, '12']:.1f} at 12 and "
            f"{p99[film, '24']:.1f} at 24; under coloured LEDs {p99[led, '9']:.1f}, {p99[led, '12']:.1f} and "
            f"{p99[led, '24']:.1f}. The panel and `relume relight` say what to expect of a scene's own.",
            "The width of a channel: the limit stands beside every figure, and only channels or filters made for a "
            "scene (`bases.scene`) go below it. 36 samples are no truth for what is narrower than they are apart.",
        ),
        _HEAD,
        rows,
    )


def _widest(channels: int) -> float:
    """The largest standard deviation of a filter's wavelengths, in nm."""
    filters = bases.fitted(channels).filters
    middle = WAVELENGTHS @ filters
    return float(np.sqrt((WAVELENGTHS**2) @ filters - middle**2).max())


def many_bounces() -> reports.Section:
    """Albedo 0.98, the sum of 20 bounces."""
    chosen = judges.measured()[:200]
    own = [
        Spectrum(spectrum.wavelengths, spectrum.values * (ALBEDO / spectrum.values.max()), spectrum.name)
        for spectrum in chosen
    ]

    def gathered(factors: Array) -> Array:
        return factors * (1 - factors**BOUNCES) / (1 - factors)

    rows = _rows(f"{len(own)} surfaces, D65", own, [library.illuminant("D65")], gathered, exposed=True)
    return reports.Section(
        f"Albedo {ALBEDO:g}, {BOUNCES} bounces",
        in_words(
            f"Reflectances stretched to a peak of {ALBEDO:g}; the sum of {BOUNCES} bounces, exposed to half of white.",
            f"p99 {rows[1][2].split(' / ')[2]} at p = 9, {rows[4][2].split(' / ')[2]} at 24.",
            "A channel has one value where a surface has many: the mean of powers is no power of a mean. Filters of 24 "
            f"channels have second lobes: the widest spreads {_widest(24):.0f} nm, of 18 channels {_widest(18):.0f}. "
            "They gain under narrow lights, and lose in high powers and at depth, what one peak each would not.",
        ),
        _HEAD,
        rows,
    )


def absorption() -> reports.Section:
    """Beer's law at several optical depths."""
    chosen = judges.measured()[:200]
    rows = []
    for depth in DEPTHS:
        # Absorption 1 - colour, as Blender's volumes take a colour; at most `depth` over the way through
        def through(factors: Array, depth: float = depth) -> Array:
            return np.exp(-depth * (1 - factors))

        name = f"{len(chosen)} media of optical depth {depth}, D65"
        rows += _rows(name, chosen, [library.illuminant("D65")], through)
        at = depth_for(depth)
        for p in CHANNELS:
            model = bases.fitted(p)
            tints = np.stack([tint(model, colour, at) for colour in chosen])

            def by_depth(factors: Array, depth: float = depth, tints: Array = tints) -> Array:
                return np.exp(-depth * (1 - (tints if factors.shape == tints.shape else factors)))

            reached, limit = errors(model, chosen, [library.illuminant("D65")], by_depth)
            rows.append([name, f"{p}, right at {at:g}", _cells(reached), _cells(limit)])
    deep = {row[1]: row[2].split(" / ")[2] for row in rows if row[0] == name}
    return reports.Section(
        "Absorbing volumes",
        in_words(
            "Media that absorb 1 less a measured colour, as a volume of that colour does in Blender, of an optical "
            "depth where they absorb all; seen in front of a white under D65.",
            f"p99 at depth {DEPTHS[-1]}: {deep['9']} at p = 9, {deep['24']} at 24 with the mean absorption of each "
            f"channel; {deep[f'9, right at {at:g}']} and {deep[f'24, right at {at:g}']} with the one that is right "
            f"behind a depth of {at:g}, as Relume assigns a colour of absorption to a thing {DEPTHS[-1]} deep.",
            "Behind a channel light is the mean of exponentials, and a renderer has the exponential of a mean.",
        ),
        _HEAD,
        rows,
    )
