"""The loop of the augmented-Lagrangian methods over one zone.

Each step chooses a direction of descent p of the augmented Lagrangian L (`lagrangian.py`), a step
size by a line search, and moves x. The multipliers are updated after every step, or after an inner
solve that has minimised L for fixed multipliers. The penalty mu stays fixed, or grows while the
constraints do not improve fast enough.

The loop is written once for all methods. Integer codes choose the direction, the line search and
the updates at run time.

Source: XRTailor documentation, "Impact Zone Optimization", figure `algorithm_cpu`;
docs/method sections 3 and 4.
"""

import math

import numpy as np

from izo_ref.base.arrays import AnyBool, AnyInt, Floats
from izo_ref.base.compile import compiled
from izo_ref.base.serial.thread_group import ThreadGroup, group_maxima
from izo_ref.solvers.serial.directions.cg import cg_direction
from izo_ref.solvers.serial.directions.chebyshev import accelerate, goes_uphill, next_omega
from izo_ref.solvers.serial.directions.gradient import gradient_direction
from izo_ref.solvers.serial.directions.lbfgs import lbfgs_direction, remember_pair
from izo_ref.solvers.serial.directions.newton import newton_direction
from izo_ref.solvers.serial.lagrangian import (
    AGE,
    BEST,
    INNER,
    MU,
    OMEGA,
    STEP,
    STORED,
    WORST,
    Measures,
    Zone,
    evaluate,
    hessian_diagonal,
    prepare_line,
    renew_constraints,
    update_multipliers,
)
from izo_ref.solvers.serial.line_search import search_line
from izo_ref.solvers.serial.records import Inputs, Results, WorkSpace
from izo_ref.solvers.serial.settings import Settings
from izo_ref.solvers.serial.stopping import is_inner_solve_done, is_over, relative_gap

GRADIENT, JACOBI, CHEBYSHEV, CG, LBFGS, NEWTON = range(6)
# First step of a line search: the last step, 1, or the minimum of the local quadratic model.
LAST, UNIT, MODEL = 0, 1, 2


@compiled
def choose_direction(
    zone: Zone, settings: Settings, restart: AnyBool
) -> tuple[float, float, float]:
    """Compute the direction p of the method, or the gradient's where p is no descent.

    The gradient's direction is -g, or -g / D if the settings say so, with D the diagonal of the
    generalised Hessian. With `restart`, the direction forgets the steps before.

    Returns:
        The derivatives of L along p, see `prepare_line`.
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
def choose_step(
    zone: Zone, settings: Settings, line: tuple[float, float, float]
) -> tuple[float, float]:
    """Return the step size and the change of L; the step is 0 if the search found none."""
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
def move(zone: Zone, settings: Settings, length: float, iteration: AnyInt) -> None:
    """Move x by length p, accelerate if the method does, and update the constraints.

    Afterwards `zone.direction` holds the step length p. The constraints are computed anew every 32
    steps, and after each accelerated step.
    """
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
def take_step(
    zone: Zone, settings: Settings, restart: AnyBool, iteration: AnyInt
) -> tuple[float, float]:
    """Choose a direction and a step size, and move; return the step size and the change of L."""
    line = choose_direction(zone, settings, restart)
    length, change = choose_step(zone, settings, line)
    if length != 0.0:
        move(zone, settings, length, iteration)
    return length, change


@compiled
def remember_step(zone: Zone, settings: Settings) -> None:
    """Keep what the last step tells: y = g - g_before for cg, and the pair s, y for lbfgs."""
    for i in range(zone.group.rank(), zone.x.size, zone.group.size()):
        zone.previous[i] = zone.gradient[i] - zone.previous[i]
    if settings.direction == LBFGS:
        stored = int(zone.state[STORED])
        zone.state[STORED] = remember_pair(zone, stored, settings.rounding)


@compiled
def next_multipliers(
    zone: Zone, settings: Settings, measures: Measures, mu_cap: float, iteration: AnyInt
) -> None:
    """Update the multipliers, and then mu.

    mu grows if the shift of the multipliers has not fallen to a quarter since the last look. With
    updates after every step, the loop looks every ten steps.

    Source: page eq. 9.
    """
    state = zone.state
    update_multipliers(zone, state[MU])
    look = not settings.every_step or iteration % 10 == 0
    if look and settings.penalty_growth > 1.0:
        if measures.largest_shift > 0.25 * state[WORST]:
            state[MU] = min(settings.penalty_growth * state[MU], mu_cap)
        state[WORST] = measures.largest_shift


@compiled
def initialise(zone: Zone, mu: float, first_step: float) -> float:
    """Set the state and the constraints for x = 0, and return the largest |c| there."""
    state, largest = zone.state, 0.0
    state[MU], state[STEP], state[OMEGA] = mu, first_step, 1.0
    state[WORST], state[BEST] = math.inf, math.inf
    for j in range(zone.group.rank(), zone.starts.size, zone.group.size()):
        zone.constraints[j] = zone.starts[j]
        largest = max(largest, abs(zone.starts[j]))
    return group_maxima(zone.group, largest, 0.0)[0]


@compiled
def record_trace(
    zone: Zone, measures: Measures, unit: float, iteration: AnyInt, trace_out: Floats
) -> None:
    """Write the objective [kg m^2] and the violation [m] after a step, if there is room."""
    if zone.group.rank() == 0 and 0 < iteration <= trace_out.shape[0]:
        trace_out[iteration - 1, 0] = unit * measures.objective
        trace_out[iteration - 1, 1] = measures.violation_m


@compiled
def minimise(
    zone: Zone,
    settings: Settings,
    mu: float,
    mu_cap: float,
    first_step: float,
    unit: float,
    trace_out: Floats,
) -> tuple[AnyInt, float, float]:
    """Run the loop on one zone from x = 0.

    Args:
        zone: The zone, with x = 0. At the end, x and the multipliers hold the answer.
        settings: Parameters of the loop.
        mu: Penalty at first.
        mu_cap: Largest penalty.
        first_step: Step that the first line search begins with, if searches begin at the last
            step.
        unit: [kg m^2], an objective of 1, for the trace.
        trace_out: (k, 2) f8, objective [kg m^2] and violation [m] after each of the first k
            steps; k may be 0.

    Returns:
        The number of steps, the relative duality gap and the largest violation [m].
    """
    state, largest_start = zone.state, initialise(zone, mu, first_step)
    has_memory = settings.direction == CG or settings.direction == LBFGS
    # `judged`: only the multipliers are new; x is not, and has been judged already
    iteration, idle, judged, restart, change = np.int64(0), True, False, True, 0.0
    while True:
        measures = evaluate(zone, state[MU])
        if not judged:
            record_trace(zone, measures, unit, iteration, trace_out)
            if iteration >= settings.max_steps or zone.stop[0]:
                break
            if is_over(zone, settings, measures, largest_start, iteration):
                break
            if has_memory and not idle:
                remember_step(zone, settings)
            due = has_memory and iteration > 0
            if not settings.every_step:
                done = idle or is_inner_solve_done(zone, settings, measures, change)
                due = iteration > 0 and done
                restart = restart or due
            if due:
                next_multipliers(zone, settings, measures, mu_cap, iteration)
                state[INNER], judged = 0.0, True
                continue
        judged = False
        if settings.faithful and state[INNER] == 0.0 and measures.gradient_sq <= settings.eps_g**2:
            break  # an inner solve that takes no step is the last
        # At the minimum of L, to rounding, no step satisfies the strict inequality of eq. 18. The
        # multipliers are updated nevertheless.
        noise = settings.rounding * (measures.largest_pull + state[MU] * largest_start)
        idle = measures.largest_gradient <= noise
        if not idle:
            length, change = take_step(zone, settings, restart, iteration)
            idle, restart = length == 0.0, False
            if idle and settings.faithful:
                break
        if idle and not settings.faithful:
            state[STEP], restart = first_step, True
        if settings.every_step and not has_memory:
            next_multipliers(zone, settings, measures, mu_cap, iteration)
        state[INNER] += 1.0
        iteration += 1
    if not settings.faithful:
        for j in range(zone.group.rank(), zone.pushed.size, zone.group.size()):
            zone.multipliers[j] = max(state[MU] * zone.pushed[j], 0.0)
    return iteration, relative_gap(measures), measures.violation_m


@compiled
def minimise_zone(
    number: AnyInt,
    state: Floats,
    group: ThreadGroup,
    inputs: Inputs,
    settings: Settings,
    results_out: Results,
    work_out: WorkSpace,
) -> None:
    """Run the loop on one of several zones whose arrays lie side by side.

    Args:
        number: The zone to solve.
        state: (9,) f8, zeros, of this thread alone.
        group: The threads that work on the zone.
        inputs: The inputs of all zones.
        settings: Parameters of the loop.
        results_out: The results of all zones; those of this zone are written.
        work_out: Work space of all zones.
    """
    a, b = inputs.impact_offsets[number], inputs.impact_offsets[number + 1]
    i, k = inputs.unknown_offsets[number], inputs.unknown_offsets[number + 1]
    first, end = inputs.memory_offsets[number], inputs.memory_offsets[number + 1]
    zone = Zone(
        inputs.nodes[a:b],
        inputs.coefficients[a:b],
        inputs.entries,
        inputs.arms,
        inputs.entry_starts[i // 3 : k // 3 + 1],
        inputs.normals[a:b],
        inputs.starts[a:b],
        inputs.metres[a:b],
        inputs.curvatures[i:k],
        results_out.x[i:k],
        results_out.multipliers[a:b],
        work_out.unknowns[0, i:k],
        work_out.unknowns[1, i:k],
        work_out.unknowns[2, i:k],
        work_out.unknowns[3, i:k],
        work_out.impacts[0, a:b],
        work_out.impacts[1, a:b],
        work_out.impacts[2, a:b],
        work_out.memory[first:end],
        state,
        group,
        work_out.stop,
    )
    steps, gap, violation_m = minimise(
        zone,
        settings,
        inputs.mus[number],
        inputs.mu_caps[number],
        inputs.first_steps[number],
        inputs.units[number],
        results_out.trace[number],
    )
    results_out.steps[number] = steps
    results_out.gaps[number] = gap
    results_out.violations[number] = violation_m
