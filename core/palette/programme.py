"""The least squares of a system of equations: without bounds the solution of least norm, within bounds a programme.

Both are exact to some 1e-9. `benchmarks/palette_solvers.py` says why the programme is solved by Clarabel.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..spectra.arrays import Array
from .criteria import Block, System
from .design import Key

__all__ = ["minimum", "unbounded"]

Values = dict[Key, Array]

# Weight of the length of what is found: among equal solutions the shortest. It must not outweigh the smoothness
RIDGE, LEAST_RIDGE = 1e-6, 1e-9
# Scale of all residuals, so that the solver's tolerances are finer than the smoothness, and least weight of the length.
# Now and then it stops early with one pair: the next is tried where the error of the KKT conditions is above ENOUGH
ATTEMPTS, ENOUGH = (*((scale, LEAST_RIDGE) for scale in (1e2, 1e3, 1e1)), (1e2, 1e-5), (1e1, 1e-4)), 1e-7
FAIR = 1e-3  # ... and above this it is no solution
SOFT = 1e3  # weight of free colours where nothing makes them equal
INSIDE, HELD = 1e-12, 1e-7  # by how much bounds and hard equations may be missed


def minimum(equations: System, soften: bool = False) -> tuple[Values, float, tuple[str, ...]]:
    """The x of least squared residuals within its bounds -> {key: (n,)}, error of the KKT conditions, words.

    The words name hard equations that nothing within the bounds fulfils, and which are then only weighty; `soften` says
    that it is known already that there are such.
    """
    x = unbounded(equations)
    inside = all(
        (low - INSIDE <= x[key]).all() and (x[key] <= high + INSIDE).all()
        for key, (low, high) in equations.bounds.items()
    )
    held = not _unmet(equations, x)
    if inside and held:
        x = {key: np.clip(x[key], *equations.bounds[key]) for key in x}
        return x, _kkt(equations, x, None), ()
    # What cannot hold without bounds cannot hold within them
    best = _within(equations) if held and not soften else None
    if best is not None:
        return *best, ()
    softened = replace(equations, blocks=tuple(_softened(block) for block in equations.blocks))
    best = _within(softened)
    if best is None:
        clipped = {key: np.clip(x[key], *equations.bounds[key]) for key in x}
        best = clipped, _kkt(softened, clipped, None)
    return *best, _unmet(equations, best[0])


def _within(equations: System) -> tuple[Values, float] | None:
    """The best that is found within the bounds -> {key: (n,)}, error of the KKT conditions; None for nothing."""
    best: tuple[Values, float] | None = None
    for scale, ridge in ATTEMPTS:
        # Those that mind the length are for where nothing else has come to an end
        if ridge > LEAST_RIDGE and best is not None:
            break
        found = _programme(equations, scale, ridge)
        error = np.inf if found is None else _kkt(equations, *found)
        if found is not None and error < FAIR and (best is None or error < best[1]):
            best = found[0], error
        if error < ENOUGH:
            break
    return best if best is None else _polished(equations, *best)


def _polished(equations: System, x: Values, error: float) -> tuple[Values, float]:
    """The same, where only free colours have bounds: once these are found, least squares finds the rest, and better.

    A spectrum without bounds may go far in directions that cost next to nothing, before the programme minds.
    """
    bounded = [
        key for key, (low, high) in equations.bounds.items() if np.isfinite(low).any() or np.isfinite(high).any()
    ]
    if not bounded or any(key[0] != "free" for key in bounded):
        return x, error
    known = {key: x[key] for key in x if key[0] == "free"}
    blocks = []
    for block in equations.blocks:
        rest = tuple((key, matrix) for key, matrix in block.parts if key not in known)
        right = block.right - sum((matrix @ known[key] for key, matrix in block.parts if key in known), 0.0)
        blocks += [replace(block, parts=rest, right=right)] if rest else []
    sizes = {key: size for key, size in equations.sizes.items() if key not in known}
    better = known | unbounded(replace(equations, blocks=tuple(blocks), sizes=sizes))
    return better, max(error, _kkt(equations, better, None))


def _unmet(equations: System, x: Values) -> tuple[str, ...]:
    """The words of hard equations that do not hold."""
    return tuple(b.words for b in equations.blocks if b.hard and np.abs(b.residual(x)).max() > HELD)


def _softened(block: Block) -> Block:
    if not block.hard:
        return block
    parts = tuple((key, SOFT * matrix) for key, matrix in block.parts)
    return replace(block, hard=False, parts=parts, right=SOFT * block.right)


def _layout(equations: System) -> tuple[dict[Key, slice], int]:
    """{key: slice} of one vector of all unknowns, and its length."""
    places, at = {}, 0
    for key, size in equations.sizes.items():
        places[key] = slice(at, at + size)
        at += size
    return places, at


def _ridges(equations: System) -> dict[Key, float]:
    """{key: weight of its length}."""
    own = {block.own for block in equations.blocks}
    return {key: LEAST_RIDGE if key in own else RIDGE for key in equations.sizes}


def unbounded(equations: System) -> Values:
    """The least squares solution of least norm, as if there were no bounds -> {key: (n,)}.

    Blocks of one spectrum alone, as smoothness, are its norm: x = G^-1 (h + u). The rest is a system of few rows, whose
    least-norm solution is u: milliseconds for a dozen spectra.
    """
    places, size = _layout(equations)
    ridges = _ridges(equations)
    inverse, known = {}, np.zeros(size)
    for key, place in places.items():
        alone = [block for block in equations.blocks if block.own == key]
        own = [block.parts[0][1] for block in alone] + [ridges[key] * np.eye(equations.sizes[key])]
        triangular = np.linalg.qr(np.concatenate(own), mode="r")
        inverse[key] = np.linalg.inv(triangular)
        right = sum((block.parts[0][1].T @ block.right for block in alone), np.zeros(equations.sizes[key]))
        known[place] = inverse[key] @ (inverse[key].T @ right)
    rest = [block for block in equations.blocks if block.own is None]
    if rest:
        rows, right = _stacked(rest, places, size)
        right = right - rows @ known
        for key, place in places.items():
            rows[:, place] = rows[:, place] @ inverse[key]
        # Soft equations may be missed, at a price of their residual
        missed = np.diag(np.concatenate([np.full(block.right.size, float(not block.hard)) for block in rest]))
        u = np.linalg.lstsq(np.concatenate([rows, missed], axis=1), right, rcond=1e-15)[0]
        for key, place in places.items():
            known[place] += inverse[key] @ u[place]
    return {key: known[place] for key, place in places.items()}


def _programme(equations: System, scale: float, ridge: float) -> tuple[Values, Array] | None:
    """Minimise within bounds -> {key: (n,)}, multipliers of the hard blocks; None where those cannot hold."""
    import clarabel
    from scipy import sparse

    places, size = _layout(equations)
    soft = [block for block in equations.blocks if not block.hard]
    hard = [block for block in equations.blocks if block.hard]
    matrix, right = _stacked(soft, places, size)
    count = right.size
    held, values = _stacked(hard, places, size)
    lower = np.concatenate([equations.bounds[key][0] for key in places])
    upper = np.concatenate([equations.bounds[key][1] for key in places])
    below, above = np.isfinite(lower), np.isfinite(upper)
    # The residuals are unknowns of their own: the matrix squared would have half the digits
    nothing = sparse.csc_matrix((size, count))
    rows = [
        sparse.hstack([sparse.csc_matrix(scale * matrix), -sparse.eye(count)]),
        sparse.hstack([sparse.csc_matrix(held), sparse.csc_matrix((values.size, count))]),
        sparse.hstack([sparse.eye(size), nothing]).tocsr()[above],
        sparse.hstack([-sparse.eye(size), nothing]).tocsr()[below],
    ]
    ridges = _ridges(equations)
    lengths = np.concatenate(
        [np.full(size, (scale * max(ridges[key], ridge)) ** 2) for key, size in equations.sizes.items()]
    )
    cost = sparse.diags(np.concatenate([lengths, np.ones(count)])).tocsc()
    cones = [
        clarabel.ZeroConeT(count + values.size),
        clarabel.NonnegativeConeT(int(above.sum() + below.sum())),
    ]
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_iter = 100
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-12
    settings.max_threads = 1
    limits = np.concatenate([scale * right, values, upper[above], -lower[below]])
    linear = np.zeros(size + count)
    found = clarabel.DefaultSolver(cost, linear, sparse.vstack(rows).tocsc(), limits, cones, settings).solve()
    if "Infeasible" in str(found.status) or not np.isfinite(found.x).all():
        return None
    x = np.clip(np.array(found.x)[:size], lower, upper)
    if np.abs(held @ x - values).max(initial=0.0) > HELD:
        return None
    duals = np.array(found.z)[count : count + values.size] / scale**2
    return {key: x[place] for key, place in places.items()}, duals


def _stacked(blocks: Sequence[Block], places: dict[Key, slice], size: int) -> tuple[Array, Array]:
    """Blocks as one matrix (m, size) and right side (m,)."""
    right = np.concatenate([np.zeros(0), *(block.right for block in blocks)])
    matrix, at = np.zeros((right.size, size)), 0
    for block in blocks:
        for key, part in block.parts:
            matrix[at : at + block.right.size, places[key]] = part
        at += block.right.size
    return matrix, right


def _kkt(equations: System, x: Values, duals: Array | None) -> float:
    """How far a projected step down the gradient, no longer than the steepest curvature allows, moves x.

    duals: multipliers of the hard equations; those that fit best where there are none.
    """
    places, size = _layout(equations)
    soft, right = _stacked([block for block in equations.blocks if not block.hard], places, size)
    hard, _ = _stacked([block for block in equations.blocks if block.hard], places, size)
    values = np.concatenate([x[key] for key in places])
    low, high = (np.concatenate([equations.bounds[key][side] for key in places]) for side in (0, 1))
    gradient = soft.T @ (soft @ values - right)
    if duals is None:
        inside = (values > low + 1e-6) & (values < high - 1e-6)
        duals = np.linalg.lstsq(hard.T[inside], -gradient[inside], rcond=None)[0]
    gradient += hard.T @ duals
    curvature = max(1.0, (soft**2).sum(axis=0).max(initial=0.0))
    return float(np.abs(values - np.clip(values - gradient / curvature, low, high)).max(initial=0.0))
