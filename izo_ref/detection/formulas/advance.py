"""Does a vertex-face or edge-edge pair meet on its path, and when first?

From t = 0 on, each step proves the pair apart on [t, t_next] in one of two ways, takes
the one that reaches farther, and goes on from there:

* **a direction that separates**: for a fixed n, n . (p_i(t) - p_j(t)) is linear in t for
  every node i of the first side and j of the second. If it is positive for all of them at
  t and at t_next, the sides are apart in between. n is the vector between the closest
  points at t; any n would be sound, this one reaches far. When the pair approaches
  without turning, one step ends at the contact; otherwise the error is squared each step.
* **no coplanar time**: the cubic of `detection/formulas/coplanar.py` has no root in [t, t_next].
  That one does not mind rotation, but says nothing where the pair stays coplanar.

So nothing is missed: a pair is called APART only when each part of [0, 1] was proved.
CONTACT says that at `toi` neither proof gets on: the pair touches but for rounding, which
is some 1e-14 of the size of a well-shaped pair, and more for slivers. UNDECIDED says that
`max_steps` did not suffice, with the time until which it is proved apart.

Rounding of the first proof. u = 2^-53; M bounds |e_k|_inf (node k relative to node 0) at
both ends; n is taken as exact. Each projection n . e_k has the input's error u and
gamma_3 of the dot product, 4 u |n|_1 M; a difference of two projections 8 u |n|_1 M + its
own rounding 2 u |n|_1 M: 10 u. Its interpolation at t adds 3 u * 2 |n|_1 M = 6 u, and the
time at which it falls to the threshold is computed with 5 u of relative error on a
difference of at most 4 |n|_1 M: 20 u. Together 36 u; GAP_ERROR = 48 u is the threshold.

Ends that are not known: node k may end within `reach` e_k of b_k, along each axis. A gap of
nodes i and j at t = 1 is less by |n|_1 (e_i + e_j) at most, and in between by t times that: so
it is taken off at t = 1, and what is linear stays linear. M is made larger by the reach; the
product, 4 u |n|_1 M, and the subtraction, 2 u |n|_1 M, bring the 36 u to 42 u.
"""

from izo_ref.base.compile import compiled
from izo_ref.base.formulas.vec3 import (
    dot3,
    lerp3,
    max_abs3,
    power_of_two_for,
    scale3,
    sum_abs3,
    unit3,
)
from izo_ref.detection.formulas.closest import pair_weights, weighted_sum
from izo_ref.detection.formulas.coplanar import (
    COEFFICIENT_ERROR,
    TINY,
    bernstein_coefficients,
    root_free_until,
)
from izo_ref.detection.formulas.frame import feature_normal

APART = 0
CONTACT = 1
UNDECIDED = 2

GAP_ERROR = 48.0 * 2.0**-53
# |det| <= 6 times the product of its columns' largest entries; what is above 6 is for rounding.
REACH_ERROR = 6.0 + 2.0**-40
# Half of the 23,958 contacts of armadillo-rollers take 5 steps at most, 99 % at most 22;
# one takes all of these.
MAX_STEPS = 400
# t is in [0, 1]: a step below a few of its roundings is none.
MIN_STEP = 16.0 * 2.0**-53


@compiled
def _gap_until(h0, h1, t, threshold):
    """Largest time up to which a gap, h0 at 0 and h1 at 1, stays above threshold.

    -1 when it is not above it at t.
    """
    if not (1.0 - t) * h0 + t * h1 > threshold:
        return -1.0
    if h1 > threshold:
        return 2.0
    return (h0 - threshold) / (h0 - h1)


@compiled
def separated_until(is_edge_edge, n, a1, a2, a3, b1, b2, b3, reach, t, threshold):
    """Largest time until which n keeps the two sides apart, from t on.

    2 for the whole path, -1 when n does not separate them at t.
    """
    s1, s2, s3 = dot3(n, a1), dot3(n, a2), dot3(n, a3)
    r1, r2, r3 = dot3(n, b1), dot3(n, b2), dot3(n, b3)
    size = sum_abs3(n)
    t2 = _gap_until(-s2, -r2 - size * (reach[0] + reach[2]), t, threshold)
    t3 = _gap_until(-s3, -r3 - size * (reach[0] + reach[3]), t, threshold)
    until = min(t2, t3)
    if is_edge_edge:
        t12 = _gap_until(s1 - s2, r1 - r2 - size * (reach[1] + reach[2]), t, threshold)
        t13 = _gap_until(s1 - s3, r1 - r3 - size * (reach[1] + reach[3]), t, threshold)
        return min(until, min(t12, t13))
    return min(until, _gap_until(-s1, -r1 - size * (reach[0] + reach[1]), t, threshold))


@compiled
def _apart_along(is_edge_edge, s1, s2, s3, r1, r2, r3, size, reach, threshold):
    """Whether a direction separates the sides all the time, either way round.

    s_k, r_k are the projections of nodes 1..3 at t = 0, 1; node 0 has 0. `size` is |n|_1.
    """
    e0, e1, e2, e3 = size * reach[0], size * reach[1], size * reach[2], size * reach[3]
    if is_edge_edge:
        low = min(s2, s3) - max(0.0, s1)
        low_t1 = min(r2 - e2, r3 - e3) - max(e0, r1 + e1)
        high = min(0.0, s1) - max(s2, s3)
        high_t1 = min(-e0, r1 - e1) - max(r2 + e2, r3 + e3)
    else:
        low = min(s1, min(s2, s3))
        low_t1 = min(r1 - e1, min(r2 - e2, r3 - e3)) - e0
        high = -max(s1, max(s2, s3))
        high_t1 = -e0 - max(r1 + e1, max(r2 + e2, r3 + e3))
    return min(low, low_t1) > threshold or min(high, high_t1) > threshold


@compiled
def _apart_along_diagonals(is_edge_edge, i, j, a1, a2, a3, b1, b2, b3, reach, threshold):
    """The same of the two diagonals of axes i and j."""
    return _apart_along(
        is_edge_edge,
        a1[i] + a1[j],
        a2[i] + a2[j],
        a3[i] + a3[j],
        b1[i] + b1[j],
        b2[i] + b2[j],
        b3[i] + b3[j],
        2.0,
        reach,
        threshold,
    ) or _apart_along(
        is_edge_edge,
        a1[i] - a1[j],
        a2[i] - a2[j],
        a3[i] - a3[j],
        b1[i] - b1[j],
        b2[i] - b2[j],
        b3[i] - b3[j],
        2.0,
        reach,
        threshold,
    )


@compiled
def advance(is_edge_edge, a1, a2, a3, b1, b2, b3, reach, max_steps):
    """First contact of a pair; a_k, b_k are nodes 1..3 relative to node 0 at t = 0, 1.

    Args:
        reach: of nodes 0..3. Each may end anywhere so far from its end, along each axis:
            APART holds for all such ends. For anything else let it be zero.
        max_steps: [steps] before it gives up.

    Returns:
        status: APART, CONTACT or UNDECIDED.
        toi: time of impact in [0, 1]; until there the pair is proved apart.
        direction: the last direction that separated the sides (second to first), or zero.
        steps: number of proofs.
    """
    e1, e2, e3 = reach[0] + reach[1], reach[0] + reach[2], reach[0] + reach[3]
    m1 = max(max_abs3(a1), max_abs3(b1)) + e1
    m2 = max(max_abs3(a2), max_abs3(b2)) + e2
    m3 = max(max_abs3(a3), max_abs3(b3)) + e3
    gap_error = GAP_ERROR * max(m1, max(m2, m3))
    # The relative motion is mostly small, however far the pair travels: the axes, by which the
    # boxes were compared, and the diagonals of their planes, |n|_1 = 2, settle most pairs with
    # next to no product. Without the diagonals armadillo-rollers takes 993,475 proofs, with them
    # 449,144, which its certificate counts.
    for k in range(3):
        if _apart_along(
            is_edge_edge, a1[k], a2[k], a3[k], b1[k], b2[k], b3[k], 1.0, reach, gap_error + TINY
        ):
            return APART, 1.0, (0.0, 0.0, 0.0), 0
    for k in range(3):
        if _apart_along_diagonals(
            is_edge_edge, k, (k + 1) % 3, a1, a2, a3, b1, b2, b3, reach, 2.0 * gap_error + TINY
        ):
            return APART, 1.0, (0.0, 0.0, 0.0), 0
    # By a power of two to a size near 1: exact, and products neither overflow nor vanish.
    size = power_of_two_for(max(m1, max(m2, m3)))
    a1, a2, a3 = scale3(size, a1), scale3(size, a2), scale3(size, a3)
    b1, b2, b3 = scale3(size, b1), scale3(size, b2), scale3(size, b3)
    m1, m2, m3, gap_error = size * m1, size * m2, size * m3, size * gap_error
    e1, e2, e3 = size * e1, size * e2, size * e3
    reach = (size * reach[0], size * reach[1], size * reach[2], size * reach[3])
    cubic_error = COEFFICIENT_ERROR * (m1 * m2 * m3) + TINY
    # by the reach a determinant changes by |e|_inf in any of its columns, or in several
    cubic_error += REACH_ERROR * (e1 * m2 * m3 + m1 * e2 * m3 + m1 * m2 * e3)
    # a pair that is never coplanar needs no closest points
    cubic = bernstein_coefficients(a1, a2, a3, b1, b2, b3)
    low = min(min(cubic[0], cubic[1]), min(cubic[2], cubic[3]))
    high = max(max(cubic[0], cubic[1]), max(cubic[2], cubic[3]))
    if low > cubic_error or high < -cubic_error:
        return APART, 1.0, (0.0, 0.0, 0.0), 1
    direction = (0.0, 0.0, 0.0)
    t = 0.0
    for step in range(1, max_steps + 1):
        q1, q2, q3 = lerp3(a1, b1, t), lerp3(a2, b2, t), lerp3(a3, b3, t)
        weights = pair_weights(is_edge_edge, q1, q2, q3)
        n = unit3(weighted_sum(weights, q1, q2, q3))
        threshold = gap_error * sum_abs3(n) + TINY
        until = separated_until(is_edge_edge, n, a1, a2, a3, b1, b2, b3, reach, t, threshold)
        if until > 1.0:
            return APART, 1.0, n, step
        if until >= 0.0:
            direction = n
        m = feature_normal(is_edge_edge, weights, q1, q2, q3, n)
        threshold = gap_error * sum_abs3(m) + TINY
        until_m = separated_until(is_edge_edge, m, a1, a2, a3, b1, b2, b3, reach, t, threshold)
        if until_m > 1.0:
            return APART, 1.0, m, step
        if until_m > until:
            until = until_m
            direction = m
        until = max(until, root_free_until(cubic, t, cubic_error))
        if until > 1.0:
            return APART, 1.0, direction, step
        # the proofs hold up to here; rounded down so that they hold for the float too
        until -= MIN_STEP
        if not until > t + MIN_STEP:
            return CONTACT, t, direction, step
        t = until
    return UNDECIDED, t, direction, max_steps
