"""The optimum of a zone by quadratic-programming libraries of other authors, through qpsolvers.

Question: which point z with C z >= s is closest to zero (the scaled zone of `answer.py`)?

Method: that of each library: interior point (PIQP, Clarabel), operator splitting (OSQP), proximal
augmented Lagrangian (ProxQP), dual active set (DAQP).

Independent of `izo_ref`: the scaled zone is written from the mathematics, and the solvers are
libraries of other authors.

Limits: an answer is as exact as its library. A library may claim success far from the optimum, so
its answer and its claim are kept apart, and a caller judges the answer.
"""

import time
import warnings
from typing import Any

import numpy as np

from validation.oracles.answer import Answer, ZoneArrays, no_answer, scaled_zone

# The accuracy that is asked of each library. The names of the tolerances are those of the library.
SETTINGS: dict[str, dict[str, Any]] = {
    "piqp": {"eps_abs": 1e-12, "eps_rel": 1e-12},
    "clarabel": {"tol_gap_abs": 1e-12, "tol_gap_rel": 1e-12, "tol_feas": 1e-12},
    "osqp": {"eps_abs": 1e-10, "eps_rel": 1e-10, "max_iter": 200_000},
    "proxqp": {"eps_abs": 1e-12, "eps_rel": 0.0},
    "daqp": {"primal_tol": 1e-12, "dual_tol": 1e-12},
}
# Libraries that get dense matrices: DAQP accepts no other form, and ProxQP does better with it.
# Even so, ProxQP calls many zones infeasible that are not.
DENSE = ("daqp", "proxqp")


def solve(problem: ZoneArrays, solver: str, **settings: Any) -> Answer:
    """Solve a zone in scaled variables.

    Args:
        problem: A zone problem.
        solver: A key of SETTINGS.
        **settings: Settings of that library, which override SETTINGS.

    Returns:
        The answer of the library. If the library raises, the message holds the exception and the
        displacements are NaN.
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
        with warnings.catch_warnings(record=True) as said:  # qpsolvers passes on a status as one
            warnings.simplefilter("always")
            found = solve_problem(stated, solver=solver, **(SETTINGS[solver] | settings))
    except Exception as error:  # an exception of a library is an answer, too
        return no_answer(problem, repr(error)[:200], time.perf_counter() - begin)
    seconds = time.perf_counter() - begin
    if found.x is None or found.z is None:
        return no_answer(problem, "no answer", seconds)
    multipliers = zone.multipliers(np.maximum(found.z, 0.0))
    claims = bool(found.found)
    message = "; ".join(str(warning.message) for warning in said)
    message = message or ("solved" if claims else "not solved")
    return Answer(zone.displacements(found.x), multipliers, claims, message, seconds)
