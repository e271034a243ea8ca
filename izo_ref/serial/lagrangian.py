"""The augmented Lagrangian of one zone: value, gradient, and itself along a line.

    L(x) = sum_i w_i x_i^2 / 2 + mu/2 sum_j max(c_j + l_j / mu, 0)^2 - sum_j l_j^2 / (2 mu)
    c_j  = s_j - N_j . sum_k a_jk x_jk

with x the displacement from the candidate positions, so that nothing cancels there, and
w = 2 kappa. The caller chooses the variables: metres, or those of SPEC 5.

Pinned vertices are one row of x more, the last, with coefficient zero: no branches.

Source: XRTailor documentation, "Impact Zone Optimization", eqs. 5 to 11; eq. 9 with the
slack eliminated (clamped), as it is meant.
"""

from typing import NamedTuple

import numpy as np

from izo_ref._jit import compiled


class Zone(NamedTuple):
    """One zone and its work space; n = 3 times (vertices + 1), m impacts.

    Arrays are all of one type, float64 or float32. Sums over them are float64 in either
    case, and so are mu and the step until they multiply an array.
    """

    nodes: np.ndarray  # (m, 4) u4, 3 times the vertex: where its coordinates begin
    coefficients: np.ndarray  # (m, 4), a
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
    along: np.ndarray  # (m,), A p
    memory: np.ndarray  # flat, vectors of lbfgs or of newton
    state: np.ndarray  # (9,) f8, numbers that the loop and the directions keep


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
def row_products(zone, vector, rows_out):
    """A v: N_j . sum_k a_jk v_jk."""
    for j in range(rows_out.size):
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
    row_products(zone, zone.x, zone.constraints)
    for j in range(zone.constraints.size):
        zone.constraints[j] = zone.starts[j] - zone.constraints[j]


@compiled
def evaluate(zone, penalty):
    """Gradient of L at x, `pushed`, and `Measures` of (x, max(l + mu c, 0)).

    As multipliers that pair has max(l + mu c, 0), for which the gradient is what is missing
    from stationarity; so the duality gap is error / 2 + products (SPEC section 8).
    """
    mu = zone.x.dtype.type(penalty)
    inverse = zone.x.dtype.type(1.0 / penalty)
    for i in range(zone.x.size):
        zone.gradient[i] = zone.curvatures[i] * zone.x[i]
    squares, products, shift_sq, largest_shift, violation_m = 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(zone.constraints.size):
        c, rest = zone.constraints[j], zone.multipliers[j] * inverse
        pushed = c + rest
        zone.pushed[j] = pushed
        violation_m = max(violation_m, c * zone.metres[j])
        shift = min(-c, rest)
        shift_sq += shift * shift
        largest_shift = max(largest_shift, abs(shift))
        squares -= rest * rest
        if pushed > 0:
            push = mu * pushed
            squares += pushed * pushed
            products += push * abs(c)
            for k in range(4):
                pull = push * zone.coefficients[j, k]
                i = zone.nodes[j, k]
                zone.gradient[i] -= pull * zone.normals[j, 0]
                zone.gradient[i + 1] -= pull * zone.normals[j, 1]
                zone.gradient[i + 2] -= pull * zone.normals[j, 2]
    objective, error, gradient_sq, largest, pull = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(zone.x.size):
        g, own = zone.gradient[i], zone.curvatures[i] * zone.x[i]
        objective += own * zone.x[i]
        gradient_sq += g * g
        error += g * g / zone.curvatures[i]
        largest, pull = max(largest, abs(g)), max(pull, abs(own))
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
    slope, curvature, active = 0.0, 0.0, 0.0
    for i in range(zone.x.size):
        p = zone.direction[i]
        slope += zone.gradient[i] * p
        curvature += zone.curvatures[i] * p * p
    row_products(zone, zone.direction, zone.along)
    for j in range(zone.along.size):
        if zone.pushed[j] > 0:
            active += zone.along[j] * zone.along[j]
    return slope, curvature, curvature + penalty * active


@compiled
def along_line(zone, penalty, slope, curvature, step):
    """L(x + step p) - L(x), and the first two derivatives of L there.

    The difference of two values of L loses a gradient below the square root of rounding.
    Here all that comes to the slope at x is a sum of terms >= 0, with nothing cancelled:
    a row active at both ends adds (step q)^2, q = A p, one that leaves t (2 step q - t),
    t = c + l / mu, and one that enters (t - step q)^2, each times mu / 2.
    """
    value, rise, second = 0.0, 0.0, 0.0
    for j in range(zone.pushed.size):
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
    return (
        step * (slope + 0.5 * curvature * step) + 0.5 * penalty * value,
        slope + curvature * step + penalty * rise,
        curvature + penalty * second,
    )


@compiled
def update_multipliers(zone, penalty):
    """Page eq. 9, clamped: l <- max(l + mu c, 0)."""
    for j in range(zone.multipliers.size):
        pushed = zone.constraints[j] * penalty + zone.multipliers[j]
        zone.multipliers[j] = max(pushed, 0.0)


@compiled
def hessian_diagonal(zone, penalty):
    """Diagonal of the generalised Hessian diag(w) + mu sum_active a a^T."""
    mu = zone.x.dtype.type(penalty)
    for i in range(zone.x.size):
        zone.diagonal[i] = zone.curvatures[i]
    for j in range(zone.pushed.size):
        if zone.pushed[j] > 0:
            for k in range(4):
                i, a = zone.nodes[j, k], zone.coefficients[j, k]
                for axis in range(3):
                    entry = a * zone.normals[j, axis]
                    zone.diagonal[i + axis] += mu * entry * entry
