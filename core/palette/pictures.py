"""Pictures of a design, by matplotlib: the matrix of its colours, and its spectra as curves."""

import numpy as np

from ..spectra.spectrum import WAVELENGTHS
from . import colours
from .report import patches
from .solve import start

__all__ = ["curves", "matrix", "matrix_colours", "matrix_xyz"]

_INCHES, _DPI = 1.15, 120  # width of one patch


def matrix_xyz(palette):
    """What the matrix shows, in XYZ: wanted (r, l, 3), NaN where nothing is; full (r, l, 3); model (r, l, 3);
    lights on white (l, 3); reflectances under flat light (r, 3). Without a model its colours are the full ones.
    """
    full, model = patches(palette)
    wanted = np.full(full.shape, np.nan)
    for cell in palette.cells:
        if cell.target is not None:
            wanted[cell.reflectance, cell.light] = cell.target
    state = start(palette)
    weights = colours.xyz_weights().T
    return wanted, full, full if model is None else model, state.lights @ weights, state.reflectances @ weights


def matrix_colours(palette):
    """The same in sRGB 0..1."""
    return tuple(colours.srgb_from_xyz(xyz) for xyz in matrix_xyz(palette))


def matrix(path, palette, report=None):
    """Write the matrix as a picture.

    Each patch is the wanted colour, or what a free colour came to, and on its right that of full spectra over that of
    the model. The margins show lights on white and reflectances under flat light.
    """
    wanted, full, model, lights, reflectances = matrix_colours(palette)
    errors = {(cell.reflectance, cell.light): cell.error for cell in report.cells} if report else {}
    free = {(cell.reflectance, cell.light): cell.free for cell in palette.cells}
    rows, columns = full.shape[:2]
    figure, axis = _figure(_INCHES * (columns + 1) + 1.4, _INCHES * (rows + 1) + 0.3)

    def patch(column, row, width, height, color):
        from matplotlib.patches import Rectangle

        axis.add_patch(
            Rectangle((column, row), width, height, facecolor=np.clip(color, 0, 1), edgecolor="0.8", linewidth=0.4)
        )

    for column, entry in enumerate(palette.lights):
        patch(column, -0.55, 0.94, 0.42, lights[column])
        axis.text(column + 0.47, -0.62, entry.name + _mark(entry), ha="center", va="bottom", fontsize=9)
    for row, entry in enumerate(palette.reflectances):
        patch(-0.55, row, 0.42, 0.94, reflectances[row])
        axis.text(-0.62, row + 0.47, entry.name + _mark(entry), ha="right", va="center", fontsize=9)
        for column in range(columns):
            here, target = (row, column), wanted[row, column]
            used = here in free
            left = full[here] if np.isnan(target).any() else target
            patch(column, row, 0.47, 0.94, left)
            patch(column + 0.47, row, 0.47, 0.47, full[here])
            patch(column + 0.47, row + 0.47, 0.47, 0.47, model[here])
            words = [free.get(here, "")] + ([f"{errors[here]:.1f}"] if here in errors and not free[here] else [])
            ink = "white" if full[here] @ (0.2126, 0.7152, 0.0722) < 0.5 else "black"
            axis.text(column + 0.06, row + 0.86, " ".join(words).strip(), fontsize=8, color=ink)
            if used:
                from matplotlib.patches import Rectangle

                axis.add_patch(Rectangle((column, row), 0.94, 0.94, fill=False, edgecolor="0.25", linewidth=1.0))
    axis.set(xlim=(-1.6, columns), ylim=(rows, -0.95), aspect="equal")
    axis.set_axis_off()
    figure.savefig(path)


def _mark(entry):
    return " *" if entry.designed else ""


def curves(path, palette):
    """Write the spectra as curves: lights, each with its highest at 1, and reflectances; what is designed is bold."""
    from matplotlib.ticker import MaxNLocator

    figure, axes = _figure(10.0, 3.6, 2)
    for axis, kind, entries in zip(axes, ("light", "reflectance"), (palette.lights, palette.reflectances), strict=True):
        for number, (entry, values) in enumerate(zip(entries, palette.sampled(kind), strict=True)):
            peak = np.abs(values).max() if kind == "light" else 1.0
            style = {"linewidth": 2.0} if entry.designed else {"linewidth": 1.0, "linestyle": "--"}
            axis.plot(WAVELENGTHS, values / (peak or 1.0), color=f"C{number}", label=entry.name, **style)
        if kind == "reflectance":
            for bound in (0.0, 1.0):
                axis.axhline(bound, color="0.7", linewidth=0.8, zorder=0)
        axis.set(xlim=(WAVELENGTHS[0], WAVELENGTHS[-1]), xlabel="nm", title=f"{kind}s")
        axis.yaxis.set_major_locator(MaxNLocator(6))
        if entries:
            axis.legend(fontsize=8)
    figure.savefig(path)


def _figure(width, height, columns=1):
    """A figure that is drawn without a screen, and its axes."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=_DPI, layout="constrained", facecolor="white")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(1, columns)
