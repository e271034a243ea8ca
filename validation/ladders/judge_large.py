"""Run a zone problem that is too large for rational numbers, and judge it by what is proved."""

import math
from typing import Any

from izo_ref.base.arrays import Floats
from izo_ref.base.errors import IzoError
from izo_ref.zones.distance import distance_bound
from izo_ref.zones.problem import ZoneProblem
from validation.ladders.judge_zone import CLAIM, TOLERANCE, claims, run_twice
from validation.ladders.ladder import OWN, RIGHT, SAYS_SO, WRONG, Outcome
from validation.oracles import qp
from validation.oracles.answer import mass_norm

PROVED = "The error is an upper bound that is proved."
OTHERS = ("piqp", "clarabel")  # the first that answers stands beside


def judge_large(problem: ZoneProblem, tolerance: float = TOLERANCE, **settings: Any) -> Outcome:
    """Solve a large zone by our default solver, and judge it by the proved distance to the optimum.

    An answer is right if the proved bound is within tolerance, or if another solver claims an
    answer that is so near. It is wrong if it counts as solved and another answer, with the bound
    that is proved for that one, shows that it is farther from the optimum than its gap promises.

    Args:
        problem: The zone.
        tolerance: Largest relative error that counts as right.
        settings: Further arguments of `solve_zone`.
    """
    try:
        solution, seconds = run_twice(problem, settings)
    except IzoError as error:
        return Outcome(SAYS_SO, type(error).__name__, note=str(error))
    moves = solution.displacements
    size = mass_norm(problem.masses, moves)
    error = distance_bound(problem, solution.positions, solution.multipliers, moves) / size
    solved, refuted, note = claims(solution), False, PROVED
    if not error <= tolerance:
        apart, refuted, note = _beside(problem, moves, size)
        error = min(error, apart) if apart <= tolerance else error
    if solved and refuted:
        verdict, status = WRONG, "solved"
    elif error <= tolerance:
        verdict, status = RIGHT, "solved" if solved else "not solved, by its own residuals"
    else:
        verdict = SAYS_SO
        status = f"solved, not proved to {tolerance:.0e}" if solved else "not solved"
    return Outcome(
        verdict,
        status,
        OWN,
        error if math.isfinite(error) else None,
        solution.residuals.violation,
        solution.iterations,
        seconds,
        note=note,
    )


def _beside(problem: ZoneProblem, moves: Floats, size: float) -> tuple[float, bool, str]:
    """Compare an answer with that of another solver.

    Args:
        problem: The zone.
        moves: (n, 3) f8 [m], our answer.
        size: Its length in the norm of the masses [m kg^1/2].

    Returns:
        How far the two are apart, over the size; infinity if no other solver claims an answer.
        Whether the other one refutes that ours is as near as a gap of CLAIM promises. A sentence.
    """
    for name in OTHERS:
        answer = qp.solve(problem, name)
        if not answer.claims or answer.multipliers is None:
            continue
        theirs = answer.displacements
        apart = mass_norm(problem.masses, theirs - moves) / size
        if apart <= math.sqrt(2.0 * CLAIM):
            return apart, False, f"The answer of {name} is {apart:.1e} away."
        proved = distance_bound(problem, problem.proposed + theirs, answer.multipliers, theirs)
        said = f"The answer of {name} is {apart:.1e} away, with a bound of {proved / size:.1e}."
        return apart, apart - proved / size > math.sqrt(2.0 * CLAIM), said
    return math.inf, False, "No bound is proved, and no other solver claims an answer."
