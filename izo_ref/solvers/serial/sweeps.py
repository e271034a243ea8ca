"""Projected Gauss-Seidel on the multipliers of one zone, plain or accelerated.

In scaled variables (SPEC 5) the dual of a zone is: minimise 1/2 |C^T u|^2 - s . u subject to
u >= 0. A sweep minimises it over one multiplier after the other; z = C^T u is kept. The
accelerated form begins each sweep a little beyond the last, and from the last itself when
that went wrong.

Source: D. P. Bertsekas, Nonlinear Programming (1999), 2.7 for sweeps; B. O'Donoghue,
E. Candes, Adaptive restart for accelerated gradient schemes (2015), 3.2, for restarts. That
sweeps take the place of gradient steps there has no proof; an increase restarts it.
"""

import math

import numpy as np

from izo_ref.base.compile import compiled
from izo_ref.solvers.serial.constraints import add_constraint, constraint_dot, pull, residuals

# Sweeps between two looks at the residuals, which cost half a sweep.
INTERVAL = 4


@compiled
def _sweep(first, nodes, coefficients, normals, s, diagonal, u, z):
    for j in range(u.shape[0]):
        if diagonal[j] > 0.0:
            missing = s[j] - constraint_dot(j, first, nodes, coefficients, normals, z)
            step = max(missing / diagonal[j], -u[j])
            if step != 0.0:
                u[j] += step
                add_constraint(step, j, first, nodes, coefficients, normals, z)


@compiled
def sweeps(
    begin,
    end,
    first,
    last,
    all_nodes,
    all_coefficients,
    all_normals,
    rhs,
    all_metres,
    accelerated,
    max_sweeps,
    gap_tolerance,
    violation_tolerance,
    multipliers_out,
    z_out,
    trace_out,
):
    """Sweep over the impacts begin..end and unknowns first..last until they hold.

    Args:
        all_nodes, all_coefficients, all_normals, rhs: as of `block_pivot`.
        all_metres: (n_impacts,) f8 [m], violation of a row of 1.
        accelerated: whether sweeps begin beyond the last one.
        max_sweeps: at most.
        gap_tolerance: relative duality gap to reach.
        violation_tolerance: [m].
        multipliers_out: (n_impacts,), u; begin..end are written. On entry they are where to
            begin.
        z_out: (3 n_unknowns,); those of first..last are written.
        trace_out: (n, 2): after each sweep 1/2 |z|^2 and the largest violation [m]; as many
            as it has room for.

    Returns:
        The number of sweeps.
    """
    rows = slice(begin, end)
    nodes, coefficients, normals = all_nodes[rows], all_coefficients[rows], all_normals[rows]
    s, metres, u = rhs[rows], all_metres[rows], multipliers_out[rows]
    z = z_out[3 * first : 3 * last]
    diagonal, before = np.zeros_like(u), np.empty_like(u)
    pull(first, nodes, coefficients, normals, u, z)
    for j in range(u.shape[0]):
        before[j] = u[j]
        for k in range(4):
            if nodes[j, k] >= 0:
                diagonal[j] += coefficients[j, k] ** 2
        length_sq = normals[j, 0] ** 2 + normals[j, 1] ** 2 + normals[j, 2] ** 2
        diagonal[j] *= length_sq
    momentum, lowest = 1.0, np.inf
    for number in range(max_sweeps):
        if accelerated:
            following = 0.5 * (1.0 + math.sqrt(1.0 + 4.0 * momentum * momentum))
            beyond = (momentum - 1.0) / following
            momentum = following
            for j in range(u.shape[0]):
                own = u[j]
                u[j] = max(own + beyond * (own - before[j]), 0.0)
                before[j] = own
            pull(first, nodes, coefficients, normals, u, z)
        _sweep(first, nodes, coefficients, normals, s, diagonal, u, z)
        if accelerated:
            value = 0.0
            for i in range(z.shape[0]):
                value += 0.5 * z[i] * z[i]
            for j in range(u.shape[0]):
                value -= s[j] * u[j]
            if value > lowest:
                momentum = 1.0
            lowest = value
        traced = number < trace_out.shape[0]
        if traced or number % INTERVAL == INTERVAL - 1 or number < INTERVAL:
            pull(first, nodes, coefficients, normals, u, z)  # rounding of the steps adds up
            violation, gap = residuals(first, nodes, coefficients, normals, s, metres, u, z)
            if traced:
                trace_out[number, 0] = 0.0
                for i in range(z.shape[0]):
                    trace_out[number, 0] += 0.5 * z[i] * z[i]
                trace_out[number, 1] = violation
            if violation <= violation_tolerance and gap <= gap_tolerance:
                return number + 1
    return max_sweeps
