"""Decide when the augmented-Lagrangian loop and its inner solves end."""

import math

from izo_ref.base.arrays import AnyInt
from izo_ref.base.compile import compiled
from izo_ref.base.serial.thread_group import group_sum
from izo_ref.solvers.serial.lagrangian import BEST, BEST_AT, INNER, MU, Measures, Zone
from izo_ref.solvers.serial.settings import LEAST_TOLERANCE, Settings


@compiled
def relative_gap(measures: Measures) -> float:
    """Return the duality gap of (x, max(l + mu c, 0)) over the objective.

    The gap is what is missing from stationarity and from complementarity.

    Source: docs/method section 8.
    """
    gap = 0.5 * measures.error + measures.products
    if measures.objective > 0.0:
        return gap / measures.objective
    return 0.0 if gap == 0.0 else math.inf


@compiled
def is_inner_solve_done(zone: Zone, settings: Settings, measures: Measures, change: float) -> bool:
    """Return whether an inner solve is done, after a step that changed L by `change`.

    An inner solve minimises L with fixed multipliers. By criterion B of Rockafellar it is done
    when L is within delta^2 / (2 mu) |change of l|^2 of its minimum. Since w is the least
    curvature, |g|^2 / (2 w) bounds the distance of L from its minimum. So inner solves become more
    accurate as the multipliers settle. Presets have the three stops of their library instead.

    Source: R. T. Rockafellar, Augmented Lagrangians and applications of the proximal point
    algorithm in convex programming (1976).
    """
    if zone.state[INNER] >= settings.inner_steps:
        return True
    if not settings.faithful:
        limit = settings.inner_accuracy * settings.inner_accuracy
        return measures.error <= limit * zone.state[MU] * measures.shift_sq
    if measures.gradient_sq <= settings.eps_g**2:
        return True
    length_sq = 0.0
    for i in range(zone.group.rank(), zone.x.size, zone.group.size()):
        length_sq += zone.direction[i] * zone.direction[i]
    length_sq = group_sum(zone.group, length_sq)
    largest = max(abs(measures.value), abs(measures.value - change), 1.0)
    return math.sqrt(length_sq) <= settings.eps_x or -change <= settings.eps_f * largest


@compiled
def is_over(
    zone: Zone, settings: Settings, measures: Measures, largest_start: float, iteration: AnyInt
) -> bool:
    """Return whether the loop ends.

    It ends when the zone is solved, when nothing but rounding is left, when there was no progress
    for long, and when it diverges. A preset ends only when it diverges, or is at the exact
    solution. `largest_start` is the largest |c| at x = 0.
    """
    state = zone.state
    if not measures.objective < 1e30:  # diverging: x is 1e15 units off; its square fits a float32
        return True
    if settings.faithful:
        return measures.error == 0.0 and measures.shift_sq == 0.0
    gap = relative_gap(measures)
    if gap <= settings.gap_tolerance and measures.violation_m <= settings.violation_m:
        return True
    # the rounding of some ten operations, each on numbers of this size
    unit = 10.0 * settings.rounding
    noise = unit * (measures.largest_pull + state[MU] * largest_start)
    if measures.largest_gradient <= noise and measures.largest_shift <= unit * largest_start:
        return True
    violation = measures.violation_m / max(settings.violation_m, LEAST_TOLERANCE)
    merit = max(gap / max(settings.gap_tolerance, LEAST_TOLERANCE), violation)
    if not merit >= 0.5 * state[BEST]:
        state[BEST], state[BEST_AT] = merit, iteration
    # Linear convergence, however slow, halves the merit in a constant number of steps. The first
    # halving may take longer, because the multipliers begin at 0.
    return iteration > 2.0 * state[BEST_AT] + 2000.0
