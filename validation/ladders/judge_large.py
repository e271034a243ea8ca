"""Run a zone problem that is too large for rational numbers, and judge it by what is proved."""

import math
from typing import Any

from izo_ref.base.errors import IzoError
from izo_ref.zones.distance import distance_bound
from izo_ref.zones.problem import ZoneProblem
from validation.ladders.judge_zone import CLAIM, TOLERANCE, claims, run_twice
from validation.ladders.ladder import OWN, RIGHT, SAYS_SO, WRONG, Outcome
from validation.oracles import qp
from validation.oracles.answer import mass_norm

PROVED = "The error is an upper bound that is proved; {other}"
OTHERS = ("piqp", "clarabel")  # the first that answers stands beside


def judge_large(problem: ZoneProblem, tolerance: float = TOLERANCE, **settings: Any) -> Outcome:
    """Solve a large zone by our default solver, and judge it by the proved distance to the optimum.

    An answer is right if the proved bound is within tolerance. It is wrong if it counts as solved
    and another answer, with the bound that is proved for that one, shows that it is farther from
    the optimum than its gap promises.

    Args:
        problem: The zone.
        tolerance: Largest relative bound of the error that counts as right.
        settings: Further arguments of `solve_zone`.
    """
    try:
        solution, seconds = run_twice(problem, settings)
    except IzoError as error:
        return Outcome(SAYS_SO, type(error).__name__, note=str(error))
    moves = solution.displacements
    size = mass_norm(problem.masses, moves)
    bound = distance_bound(problem, solution.positions, solution.multipliers, moves) / size
    solved = claims(solution)
    refuted, other = False, "no other answer has a bound."
    if not bound <= tolerance:
        refuted, other = _refuted(problem, moves, size)
    if solved and refuted:
        verdict, status = WRONG, "solved"
    elif bound <= tolerance:
        verdict, status = RIGHT, "solved" if solved else "not solved, by its own residuals"
    else:
        verdict = SAYS_SO
        status = f"solved, not proved to {tolerance:.0e}" if solved else "not solved"
    return Outcome(
        verdict,
        status,
        OWN,
        bound,
        solution.residuals.violation,
        solution.iterations,
        seconds,
        note=PROVED.format(other=other if bound > tolerance else "no other answer is needed."),
    )


def _refuted(problem: ZoneProblem, moves: Any, size: float) -> tuple[bool, str]:
    """Return whether another answer refutes that the moves are near the optimum, and a sentence."""
    for name in OTHERS:
        answer = qp.solve(problem, name)
        if not answer.claims or answer.multipliers is None:
            continue
        theirs = answer.displacements
        proved = distance_bound(problem, problem.proposed + theirs, answer.multipliers, theirs)
        apart = mass_norm(problem.masses, theirs - moves) / size
        promised = math.sqrt(2.0 * CLAIM)
        said = f"the answer of {name} is {apart:.1e} away, {proved / size:.1e} proved."
        return apart - proved / size > promised, said
    return False, "no other solver claims an answer."
