"""Run a zone problem of a ladder and compare it with the exact optimum."""

import time
from typing import Any

import numpy as np

from izo_ref.base.arrays import Floats
from izo_ref.base.errors import IzoError
from izo_ref.solvers.solve import solve_zone
from izo_ref.zones.problem import ZoneProblem, ZoneSolution
from validation.ladders.ladder import NO_ANSWER, OWN, RIGHT, SAYS_SO, WRONG, Outcome
from validation.oracles.answer import Answer, scaled_zone
from validation.oracles.rational import ExactPoint, ExactZone, active_rows

TOLERANCE = 1e-9  # largest relative error of an answer that counts as right
REPEAT_BELOW_S = 0.5  # a run that is faster is timed again, without what happens once
EXACT = "The exact optimum is computed in rational numbers."
INFEASIBLE = "No positions satisfy the constraints, which rational numbers prove."


def condition_number(problem: ZoneProblem) -> float:
    """Compute the condition number of A M^-1 A^T over its range.

    It is the square of the ratio of the singular values of A M^-1/2, whose largest errors are some
    1e-16 of the largest value. So condition numbers up to some 1e31 can be told, and singular
    values below that count as 0: they belong to constraints that depend on others.
    """
    matrix = scaled_zone(problem)
    values = np.linalg.svd(matrix.lengths[:, None] * matrix.matrix.toarray(), compute_uv=False)
    kept = values[values > 4.0 * np.finfo(float).eps * values[0]]
    return float((kept[0] / kept[-1]) ** 2)


def judge_zone(
    problem: ZoneProblem,
    *,
    tolerance: float = TOLERANCE,
    others: dict[str, Any] | None = None,
    note: str = EXACT,
    **settings: Any,
) -> list[Outcome]:
    """Solve a zone by our default solver, and compare it with the exact optimum.

    Args:
        problem: The zone, at most some 60 impacts, since the optimum is exact.
        tolerance: Largest relative error that counts as right: |x - x*| over |x* - y| in the norm
            of the masses.
        others: `{name: function of the problem that returns an Answer}` of solvers beside it.
        note: A sentence about what is known.
        settings: Further arguments of `solve_zone`.

    Returns:
        Our outcome, then those of the others.
    """
    try:
        solution, seconds = _timed(problem, settings)
    except IzoError as error:
        return [Outcome(SAYS_SO, type(error).__name__, note=str(error))]
    zone = ExactZone(problem)
    optimum = zone.solve(active_rows(solution.multipliers))
    residuals = solution.residuals
    claims = solution.feasible and residuals.solved(1e-9, 1e-9)
    status = "solved" if claims else "not solved"
    error = None
    if optimum is None:
        verdict, note = (WRONG if claims else RIGHT), INFEASIBLE
    else:
        error = _error(zone, optimum, solution.displacements)
        verdict = RIGHT if error <= tolerance else (WRONG if claims else SAYS_SO)
        if not claims and verdict == RIGHT:
            status = "not solved, by its own residuals"
    condition = condition_number(problem)
    own = Outcome(
        verdict,
        status,
        OWN,
        error,
        residuals.violation,
        solution.iterations,
        seconds,
        condition,
        note,
    )
    rest = [
        _outcome_of_other(name, problem, solve(problem), zone, optimum, tolerance)
        for name, solve in (others or {}).items()
    ]
    return [own, *rest]


def _timed(problem: ZoneProblem, settings: dict[str, Any]) -> tuple[ZoneSolution, float]:
    """Solve a zone, and again if that was fast, so that compiling does not count."""
    solution, seconds = _run(problem, settings)
    return (solution, seconds) if seconds > REPEAT_BELOW_S else _run(problem, settings)


def _run(problem: ZoneProblem, settings: dict[str, Any]) -> tuple[ZoneSolution, float]:
    begin = time.perf_counter()
    solution = solve_zone(problem, **settings)
    return solution, time.perf_counter() - begin


def _error(zone: ExactZone, optimum: ExactPoint, displacements: Floats) -> float:
    """Return |x - x*| over |x* - y|; if the optimum is the proposal, 0 or infinity."""
    if all(v == 0 for move in optimum.moves for v in move):
        return 0.0 if not displacements.any() else float("inf")
    return zone.relative_error(displacements, optimum)


def _outcome_of_other(
    name: str,
    problem: ZoneProblem,
    answer: Answer,
    zone: ExactZone,
    optimum: ExactPoint | None,
    tolerance: float,
) -> Outcome:
    """Judge another solver; that it reports success without being right is "wrong"."""
    finite = bool(np.isfinite(answer.displacements).all())
    if not finite and not answer.claims:
        return Outcome(NO_ANSWER, answer.message, name, seconds=answer.seconds)
    status = f"{'success' if answer.claims else 'no success'}: {answer.message}"
    if optimum is None:
        verdict, error = (WRONG if answer.claims else RIGHT), None
    else:
        error = _error(zone, optimum, answer.displacements)
        verdict = RIGHT if error <= tolerance else (WRONG if answer.claims else SAYS_SO)
    points = (problem.proposed + answer.displacements)[problem.nodes]
    gaps = np.einsum("jk,jkx,jx->j", problem.weights, points, problem.normals)
    violation = max(0.0, float((problem.thickness - gaps).max())) / problem.thickness
    return Outcome(verdict, status, name, error, violation, None, answer.seconds)
