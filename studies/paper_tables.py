"""Every table and figure in words of Drew & Finlayson, printed values beside, as sections of a report.

[DF] M. S. Drew, G. D. Finlayson, "Multispectral processing without spectra", JOSA A 20 (2003) 1181-1193.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from ..core.colour import differences
from ..core.model.factor_model import FactorModel
from ..core.spectra import library
from ..core.spectra.arrays import Array
from ..core.spectra.spectrum import Spectrum
from . import multispectral as paper
from . import printed
from .reports import Section

__all__ = ["THREE_SURFACES", "chart_basis", "metamer_sections", "random_sections", "signal_section", "three_bounces"]

THREE_SURFACES = ("light skin", "foliage", "blue sky")
WORDS = {
    1: "CIE 1976 difference, over 1 to 5 reflections: the median over the reflectances, and of that the median over "
    "trials.",
    2: "The same, the 90th percentile over trials.",
    3: "RMS error of whole spectra in percent: the median over the reflectances, and of that the median over trials.",
}
SEVEN = 7  # channels of the specialised basis
SMOOTHNESS = (0.03, 0.1, 0.4)  # the first is that of the pairs
METHODS = ("best linear model", "eq. 12")


def with_printed(label: Sequence, values: Array, theirs: Sequence[float] | None) -> Iterator[list]:
    """The row of what comes out and, where there is one, that of what is printed; `label` ends in the method."""
    yield [*label, *(f"{value:.2f}" for value in values)]
    if theirs is not None:
        yield [*label[:-1], f"{label[-1]}, printed", *(f"{value:.2f}" for value in theirs)]


def random_sections(reflectances: Sequence[Spectrum]) -> Iterator[Section]:
    """Tables 1 to 3, Table 1 by the other rule of accumulation, and what they say."""
    found = {p: paper.random_bounces(p, reflectances) for p in paper.CHANNELS}
    head = ("p", "method", *map(str, range(1, paper.BOUNCES + 1)))
    for number, words in WORDS.items():
        rows: list[list] = []
        for p, by_method in found.items():
            for method, (apart, spectral) in by_method.items():
                if (method == "multiply XYZ" and p != paper.CHANNELS[0]) or (number == 3 and np.isnan(spectral).any()):
                    continue
                p_or_none = 0 if method == "multiply XYZ" else p
                values = np.percentile(spectral if number == 3 else apart, 90 if number == 2 else 50, axis=0)
                theirs = printed.RANDOM_TABLES[number].get((p_or_none, method))
                rows += with_printed((p_or_none or "-", method), values, theirs)
        yield Section(f"Table {number}", words, head, rows)
    physical: list[list] = []
    for p in paper.CHANNELS:
        for method, (apart, _) in paper.random_bounces(p, reflectances, "physical").items():
            if method != "multiply XYZ" or p == paper.CHANNELS[0]:
                shown = "-" if method == "multiply XYZ" else p
                physical += with_printed((shown, method), np.median(apart, axis=0), None)
    words = "Table 1 with bounces added as S1 + S1 S2 + ..., as light between surfaces does."
    yield Section("Table 1, physical", words, head, physical)
    yield _findings({p: {m: float(np.median(a)) for m, (a, _) in rows.items()} for p, rows in found.items()})


def _findings(medians: dict[int, dict[str, float]]) -> Section:
    """Where the claims of [DF] hold and where not, from {p: {method: median difference over all bounces}}."""
    pairs = (
        ("eq. 12", "multiply XYZ"),
        ("boxes on the intervals", "eq. 12"),
        ("adjoining boxes", "eq. 12"),
        ("eq. 11", "eq. 12"),
        ("fitted (ours)", "eq. 12"),
        ("fitted (ours)", "best linear model"),
    )
    rows = [[p, *(f"{found[over] / found[under]:.2f}" for over, under in pairs)] for p, found in medians.items()]
    words = (
        "Medians over all bounces as ratios; below 1 the first is nearer. The paper calls block filters "
        '"overwhelmingly worse": the second column is of boxes on its intervals, with gaps between them, the third '
        "of boxes that adjoin. "
        "The fourth is the price of filters that are nowhere negative."
    )
    return Section("What the tables say", words, ("p", *(f"{over} / {under}" for over, under in pairs)), rows)


def signal_section(reflectances: Sequence[Spectrum]) -> Section:
    """Sections 3.A, 3.C and 3.E.1: all 1190 colour signals, as spectra and as products."""
    surfaces, lights = paper.sampled(reflectances), np.stack([paper.paper_light(name) for name in paper.LIGHTS])
    cmfs = paper.observer()
    light, series = lights[:, None], surfaces[None, None]
    true = light * surfaces
    white = (lights @ cmfs)[:, None]
    found: dict[tuple[str, str], Array] = {}

    def judge(method: str, lamp: Array, signal: Array, product: Array) -> None:
        found["lights, RMS %", method] = paper.relative_error(lamp, lights)
        for what, spectra in (("signals", signal), ("products", product)):
            found[f"{what}, RMS %", method] = paper.relative_error(spectra, true)
            xyz = spectra @ cmfs
            found[f"{what}, XYZ %", method] = 100 * np.linalg.norm(xyz - true @ cmfs, axis=-1)
            found[f"{what}, XYZ %", method] /= np.linalg.norm(true @ cmfs, axis=-1)
            found[f"{what}, difference", method] = differences.delta_E_1976(xyz, true @ cmfs, white)

    for p in (5, SEVEN):
        basis = paper.components(p, lights, surfaces)
        model = paper.eq_12(basis)
        product = paper.factors(model)(light, series, "last")[0]
        projected = lights @ basis @ basis.T, true @ basis @ basis.T
        judge(f"best linear model, p = {p}", *projected, projected[1])
        judge(f"eq. 12, p = {p}", *projected, product)
        blocks = paper.boxes(paper.INTERVALS[p])
        rebuilt = [model_of(blocks, values) for values in (lights, true)]
        judge(f"boxes, p = {p}", rebuilt[0], rebuilt[1], paper.factors(blocks)(light, series, "last")[0])
    rows = []
    for (what, method, of_what), theirs in printed.SIGNALS.items():
        # The paper does not say how many its boxes are: both numbers that it works with.
        named = [f"{method}, p = {p}" for p in (5, SEVEN)] if method == "boxes" else [method]
        for name in named:
            values = found[what, name]
            ours = values.mean() if of_what == "mean" else np.percentile(values, {"median": 50, "95 %": 95}[of_what])
            rows.append([what, name, of_what, f"{ours:.2f}", f"{theirs:.2f}"])
    words = (
        f"Sections 3.A, 3.C and 3.E.1: {true[..., 0].size} colour signals. A signal is rebuilt from its own "
        "coefficients, a product from those of the light times those of the surface."
    )
    return Section("Colour signals", words, ("what", "method", "of all", "here", "printed"), rows)


def model_of(model: FactorModel, spectra: Array) -> Array:
    """Spectra (..., 31) rebuilt from their own coefficients."""
    return model.reconstruct(model.coefficients(spectra))


def chart_basis(channels: int) -> Array:
    """The basis of section 3.D's end: of the 24 patches of the ColorChecker under FL2 -> (31, p)."""
    return paper.components(
        channels, paper.paper_light("FL2")[None], paper.sampled(library.reflectances("colorchecker"))
    )


def three_surfaces() -> Array:
    """Light skin, foliage and blue sky of the ColorChecker -> (3, 31)."""
    return paper.sampled([library.reflectance(f"ColorChecker: {name}") for name in THREE_SURFACES])


def three_bounces(reflectances: Sequence[Spectrum]) -> Section:
    """Section 3.D in full: D65 and FL2 off light skin, foliage and blue sky, every bounce, five channels."""
    lights = np.stack([paper.paper_light(name) for name in paper.LIGHTS])
    bases = {"D65": paper.components(5, lights, paper.sampled(reflectances)), "FL2": chart_basis(5)}
    cmfs, series = paper.observer(), three_surfaces()
    rows: list[list] = []
    for name, basis in bases.items():
        light = paper.paper_light(name)
        true = light * paper.accumulated(series, "last")
        # The paper's matching functions sum to 10.67 each, and its D65 is 100 at 560 nm.
        scaled = 100 / light[list(paper.WAVELENGTHS).index(560)] * cmfs * 10.67 / cmfs.sum(axis=0)
        made = {"best linear model": paper.best_linear(basis), "eq. 12": paper.factors(paper.eq_12(basis))}
        if name == "D65":
            for axis, letter in enumerate("XYZ"):
                theirs = [triple[axis] for triple in printed.THREE_BOUNCES_XYZ]
                rows += with_printed((name, letter, "true"), (true @ scaled)[:, axis], theirs)
        for method, make in made.items():
            spectra = make(light, series, "last")
            for what, values in (
                ("RMS %", paper.relative_error(spectra, true)),
                ("XYZ apart", np.linalg.norm((spectra - true) @ scaled, axis=1)),
                ("difference", differences.delta_E_1976(spectra @ cmfs, true @ cmfs, light @ cmfs)),
            ):
                rows += with_printed((name, what, method), values, printed.THREE_BOUNCES.get((name, what, method)))
    words = (
        "Light off light skin, foliage and blue sky of the ColorChecker, p = 5. D65 with the basis of all colour "
        "signals; FL2 with one of the ColorChecker under FL2. XYZ apart is the length of the difference of XYZ."
    )
    return Section("Section 3.D", words, ("light", "what", "method", "1", "2", "3"), rows)


def metamer_sections(reflectances: Sequence[Spectrum]) -> Iterator[Section]:
    """Tables 4 and 5 and section 3.E.2, on three pairs made by the palette designer."""
    cmfs, pairs = paper.observer(), paper.sampled_values(paper.metamer_pairs())
    lights = {name: paper.paper_light(name) for name in ("D65", "A")}
    six = pairs.reshape(6, -1)
    basis = paper.components(SEVEN, np.stack(list(lights.values())), six)
    general = paper.components(
        SEVEN, np.stack([paper.paper_light(name) for name in paper.LIGHTS]), paper.sampled(reflectances)
    )
    made = {"best linear model": paper.best_linear(basis), "eq. 12": paper.factors(paper.eq_12(basis))}
    tables: dict[int, list[list]] = {4: [], 5: []}
    for method in ("best linear model", "eq. 12", "multiply XYZ"):
        for name, light in lights.items():
            true = light * paper.accumulated(six, "paper")
            if method == "multiply XYZ":
                xyz = paper.multiplied_xyz(light, six, "paper")
            else:
                spectra = made[method](light, six, "paper")
                xyz = spectra @ cmfs
                theirs = printed.METAMER_TABLES[5][method, name]
                tables[5] += with_printed((name, method), paper.relative_error(spectra, true), theirs)
            apart = differences.delta_E_1976(xyz, true @ cmfs, light @ cmfs)
            tables[4] += with_printed((name, method), apart, printed.METAMER_TABLES[4][method, name])
    head = ("light", "method", *map(str, range(1, 7)))
    about = (
        f"The six metamers in order, accumulated; a basis of {SEVEN} of the six under D65 and A. The pairs are "
        "designed (assets/palettes/metamer_pairs.toml), for the paper's are not printed: the size of a row may be "
        "compared with the printed one, its single values may not."
    )
    yield Section("Table 4", f"CIE 1976 difference. {about}", head, tables[4])
    yield Section("Table 5", f"RMS error of whole spectra in percent. {about}", head, tables[5])

    yield _smoother()

    rows = []
    for method in ("full spectra", "multiply XYZ", "eq. 12, general basis", "eq. 12, specialised"):
        for name, light in lights.items():
            if method == "full spectra":
                xyz = (light * pairs) @ cmfs
            elif method == "multiply XYZ":
                xyz = paper.multiplied_xyz(light, pairs[None], "last")[0]
            else:
                model = paper.eq_12(general if "general" in method else basis)
                xyz = paper.factors(model)(light, pairs[None], "last")[0] @ cmfs
            apart = differences.delta_E_1976(xyz[:, 0], xyz[:, 1], light @ cmfs)
            error = differences.delta_E_1976(xyz, (light * pairs) @ cmfs, light @ cmfs)
            expected = printed.PAIR_SPLITS.get((method, name))
            median = f"{np.median(error):.2f}"
            if method == "eq. 12, general basis" and name == "A":
                median += f" (printed {printed.PAIR_ERROR:.2f})"
            shown = " / ".join(f"{value:.2f}" for value in expected) if expected else "-"
            rows.append([name, method, " / ".join(f"{value:.2f}" for value in apart), shown, median])
    words = (
        f"CIE 1976 difference within each pair, as in section 3.E.2, p = {SEVEN}, and the median error of the six. "
        "What full spectra show under A is made to be the paper's."
    )
    yield Section("Metamer pairs", words, ("light", "method", "within the pairs", "printed", "error, median"), rows)


def _smoother() -> Section:
    """What smoother pairs would make of Table 4, and how far they part."""
    cmfs, rows = paper.observer(), []
    lights = {name: paper.paper_light(name) for name in ("D65", "A")}
    for smoothness in SMOOTHNESS:
        pairs = paper.sampled_values(paper.metamer_pairs(smoothness))
        six = pairs.reshape(6, -1)
        basis = paper.components(SEVEN, np.stack(list(lights.values())), six)
        cells = []
        for method in (paper.best_linear(basis), paper.factors(paper.eq_12(basis))):
            for light in lights.values():
                true = light * paper.accumulated(six, "paper")
                spectra = method(light, six, "paper")
                cells.append(differences.delta_E_1976(spectra @ cmfs, true @ cmfs, light @ cmfs).mean())
        seen = (lights["A"] * pairs) @ cmfs
        apart = differences.delta_E_1976(seen[:, 0], seen[:, 1], lights["A"] @ cmfs)
        parted = " / ".join(f"{value:.1f}" for value in apart)
        rows.append([f"{smoothness:g}", parted, *(f"{value:.2f}" for value in cells)])
    theirs = [np.mean(printed.METAMER_TABLES[4][method, name]) for method in METHODS for name in lights]
    wanted = " / ".join(f"{value:.1f}" for value in printed.PAIR_SPLITS["full spectra", "A"])
    rows.append(["printed", wanted, *(f"{value:.2f}" for value in theirs)])
    words = (
        "The pairs designed with other weights of smoothness: how far they part under A, and the rows of Table 4 as "
        "means over six reflections. Smooth ones that stay within 0 and 1 part less than the paper's do."
    )
    head = ("smoothness", "apart under A", *(f"{method}, {name}" for method in METHODS for name in lights))
    return Section("Smoother pairs", words, head, rows)
