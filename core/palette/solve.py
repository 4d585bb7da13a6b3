"""Finding the spectra of a design: in one step where it is convex, step by step where it is not.

Lights and reflectances that meet and are both designed are found in turn: reflectances, lights, reflectances, …
"""

from dataclasses import dataclass, replace

import numpy as np

from ..errors import PaletteError
from ..spectra.arrays import Array
from ..spectra.spectrum import RANGES, WAVELENGTHS, Spectrum
from . import colours
from .criteria import State, system
from .design import Entry, Key, Palette
from .programme import minimum

__all__ = ["Solution", "costs", "create", "start"]

STEPS = 200  # most of them, of what is not convex
# It has converged where no colour changes by more than this, or the squared residuals by no more than these
SETTLED, COST_RELATIVE, COST_ABSOLUTE = 1e-6, 1e-4, 1e-9
PATIENCE = 8  # steps without anything better, after which no more are taken
TRIED = 4  # steps with each direction in which equal colours can be taken apart


@dataclass(frozen=True, eq=False)
class Solution:
    """palette: with its designed spectra. state: all spectra. free: {name: RGB (3,)}.

    convex: whether the design is one convex problem; otherwise `converged` in `steps`. kkt: how far the solution is
    from the conditions of an optimum. slack: free colours that had to be softened, in words.
    """

    palette: Palette
    state: State
    free: dict[str, Array]
    convex: bool
    converged: bool
    steps: int
    kkt: float
    cost: float
    slack: tuple[str, ...] = ()


def create(palette: Palette) -> Solution:
    """Find the designed spectra of a Palette -> Solution. Raises PaletteError for a design without anything to do."""
    designed = palette.designed()
    if not designed:
        raise PaletteError("nothing is to be designed: mark a light or a reflectance as designed")
    if not palette.meetings() and not any(palette.entry(*key).near_weight > 0 for key in designed):
        raise PaletteError("the design has no targets: say what colour a reflectance is to have under a light")
    for cell in palette.cells:
        if cell.weight > 0 and cell.target is not None and np.min(cell.target) < -1e-9 and palette.criteria.bounded:
            raise PaletteError(f"{palette.where(cell)}: a target colour below black needs spectra without bounds")
    from ..model.optimise import one_thread

    with one_thread():
        return _best(palette, designed)


def _best(palette: Palette, designed: list[Key]) -> Solution:
    starts: list[Array | None] = [None]
    if any(one.least is not None for one in palette.differences):
        starts = [sign * axis for axis in np.eye(3) for sign in (1.0, -1.0)]
    tried = [_descend(palette, start(palette), designed, push, STEPS if len(starts) == 1 else TRIED) for push in starts]
    best = min(tried, key=lambda one: one.cost)
    if len(starts) > 1:
        best = _descend(palette, best.state, designed, None, STEPS)
    made = {key: _made(palette.entry(*key), *key, best.state) for key in designed}
    filled = replace(
        palette,
        lights=tuple(made.get(("light", j), entry) for j, entry in enumerate(palette.lights)),
        reflectances=tuple(made.get(("reflectance", i), entry) for i, entry in enumerate(palette.reflectances)),
    )
    return replace(best, palette=filled)


def _made(entry: Entry, kind: str, index: int, state: State) -> Entry:
    """The entry with its spectrum found."""
    is_light = kind == "light"
    values = (state.lights if is_light else state.reflectances)[index]
    luminance = max(float(colours.xyz_weights()[1] @ values), 0.0) if is_light else entry.luminance
    quantity = "illuminant" if is_light else "reflectance"
    if np.abs(values).max() > RANGES[quantity][1]:
        raise PaletteError(f"{kind} {entry.name!r} grows without end: give it bounds, or ask for more smoothness")
    spectrum = Spectrum(WAVELENGTHS, values, entry.name, quantity, "designed")
    return replace(entry, spectrum=spectrum, luminance=luminance)


def start(palette: Palette) -> State:
    """Where a design begins: spectra as they are, flat where there are none yet -> State."""
    return State(palette.sampled("light"), palette.sampled("reflectance"), {})


def _turns(palette: Palette, designed: list[Key]) -> list[list[Key]]:
    """What is solved for together: all, or lights and reflectances in turn where two of them meet."""
    chosen = set(designed)
    meet = any(("reflectance", i) in chosen and ("light", j) in chosen for i, j in palette.meetings())
    if not meet:
        return [designed]
    return [[key for key in designed if key[0] == kind] for kind in ("reflectance", "light")]


def is_convex(palette: Palette, designed: list[Key]) -> bool:
    """Whether one step is all: nothing depends on the spectra that are being found."""
    moving = {index for kind, index in designed if kind == "light"}
    light = any(cell.light in moving for cell in palette.cells)
    perceptual = palette.criteria.space == "perceptual"
    return not (
        len(_turns(palette, designed)) > 1
        or palette.differences
        or (light and (perceptual or palette.criteria.model is not None))
        or any(perceptual or (one.adapted and moving & set(one.lights)) for one in palette.constancies)
        or (perceptual and palette.criteria.model is not None and any(cell.free for cell in palette.cells))
    )


def _descend(palette: Palette, state: State, designed: list[Key], push: Array | None, most: int) -> Solution:
    """Solve, look where that leads, and solve again until nothing changes -> Solution; the best where it goes on."""
    turns, convex = _turns(palette, designed), is_convex(palette, designed)
    best: Solution | None = None
    before, cost = None, np.inf
    slack: dict[int, tuple[str, ...]] = {}  # of each turn, in words
    for step in range(1, (2 if convex else most + 1)):
        kkt = 0.0
        for number, turn in enumerate(turns):
            x, error, slack[number] = minimum(system(palette, state, turn, push), soften=bool(slack.get(number)))
            kkt, state = max(kkt, error), _moved(state, x)
        former, cost = cost, sum(costs(palette, state).values())
        seen = state.colours()
        level = abs(former - cost) < COST_RELATIVE * cost + COST_ABSOLUTE
        done = convex or (before is not None and (level or np.abs(seen - before).max() < SETTLED))
        free = {name: values for (kind, name), values in state.free.items() if kind == "free"}
        words = tuple(dict.fromkeys(each for turn_words in slack.values() for each in turn_words))
        now = Solution(palette, state, free, convex, done, step, kkt, cost, words)
        if done:
            return now
        if best is None or cost < best.cost:
            best = now
        elif step > best.steps + PATIENCE:
            break
        before = seen
    assert best is not None, "at least one step is taken"
    return best


def costs(palette: Palette, state: State) -> dict[str, float]:
    """{criterion: squared residuals} of a State that a design has come to."""
    found: dict[str, float] = {}
    counted: set[tuple[str, str]] = set()
    x = {("light", j): values for j, values in enumerate(state.lights)}
    x |= {("reflectance", i): values for i, values in enumerate(state.reflectances)} | state.free
    for turn in _turns(palette, palette.designed()):
        for block in system(palette, state, turn).blocks:
            if (block.criterion, block.words) not in counted:
                residual = block.residual(x)
                found[block.criterion] = found.get(block.criterion, 0.0) + float(residual @ residual)
                counted.add((block.criterion, block.words))
    return found


def _moved(state: State, x: dict[Key, Array]) -> State:
    lights, reflectances = state.lights.copy(), state.reflectances.copy()
    free = dict(state.free)
    for (kind, index), values in x.items():
        if kind == "light":
            lights[index] = values
        elif kind == "reflectance":
            reflectances[index] = values
        else:
            free[kind, index] = values
    return State(lights, reflectances, free)
