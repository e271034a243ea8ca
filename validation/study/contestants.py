"""Solvers of other authors, called directly, so that only their own set-up and solve are timed.

Each library gets the zone in scaled variables (minimise 1/2 |z|^2 subject to C z >= s), in arrays
of the form that it needs. Making these arrays is not timed, and there is no wrapper in between.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from scipy.sparse import csc_matrix, eye_array

from izo_ref.base.arrays import Floats
from validation.oracles.answer import ScaledZone

# 1e-10 is among them because a library that is asked for 1e-9 often ends a little above
TOLERANCES = (1e-3, 1e-6, 1e-8, 1e-10, 1e-12)
DENSE_IMPACTS = 1024  # limit of dense libraries, which take 8 n m bytes and n^3 operations
EVERY = 1 << 30
SLSQP_IMPACTS = 64  # limit of SLSQP; it factorises all constraints in each iteration, 2 s for these
PIQP_DENSE_IMPACTS = 256  # limit of PIQP's dense solver; above, its sparse solver is faster


class Found(NamedTuple):
    """The answer of a library, in scaled variables."""

    z: Floats | None  # (3 n_unpinned,) f8
    multipliers: Floats | None  # (n_impacts,) f8
    says: str  # "solved", or the status that the library reports


Prepared: TypeAlias = tuple[Callable[[], Any], Callable[[Any], Found]]  # call, read


class Library(NamedTuple):
    """A library that solves zones.

    Attributes:
        name: Its name on the page.
        prepare: Function of a `ScaledZone`, a tolerance and a limit of seconds. It returns `call`
            and `read`. `call()` is timed, and `read` converts its result to a `Found`.
        tolerances: Tolerances that the library can be asked for; one if it has no such setting.
        most: Largest number of impacts of a zone that it gets.
    """

    name: str
    prepare: Callable[[ScaledZone, float, float], Prepared]
    tolerances: tuple[float, ...]
    most: int


def _dense(zone: ScaledZone) -> tuple[Floats, Floats, int]:
    """Return the dense matrix, the right-hand side and the number of unknowns."""
    return zone.matrix.toarray(), zone.rhs, zone.matrix.shape[1]


def _daqp(zone: ScaledZone, tolerance: float, limit_s: float) -> Prepared:
    from ctypes import c_int

    import daqp

    matrix, rhs, n = _dense(zone)
    upper, sense = np.full(len(rhs), 1e30), np.zeros(len(rhs), c_int)  # infinity of DAQP
    settings = {
        "primal_tol": tolerance,
        "dual_tol": tolerance,
        "iter_limit": 100 * (len(rhs) + n),
        "time_limit": limit_s,
    }

    def call() -> Any:
        # without an objective DAQP minimises 1/2 |z|^2, a third faster than with the identity
        return daqp.solve(None, None, matrix, upper, rhs, sense, **settings)

    def read(result: Any) -> Found:
        z, _, flag, info = result
        return Found(z, np.abs(info["lam"]), "solved" if flag == 1 else f"exit flag {flag}")

    return call, read


def _quadprog(zone: ScaledZone, tolerance: float, limit_s: float) -> Prepared:
    import quadprog

    matrix, rhs, n = _dense(zone)
    columns = np.asfortranarray(matrix.T)
    factor, gradient = np.eye(n), np.zeros(n)

    def call() -> Any:
        return quadprog.solve_qp(factor, gradient, columns, rhs, 0, True)

    def read(result: Any) -> Found:
        return Found(result[0], result[4], "solved")

    return call, read


def _piqp(zone: ScaledZone, tolerance: float, limit_s: float, dense: bool = False) -> Prepared:
    import piqp

    n = zone.matrix.shape[1]
    kind = piqp.DenseSolver if dense else piqp.SparseSolver
    matrices: list[Any] = [csc_matrix(eye_array(n)), csc_matrix(zone.matrix)]
    if dense:
        matrices = [np.asfortranarray(sparse.toarray()) for sparse in matrices]
    quadratic, matrix = matrices
    gradient, rhs = np.zeros(n), zone.rhs

    def call() -> Any:
        solver = kind()
        settings = solver.settings
        settings.eps_abs = settings.eps_rel = tolerance
        settings.eps_duality_gap_abs = settings.eps_duality_gap_rel = tolerance
        solver.setup(quadratic, gradient, None, None, matrix, rhs, None)
        return solver.solve(), solver

    def read(result: Any) -> Found:
        status, solver = result
        solved = int(status) == 1
        return Found(solver.result.x, solver.result.z_l, "solved" if solved else str(status))

    return call, read


def _proxqp(zone: ScaledZone, tolerance: float, limit_s: float) -> Prepared:
    from proxsuite import proxqp

    matrix, rhs, n = _dense(zone)
    quadratic, gradient = np.eye(n), np.zeros(n)
    upper = np.full(len(rhs), 1e20)

    def call() -> Any:
        solver = proxqp.dense.QP(n, 0, len(rhs), False, proxqp.dense.HessianType.Diagonal)
        solver.settings.eps_abs, solver.settings.eps_rel = tolerance, 0.0
        solver.init(quadratic, gradient, None, None, matrix, rhs, upper)
        solver.solve()
        return solver.results

    def read(result: Any) -> Found:
        solved = result.info.status == proxqp.PROXQP_SOLVED
        says = "solved" if solved else str(result.info.status).rpartition(".")[2]
        return Found(np.array(result.x), np.maximum(-np.array(result.z), 0.0), says)

    return call, read


def _osqp(zone: ScaledZone, tolerance: float, limit_s: float) -> Prepared:
    import osqp

    n = zone.matrix.shape[1]
    quadratic, matrix = csc_matrix(eye_array(n)), csc_matrix(zone.matrix)
    gradient, upper = np.zeros(n), np.full(len(zone.rhs), np.inf)
    settings = {
        "eps_abs": tolerance,
        "eps_rel": tolerance,
        "max_iter": 1_000_000,
        "time_limit": limit_s,
        "verbose": False,
    }

    def call() -> Any:
        solver = osqp.OSQP()
        solver.setup(quadratic, gradient, matrix, zone.rhs, upper, **settings)
        return solver.solve(raise_error=False)

    def read(result: Any) -> Found:
        return Found(result.x, np.maximum(-result.y, 0.0), result.info.status)

    return call, read


def _clarabel(zone: ScaledZone, tolerance: float, limit_s: float) -> Prepared:
    import clarabel

    library: Any = clarabel  # its classes are compiled, and the type checker does not see them
    n = zone.matrix.shape[1]
    quadratic, matrix = csc_matrix(eye_array(n)), csc_matrix(-zone.matrix)
    gradient, rhs = np.zeros(n), -zone.rhs
    settings = library.DefaultSettings()
    settings.verbose = False
    settings.time_limit = limit_s
    settings.tol_feas = settings.tol_gap_abs = settings.tol_gap_rel = tolerance
    cones = [library.NonnegativeConeT(len(rhs))]

    def call() -> Any:
        return library.DefaultSolver(quadratic, gradient, matrix, rhs, cones, settings).solve()

    def read(result: Any) -> Found:
        return Found(np.array(result.x), np.array(result.z), str(result.status).lower())

    return call, read


def _nnls(zone: ScaledZone, tolerance: float, limit_s: float) -> Prepared:
    """Prepare the least-distance form of Lawson and Hanson, as in `oracles/nnls.py`."""
    from scipy.optimize import nnls

    dense, rhs, _ = _dense(zone)
    matrix = np.vstack((dense.T, rhs))
    target = np.zeros(len(matrix))
    target[-1] = 1.0

    def call() -> Any:
        return nnls(matrix, target, maxiter=30 * matrix.shape[1])

    def read(result: Any) -> Found:
        residual = matrix @ result[0] - target
        if not residual[-1] < 0.0:
            return Found(None, None, "no feasible point")
        return Found(-residual[:-1] / residual[-1], result[0] / -residual[-1], "solved")

    return call, read


def _slsqp(zone: ScaledZone, tolerance: float, limit_s: float) -> Prepared:
    from scipy.optimize import minimize

    matrix, rhs, n = _dense(zone)
    constraints = {"type": "ineq", "fun": lambda z: matrix @ z - rhs, "jac": lambda z: matrix}
    # ftol is for the objective, whose error is the square of the error of z
    options = {"ftol": tolerance**2, "maxiter": 1000}

    def call() -> Any:
        return minimize(
            lambda z: 0.5 * float(z @ z),
            np.zeros(n),
            jac=lambda z: z,
            method="SLSQP",
            constraints=constraints,
            options=options,
        )

    def read(result: Any) -> Found:
        multipliers = getattr(result, "multipliers", None)
        return Found(result.x, multipliers, "solved" if result.success else result.message)

    return call, read


LIBRARIES = (
    Library("DAQP", _daqp, TOLERANCES, DENSE_IMPACTS),
    Library("quadprog", _quadprog, (1e-12,), DENSE_IMPACTS),
    Library("PIQP", _piqp, TOLERANCES, EVERY),
    Library("PIQP dense", partial(_piqp, dense=True), TOLERANCES, PIQP_DENSE_IMPACTS),
    Library("ProxQP", _proxqp, TOLERANCES, DENSE_IMPACTS),
    Library("OSQP", _osqp, TOLERANCES[:4], EVERY),
    Library("Clarabel", _clarabel, TOLERANCES, EVERY),
    Library("NNLS", _nnls, (1e-12,), DENSE_IMPACTS),
    Library("SLSQP", _slsqp, TOLERANCES[:4], SLSQP_IMPACTS),
)
