"""What a design has come to: how near each colour is, what gave way, and what could have been had instead."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..colour.differences import delta_E_2000
from ..colour.spaces import D65_WHITE
from ..spectra.arrays import Array
from . import colours, criteria
from .criteria import State
from .design import Cell, Constancy, Difference, Entry, Palette
from .solve import Solution, costs, create, start

__all__ = ["CellReport", "Report", "matrix_colours", "matrix_xyz", "patches", "report"]

NOTICED = 1.0  # CIEDE2000 from which a wanted colour counts as missed
UNSEEN = 0.05  # CIEDE2000 by which a difference may be beside what was asked without a word

Met = tuple[str, str, float, bool]  # words, demand, CIEDE2000 reached, whether that is what was asked


@dataclass(frozen=True, eq=False)
class CellReport:
    """One cell. Colours are XYZ (3,); None where there are none.

    wanted: the target, or what the free colour came to. full, model: from full spectra, and as the factor model has it.
    error: CIEDE2000 of wanted and full; model_error: of full and model. nearest: for a missed target the nearest colour
    that this cell alone could have, nearest_error away.
    """

    where: str
    reflectance: int
    light: int
    wanted: Array
    full: Array
    model: Array | None
    error: float
    model_error: float | None
    nearest: Array | None = None
    nearest_error: float | None = None


@dataclass(frozen=True, eq=False)
class Report:
    """cells: CellReport for each cell that takes part. shares: {criterion: part of the squared residuals, 0..1}.

    constancies: (words, the largest CIEDE2000 of two of its colours). remarks: sentences on what gave way and whether
    the design converged.
    """

    cells: tuple[CellReport, ...]
    differences: tuple[Met, ...]
    constancies: tuple[tuple[str, float], ...]
    shares: dict[str, float]
    remarks: tuple[str, ...]


def report(solution: Solution) -> Report:
    """How near a Solution comes to what its design asks for."""
    palette, state = solution.palette, solution.state
    xyz, whites = state.colours(), state.whites()
    cells = tuple(_cell(palette, state, xyz, whites, solution.free, cell) for cell in palette.cells if cell.weight > 0)
    differences = tuple(_difference(palette, xyz, whites, one) for one in palette.differences)
    constancies = tuple(_constancy(palette, xyz, whites, one) for one in palette.constancies)
    shares = _shares(solution)
    return Report(cells, differences, constancies, shares, tuple(_remarks(solution, cells, differences, shares)))


def patches(palette: Palette) -> tuple[Array, Array | None]:
    """XYZ of all cells as the spectra are now: full (r, l, 3), and of the model (r, l, 3) or None."""
    state = start(palette)
    model = palette.criteria.model
    if model is None:
        return state.colours(), None
    made = [criteria.model_colour(model, light, state.reflectances) for light in state.lights]
    return state.colours(), np.stack(made, axis=1) if made else state.colours()


def matrix_xyz(palette: Palette) -> tuple[Array, ...]:
    """What the matrix shows, in XYZ: wanted (r, l, 3), NaN where nothing is; full (r, l, 3); model (r, l, 3);
    lights on white (l, 3); reflectances under flat light (r, 3). Without a model its colours are the full ones.
    """
    full, model = patches(palette)
    wanted = np.full(full.shape, np.nan)
    for cell in palette.cells:
        if cell.target is not None:
            wanted[cell.reflectance, cell.light] = cell.target
    lights, reflectances = (palette.sampled(kind) @ colours.xyz_weights().T for kind in ("light", "reflectance"))
    return wanted, full, full if model is None else model, lights, reflectances


def matrix_colours(palette: Palette) -> tuple[Array, ...]:
    """The same in sRGB 0..1."""
    return tuple(colours.srgb_from_xyz(xyz) for xyz in matrix_xyz(palette))


def _cell(palette: Palette, state: State, xyz: Array, whites: Array, free: dict[str, Array], cell: Cell) -> CellReport:
    full, white, model = xyz[cell.reflectance, cell.light], whites[cell.light], palette.criteria.model
    made = None
    if model is not None:
        made = criteria.model_colour(model, state.lights[cell.light], state.reflectances[cell.reflectance])
    wanted = colours.xyz_from_rgb(free[cell.free]) if cell.free in free else full
    wanted = wanted if cell.target is None else np.array(cell.target, float)
    seen = made if palette.criteria.use_model and made is not None else full
    error = float(delta_E_2000(wanted, seen, white))
    model_error = None if made is None else float(delta_E_2000(full, made, white))
    nearest = nearest_error = None
    if cell.target is not None and error > NOTICED:
        alone = _alone(palette, cell)
        if alone is not None:
            nearest = alone.state.colours()[cell.reflectance, cell.light]
            nearest_error = float(delta_E_2000(wanted, nearest, alone.state.whites()[cell.light]))
    place = palette.where(cell), cell.reflectance, cell.light
    return CellReport(*place, wanted, full, made, error, model_error, nearest, nearest_error)


def _alone(palette: Palette, cell: Cell) -> Solution | None:
    """The Solution of a design for one cell only; None where nothing is designed in it."""
    keys = (("light", cell.light), ("reflectance", cell.reflectance))
    # Where both are designed the light is left as it is: the reflectance alone can do most
    made = next((key for key in reversed(keys) if palette.entry(*key).designed), None)
    if made is None:
        return None

    def only(kind: str, entries: Sequence[Entry]) -> tuple[Entry, ...]:
        return tuple(
            replace(entry, designed=(kind, index) == made, near_weight=0.0, span_weight=0.0)
            for index, entry in enumerate(entries)
        )

    return create(
        replace(
            palette,
            lights=only("light", palette.lights),
            reflectances=only("reflectance", palette.reflectances),
            cells=(replace(cell, weight=1.0),),
            differences=(),
            constancies=(),
            criteria=replace(palette.criteria, space="perceptual", smoothness=1e-5, model_error=0.0),
        )
    )


def _difference(palette: Palette, xyz: Array, whites: Array, one: Difference) -> Met:
    reached = float(delta_E_2000(xyz[one.first, one.light], xyz[one.second, one.light], whites[one.light]))
    bounds = (("at least", one.least), ("at most", one.most))
    demands = [f"{word} {bound:g}" for word, bound in bounds if bound is not None]
    met = (one.least is None or reached > one.least - UNSEEN) and (one.most is None or reached < one.most + UNSEEN)
    return palette.where_both(one), " and ".join(demands), reached, met


def _constancy(palette: Palette, xyz: Array, whites: Array, one: Constancy) -> tuple[str, float]:
    seen, white = [xyz[one.reflectance, light] for light in one.lights], whites[one.lights[0]]
    if one.adapted:
        seen = [colours.adapted(whites[light]) @ colour for light, colour in zip(one.lights, seen, strict=True)]
        white = D65_WHITE * white[1]
    names = ", ".join(repr(palette.lights[light].name) for light in one.lights)
    largest = max(float(delta_E_2000(a, b, white)) for a in seen for b in seen)
    return f"{palette.reflectances[one.reflectance].name!r} under {names}", largest


def _shares(solution: Solution) -> dict[str, float]:
    found = costs(solution.palette, solution.state)
    total = sum(found.values())
    return {name: cost / total if total > 0 else 0.0 for name, cost in found.items()}


def _remarks(
    solution: Solution, cells: Sequence[CellReport], differences: Sequence[Met], shares: dict[str, float]
) -> Iterator[str]:
    if not solution.convex:
        how = "converged" if solution.converged else "has not converged"
        yield f"Not convex, so solved step by step: it {how} in {solution.steps} steps."
    for words in solution.slack:
        yield f"{words[0].upper()}{words[1:]} cannot be equal to the others: it is as near as the bounds let it."
    missed = [cell for cell in cells if cell.error > NOTICED]
    for cell in missed:
        sentence = f"{cell.where} misses its target by CIEDE2000 {cell.error:.1f}"
        if cell.nearest is None or cell.nearest_error is None:
            yield f"{sentence}: neither its light nor its reflectance is designed."
        elif cell.nearest_error > NOTICED:
            near = f"{colours.encoded(cell.nearest)}, {cell.nearest_error:.1f} away"
            yield f"{sentence}; alone it could come to {near}: its bounds do not let it come nearer."
        else:
            yield f"{sentence}; alone it could be had: it gives way to the other demands."
    for words, demand, reached, met in differences:
        if not met:
            yield f"{words} are CIEDE2000 {reached:.1f} apart and not {demand}."
    if missed and _reachable_without_bounds(solution.palette, missed):
        yield "Without bounds every target could be had: it is the bounds that stand in the way."
    if missed and shares:
        name = max(shares, key=lambda criterion: shares[criterion])
        yield f"Of what is left over, the criterion {name!r} has {100 * shares[name]:.0f} %."


def _reachable_without_bounds(palette: Palette, missed: Sequence[CellReport]) -> bool:
    if not palette.criteria.bounded:
        return False
    free = replace(palette, criteria=replace(palette.criteria, bounded=False))
    state = create(free).state
    xyz, whites = state.colours(), state.whites()
    seen = [delta_E_2000(one.wanted, xyz[one.reflectance, one.light], whites[one.light]) for one in missed]
    return bool(max(seen) < NOTICED)
