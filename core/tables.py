"""The tables and figures of Drew & Finlayson, made again: `relume tables`.

[DF] M. S. Drew, G. D. Finlayson, "Multispectral processing without spectra", JOSA A 20 (2003) 1181-1193.

What the paper does not say is inferred, and each table says so: the lights (LIGHTS) and the range (LIMITS), how bounces
accumulate, that Table 2 is the 90th percentile over trials of the median over lights, and intervals of equal width.
"""

import argparse
import csv
import re
import sys
from collections import defaultdict
from pathlib import Path

import numpy as np

from . import bases, files, library, measure, palette
from .factor_model import ModelError
from .relight import power_weights
from .spectrum import WAVELENGTHS, SpectrumError

__all__ = ["bounce_experiment", "main", "metamer_experiment"]

LIGHTS = ("A", "C", "D 4800 K", "D55", "D65", "D75", "D 10000 K")
LIMITS = (400, 700)  # nm
CHANNELS = (3, 5, 7, 9)
BOUNCES = 5
# Printed in [DF], CIE 1976 colour difference over 1 to 5 bounces; (table, p, row)
PRINTED = {
    (1, 5, "multiply XYZ"): (1.76, 1.99, 2.27, 2.67, 3.16),
    (1, 5, "best linear model"): (0.95, 0.96, 1.12, 1.34, 1.70),
    (1, 5, "eq. 12, non-negative"): (2.51, 2.92, 3.58, 4.35, 6.25),
    (1, 7, "eq. 12, non-negative"): (1.13, 1.31, 1.44, 1.78, 2.09),
    (1, 9, "eq. 12, non-negative"): (0.88, 1.04, 1.15, 1.25, 1.81),
    (3, 5, "best linear model"): (7.59, 7.50, 7.35, 7.90, 8.61),
}
RULES = {
    "as the paper": "bounces accumulate as a <- a (1 + S): inferred, it reproduces the row of multiplied XYZ",
    "physical": "bounces add as S1 + S1 S2 + S1 S2 S3 + ...: what light between two surfaces does",
}
INFERRED = (
    f"Inferred as well: lights {', '.join(LIGHTS)}, {LIMITS[0]} to {LIMITS[1]} nm, intervals of equal width (the paper "
    "gives its own for p = 5 only, and its figures for p = 7 and 9 are not reached)."
)


def accumulated(factors, rule):
    """Light after 1 to k bounces from k factors (k, ...) -> (k, ...), for spectra and coefficients alike."""
    if rule == "as the paper":
        return np.cumprod(np.concatenate([factors[:1], 1 + factors[1:]]), axis=0)
    return np.cumsum(np.cumprod(factors, axis=0), axis=0)


def bounce_experiment(channels, spectra, lights, rule="as the paper", trials=400, seed=2003):
    """Random series of bounces by every method, over LIMITS.

    spectra: reflectances (list of Spectrum), lights (list of Spectrum) -> {row: CIE 1976 differences (trials, lights,
    bounces)}, and the same for the relative error of the spectra in percent, of those methods that rebuild spectra.
    """
    random = np.random.default_rng(seed)
    reflectances = np.stack([spectrum.sampled() for spectrum in spectra])
    series = reflectances[random.integers(len(reflectances), size=(BOUNCES, trials))]
    true = accumulated(series, rule)
    inside = (LIMITS[0] <= WAVELENGTHS) & (LIMITS[1] >= WAVELENGTHS)
    cmfs = library.observer() * inside[:, None]
    equal = power_weights(np.ones(WAVELENGTHS.size), cmfs)

    published = {"eq. 11, Lagrange": "lagrange", "eq. 12, non-negative": "nonnegative"}
    published = {row: bases.sharpened(channels, how, lights, spectra, limits=LIMITS) for row, how in published.items()}
    linear = np.linalg.qr(published["eq. 11, Lagrange"].filters)[0]
    ours = {"block filters": bases.block(channels), "fitted (ours)": bases.fitted(channels)}

    differences, spectral = defaultdict(list), defaultdict(list)
    for light in lights:
        power = light.sampled() / (light.sampled() @ cmfs[:, 1])  # Y = 1 for a perfect white
        white = power @ cmfs
        signal = true * power * inside
        rebuilt = {"best linear model": signal @ linear @ linear.T}
        for row, model in published.items():
            # In [DF] the light is one more factor: its coefficients multiply those of the surfaces.
            coefficients = model.coefficients(power) * accumulated(model.coefficients(series), rule)
            rebuilt[row] = coefficients @ model.reconstruction.T
        colours = {row: spectrum @ cmfs for row, spectrum in rebuilt.items()}
        for row, model in ours.items():
            coefficients = accumulated(model.coefficients(series), rule)
            colours[row] = coefficients @ model.relight(light, cmfs).T
        colours["multiply XYZ"] = accumulated(series @ equal / equal.sum(axis=0), rule) * white
        for row, xyz in colours.items():
            differences[row].append(measure.delta_E_1976(xyz, signal @ cmfs, white))
        for row, spectrum in rebuilt.items():
            error = np.linalg.norm(spectrum - signal, axis=-1) / np.linalg.norm(signal, axis=-1)
            spectral[row].append(100 * error)
    return tuple({row: np.stack(v).transpose(2, 0, 1) for row, v in rows.items()} for rows in (differences, spectral))


def metamer_experiment(channels, matched="D65", others=("A", "FL11"), count=414):
    """How far pairs that match under one light come apart under others, in truth and by the fitted model.

    -> {light: (true difference (count,), the model's difference (count,))}, CIEDE2000.
    """
    pairs = palette.metamers(library.illuminant(matched), count)
    model = bases.fitted(channels)
    result = {}
    for name in (matched, *others):
        light = library.illuminant(name)
        weights = power_weights(light.sampled(), library.observer())
        white = weights.sum(axis=0)
        true, seen = pairs @ weights, model.coefficients(pairs) @ model.relight(light).T
        result[name] = tuple(measure.delta_E_2000(xyz[:, 0], xyz[:, 1], white) for xyz in (true, seen))
    return result


def _three_bounces():
    """[DF] section 3.D: FL2, then light skin, foliage and blue sky; basis of the ColorChecker under FL2."""
    light = library.illuminant("FL2")
    chart = library.reflectances("colorchecker")
    surfaces = np.stack(
        [library.reflectance(f"ColorChecker: {n}").sampled() for n in ("light skin", "foliage", "blue sky")]
    )
    weights = power_weights(light.sampled(), library.observer())
    white, truth = weights.sum(axis=0), surfaces.prod(axis=0) @ weights
    rows = []
    for channels in CHANNELS:
        for row, model in {
            "eq. 11, Lagrange": bases.sharpened(channels, "lagrange", [light], chart),
            "eq. 12, non-negative": bases.sharpened(channels, "nonnegative", [light], chart),
            "block filters": bases.block(channels),
            "fitted (ours)": bases.fitted(channels),
        }.items():
            xyz = model.coefficients(surfaces).prod(axis=0) @ model.relight(light).T
            rows.append([channels, row, f"{measure.delta_E_1976(xyz, truth, white):.2f}"])
    equal = power_weights(library.illuminant("E").sampled(), library.observer())
    multiplied = (surfaces @ equal / equal.sum(axis=0)).prod(axis=0) * white
    rows.append(["-", "multiply XYZ", f"{measure.delta_E_1976(multiplied, truth, white):.2f}"])
    return rows


def _all_tables(spectra, lights):
    """Every table as (name, explanation, head, rows)."""
    bounces = [f"{k}" for k in range(1, BOUNCES + 1)]
    summaries = {
        1: ("Median CIE 1976 difference", lambda d: np.median(d, axis=(0, 1))),
        2: (
            "90th percentile over trials of the median over lights, CIE 1976 (which percentile is inferred)",
            lambda d: np.percentile(np.median(d, axis=1), 90, axis=0),
        ),
        3: ("Median relative error of the rebuilt spectra, percent", lambda d: np.median(d, axis=(0, 1))),
    }
    for rule, words in RULES.items():
        results = {p: bounce_experiment(p, spectra, lights, rule) for p in CHANNELS}
        for number, (title, summary) in summaries.items():
            rows = []
            for p in CHANNELS:
                for row, values in results[p][number == 3].items():
                    rows.append([p, row, *(f"{v:.2f}" for v in summary(values))])
                    if rule == "as the paper" and (number, p, row) in PRINTED:
                        rows.append([p, f"{row}, printed in [DF]", *(f"{v:.2f}" for v in PRINTED[number, p, row])])
            suffix = "" if rule == "as the paper" else ", physical"
            yield f"table {number}{suffix}", f"{title}; {words}. {INFERRED}", ["p", "method", *bounces], rows
    yield (
        "section 3.D",
        "CIE 1976 difference of light skin, foliage and blue sky in a row under FL2; bases of the ColorChecker there.",
        ["p", "method", "difference"],
        _three_bounces(),
    )
    for number, matched, others in ((4, "D65", ("A", "FL11")), (5, "A", ("D65", "FL2"))):
        rows = []
        for channels in (3, 6, 9, 12, 15):
            for light, (true, seen) in metamer_experiment(channels, matched, others).items():
                share = (
                    "-"
                    if light == matched
                    else f"{100 * np.median(np.abs(seen - true)[true > 1] / true[true > 1]):.1f}"
                )
                rows.append([channels, light, f"{np.median(true):.2f}", f"{np.median(seen):.2f}", share])
        words = f"414 constructed pairs that match under {matched}; CIEDE2000 between the two of a pair, medians."
        yield f"table {number}", words, ["p", "light", "true", "fitted (ours)", "error of the split, %"], rows


def _figures(out):
    """Figures 1 and 2 of [DF] as PNG -> paths. Raises ImportError without matplotlib."""
    from matplotlib.figure import Figure

    paths = []
    figure = Figure(figsize=(10, 7), layout="constrained")
    for axes, (title, model) in zip(
        figure.subplots(2, 2).flat,
        {
            "eq. 11, p = 5": bases.sharpened(5, "lagrange"),
            "eq. 12, p = 5": bases.sharpened(5, "nonnegative"),
            "fitted, p = 5": bases.fitted(5),
            "fitted, p = 9": bases.fitted(9),
        }.items(),
        strict=True,
    ):
        axes.plot(WAVELENGTHS, model.filters)
        axes.set(title=title, xlabel="wavelength, nm", ylabel="filter")
    paths.append(out / "figure1.png")
    figure.savefig(paths[-1], dpi=110)

    light = library.illuminant("FL2")
    chart = library.reflectances("colorchecker")
    surfaces = np.stack(
        [library.reflectance(f"ColorChecker: {n}").sampled() for n in ("light skin", "foliage", "blue sky")]
    )
    figure = Figure(figsize=(12, 3.6), layout="constrained")
    models = {
        "eq. 12, p = 9": bases.sharpened(9, "nonnegative", [light], chart),
        "fitted, p = 9": bases.fitted(9),
    }
    for count, axes in enumerate(figure.subplots(1, 3), start=1):
        axes.plot(WAVELENGTHS, surfaces[:count].prod(axis=0), "k", label="true")
        for label, model in models.items():
            product = model.coefficients(surfaces[:count]).prod(axis=0)
            axes.plot(WAVELENGTHS, model.reconstruct(product), "--", label=label)
        axes.set(title=f"{count} bounce{'s' * (count > 1)}", xlabel="wavelength, nm", ylabel="reflectance")
        axes.legend()
    paths.append(out / "figure2.png")
    figure.savefig(paths[-1], dpi=110)
    return paths


def _markdown(name, words, head, rows):
    lines = [
        f"## {name[0].upper()}{name[1:]}",
        "",
        words,
        "",
        "| " + " | ".join(head) + " |",
        "|" + " --- |" * len(head),
    ]
    return "\n".join([*lines, *("| " + " | ".join(str(cell) for cell in row) + " |" for row in rows), ""])


def main(argv=None):
    """The command `relume tables` -> exit status."""
    parser = argparse.ArgumentParser(prog="relume tables", description="Print the tables of Drew & Finlayson (2003).")
    parser.add_argument(
        "--reflectances", type=Path, metavar="CSV", help="spectra to bounce light off; default: the CES"
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="write Markdown, CSV and PNG files there too")
    options = parser.parse_args(argv)
    try:
        spectra = files.read(options.reflectances) if options.reflectances else library.reflectances("ces")
        if options.out:
            options.out.mkdir(parents=True, exist_ok=True)
        texts = []
        for name, words, head, rows in _all_tables(spectra, [library.illuminant(light) for light in LIGHTS]):
            texts.append(_markdown(name, words, head, rows))
            print(texts[-1], flush=True)
            if options.out:
                path = options.out / f"{re.sub('[^a-z0-9]+', '_', name.lower())}.csv"
                with open(path, "w", newline="", encoding="utf-8") as file:
                    csv.writer(file).writerows([head, *rows])
        if options.out:
            (options.out / "tables.md").write_text("\n".join(texts), encoding="utf-8")
            try:
                _figures(options.out)
            except ImportError:
                print("relume tables: no figures: they need the package matplotlib", file=sys.stderr)
            print(f"written to {options.out}")
    except (OSError, SpectrumError, ModelError, library.LibraryError) as error:
        print(f"relume tables: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
