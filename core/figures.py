"""Pictures of pictures: side by side, and maps of colour differences with a colour bar."""

import importlib.util
from pathlib import Path

import numpy as np

__all__ = ["available", "curves", "delta_e_maps", "error_over_time", "picture_row"]

_INCHES = 4.0  # width of one picture on the page
_DPI = 120


def available() -> bool:
    """Whether matplotlib, which draws them, is there: Blender's own Python lacks it."""
    try:
        return importlib.util.find_spec("matplotlib") is not None
    except ValueError:
        return False  # colour-science has put a stand-in in its place


def _page(columns: int, rows: int, aspect: float):
    """A figure of columns × rows pictures, `aspect` high for 1 wide, drawn without a screen."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    size = (_INCHES * columns, (_INCHES * aspect + 0.45) * rows)
    figure = Figure(figsize=size, dpi=_DPI, layout="constrained", facecolor="white")
    FigureCanvasAgg(figure)
    axes = np.atleast_1d(figure.subplots(rows, columns)).ravel()
    for axis in axes:
        axis.set_axis_off()
    return figure, axes


def _aspect(pictures) -> float:
    height, width = pictures[0][1].shape[:2]
    return height / width


def picture_row(path: Path, pictures: list[tuple[str, np.ndarray]]) -> None:
    """Write pictures in a row: (title, (height, width, 3) encoded for the display, 0..1) each."""
    figure, axes = _page(len(pictures), 1, _aspect(pictures))
    for axis, (title, picture) in zip(axes, pictures, strict=True):
        axis.imshow(np.clip(picture, 0.0, 1.0), interpolation="lanczos")
        axis.set_title(title, fontsize=11)
    figure.savefig(path)


def delta_e_maps(path: Path, maps: list[tuple[str, np.ndarray]], vmax: float = 5.0, columns: int = 2) -> None:
    """Write maps of colour difference (title, (height, width)) in a grid, with one colour bar from 0 to `vmax`.

    The title of each gets the median and the 98th percentile; 1 is a just noticeable difference.
    """
    figure, axes = _page(columns, -(-len(maps) // columns), _aspect(maps))
    for axis, (title, values) in zip(axes, maps, strict=False):
        shown = axis.imshow(values, vmin=0.0, vmax=vmax, cmap="inferno", interpolation="nearest")
        median, p98 = np.percentile(values, [50, 98])
        axis.set_title(f"{title}\nmedian {median:.2f}, 98th percentile {p98:.2f}", fontsize=9)
    bar = figure.colorbar(shown, ax=list(axes), fraction=0.03, extend="max")
    bar.set_label("ΔE2000 (1 is just noticeable)")
    figure.savefig(path)


def error_over_time(path: Path, points: list[tuple[str, float, float, float]], marked: str) -> None:
    """Plot (name, seconds, total error, error of the model alone), both axes logarithmic; `marked` stands out."""
    figure, (axis,) = _plot(1)
    least = 0.01  # a logarithmic axis has no zero
    for name, seconds, total, model in points:
        color = "tab:red" if name == marked else "tab:blue"
        total, model = max(total, least), max(model, least)
        axis.plot([seconds, seconds], [model, total], color=color, linewidth=1, alpha=0.5)
        axis.plot(seconds, total, "o", color=color)
        axis.plot(seconds, model, "_", color=color, markersize=12)
        axis.annotate(name, (seconds, model), xytext=(7, -4), textcoords="offset points", fontsize=9, color=color)
    axis.axhline(1.0, color="grey", linewidth=0.8, linestyle=":")
    axis.margins(x=0.2)
    axis.set(xscale="log", yscale="log", xlabel="seconds", ylabel="ΔE2000 to the reference, 98th percentile")
    for ticks in (axis.xaxis, axis.yaxis):
        ticks.set_major_formatter("{x:g}")
        ticks.set_minor_formatter("")
    axis.xaxis.set_minor_formatter("{x:g}")
    axis.set_title("Error against run time: dot with noise, dash the model alone", fontsize=11)
    figure.savefig(path)


def curves(path: Path, panels: list[tuple[str, list]], up: str) -> None:
    """Plot lines (name, x, y) in panels side by side, all axes logarithmic; values of 0 or less are left out.

    panels: (what x is, lines) each. up: what y is. A name has the same colour everywhere, and one legend.
    """
    figure, axes = _plot(len(panels))
    colors = {}
    for axis, (across, lines) in zip(axes, panels, strict=True):
        for name, x, y in lines:
            color = colors.setdefault(name, f"C{len(colors)}")
            axis.plot(x, np.where(np.asarray(y) > 0, y, np.nan), "o-", markersize=4, linewidth=1.2, color=color)
        axis.set(xscale="log", yscale="log", xlabel=across)
        for ticks in (axis.xaxis, axis.yaxis):
            ticks.set_major_formatter("{x:g}")
            ticks.set_minor_formatter("")
        axis.grid(True, linewidth=0.4, alpha=0.5)
    axes[0].set_ylabel(up)
    handles = [axes[0].plot([], [], "o-", markersize=4, color=color, label=name)[0] for name, color in colors.items()]
    figure.legend(handles=handles, loc="outside lower center", ncols=6, fontsize=9)
    figure.savefig(path)


def _plot(panels: int):
    """A figure with axes side by side, drawn without a screen."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    size = (8, 5.5) if panels == 1 else (_INCHES * panels, 4.5)
    figure = Figure(figsize=size, dpi=_DPI, layout="constrained", facecolor="white")
    FigureCanvasAgg(figure)
    return figure, np.atleast_1d(figure.subplots(1, panels, sharey=True))
