"""The augmented Lagrangian of one zone: value, gradient, and itself along a line.

    L(x) = sum_i w_i x_i^2 / 2 + mu/2 sum_j max(c_j + l_j / mu, 0)^2 - sum_j l_j^2 / (2 mu)
    c_j  = s_j - N_j . sum_k a_jk x_jk

with x the displacement from the candidate positions, so that nothing cancels there, and
w = 2 kappa. The caller chooses the variables: metres, or those of SPEC 5.

Pinned vertices are one row of x more, the last, with coefficient zero: no branches.

A zone is worked on by one thread or by several (`team.py`): rows write rows, and each vertex
gathers from its rows in their order, so that nobody adds to what another adds to.

Source: XRTailor documentation, "Impact Zone Optimization", eqs. 5 to 11; eq. 9 with the
slack eliminated (clamped), as it is meant.
"""

from typing import NamedTuple

import numpy as np

from izo_ref.base.compile import compiled
from izo_ref.base.serial.thread_group import ThreadGroup, group_maxima, group_sum, group_sums


class Zone(NamedTuple):
    """One zone and its work space; n = 3 times (vertices + 1), m impacts.

    Arrays are all of one type, float64 or float32. Sums over them are float64 in either
    case, and so are mu and the step until they multiply an array.
    """

    nodes: np.ndarray  # (m, 4) u4, 3 times the vertex: where its coordinates begin
    coefficients: np.ndarray  # (m, 4), a
    entries: np.ndarray  # (n_entries,) u4, rows of each vertex
    arms: np.ndarray  # (n_entries, 3), a N of the vertex in each
    entry_starts: np.ndarray  # (n / 3 + 1,) u8, where those of each vertex begin
    normals: np.ndarray  # (m, 3), N
    starts: np.ndarray  # (m,), s, the constraints at x = 0
    metres: np.ndarray  # (m,), violation in m of c = 1
    curvatures: np.ndarray  # (n,), w
    x: np.ndarray  # (n,)
    multipliers: np.ndarray  # (m,), l
    gradient: np.ndarray  # (n,), of L
    direction: np.ndarray  # (n,), p
    diagonal: np.ndarray  # (n,), of the generalised Hessian
    previous: np.ndarray  # (n,), the gradient (cg, lbfgs) or x (chebyshev) one step before
    constraints: np.ndarray  # (m,), c
    pushed: np.ndarray  # (m,), c + l / mu; a row is active where this is positive
    along: np.ndarray  # (m,), A p; in between what rows hand to their vertices
    memory: np.ndarray  # flat, vectors of lbfgs or of newton
    state: np.ndarray  # (9,) f8, numbers that the loop and the directions keep, of each thread
    group: ThreadGroup


class Measures(NamedTuple):
    """What one pass over gradient and rows finds; sums of squares, not norms."""

    value: float  # L
    objective: float  # sum w x^2 / 2
    error: float  # sum g^2 / w
    gradient_sq: float  # sum g^2
    largest_gradient: float  # largest |g|
    largest_pull: float  # largest |w x|
    products: float  # sum_j max(l + mu c, 0) |c|
    shift_sq: float  # sum_j min(-c, l / mu)^2, what an update changes l by, over mu
    largest_shift: float  # its largest entry
    violation_m: float  # largest violation


@compiled
def constraint_products(zone, vector, rows_out):
    """A v: N_j . sum_k a_jk v_jk."""
    for j in range(zone.group.rank(), rows_out.size, zone.group.size()):
        value = vector.dtype.type(0)
        for k in range(4):
            i = zone.nodes[j, k]
            point = zone.normals[j, 0] * vector[i]
            point += zone.normals[j, 1] * vector[i + 1]
            point += zone.normals[j, 2] * vector[i + 2]
            value += zone.coefficients[j, k] * point
        rows_out[j] = value


@compiled
def renew_constraints(zone):
    """c = s - A x, without what updates step by step have added in rounding."""
    zone.group.wait()
    constraint_products(zone, zone.x, zone.constraints)
    for j in range(zone.group.rank(), zone.constraints.size, zone.group.size()):
        zone.constraints[j] = zone.starts[j] - zone.constraints[j]


@compiled
def gathered(zone, vertex, factor, values):
    """factor sum_j a_jk N_j v_j over the rows of a vertex: three numbers."""
    zero = values.dtype.type(0)
    x, y, z = zero, zero, zero
    for e in range(zone.entry_starts[vertex], zone.entry_starts[vertex + 1]):
        value = factor * values[zone.entries[e]]
        if value != 0:
            x += value * zone.arms[e, 0]
            y += value * zone.arms[e, 1]
            z += value * zone.arms[e, 2]
    return x, y, z


@compiled
def evaluate(zone, penalty):
    """Gradient of L at x, `pushed`, and `Measures` of (x, max(l + mu c, 0)).

    As multipliers that pair has max(l + mu c, 0), for which the gradient is what is missing
    from stationarity; so the duality gap is error / 2 + products (SPEC section 8).
    """
    group = zone.group
    mu = zone.x.dtype.type(penalty)
    inverse = zone.x.dtype.type(1.0 / penalty)
    squares, products, shift_sq, largest_shift, violation_m = 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(group.rank(), zone.constraints.size, group.size()):
        c, rest = zone.constraints[j], zone.multipliers[j] * inverse
        pushed = c + rest
        zone.pushed[j] = pushed
        zone.along[j] = pushed if pushed > 0 else 0
        violation_m = max(violation_m, c * zone.metres[j])
        shift = min(-c, rest)
        shift_sq += shift * shift
        largest_shift = max(largest_shift, abs(shift))
        squares -= rest * rest
        if pushed > 0:
            squares += pushed * pushed
            products += mu * pushed * abs(c)
    squares, products, shift_sq = group_sums(group, squares, products, shift_sq)
    largest_shift, violation_m = group_maxima(group, largest_shift, violation_m)
    for vertex in range(group.rank(), zone.x.size // 3, group.size()):
        pulls, i = gathered(zone, vertex, mu, zone.along), 3 * vertex
        zone.gradient[i] = zone.curvatures[i] * zone.x[i] - pulls[0]
        zone.gradient[i + 1] = zone.curvatures[i + 1] * zone.x[i + 1] - pulls[1]
        zone.gradient[i + 2] = zone.curvatures[i + 2] * zone.x[i + 2] - pulls[2]
    group.wait()
    objective, error, gradient_sq, largest, pull = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(group.rank(), zone.x.size, group.size()):
        g, own = zone.gradient[i], zone.curvatures[i] * zone.x[i]
        objective += own * zone.x[i]
        gradient_sq += g * g
        error += g * g / zone.curvatures[i]
        largest, pull = max(largest, abs(g)), max(pull, abs(own))
    objective, error, gradient_sq = group_sums(group, objective, error, gradient_sq)
    largest, pull = group_maxima(group, largest, pull)
    return Measures(
        0.5 * objective + 0.5 * penalty * squares,
        0.5 * objective,
        error,
        gradient_sq,
        largest,
        pull,
        products,
        shift_sq,
        largest_shift,
        violation_m,
    )


@compiled
def prepare_line(zone, penalty):
    """A p, and of L along p: slope, curvature without that of active rows, and with it."""
    group, slope, curvature, active = zone.group, 0.0, 0.0, 0.0
    for i in range(group.rank(), zone.x.size, group.size()):
        p = zone.direction[i]
        slope += zone.gradient[i] * p
        curvature += zone.curvatures[i] * p * p
    slope, curvature, _ = group_sums(group, slope, curvature, 0.0)
    constraint_products(zone, zone.direction, zone.along)
    for j in range(group.rank(), zone.along.size, group.size()):
        if zone.pushed[j] > 0:
            active += zone.along[j] * zone.along[j]
    return slope, curvature, curvature + penalty * group_sum(group, active)


@compiled
def along_line(zone, penalty, slope, curvature, step):
    """L(x + step p) - L(x), and the first two derivatives of L there.

    The difference of two values of L loses a gradient below the square root of rounding.
    Here all that comes to the slope at x is a sum of terms >= 0, with nothing cancelled:
    a row active at both ends adds (step q)^2, q = A p, one that leaves t (2 step q - t),
    t = c + l / mu, and one that enters (t - step q)^2, each times mu / 2.
    """
    value, rise, second = 0.0, 0.0, 0.0
    for j in range(zone.group.rank(), zone.pushed.size, zone.group.size()):
        t, q = zone.pushed[j], zone.along[j]
        move = step * q
        if t > 0.0:
            if t > move:
                value += move * move
                rise += move * q
                second += q * q
            else:
                value += t * (2.0 * move - t)
                rise += t * q
        elif t > move:
            value += (t - move) ** 2
            rise += (move - t) * q
            second += q * q
    value, rise, second = group_sums(zone.group, value, rise, second)
    return (
        step * (slope + 0.5 * curvature * step) + 0.5 * penalty * value,
        slope + curvature * step + penalty * rise,
        curvature + penalty * second,
    )


@compiled
def update_multipliers(zone, penalty):
    """Page eq. 9, clamped: l <- max(l + mu c, 0)."""
    for j in range(zone.group.rank(), zone.multipliers.size, zone.group.size()):
        pushed = zone.constraints[j] * penalty + zone.multipliers[j]
        zone.multipliers[j] = max(pushed, 0.0)


@compiled
def hessian_diagonal(zone, penalty):
    """Diagonal of the generalised Hessian diag(w) + mu sum_active a a^T."""
    mu = zone.x.dtype.type(penalty)
    for vertex in range(zone.group.rank(), zone.x.size // 3, zone.group.size()):
        for axis in range(3):
            i = 3 * vertex + axis
            zone.diagonal[i] = zone.curvatures[i]
        for e in range(zone.entry_starts[vertex], zone.entry_starts[vertex + 1]):
            if zone.pushed[zone.entries[e]] > 0:
                for axis in range(3):
                    zone.diagonal[3 * vertex + axis] += mu * zone.arms[e, axis] ** 2
    zone.group.wait()
