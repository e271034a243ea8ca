"""Zones by quadratic-programming solvers of others, through qpsolvers."""

import time
import warnings

import numpy as np

from validation.oracles.answer import Answer, no_answer, scaled_zone

# As accurate as each is asked to be; the names of the tolerances are the solvers' own.
SETTINGS = {
    "piqp": {"eps_abs": 1e-12, "eps_rel": 1e-12},
    "clarabel": {"tol_gap_abs": 1e-12, "tol_gap_rel": 1e-12, "tol_feas": 1e-12},
    "osqp": {"eps_abs": 1e-10, "eps_rel": 1e-10, "max_iter": 200_000},
    "proxqp": {"eps_abs": 1e-12, "eps_rel": 0.0},
    "daqp": {"primal_tol": 1e-12, "dual_tol": 1e-12},
}
# Those that are given dense matrices: DAQP has no other form, ProxQP does better with it. Even
# so it calls many zones infeasible that are not.
DENSE = ("daqp", "proxqp")


def solve(problem, solver, **settings) -> Answer:
    """Solve a zone in scaled variables.

    Args:
        problem: a zone problem.
        solver: one of SETTINGS.
        settings: of that solver, instead of those above.
    """
    from qpsolvers import Problem, solve_problem
    from scipy.sparse import csc_matrix, eye_array

    begin = time.perf_counter()
    zone = scaled_zone(problem)
    n = zone.matrix.shape[1]
    quadratic, matrix = csc_matrix(eye_array(n)), csc_matrix(-zone.matrix)
    if solver in DENSE:
        quadratic, matrix = quadratic.toarray(), matrix.toarray()
    stated = Problem(quadratic, np.zeros(n), matrix, -zone.rhs)
    try:
        with warnings.catch_warnings(record=True) as said:  # how qpsolvers passes on a status
            warnings.simplefilter("always")
            found = solve_problem(stated, solver=solver, **(SETTINGS[solver] | settings))
    except Exception as error:  # whatever it raises is its answer
        return no_answer(problem, repr(error)[:200], time.perf_counter() - begin)
    seconds = time.perf_counter() - begin
    if found.x is None:
        return no_answer(problem, "no answer", seconds)
    multipliers = zone.multipliers(np.maximum(found.z, 0.0))
    claims = bool(found.found)
    message = "; ".join(str(warning.message) for warning in said)
    message = message or ("solved" if claims else "not solved")
    return Answer(zone.displacements(found.x), multipliers, claims, message, seconds)
