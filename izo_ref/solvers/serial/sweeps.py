"""Projected Gauss-Seidel on the multipliers of one zone, plain or accelerated.

In scaled variables (docs/method section 5) the dual of a zone is: minimise
1/2 |C^T u|^2 - s . u subject to u >= 0. A sweep minimises it over one multiplier after the other,
and keeps z = C^T u up to date.

The accelerated form does not begin a sweep at the last point, but a little beyond it, in the
direction from the point before. Where the last sweep increased the dual, the next one begins at the
last point itself.

Source: for sweeps, D. P. Bertsekas, Nonlinear Programming (1999), section 2.7; for restarts, B.
O'Donoghue, E. Candes, Adaptive restart for accelerated gradient schemes (2015), section 3.2. The
source uses gradient steps; here sweeps take their place. Convergence is not proved for that, so the
acceleration restarts whenever the dual increases.
"""

import math

import numpy as np

from izo_ref.base.arrays import AnyFloats, AnyInt, Flags, Floats, Ints
from izo_ref.base.compile import compiled
from izo_ref.solvers.serial.constraints import add_constraint, constraint_dot, pull, residuals

# Sweeps between two computations of the residuals, each of which costs half a sweep.
INTERVAL = 4


@compiled
def _sweep(
    first: int,
    nodes: Ints,
    coefficients: AnyFloats,
    normals: AnyFloats,
    s: AnyFloats,
    diagonal: AnyFloats,
    u: AnyFloats,
    z: AnyFloats,
) -> None:
    """Minimise the dual over one multiplier after the other; `diagonal` is that of C C^T."""
    for j in range(u.shape[0]):
        if diagonal[j] > 0.0:
            missing = s[j] - constraint_dot(j, first, nodes, coefficients, normals, z)
            step = max(missing / diagonal[j], -u[j])
            if step != 0.0:
                u[j] += step
                add_constraint(step, j, first, nodes, coefficients, normals, z)


@compiled
def sweeps(
    begin: int,
    end: int,
    first: int,
    last: int,
    all_nodes: Ints,
    all_coefficients: AnyFloats,
    all_normals: AnyFloats,
    rhs: AnyFloats,
    all_metres: Floats,
    accelerated: bool,
    max_sweeps: int,
    gap_tolerance: float,
    violation_tolerance: float,
    stop: Flags,
    multipliers_out: AnyFloats,
    z_out: AnyFloats,
    trace_out: Floats,
) -> AnyInt:
    """Sweep over the zone of the impacts begin..end and the unknowns first..last.

    The sweeps end when both tolerances are reached, or after `max_sweeps`.

    Args:
        begin: The zone's first impact.
        end: Its last impact + 1.
        first: The zone's first unknown.
        last: Its last unknown + 1.
        all_nodes: (n_impacts, 4) i4, of all zones; < 0 for pinned vertices.
        all_coefficients: (n_impacts, 4) f8 or f4; with the normals, constraints of unit length.
        all_normals: (n_impacts, 3) f8 or f4.
        rhs: (n_impacts,) f8 or f4 [m kg^1/2], s.
        all_metres: (n_impacts,) f8 [m], what a violation of 1 is in metres.
        accelerated: Whether sweeps begin beyond the last point.
        max_sweeps: Largest number of sweeps.
        gap_tolerance: Relative duality gap to reach.
        violation_tolerance: [m], violation to reach.
        stop: (1,) b1; no further sweep begins once it is set.
        multipliers_out: (n_impacts,) f8 or f4, u; begin..end are written. On entry, the
            multipliers to begin with.
        z_out: (3 n_unknowns,) f8 or f4; the coordinates of first..last are written.
        trace_out: (k, 2) f8, 1/2 |z|^2 and the largest violation [m] after each of the first k
            sweeps; k may be 0.

    Returns:
        The number of sweeps.
    """
    own = slice(begin, end)
    nodes, coefficients, normals = all_nodes[own], all_coefficients[own], all_normals[own]
    s, metres, u = rhs[own], all_metres[own], multipliers_out[own]
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
        if stop[0]:
            return number
        if accelerated:
            following = 0.5 * (1.0 + math.sqrt(1.0 + 4.0 * momentum * momentum))
            beyond = (momentum - 1.0) / following
            momentum = following
            for j in range(u.shape[0]):
                last_u = u[j]
                u[j] = max(last_u + beyond * (last_u - before[j]), 0.0)
                before[j] = last_u
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
            pull(first, nodes, coefficients, normals, u, z)  # the rounding of the steps adds up
            violation, gap = residuals(first, nodes, coefficients, normals, s, metres, u, z)
            if traced:
                trace_out[number, 0] = 0.0
                for i in range(z.shape[0]):
                    trace_out[number, 0] += 0.5 * z[i] * z[i]
                trace_out[number, 1] = violation
            if violation <= violation_tolerance and gap <= gap_tolerance:
                return number + 1
    return max_sweeps
