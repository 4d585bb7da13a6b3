"""The figures and tables of the three papers, made again into one page: `make gallery`.

`python -m relume.benchmarks.gallery [--reflectances CSV] [--samples N] [--only NAME ...] [--out DIR]`

Each picture stands beside the number of the paper's figure and the figures measured on it. Rendered pictures are each
rendered once with a model; every lighting is made of that afterwards.
"""

import argparse
import html
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import bpy
import numpy as np

from ..addon.cli import commands
from ..addon.scene import render, render_settings
from ..assets import make_spheres, make_volumes
from ..core import results
from ..core.colour import differences, spaces
from ..core.model import bases
from ..core.model.relight import power_weights
from ..core.picture import coefficients, drawing
from ..core.picture.mix import Light
from ..core.spectra import files, library
from ..studies import dial, figures, paper_figures, reports, tables
from . import room_accuracy, room_exact, room_paper

SPHERES = {
    "full spectrum, 36 bands": lambda: bases.bands(36),
    "eq. 12, p = 7": lambda: bases.sharpened(7, limits=(400, 700)),
    "ours, p = 9": lambda: bases.fitted(9),
    "RGB": bases.rgb,
}
LIGHTS = {"D65": "daylight", "A": "tungsten"}
ROOM_PERCENT = 25  # of the room's own resolution
SEEN = 0.05  # of the brightest under flat light: where a volume is thinner nothing is compared


@dataclass
class Entry:
    """A part of the page: a heading, what the paper has there, a picture beside this page, and a table."""

    title: str
    paper: str
    picture: str = ""
    words: str = ""
    head: list[str] = field(default_factory=list)
    rows: list[list[str]] = field(default_factory=list)

    def markdown(self) -> str:
        lines = [f"## {self.title}", "", f"*{self.paper}.* {self.words}", ""]
        if self.picture:
            lines += [f"![{self.title}]({self.picture})", ""]
        if self.head:
            cells = [self.head, ["---"] * len(self.head), *self.rows]
            lines += ["| " + " | ".join(row) + " |" for row in cells] + [""]
        return "\n".join(lines)

    def html(self) -> str:
        parts = [f"<h2>{html.escape(self.title)}</h2>"]
        parts.append(f"<p><em>{html.escape(self.paper)}.</em> {html.escape(self.words)}</p>")
        if self.picture:
            parts.append(f'<img src="{html.escape(self.picture)}" alt="{html.escape(self.title)}">')
        if self.head:
            rows = [("th", self.head), *(("td", row) for row in self.rows)]
            cells = ("".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in row) for tag, row in rows)
            parts.append("<table>" + "".join(f"<tr>{row}</tr>" for row in cells) + "</table>")
        return "\n".join(parts)


def _xyz(image, illuminant, gain: float = 1.0) -> np.ndarray:
    return coefficients.to_xyz(image, dict.fromkeys(image.groups, Light(illuminant, gain)))


def _statistics(values: np.ndarray) -> list[str]:
    return [f"{np.median(values):.2f}", f"{np.percentile(values, 98):.2f}"]


def _unmixed(image, reflectances: np.ndarray) -> tuple[np.ndarray, float]:
    """The spectrum of every pixel (height, width, 81), where each is a mixture of `reflectances` (m, 81); and how far
    from one its coefficients are at most.

    So it is where volumes shine and take in all wavelengths alike: nothing is multiplied, and the weights of the
    mixture can be had from the coefficients. That is exact, without a second render.
    """
    (values,) = image.groups.values()
    known = image.model.coefficients(reflectances)
    weights = values @ np.linalg.pinv(known)
    return weights @ reflectances, float(np.abs(weights @ known - values).max())


def spheres(out: Path, samples: int, _: Path | None) -> list[Entry]:
    """[DF] Fig. 5."""
    bpy.ops.wm.open_mainfile(filepath=str(make_spheres.PATH), load_ui=False)
    scene = bpy.context.scene
    scene.cycles.samples = samples
    render_settings.compare(scene)
    images = {name: room_accuracy.render_room(scene, make(), f"spheres, {name}") for name, make in SPHERES.items()}
    truth, pictures, rows = next(iter(images.values())), [], []
    for light, words in LIGHTS.items():
        illuminant = library.illuminant(light)
        true = _xyz(truth, illuminant)
        white = truth.model.relight(illuminant).sum(axis=1)
        for name, image in images.items():
            lights = dict.fromkeys(image.groups, Light(illuminant))
            pictures.append((f"{name}, {words}", spaces.srgb_encoded(render.picture(image, lights, 1.0))))
            if image is not truth:
                apart = differences.picture_delta_E(_xyz(image, illuminant), true, white)
                rows.append([words, name, *_statistics(apart)])
    figures.picture_row(out / "spheres.png", pictures, columns=len(images))
    words = (
        f"Three metamer pairs over ColorChecker 2, up to {make_spheres.BOUNCES} bounces, white balanced. The pairs are "
        "designed to part under A as far as the paper's. CIEDE2000 to the full spectrum."
    )
    head = ["light", "model", "median", "98th percentile"]
    return [Entry("Spheres", "Drew & Finlayson, Fig. 5", "spheres.png", words, head, rows)]


def volumes(out: Path, samples: int, _: Path | None) -> list[Entry]:
    """[DF] Fig. 7, [BMD] Figs. 6 and 7: rendered once, each lighting by `relume relight` alone."""
    papers = {
        "anatomy": "Drew & Finlayson, Fig. 7; Bergner and others, Fig. 7",
        "brain": "Drew & Finlayson, Fig. 7, of a measured volume",
        "machine": "Bergner and others, Fig. 6",
    }
    entries = []
    for name, paper in papers.items():
        scene = make_volumes.build(name)
        scene.cycles.samples = max(samples // 8, 1)  # nothing scatters: they smooth edges
        render_settings.compare(scene)
        image = room_accuracy.render_room(scene, bases.fitted(9), f"{name}, 9 channels")
        full, apart_from_mixture = _unmixed(image, make_volumes.reflectances(name))
        group = next(iter(image.groups))
        exr, lamps = out / f"{name}.exr", out / f"{name}_lights.csv"
        coefficients.write(
            exr, image, render.picture(image, dict.fromkeys(image.groups, Light(library.illuminant("D65"))))
        )
        lightings, bright = make_volumes.lightings(name), full.mean(axis=-1)
        files.write(lamps, [illuminant for illuminant, _ in lightings.values()])
        pictures, rows, mixed = [], [], []
        for title, (illuminant, gain) in lightings.items():
            made = out / f"{name}_{title.replace(' ', '_').replace(',', '')}.png"
            light = f"{group}={lamps}#{title}*{gain:.6g}"
            if commands.execute(["relight", str(exr), "--light", light, "--white", "none", "--out", str(made)]):
                raise SystemExit(f"{made} was not made")
            pictures.append((title, coefficients.read_rgb(made)))
            weights = power_weights(illuminant.sampled(), library.observer())
            white = weights.sum(axis=0)
            true, found = gain * full @ weights, _xyz(image, illuminant, gain)
            mixed.append((title, found))
            seen = bright > SEEN * bright.max()
            apart = differences.delta_E_2000(true[seen], found[seen], white)
            rows.append([title, f"{gain:.2f}", *_statistics(apart)])
        figures.picture_row(out / f"{name}.png", pictures)
        field = "A measured volume" if make_volumes.SCENES[name].grid else "A field made of simple shapes"
        words = (
            f"{field} in place of the paper's data, its ranges of values with spectra of a designed palette "
            f"(assets/volumes/{name}.toml), rendered once with 9 channels; every lighting by `relume relight`. "
            "CIEDE2000 to full spectra, where the volume is: it shines and takes in all wavelengths alike: a pixel is "
            f"a mixture of its spectra (to {apart_from_mixture:.0e}), which tells its own."
        )
        head = ["lighting", "luminance", "median", "98th percentile"]
        entries.append(Entry(name.capitalize(), paper, f"{name}.png", words, head, rows))
        if name == "machine":
            colours = [drawing.swatch(illuminant) for illuminant, _ in lightings.values()]
            dial.animate(out / "dial.webp", mixed, colours)
            words = "The four lightings of the machine, mixed by a handle after the render."
            entries.append(Entry("The light dial", "Bergner and others, section 5.1", "dial.webp", words))
    return entries


def curves(out: Path, _: int, reflectances: Path | None) -> list[Entry]:
    """[DF] Figs. 1 to 4 and 6, and every table."""
    spectra = files.read(reflectances) if reflectances else library.reflectances("ces")
    source = reflectances.name if reflectances else "the CES (CIE 224)"
    done = reports.publish("tables", tables.sections(spectra, source), out)
    paper_figures.draw(done, spectra, out)
    words = {
        1: "(a) The first five singular vectors of all colour signals, (b) what eq. 12 makes of them.",
        2: "D65 off light skin, foliage and blue sky: exact, best least squares, spectral factor model.",
        3: "Three pairs of metamers, by the palette designer.",
        4: "Their colour signals under A, and the spectral factor model of seven.",
        6: "Signals of one to six bounces of D65 and A off the six metamers, accumulated.",
    }
    found = [Entry(f"Figure {n}", f"Drew & Finlayson, Fig. {n}", f"figure_{n}.png", text) for n, text in words.items()]
    for section in done:
        number = section.name.removeprefix("Table ")
        where = f"Table {number}" if number.isdigit() else "section 3"
        picture = "table_1.png" if section.name == "Table 1" else ""
        found.append(_entry(section, f"Drew & Finlayson, {where}", picture))
    return found


def room(out: Path, samples: int, _: Path | None) -> list[Entry]:
    """[WE] Table 1 and its error maps, rendered, and without noise."""
    scene, folder = room_accuracy.open_room(max(samples // 2, 1), ROOM_PERCENT), out / "room"
    folder.mkdir(exist_ok=True)
    paper = "Ward & Eydelberg-Vileshin, Table 1 and Figs. 5 to 7"
    entries = [_entry(section, paper) for section in room_paper.run(scene, folder)]
    entries[0].picture = f"{folder.name}/room_paper.png"
    exact = reports.publish("room_exact", room_exact.sections(), folder)
    entries += [_entry(section, f"{paper}, without noise") for section in exact]
    return [replace(entry, title=f"The room: {entry.title}") for entry in entries]


def _entry(section: reports.Section, paper: str, picture: str = "") -> Entry:
    rows = [[str(cell) for cell in row] for row in section.rows]
    return Entry(section.name, paper, picture, section.words, [str(cell) for cell in section.head], rows)


PARTS: dict[str, Callable[[Path, int, Path | None], list[Entry]]] = {
    "spheres": spheres,
    "volumes": volumes,
    "curves": curves,
    "room": room,
}
STYLE = "body{font:16px/1.5 sans-serif;max-width:70rem;margin:2rem auto}img{max-width:100%}td,th{padding:0 1em}"


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m relume.benchmarks.gallery", description=__doc__)
    parser.add_argument("--reflectances", type=Path, metavar="CSV", help="of Vrhel and others, for the tables")
    parser.add_argument("--samples", type=int, default=64, help="per pixel, in every pass (64)")
    parser.add_argument("--only", choices=PARTS, nargs="+", default=list(PARTS), help="these parts alone")
    parser.add_argument("--out", type=Path, default=Path("out/gallery"), metavar="DIR")
    options = parser.parse_args(argv)

    if not hasattr(bpy.types.Scene, "relume"):
        from .. import register

        register()
    out = options.out.resolve()
    out.mkdir(parents=True, exist_ok=True)
    entries = [entry for name in options.only for entry in PARTS[name](out, options.samples, options.reflectances)]
    title = "Three papers, made again"
    results.write_text(out / "gallery.md", f"# {title}\n\n" + "\n".join(entry.markdown() for entry in entries))
    body = "\n".join(entry.html() for entry in entries)
    page = f'<!doctype html>\n<html lang="en"><meta charset="utf-8"><title>{title}</title><style>{STYLE}</style>'
    results.write_text(out / "gallery.html", f"{page}\n<h1>{title}</h1>\n{body}\n</html>\n")
    print(out / "gallery.html")


if __name__ == "__main__":
    main()
