"""Every drawing made with matplotlib: pictures side by side, maps of colour differences, plots."""

import importlib.util
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..core.palette import Entry, Palette, Report

__all__ = ["Panel", "available", "curves", "delta_e_maps", "design_matrix", "picture_row"]

_INCHES = 4.0  # width of one picture on the page
_DPI = 120


@dataclass(frozen=True)
class Panel:
    """Lines (name, x, y) or (name, x, y, style of matplotlib) over `across`; `log` names the logarithmic axes.

    A name has the same colour in every panel, unless the style has one, and one entry in the legend; "" has none.
    """

    across: str
    lines: Sequence[tuple]
    up: str = ""
    title: str = ""
    log: str = ""
    ticks: ArrayLike = ()


def available() -> bool:
    """Whether matplotlib, which draws them, is there: Blender's own Python lacks it."""
    try:
        return importlib.util.find_spec("matplotlib") is not None
    except ValueError:
        return False  # colour-science has put a stand-in in its place


def _page(columns: int, rows: int, size: tuple[float, float], alike: bool = False) -> tuple["Figure", list["Axes"]]:
    """A figure of columns × rows axes, drawn without a screen; with one upward scale if `alike`."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, dpi=_DPI, layout="constrained", facecolor="white")
    FigureCanvasAgg(figure)
    return figure, list(figure.subplots(rows, columns, sharey=alike, squeeze=False).ravel())


def _page_of(pictures: Sequence[tuple[str, NDArray]], columns: int) -> tuple["Figure", list["Axes"]]:
    """A figure for pictures (title, (height, width, ...)) of one size, without scales."""
    height, width = pictures[0][1].shape[:2]
    rows = -(-len(pictures) // columns)
    figure, axes = _page(columns, rows, (_INCHES * columns, (_INCHES * height / width + 0.45) * rows))
    for axis in axes:
        axis.set_axis_off()
    return figure, axes


def picture_row(path: Path, pictures: Sequence[tuple[str, NDArray]], columns: int = 0) -> None:
    """Write pictures in a row, or `columns` to one: (title, (height, width, 3) encoded for the display, 0..1) each."""
    figure, axes = _page_of(pictures, columns or len(pictures))
    for axis, (title, picture) in zip(axes, pictures, strict=False):
        axis.imshow(np.clip(picture, 0.0, 1.0), interpolation="lanczos")
        axis.set_title(title, fontsize=11)
    figure.savefig(path)


def delta_e_maps(
    path: Path, maps: Sequence[tuple[str, NDArray]], vmax: float = 5.0, columns: int = 2, measure: str = "ΔE2000"
) -> None:
    """Write maps of colour difference (title, (height, width)) in a grid, with one colour bar from 0 to `vmax`.

    The title of each gets the median and the 98th percentile; 1 is a just noticeable difference.
    """
    figure, axes = _page_of(maps, columns)
    for axis, (title, values) in zip(axes, maps, strict=False):
        shown = axis.imshow(values, vmin=0.0, vmax=vmax, cmap="inferno", interpolation="nearest")
        median, p98 = np.percentile(values, [50, 98])
        axis.set_title(f"{title}\nmedian {median:.2f}, 98th percentile {p98:.2f}", fontsize=9)
    bar = figure.colorbar(shown, ax=list(axes), fraction=0.03, extend="max")
    bar.set_label(f"{measure} (1 is just noticeable)")
    figure.savefig(path)


def curves(path: Path, panels: Sequence[Panel], columns: int = 0) -> None:
    """Plot panels side by side, `columns` to a row, with one legend; on a logarithmic axis 0 or less is left out."""
    columns = columns or len(panels)
    rows = -(-len(panels) // columns)
    size = (8, 5.5) if len(panels) == 1 else (_INCHES * columns, 4.5 * rows)
    alike = len({(panel.up, panel.log) for panel in panels}) == 1 and "y" in panels[0].log
    figure, axes = _page(columns, rows, size, alike)
    named: dict = {}
    for axis, panel in zip(axes, panels, strict=False):
        axis.set(xlabel=panel.across, ylabel="" if alike and axis is not axes[0] else panel.up, title=panel.title)
        axis.set(**{f"{which}scale": "log" for which in panel.log})
        for name, x, y, *style in panel.lines:
            if "y" in panel.log:
                y = np.where(np.asarray(y) > 0, y, np.nan)
            (line,) = axis.plot(x, y, *(style or ["o-"]), markersize=4, linewidth=1.2, label=name)
            if name and not any(letter.isalpha() and letter != "o" for letter in "".join(style)):
                line.set_color(named[name].get_color() if name in named else f"C{len(named)}")
            if name:
                named.setdefault(name, line)
        axis.grid(True, linewidth=0.4, alpha=0.5)
        if np.size(panel.ticks):
            axis.set_xticks(panel.ticks)
        _plain_numbers(axis)
    for axis in axes[len(panels) :]:
        axis.remove()
    if named:
        figure.legend(named.values(), named.keys(), loc="outside lower center", ncols=6, fontsize=9)
    figure.savefig(path)


def design_matrix(path: Path, palette: "Palette", report: "Report") -> None:
    """Draw the colours of a design: on the left of each patch what is wanted, on its right full spectra over the model.

    What is wanted is the target, or what a free colour came to. The margins show lights on white and reflectances
    under flat light.
    """
    from matplotlib.patches import Rectangle

    from ..core.palette import matrix_colours

    wanted, full, model, lights, reflectances = matrix_colours(palette)
    errors = {(cell.reflectance, cell.light): cell.error for cell in report.cells}
    free = {(cell.reflectance, cell.light): cell.free for cell in palette.cells}
    rows, columns = full.shape[:2]
    figure, (axis,) = _page(1, 1, (1.15 * columns + 2.55, 1.15 * rows + 1.45))

    def patch(corner: tuple[float, float], width: float, height: float, colour: NDArray) -> None:
        axis.add_patch(Rectangle(corner, width, height, facecolor=colour, edgecolor="0.8", linewidth=0.4))

    def name(entry: "Entry") -> str:
        return f"{entry.name} *" if entry.designed else entry.name

    for column, entry in enumerate(palette.lights):
        patch((column, -0.55), 0.94, 0.42, lights[column])
        axis.text(column + 0.47, -0.62, name(entry), ha="center", va="bottom", fontsize=9)
    for row, entry in enumerate(palette.reflectances):
        patch((-0.55, row), 0.42, 0.94, reflectances[row])
        axis.text(-0.62, row + 0.47, name(entry), ha="right", va="center", fontsize=9)
    for row, column in np.ndindex(rows, columns):
        here, target = (row, column), wanted[row, column]
        patch((column, row), 0.47, 0.94, full[here] if np.isnan(target).any() else target)
        patch((column + 0.47, row), 0.47, 0.47, full[here])
        patch((column + 0.47, row + 0.47), 0.47, 0.47, model[here])
        if here in free:
            axis.add_patch(Rectangle((column, row), 0.94, 0.94, fill=False, edgecolor="0.25", linewidth=1.0))
            words = free[here] or (f"{errors[here]:.1f}" if here in errors else "")
            ink = "white" if full[here] @ (0.2126, 0.7152, 0.0722) < 0.5 else "black"
            axis.text(column + 0.06, row + 0.86, words, fontsize=8, color=ink)
    axis.set(xlim=(-1.6, columns), ylim=(rows, -0.95), aspect="equal")
    axis.set_axis_off()
    figure.savefig(path)


def _plain_numbers(axis: "Axes") -> None:
    """1 and 100 in place of powers of ten, on logarithmic axes."""
    for ticks in (axis.xaxis, axis.yaxis):
        if ticks.get_scale() == "log":
            ticks.set_major_formatter("{x:g}")
            ticks.set_minor_formatter("")
