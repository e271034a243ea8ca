"""Solvers of others, called directly: what is timed is a library's own set-up and solve.

Each gets the zone in scaled variables (minimise 1/2 |z|^2 subject to C z >= s), in arrays of
the form that it wants. Making those is not timed, and no wrapper stands between.
"""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.sparse import csc_matrix, eye_array

# 1e-10, because what is asked for 1e-9 often ends a little above
TOLERANCES = (1e-3, 1e-6, 1e-8, 1e-10, 1e-12)
DENSE_IMPACTS = 1024  # a dense library is given no more: 8 n m bytes, and n^3 operations
EVERY = 1 << 30
SLSQP_IMPACTS = 64  # it factors all rows in each iteration: 2 s for this many
PIQP_DENSE_IMPACTS = 256  # above, its sparse solver is the faster one


class Found(NamedTuple):
    """What a library returned, in scaled variables."""

    z: np.ndarray | None
    multipliers: np.ndarray | None
    says: str


class Contestant(NamedTuple):
    """A library.

    Attributes:
        name: as on the page.
        prepare: (`ScaledZone` of oracles/answer.py, tolerance, limit_s) -> call, read.
            `call()` is timed; `read` of what it returns gives `Found`.
        tolerances: those that it can be asked for; one, if it has no such setting.
        most: [impacts] it is given.
    """

    name: str
    prepare: Callable
    tolerances: tuple
    most: int


def _dense(zone):
    return zone.matrix.toarray(), zone.rhs, zone.matrix.shape[1]


def _daqp(zone, tolerance, limit_s):
    from ctypes import c_int

    import daqp

    matrix, rhs, n = _dense(zone)
    upper, sense = np.full(len(rhs), 1e30), np.zeros(len(rhs), c_int)  # 1e30 is its infinity
    settings = {
        "primal_tol": tolerance,
        "dual_tol": tolerance,
        "iter_limit": 100 * (len(rhs) + n),
        "time_limit": limit_s,
    }

    def call():
        # no objective is its name for 1/2 |z|^2; a third faster than the identity written out
        return daqp.solve(None, None, matrix, upper, rhs, sense, **settings)

    def read(result):
        z, _, flag, info = result
        return Found(z, np.abs(info["lam"]), "solved" if flag == 1 else f"exit flag {flag}")

    return call, read


def _quadprog(zone, tolerance, limit_s):
    import quadprog

    matrix, rhs, n = _dense(zone)
    columns = np.asfortranarray(matrix.T)
    factor, gradient = np.eye(n), np.zeros(n)

    def call():
        return quadprog.solve_qp(factor, gradient, columns, rhs, 0, True)

    def read(result):
        return Found(result[0], result[4], "solved")

    return call, read


def _piqp(zone, tolerance, limit_s, dense=False):
    import piqp

    n = zone.matrix.shape[1]
    kind = piqp.DenseSolver if dense else piqp.SparseSolver
    quadratic, matrix = csc_matrix(eye_array(n)), csc_matrix(zone.matrix)
    if dense:
        quadratic, matrix = (np.asfortranarray(a.toarray()) for a in (quadratic, matrix))
    gradient, rhs = np.zeros(n), zone.rhs

    def call():
        solver = kind()
        settings = solver.settings
        settings.eps_abs = settings.eps_rel = tolerance
        settings.eps_duality_gap_abs = settings.eps_duality_gap_rel = tolerance
        solver.setup(quadratic, gradient, None, None, matrix, rhs, None)
        return solver.solve(), solver

    def read(result):
        status, solver = result
        solved = int(status) == 1
        return Found(solver.result.x, solver.result.z_l, "solved" if solved else str(status))

    return call, read


def _proxqp(zone, tolerance, limit_s):
    from proxsuite import proxqp

    matrix, rhs, n = _dense(zone)
    quadratic, gradient = np.eye(n), np.zeros(n)
    upper = np.full(len(rhs), 1e20)

    def call():
        solver = proxqp.dense.QP(n, 0, len(rhs), False, proxqp.dense.HessianType.Diagonal)
        solver.settings.eps_abs, solver.settings.eps_rel = tolerance, 0.0
        solver.init(quadratic, gradient, None, None, matrix, rhs, upper)
        solver.solve()
        return solver.results

    def read(result):
        solved = result.info.status == proxqp.PROXQP_SOLVED
        says = "solved" if solved else str(result.info.status).rpartition(".")[2]
        return Found(np.array(result.x), np.maximum(-np.array(result.z), 0.0), says)

    return call, read


def _osqp(zone, tolerance, limit_s):
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

    def call():
        solver = osqp.OSQP()
        solver.setup(quadratic, gradient, matrix, zone.rhs, upper, **settings)
        return solver.solve(raise_error=False)

    def read(result):
        return Found(result.x, np.maximum(-result.y, 0.0), result.info.status)

    return call, read


def _clarabel(zone, tolerance, limit_s):
    import clarabel

    n = zone.matrix.shape[1]
    quadratic, matrix = csc_matrix(eye_array(n)), csc_matrix(-zone.matrix)
    gradient, rhs = np.zeros(n), -zone.rhs
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.time_limit = limit_s
    settings.tol_feas = settings.tol_gap_abs = settings.tol_gap_rel = tolerance
    cones = [clarabel.NonnegativeConeT(len(rhs))]

    def call():
        return clarabel.DefaultSolver(quadratic, gradient, matrix, rhs, cones, settings).solve()

    def read(result):
        return Found(np.array(result.x), np.array(result.z), str(result.status).lower())

    return call, read


def _nnls(zone, tolerance, limit_s):
    """Lawson and Hanson's least-distance form, as in oracles/nnls.py."""
    from scipy.optimize import nnls

    dense, rhs, _ = _dense(zone)
    matrix = np.vstack((dense.T, rhs))
    target = np.zeros(len(matrix))
    target[-1] = 1.0

    def call():
        return nnls(matrix, target, maxiter=30 * matrix.shape[1])

    def read(result):
        residual = matrix @ result[0] - target
        if not residual[-1] < 0.0:
            return Found(None, None, "no feasible point")
        return Found(-residual[:-1] / residual[-1], result[0] / -residual[-1], "solved")

    return call, read


def _slsqp(zone, tolerance, limit_s):
    from scipy.optimize import minimize

    matrix, rhs, n = _dense(zone)
    constraints = {"type": "ineq", "fun": lambda z: matrix @ z - rhs, "jac": lambda z: matrix}
    # ftol is of the objective, whose error is the square of that of z
    options = {"ftol": tolerance**2, "maxiter": 1000}

    def call():
        return minimize(
            lambda z: 0.5 * float(z @ z),
            np.zeros(n),
            jac=lambda z: z,
            method="SLSQP",
            constraints=constraints,
            options=options,
        )

    def read(result):
        multipliers = getattr(result, "multipliers", None)
        return Found(result.x, multipliers, "solved" if result.success else result.message)

    return call, read


LIBRARIES = (
    Contestant("DAQP", _daqp, TOLERANCES, DENSE_IMPACTS),
    Contestant("quadprog", _quadprog, (1e-12,), DENSE_IMPACTS),
    Contestant("PIQP", _piqp, TOLERANCES, EVERY),
    Contestant("PIQP dense", partial(_piqp, dense=True), TOLERANCES, PIQP_DENSE_IMPACTS),
    Contestant("ProxQP", _proxqp, TOLERANCES, DENSE_IMPACTS),
    Contestant("OSQP", _osqp, TOLERANCES[:4], EVERY),
    Contestant("Clarabel", _clarabel, TOLERANCES, EVERY),
    Contestant("NNLS", _nnls, (1e-12,), DENSE_IMPACTS),
    Contestant("SLSQP", _slsqp, TOLERANCES[:4], SLSQP_IMPACTS),
)
