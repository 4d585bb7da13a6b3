"""Solvers for the palette's quadratic programme: 12 reflectances of 81 samples in 0..1, four lights, a free colour.

    python -m relume.benchmarks.palette_solvers [--spectra N] [--repeat N]

Needs `qpsolvers` and what it is to try: `osqp`, `quadprog`, `highspy`, `daqp`; what is not there is left out. Prints
the median time, by how much bounds are left, the error of the KKT conditions and the squared residuals reached.
"""

import argparse
import time

import numpy as np

from ..core.model import optimise
from ..core.palette import Cell, Criteria, Entry, Palette, colours, criteria, programme, solve
from ..core.spectra import library

LIGHTS = ("D65", "A", "FL11", "LED-B1")


def design(count, seed=20040601):
    """Reflectances with one free colour under daylight, and random ones under three lamps."""
    random = np.random.default_rng(seed)
    lights = tuple(Entry(name, library.illuminant(name)) for name in LIGHTS)
    rows = tuple(Entry(f"row {i}", designed=True) for i in range(count))
    cells = [Cell(i, 0, free="A") for i in range(count)]
    real = np.stack([spectrum.sampled() for spectrum in library.reflectances("ces")])
    whites = np.array([entry.spectrum.sampled() for entry in lights])
    seen = colours.colour(whites / (whites @ colours.xyz_weights()[1])[:, None], real)
    for row in range(count):
        cells += [Cell(row, column, tuple(seen[random.integers(len(real)), column])) for column in (1, 2, 3)]
    return Palette(lights, rows, tuple(cells), criteria=Criteria("rgb"))


def stacked(equations):
    """The design as arrays: M, y of soft rows, A, b of hard ones, lower, upper."""
    places, size = programme._layout(equations)
    soft = programme._stacked([block for block in equations.blocks if not block.hard], places, size)
    hard = programme._stacked([block for block in equations.blocks if block.hard], places, size)
    lower, upper = (np.concatenate([equations.bounds[key][side] for key in places]) for side in (0, 1))
    return *soft, *hard, lower, upper


def by_lsq_linear(method):
    """SciPy's bounded least squares; free colours are held by weight, for it knows no equations."""

    def solved(m, y, a, b, lower, upper):
        from scipy.optimize import lsq_linear

        rows, right = np.concatenate([m, 1e3 * a]), np.concatenate([y, 1e3 * b])
        return lsq_linear(rows, right, (lower, upper), method=method, tol=1e-12, max_iter=200).x

    return solved


def by_minimize(m, y, a, b, lower, upper):
    """SciPy's L-BFGS-B, which is the closest to the paper's conjugate gradients with bounds."""
    from scipy.optimize import minimize

    rows, right = np.concatenate([m, 1e3 * a]), np.concatenate([y, 1e3 * b])

    def cost(x):
        residual = rows @ x - right
        return residual @ residual / 2, rows.T @ residual

    start = np.clip(np.linalg.lstsq(rows, right, rcond=1e-12)[0], lower, upper)
    options = {"maxiter": 5000, "maxfun": 10000, "ftol": 0, "gtol": 1e-12}
    return minimize(
        cost, start, jac=True, method="L-BFGS-B", bounds=list(zip(lower, upper, strict=True)), options=options
    ).x


def by_qpsolvers(name):
    """A solver of `qpsolvers`, on the programme with the residuals as unknowns if it is sparse, squared if not."""

    def solved(m, y, a, b, lower, upper):
        import qpsolvers
        from scipy import sparse

        count, size = m.shape
        if name in qpsolvers.dense_solvers:
            squared = m.T @ m + 1e-12 * np.eye(size)
            return qpsolvers.solve_qp(squared, -m.T @ y, A=a, b=b, lb=lower, ub=upper, solver=name)
        scale = programme.ATTEMPTS[0][0]
        cost = sparse.block_diag([1e-14 * sparse.eye(size), sparse.eye(count)]).tocsc()
        equal = sparse.bmat([[scale * sparse.csc_matrix(m), -sparse.eye(count)], [sparse.csc_matrix(a), None]]).tocsc()
        low = np.concatenate([lower, np.full(count, -np.inf)])
        high = np.concatenate([upper, np.full(count, np.inf)])
        options = {"osqp": {"eps_abs": 1e-10, "eps_rel": 1e-10, "max_iter": 50_000}}.get(name, {})
        found = qpsolvers.solve_qp(
            cost,
            np.zeros(size + count),
            A=equal,
            b=np.concatenate([scale * y, b]),
            lb=low,
            ub=high,
            solver=name,
            **options,
        )
        return None if found is None else found[:size]

    return solved


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--spectra", type=int, default=12, metavar="N")
    parser.add_argument("--repeat", type=int, default=3, metavar="N")
    parser.add_argument("--slow", action="store_true", help="also those that take more than ten seconds")
    arguments = parser.parse_args()
    palette = design(arguments.spectra)
    equations = criteria.system(palette, solve.start(palette), palette.designed())
    arrays = m, y, a, b, lower, upper = stacked(equations)
    solvers = {"SciPy L-BFGS-B": by_minimize} if arguments.slow else {}
    if arguments.slow:
        solvers |= {f"SciPy lsq_linear {method}": by_lsq_linear(method) for method in ("trf", "bvls")}
    try:
        import qpsolvers

        solvers |= {name: by_qpsolvers(name) for name in qpsolvers.available_solvers}
    except ImportError:
        print("qpsolvers is not installed: only SciPy and Relume's own")
    print(f"{m.shape[1]} unknowns, {m.shape[0]} soft and {len(b)} hard equations")
    print("| solver | seconds | outside bounds | free colours differ | KKT | squared residuals |")
    print("| --- | --- | --- | --- | --- | --- |")
    places, _ = programme._layout(equations)

    def line(name, solved):
        took = []
        for _ in range(arguments.repeat):
            began = time.perf_counter()
            try:
                x = solved()
            except Exception as error:
                print(f"| {name} | failed: {type(error).__name__} | | | | |")
                return
            took.append(time.perf_counter() - began)
        if x is None:
            print(f"| {name} | {np.median(took):.2f} | no solution | | | |")
            return
        clipped = np.clip(x, lower, upper)
        by_key = {key: clipped[place] for key, place in places.items()}
        print(
            f"| {name} | {np.median(took):.2f} | {np.abs(x - clipped).max():.0e} | {np.abs(a @ x - b).max():.0e} "
            f"| {programme._kkt(equations, by_key, None):.0e} | {((m @ clipped - y) ** 2).sum():.9f} |",
            flush=True,
        )

    def relume():
        x, _, _ = programme.minimum(equations)
        return np.concatenate([x[key] for key in places])

    with optimise.one_thread():
        line("Relume (Clarabel)", relume)
        for name, solver in solvers.items():
            line(name, lambda solver=solver: solver(*arrays))


if __name__ == "__main__":
    main()
