"""Run a zone problem of a ladder and compare it with the exact optimum."""

import copy
import math
import time
from typing import Any, NamedTuple

import numpy as np

from izo_ref.base.arrays import Floats
from izo_ref.base.errors import IzoError
from izo_ref.solvers.solve import solve_zone
from izo_ref.zones.distance import distance_bound
from izo_ref.zones.problem import ZoneProblem, ZoneSolution
from validation.ladders.ladder import NO_ANSWER, OWN, RIGHT, SAYS_SO, WRONG, Outcome
from validation.oracles.answer import Answer, scaled_zone
from validation.oracles.rational import (
    ExactPoint,
    ExactZone,
    active_rows,
    rational,
    to_float,
)

TOLERANCE = 1e-9  # largest relative error of an answer that counts as right
REPEAT_BELOW_S = 5.0  # a faster run is timed again: loading compiled code takes up to 3 s
CLAIM = 1e-9  # gap, and violation over the thickness, at which we count a zone as solved
EXACT = "The exact optimum is computed in rational numbers."
INFEASIBLE = "No positions satisfy the constraints, which rational numbers prove."
NEARLY = f"{INFEASIBLE} With a thickness that is smaller by the tolerance, some do."


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


def _condition(problem: ZoneProblem) -> float | None:
    """Return the condition number, or None where a constraint has no vertex that can move."""
    try:
        return condition_number(problem)
    except ValueError:
        return None


class Errors(NamedTuple):
    """How far an answer is from the optimum; all numbers are relative.

    Attributes:
        in_norm: |x - x*| over |x* - y|, in the norm of the masses.
        of_vertex: Largest |x_i - x*_i| over the largest |x*_i - y_i|; light vertices count in full.
        proved: What `distance_bound` proves of `in_norm`.
        proved_of_vertex: What it proves of `of_vertex`.
    """

    in_norm: float
    of_vertex: float
    proved: float = math.inf
    proved_of_vertex: float = math.inf

    @property
    def larger(self) -> float:
        """The larger of the two errors."""
        return max(self.in_norm, self.of_vertex)


def judge_zone(
    problem: ZoneProblem,
    *,
    tolerance: float = TOLERANCE,
    others: dict[str, Any] | None = None,
    note: str = EXACT,
    exact: ZoneProblem | None = None,
    gap: float = CLAIM,
    **settings: Any,
) -> list[Outcome]:
    """Solve a zone by our default solver, and compare it with the exact optimum.

    An answer with a larger error than the tolerance "says so" if the zone does not count as solved,
    or if `distance_bound` proves no more. It is wrong if it counts as solved and the bound is below
    the true distance, or if the distance is more than the gap promises: |x - x*|^2 is at most
    2 gap |x* - y|^2.

    Args:
        problem: The zone, at most some 60 impacts, since the optimum is exact.
        tolerance: Largest relative error that counts as right: of all positions in the norm of the
            masses, and of each vertex over the largest move.
        others: `{name: function of the problem that returns an Answer}` of solvers beside it.
        note: A sentence about what is known.
        exact: A problem with the same vertices and the same optimum, for which rational numbers
            take less time; the problem itself if None.
        gap: Tolerance that the solver is asked for.
        settings: Further arguments of `solve_zone`.

    Returns:
        Our outcome, then those of the others.
    """
    try:
        solution, seconds = run_twice(problem, {"tolerance": gap, **settings})
    except IzoError as error:
        return [Outcome(SAYS_SO, type(error).__name__, note=str(error))]
    zone = ExactZone(exact or problem)
    optimum = zone.solve(() if exact else active_rows(solution.multipliers))
    error = None
    if optimum is None:
        verdict, status, note = judge_infeasible(problem, solution)
    else:
        errors = _errors(problem, solution, zone, optimum)
        error = errors.larger
        verdict, status = judge_answer(solution, errors, tolerance)
        note += f" The bound of the error that is proved is {errors.proved:.1e}."
    own = Outcome(
        verdict,
        status,
        OWN,
        error,
        solution.residuals.violation,
        solution.iterations,
        seconds,
        _condition(exact or problem),
        note,
    )
    rest = [
        _outcome_of_other(name, problem, solve(problem), zone, optimum, tolerance)
        for name, solve in (others or {}).items()
    ]
    return [own, *rest]


def claims(solution: ZoneSolution) -> bool:
    """Return whether a zone counts as solved."""
    return solution.feasible and solution.residuals.solved(CLAIM, CLAIM)


def judge_answer(solution: ZoneSolution, errors: Errors, tolerance: float) -> tuple[str, str]:
    """Return the verdict on an answer, and its status.

    Args:
        solution: The answer.
        errors: Its errors.
        tolerance: Largest error that counts as right.
    """
    solved = claims(solution)
    if errors.proved < errors.in_norm:
        return WRONG, "a bound below the true distance"
    if errors.larger <= tolerance:
        return RIGHT, "solved" if solved else "not solved, by its own residuals"
    if not solved:
        return SAYS_SO, "not solved"
    promised = math.sqrt(2.0 * max(CLAIM, solution.residuals.gap_floor))
    if errors.in_norm > promised or errors.proved_of_vertex < errors.of_vertex:
        return WRONG, "solved"
    return SAYS_SO, f"solved, not proved to {tolerance:.0e}"


def judge_infeasible(problem: ZoneProblem, solution: ZoneSolution) -> tuple[str, str, str]:
    """Return the verdict on an answer of a zone that has none, its status, and a sentence.

    That such a zone counts as solved is right if a thickness that is smaller by the tolerance has a
    solution.
    """
    if not claims(solution):
        return RIGHT, "not solved", INFEASIBLE
    thinner = copy.copy(problem)
    floor = solution.residuals.violation_floor
    thinner.thickness = problem.thickness * (1.0 - max(CLAIM, floor))
    if ExactZone(thinner).solve(active_rows(solution.multipliers)) is None:
        return WRONG, "solved", INFEASIBLE
    return RIGHT, "solved within the tolerance", NEARLY


def run_twice(problem: ZoneProblem, settings: dict[str, Any]) -> tuple[ZoneSolution, float]:
    """Solve a zone, and again if that was fast, so that compiling does not count."""
    solution, seconds = _run(problem, settings)
    return (solution, seconds) if seconds > REPEAT_BELOW_S else _run(problem, settings)


def _run(problem: ZoneProblem, settings: dict[str, Any]) -> tuple[ZoneSolution, float]:
    begin = time.perf_counter()
    solution = solve_zone(problem, **settings)
    return solution, time.perf_counter() - begin


def _errors(
    problem: ZoneProblem, solution: ZoneSolution, zone: ExactZone, optimum: ExactPoint
) -> Errors:
    """Return the errors of our answer, and what is proved of them."""
    moves = solution.displacements
    in_norm, of_vertex = _error(zone, optimum, moves), _error_of_vertex(optimum, moves)
    size = zone.distance(optimum.moves, zone.still)
    if size == 0.0:
        return Errors(in_norm, of_vertex)
    bound = distance_bound(problem, solution.positions, solution.multipliers, moves)
    lightest = math.sqrt(float(problem.masses.min()))
    return Errors(in_norm, of_vertex, bound / size, bound / lightest / _largest(optimum))


def _largest(optimum: ExactPoint) -> float:
    """Return the largest move of a vertex along an axis [m]."""
    return float(np.abs(to_float(optimum.moves)).max())


def _error_of_vertex(optimum: ExactPoint, displacements: Floats) -> float:
    """Return the largest error of a coordinate over the largest move along an axis."""
    size = _largest(optimum)
    if size == 0.0 or not np.isfinite(displacements).all():
        return 0.0 if not displacements.any() else math.inf
    off = [
        [rational(x) - v for x, v in zip(move, right, strict=True)]
        for move, right in zip(displacements, optimum.moves, strict=True)
    ]
    return float(np.abs(to_float(off)).max()) / size


def _error(zone: ExactZone, optimum: ExactPoint, displacements: Floats) -> float:
    """Return |x - x*| over |x* - y|; if the optimum is the proposal, 0 or infinity."""
    if all(v == 0 for move in optimum.moves for v in move):
        return 0.0 if not displacements.any() else math.inf
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
