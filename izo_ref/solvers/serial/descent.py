"""The loop of the augmented-Lagrangian methods, over one zone: direction, step, multipliers.

Written once for all directions, line searches, updates of the multipliers and of the
penalty, which are chosen by integer codes at run time.

Source: XRTailor documentation, "Impact Zone Optimization", figure `algorithm_cpu`, and
SPEC sections 3 and 4.
"""

import math
from typing import NamedTuple

import numpy as np

from izo_ref.base.compile import compiled
from izo_ref.base.serial.thread_group import group_maxima, group_sum
from izo_ref.solvers.serial.directions.cg import cg_direction
from izo_ref.solvers.serial.directions.chebyshev import accelerate, goes_uphill, next_omega
from izo_ref.solvers.serial.directions.gradient import gradient_direction
from izo_ref.solvers.serial.directions.lbfgs import lbfgs_direction, remember_pair
from izo_ref.solvers.serial.directions.newton import newton_direction
from izo_ref.solvers.serial.lagrangian import (
    Zone,
    evaluate,
    hessian_diagonal,
    prepare_line,
    renew_constraints,
    update_multipliers,
)
from izo_ref.solvers.serial.line_search import search_line

GRADIENT, JACOBI, CHEBYSHEV, CG, LBFGS, NEWTON = range(6)
LAST, UNIT, MODEL = 0, 1, 2  # where line searches begin: last step, 1, minimum of the model
# Places in Zone.state
MU, STEP, STORED, AGE, OMEGA, WORST, BEST, BEST_AT, INNER = range(9)


class Settings(NamedTuple):
    """Parameters of the loop; `solvers/presets.py` says where their values are from."""

    direction: int
    line_search: int
    every_step: bool  # multipliers after every step, not after an inner solve
    preconditioned: bool  # by the diagonal of the generalised Hessian
    begin: int  # where a line search begins
    armijo: float  # c_1: fraction of the predicted decrease that has to be reached
    wolfe: float  # c_2: fraction of the slope that may be left
    shrink: float  # backtracking multiplies a step too long by this
    grow: float  # searches begin at the last step times this
    smallest_step: float  # a search that comes to this has failed
    faithful: bool  # as a preset: ends where a search fails, nothing guarded or returned anew
    max_steps: int
    gap_tolerance: float  # ends when the relative duality gap is below, and
    violation_m: float  # [m], the largest violation
    rounding: float  # half a unit in the last place of 1, of the type of the arrays
    inner_steps: int  # at most, between updates of the multipliers
    inner_accuracy: float  # delta of an inner solve, see there
    eps_x: float  # ARCSim's stops of an inner solve; negative: none
    eps_f: float
    eps_g: float
    penalty_growth: float  # mu grows by this, 1: never
    delay: int  # of Chebyshev's omega
    rho: float
    linear_tolerance: float  # of Newton's linear systems, and
    linear_steps: int  # their products with the Hessian at most, times the unknowns


@compiled
def choose_direction(zone, settings, restart):
    """Direction p by the code; -g / D or -g where that is no descent.

    Returns what `prepare_line` says of it.
    """
    state = zone.state
    if settings.preconditioned:
        hessian_diagonal(zone, state[MU])
    if settings.direction == CG:
        restart = restart or state[AGE] >= zone.x.size
    elif settings.direction == CHEBYSHEV:
        restart = restart or goes_uphill(zone)
    state[AGE] = 0.0 if restart else state[AGE] + 1.0
    line = 0.0, 0.0, 0.0
    for attempt in range(2):
        if attempt == 1 or settings.direction <= CHEBYSHEV:
            gradient_direction(zone, settings.preconditioned)
        elif settings.direction == CG:
            cg_direction(zone, restart)
        elif settings.direction == LBFGS:
            lbfgs_direction(zone, int(state[STORED]))
        else:
            limit = settings.linear_steps * zone.x.size
            newton_direction(zone, state[MU], settings.linear_tolerance, limit)
        line = prepare_line(zone, state[MU])
        if line[0] < 0.0:
            break
        state[STORED], state[AGE] = 0.0, 0.0
    return line


@compiled
def choose_step(zone, settings, line):
    """Step size and the change of L; 0 if there is none."""
    slope, curvature, second = line
    state, first = zone.state, 1.0
    if settings.begin == LAST:
        first = state[STEP] * settings.grow
    elif settings.begin == MODEL or (settings.direction == LBFGS and state[STORED] == 0.0):
        first = -slope / second
    step, change = search_line(zone, state[MU], slope, curvature, first, settings)
    if settings.begin == LAST and step > 0.0:
        state[STEP] = step
    return step, change


@compiled
def move(zone, settings, length, iteration):
    """x + length p, accelerated or not, and the constraints there."""
    step, state = zone.x.dtype.type(length), zone.state
    for i in range(zone.group.rank(), zone.x.size, zone.group.size()):
        zone.direction[i] *= step
        zone.x[i] += zone.direction[i]
    renew = iteration % 32 == 31
    if settings.direction == CHEBYSHEV:
        state[OMEGA] = next_omega(state[OMEGA], state[AGE], settings.delay, settings.rho)
        accelerate(zone, state[OMEGA])
        renew = renew or state[OMEGA] != 1.0
    if renew:
        renew_constraints(zone)
    else:
        for j in range(zone.group.rank(), zone.constraints.size, zone.group.size()):
            zone.constraints[j] -= step * zone.along[j]


@compiled
def learn(zone, settings):
    """Of the step just made: y = g - g_before for cg, and a pair for lbfgs."""
    for i in range(zone.group.rank(), zone.x.size, zone.group.size()):
        zone.previous[i] = zone.gradient[i] - zone.previous[i]
    if settings.direction == LBFGS:
        stored = int(zone.state[STORED])
        zone.state[STORED] = remember_pair(zone, stored, settings.rounding)


@compiled
def inner_done(zone, settings, found, change):
    """Whether an inner solve is done.

    By criterion B of Rockafellar: L is within delta^2 / (2 mu) |change of l|^2 of its
    minimum, which |g|^2 / (2 w) bounds since w is the least curvature. So inner solves
    tighten as the multipliers settle. Presets have the three stops of their library.

    Source: R. T. Rockafellar, Augmented Lagrangians and applications of the proximal point
    algorithm in convex programming (1976).
    """
    if zone.state[INNER] >= settings.inner_steps:
        return True
    if not settings.faithful:
        limit = settings.inner_accuracy * settings.inner_accuracy
        return found.error <= limit * zone.state[MU] * found.shift_sq
    if found.gradient_sq <= settings.eps_g**2:
        return True
    length_sq = 0.0
    for i in range(zone.group.rank(), zone.x.size, zone.group.size()):
        length_sq += zone.direction[i] * zone.direction[i]
    length_sq = group_sum(zone.group, length_sq)
    largest = max(abs(found.value), abs(found.value - change), 1.0)
    return math.sqrt(length_sq) <= settings.eps_x or -change <= settings.eps_f * largest


@compiled
def next_multipliers(zone, settings, found, mu_cap, iteration):
    """Page eq. 9; then mu grows if their shift has not fallen to a quarter since last looked."""
    state = zone.state
    update_multipliers(zone, state[MU])
    look = not settings.every_step or iteration % 10 == 0
    if look and settings.penalty_growth > 1.0:
        if found.largest_shift > 0.25 * state[WORST]:
            state[MU] = min(settings.penalty_growth * state[MU], mu_cap)
        state[WORST] = found.largest_shift


@compiled
def relative_gap(found):
    """Of (x, max(l + mu c, 0)): what is missing from stationarity and complementarity."""
    gap = 0.5 * found.error + found.products
    if found.objective > 0.0:
        return gap / found.objective
    return 0.0 if gap == 0.0 else math.inf


@compiled
def is_over(zone, settings, found, largest_start, iteration):
    """Solved; or nothing left but rounding; or no progress for long; or diverging."""
    state = zone.state
    if not found.objective < 1e30:  # of units of 1; its square is still a float32
        return True
    if settings.faithful:
        return found.error == 0.0 and found.shift_sq == 0.0
    gap = relative_gap(found)
    if gap <= settings.gap_tolerance and found.violation_m <= settings.violation_m:
        return True
    # each of some ten operations on numbers of this size
    unit = 10.0 * settings.rounding
    noise = unit * (found.largest_pull + state[MU] * largest_start)
    if found.largest_gradient <= noise and found.largest_shift <= unit * largest_start:
        return True
    violation = found.violation_m / settings.violation_m
    merit = max(gap / settings.gap_tolerance, violation)
    if not merit >= 0.5 * state[BEST]:
        state[BEST], state[BEST_AT] = merit, iteration
    # Linear convergence, however slow, halves the merit in a constant number of steps; the
    # first halving may take longer, for the multipliers begin at 0.
    return iteration > 2.0 * state[BEST_AT] + 2000.0


@compiled
def begin(zone, mu, first_step):
    """State and constraints at x = 0; returns the largest of these."""
    state, largest = zone.state, 0.0
    state[MU], state[STEP], state[OMEGA] = mu, first_step, 1.0
    state[WORST], state[BEST] = math.inf, math.inf
    for j in range(zone.group.rank(), zone.starts.size, zone.group.size()):
        zone.constraints[j] = zone.starts[j]
        largest = max(largest, abs(zone.starts[j]))
    return group_maxima(zone.group, largest, 0.0)[0]


@compiled
def minimise(zone, settings, mu, mu_cap, first_step, unit, trace_out):
    """Run the loop on one zone from x = 0; returns the number of steps, gap and violation.

    `unit` makes the objective kg m^2 for `trace_out`, (steps, 2) f8 or empty.
    """
    state, largest_start = zone.state, begin(zone, mu, first_step)
    learns = settings.direction == CG or settings.direction == LBFGS
    # `fresh`: the multipliers are new and x is not, so it has been judged
    iteration, idle, fresh, restart, change = np.int64(0), True, False, True, 0.0
    while True:
        found = evaluate(zone, state[MU])
        if not fresh:
            if zone.group.rank() == 0 and 0 < iteration <= trace_out.shape[0]:
                trace_out[iteration - 1, 0] = unit * found.objective
                trace_out[iteration - 1, 1] = found.violation_m
            if iteration >= settings.max_steps:
                break
            if is_over(zone, settings, found, largest_start, iteration):
                break
            if learns and not idle:
                learn(zone, settings)
            due = learns and iteration > 0
            if not settings.every_step:
                due = iteration > 0 and (idle or inner_done(zone, settings, found, change))
                restart = restart or due
            if due:
                next_multipliers(zone, settings, found, mu_cap, iteration)
                state[INNER], fresh = 0.0, True
                continue
        fresh = False
        if settings.faithful and state[INNER] == 0.0 and found.gradient_sq <= settings.eps_g**2:
            break  # an inner solve that takes no step is the last
        # At the minimum of L, to rounding, no step satisfies the strict inequality of
        # eq. 18: the multipliers still have their turn.
        noise = settings.rounding * (found.largest_pull + state[MU] * largest_start)
        idle = found.largest_gradient <= noise
        if not idle:
            line = choose_direction(zone, settings, restart)
            length, change = choose_step(zone, settings, line)
            idle, restart = length == 0.0, False
            if idle and settings.faithful:
                break
            if not idle:
                move(zone, settings, length, iteration)
        if idle and not settings.faithful:
            state[STEP], restart = first_step, True
        if settings.every_step and not learns:
            next_multipliers(zone, settings, found, mu_cap, iteration)
        state[INNER] += 1.0
        iteration += 1
    if not settings.faithful:
        for j in range(zone.group.rank(), zone.pushed.size, zone.group.size()):
            zone.multipliers[j] = max(state[MU] * zone.pushed[j], 0.0)
    return iteration, relative_gap(found), found.violation_m


@compiled
def minimise_zone(
    zone,
    state,
    group,
    impact_offsets,
    row_offsets,
    memory_offsets,
    nodes,
    coefficients,
    entries,
    arms,
    entry_starts,
    normals,
    starts,
    metres,
    curvatures,
    mus,
    mu_caps,
    first_steps,
    units,
    settings,
    x_out,
    multipliers_out,
    steps_out,
    gaps_out,
    violations_out,
    trace_out,
    vectors_out,
    rows_out,
    memory_out,
):
    """Run it on one of several zones side by side; arrays are those of the kernels' contract.

    `state` is the thread's own.
    """
    a, b = impact_offsets[zone], impact_offsets[zone + 1]
    i, k = row_offsets[zone], row_offsets[zone + 1]
    steps_out[zone], gaps_out[zone], violations_out[zone] = minimise(
        Zone(
            nodes[a:b],
            coefficients[a:b],
            entries,
            arms,
            entry_starts[i // 3 : k // 3 + 1],
            normals[a:b],
            starts[a:b],
            metres[a:b],
            curvatures[i:k],
            x_out[i:k],
            multipliers_out[a:b],
            vectors_out[0, i:k],
            vectors_out[1, i:k],
            vectors_out[2, i:k],
            vectors_out[3, i:k],
            rows_out[0, a:b],
            rows_out[1, a:b],
            rows_out[2, a:b],
            memory_out[memory_offsets[zone] : memory_offsets[zone + 1]],
            state,
            group,
        ),
        settings,
        mus[zone],
        mu_caps[zone],
        first_steps[zone],
        units[zone],
        trace_out[zone],
    )
