"""The augmented Lagrangian of one zone: its value, its gradient, and its course along a line.

A zone minimises sum_i w_i x_i^2 / 2 subject to c_j <= 0 for each constraint j. Every constraint
has a multiplier l_j >= 0, and mu > 0 is the penalty:

    L(x) = sum_i w_i x_i^2 / 2 + mu/2 sum_j max(c_j + l_j / mu, 0)^2 - sum_j l_j^2 / (2 mu)
    c_j  = s_j - N_j . sum_k a_jk x_jk,   in short c = s - A x

Here x is the displacement from the proposed positions, so that nothing cancels there; N_j is the
normal of impact j, a_jk its coefficient at node k, and s_j the value of c_j at x = 0. The weights
are w = 2 kappa, where sum_i kappa_i x_i^2 is the objective g. The caller chooses the variables:
metres, or those of docs/method section 5.

A constraint is active where c_j + l_j / mu > 0. Between the points where a constraint becomes
active or inactive, L is quadratic. Its generalised Hessian is diag(w) + mu sum_active A_j A_j^T.

All pinned vertices share one place, the last three numbers of x. Their coefficients are zero, so
that loops need no branch for them.

One thread or several work on a zone (`base/serial/thread_group.py`). Constraints write entries of
constraints, and then each vertex gathers from its constraints in their order. So no thread adds to
a number to which another one adds.

Source: docs/method section 3; XRTailor documentation, "Impact Zone Optimization", eqs. 5 to 11.
Eq. 9 is taken as it is meant, with the slack eliminated (clamped).
"""

from typing import NamedTuple

from izo_ref.base.arrays import AnyFloat, AnyFloats, AnyInts, Flags, Floats
from izo_ref.base.compile import compiled
from izo_ref.base.serial.thread_group import ThreadGroup, group_maxima, group_sum, group_sums

# Places in Zone.state, and their number
N_STATES = 9
MU, STEP, STORED, AGE, OMEGA, WORST, BEST, BEST_AT, INNER = range(N_STATES)


class Zone(NamedTuple):
    """One zone and its work space, with n = 3 (vertices + 1) numbers in x, and m impacts.

    The arrays are all of one type, float64 or float32. Sums over them are float64 in either case,
    and so are mu and the step until they multiply an array.
    """

    nodes: AnyInts  # (m, 4) u4, 3 times the vertex: where its coordinates begin in x
    coefficients: AnyFloats  # (m, 4), a
    entries: AnyInts  # (n_entries,) u4, the constraints of each vertex, vertex by vertex
    arms: AnyFloats  # (n_entries, 3), a N of the vertex in each of these constraints
    entry_starts: AnyInts  # (n / 3 + 1,) u8, where the entries of each vertex begin
    normals: AnyFloats  # (m, 3), N
    starts: AnyFloats  # (m,), s, the constraints at x = 0
    metres: AnyFloats  # (m,), violation [m] of a constraint with c = 1
    curvatures: AnyFloats  # (n,), w
    x: AnyFloats  # (n,)
    multipliers: AnyFloats  # (m,), l
    gradient: AnyFloats  # (n,), of L
    direction: AnyFloats  # (n,), p
    diagonal: AnyFloats  # (n,), of the generalised Hessian
    previous: AnyFloats  # (n,), the gradient (cg, lbfgs) or x (chebyshev) one step before
    constraints: AnyFloats  # (m,), c
    pushed: AnyFloats  # (m,), c + l / mu; a constraint is active where this is positive
    along: AnyFloats  # (m,), A p; at other times what constraints hand to their vertices
    memory: AnyFloats  # flat, vectors of lbfgs or of newton
    state: Floats  # (9,) f8, numbers that the loop and the directions keep, one array per thread
    group: ThreadGroup
    stop: Flags  # (1,) b1, no further step begins once it is set


class Measures(NamedTuple):
    """What one pass over the gradient and the constraints finds.

    Sums are sums of squares, not norms.
    """

    value: float  # L
    objective: float  # sum w x^2 / 2
    error: float  # sum g^2 / w, with g the gradient of L
    gradient_sq: float  # sum g^2
    largest_gradient: float  # largest |g|
    largest_pull: float  # largest |w x|
    products: float  # sum_j max(l + mu c, 0) |c|
    shift_sq: float  # sum_j min(-c, l / mu)^2; an update changes l by mu times this minimum
    largest_shift: float  # largest |min(-c, l / mu)|
    violation_m: float  # [m], largest violation


@compiled
def constraint_products(zone: Zone, vector: AnyFloats, products_out: AnyFloats) -> None:
    """Compute A v: N_j . sum_k a_jk v_jk for each constraint."""
    for j in range(zone.group.rank(), products_out.size, zone.group.size()):
        value = vector.dtype.type(0)
        for k in range(4):
            i = zone.nodes[j, k]
            point = zone.normals[j, 0] * vector[i]
            point += zone.normals[j, 1] * vector[i + 1]
            point += zone.normals[j, 2] * vector[i + 2]
            value += zone.coefficients[j, k] * point
        products_out[j] = value


@compiled
def renew_constraints(zone: Zone) -> None:
    """Compute c = s - A x anew, without the rounding that step-by-step updates have added."""
    zone.group.wait()
    constraint_products(zone, zone.x, zone.constraints)
    for j in range(zone.group.rank(), zone.constraints.size, zone.group.size()):
        zone.constraints[j] = zone.starts[j] - zone.constraints[j]


@compiled
def gather_at_vertex(
    zone: Zone, vertex: int, factor: AnyFloat, values: AnyFloats
) -> tuple[AnyFloat, AnyFloat, AnyFloat]:
    """Return factor sum_j a_jk N_j v_j over the constraints of a vertex, three numbers."""
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
def evaluate(zone: Zone, penalty: float) -> Measures:
    """Compute the gradient of L at x, `pushed`, and the measures of (x, max(l + mu c, 0)).

    With max(l + mu c, 0) as multipliers, the gradient of L is what is missing from
    stationarity. So the duality gap of this pair is error / 2 + products.

    Source: docs/method section 8.
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
        pulls, i = gather_at_vertex(zone, vertex, mu, zone.along), 3 * vertex
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
def prepare_line(zone: Zone, penalty: float) -> tuple[float, float, float]:
    """Compute A p, and return three derivatives of L along p at x.

    Returns:
        The slope; the second derivative without the active constraints; the second derivative.
    """
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
def along_line(
    zone: Zone, penalty: float, slope: float, curvature: float, step: float
) -> tuple[float, float, float]:
    """Return L(x + step p) - L(x), and the first two derivatives of L there along p.

    Near the minimum, the difference of two values of L is rounding. So the change is not computed
    as a difference: what is added to the slope at x is a sum of terms >= 0, in which nothing
    cancels. With q = A p and t = c + l / mu, a constraint adds mu / 2 times

        (step q)^2          if it is active at both ends,
        t (2 step q - t)    if it is active at x only,
        (t - step q)^2      if it is active at x + step p only.

    `slope` and `curvature` are the first two numbers that `prepare_line` returned.
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
def update_multipliers(zone: Zone, penalty: float) -> None:
    """Update the multipliers: l <- max(l + mu c, 0).

    Source: page eq. 9, clamped.
    """
    for j in range(zone.group.rank(), zone.multipliers.size, zone.group.size()):
        pushed = zone.constraints[j] * penalty + zone.multipliers[j]
        zone.multipliers[j] = max(pushed, 0.0)


@compiled
def hessian_diagonal(zone: Zone, penalty: float) -> None:
    """Compute the diagonal of the generalised Hessian diag(w) + mu sum_active A_j A_j^T."""
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
