"""Decide whether a vertex-face or edge-edge pair meets on its path, and find when it first does.

**Symbols.** A pair has four nodes, 0 to 3. Node k moves from p_k(0) to p_k(1) on a straight line:
p_k(t) = (1 - t) p_k(0) + t p_k(1). The two sides are the vertex 0 and the face 1 2 3, or the edge
0 1 and the edge 2 3. Node k relative to node 0 is e_k(t) = p_k(t) - p_0(t), so e_0 = 0. The
functions take a_k = e_k(0) and b_k = e_k(1) for k = 1, 2, 3, each computed as a difference of
floats.

**Method.** `advance` begins at t = 0. In each step it proves that the pair is apart on an interval
[t, t_next]. It tries two kinds of proof, takes the one that reaches farther, and goes on from
t_next:

* *A direction that separates the sides.* For a fixed vector n, the gap n . (e_i(t) - e_j(t)) is
  linear in t, for each node i of the first side and each node j of the second. If all these gaps
  are positive at t and at t_next, they are positive in between, so the sides are apart. This proof
  is sound for any n. The step tries the vector between the closest points at t, which reaches far,
  and the normal of the features (face, edges) on which these points lie. If the pair approaches
  without turning, one step ends at the contact. Otherwise each step squares the error.
* *No coplanar time.* Sides that meet have coplanar nodes, and at such a time the cubic of
  `detection/formulas/coplanar.py` is zero. So the pair is apart on [t, t_next] if the cubic has no
  root there. Rotation does not weaken this proof, but it says nothing where the pair stays
  coplanar.

**Result.**

* APART: every part of [0, 1] was proved. This is the only way to this answer, so no pair that
  meets is missed.
* CONTACT: the pair is proved apart until `toi`, and neither proof reaches a later time. Nearly
  always the pair touches at `toi` as far as rounding can tell: its distance is about 1e-14 of the
  size of a well-shaped pair, and larger for slivers. There is one exception. A vertex that slides
  in the plane of a face just past a corner may be a CONTACT although it stays apart: the squared
  distances to the edges differ by less than their rounding there, so the closest points may be
  taken on the wrong edge, and no direction that the step tries separates the sides. Distances of
  up to 1e-7 of the size were measured, and up to 7e-5 for a face without area, in 14 of 44,400
  constructed pairs (`validation/scenes/queries.py`). Such a pair costs an impact, and no
  correctness.
* UNDECIDED: `max_steps` steps were not enough. The pair is proved apart until `toi`.

**Rounding of the first proof.** Let u = 2^-53, and let M bound |e_k|_inf at both ends for all k.
The direction n needs no error: any n is sound, so the computed n is the direction itself. Let h0
and h1 be the computed gap of two nodes at t = 0 and t = 1.

Claim: if (1 - t) h0 + t h1 > threshold = 48 u |n|_1 M in floats, then the exact gap is positive
from t until the time that `_gap_until` computes. The errors, in units of u |n|_1 M and up to terms
in u^2, are:

    projection n . e_k      the input e_k: 1; a dot product of three terms, gamma_3: 3         4
    gap, h0 or h1           two projections: 8; the difference is at most 2 |n|_1 M: 2        10
    gap at t                1 - t, a product and a sum, of values up to 2 |n|_1 M: 3 * 2       6
    time of the threshold   (h0 - threshold) / (h0 - h1) has a relative error of at most 5 u,
                            and the gap changes by at most 4 |n|_1 M on the path: 5 * 4       20

Together these are 36. GAP_ERROR = 48 u leaves room for the terms in u^2, such as the rounding of
the threshold. `TINY` covers products that underflow.

**Ends that are not known.** Node k may end anywhere within `reach[k]` of p_k(1), along each axis;
call this reach_k. For such ends the gap of nodes i and j at t = 1 is smaller by at most
|n|_1 (reach_i + reach_j), and the gap at time t by t times that. So this amount is subtracted from
h1: what remains is linear in t, and is a lower bound for every end within reach. M is now the
largest M_k = max(|a_k|_inf, |b_k|_inf) + reach_0 + reach_k. In the units above, the errors of h1
are:

    of node i or j          4 u |n|_1 |b_i|_inf for the projection; 4 u |n|_1 reach_i for the
                            norm, the sum of both reaches and the product; u |n|_1 reach_i
                            because the reach holds up to a rounding. As
                            |b_i|_inf + reach_i <= M, at most 5 for each of the two nodes     10
    two subtractions        the results are at most 2 |n|_1 M: 2 * 2                           4

These 14 replace the 10 of the table, which makes 40 in place of 36: still below 48. The tests
along axes and diagonals need no interpolation and no time, so 14 covers them.
"""

from izo_ref.base.arrays import Vec3, Vec4
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
# |det(x, y, z)| <= 6 |x|_inf |y|_inf |z|_inf, because it has six terms. The part above 6 covers the
# rounding of the products.
REACH_ERROR = 6.0 + 2.0**-40
# Of the 23,958 contacts of armadillo-rollers, half take at most 5 steps, and 99 % at most 22. One
# takes all 400.
MAX_STEPS = 400
# A shorter step is no progress: t is in [0, 1] and has an error of a few u. Each step also ends
# earlier by this much, which covers the rounding of `root_free_until`.
MIN_STEP = 16.0 * 2.0**-53


@compiled
def _gap_until(h0: float, h1: float, t: float, threshold: float) -> float:
    """Return the largest time up to which a gap stays above the threshold from t on.

    The gap is h0 at time 0 and h1 at time 1, and linear in between. The result is 2 if the gap is
    above the threshold until time 1, and -1 if it is not above it at t.
    """
    if not (1.0 - t) * h0 + t * h1 > threshold:
        return -1.0
    if h1 > threshold:
        return 2.0
    return (h0 - threshold) / (h0 - h1)


@compiled
def separated_until(
    is_edge_edge: bool,
    n: Vec3,
    a1: Vec3,
    a2: Vec3,
    a3: Vec3,
    b1: Vec3,
    b2: Vec3,
    b3: Vec3,
    reach: Vec4,
    t: float,
    threshold: float,
) -> float:
    """Return the largest time until which the direction n keeps the sides apart, from t on.

    The result is 2 if it keeps them apart until time 1, and -1 if it does not separate them at t.
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
def _apart_along(
    is_edge_edge: bool,
    s1: float,
    s2: float,
    s3: float,
    r1: float,
    r2: float,
    r3: float,
    size: float,
    reach: Vec4,
    threshold: float,
) -> bool:
    """Return whether a direction n, or -n, separates the sides on the whole path.

    s_k and r_k are the projections of nodes 1 to 3 on n at t = 0 and t = 1; those of node 0 are 0.
    `size` is |n|_1.
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
def _apart_along_diagonals(
    is_edge_edge: bool,
    i: int,
    j: int,
    a1: Vec3,
    a2: Vec3,
    a3: Vec3,
    b1: Vec3,
    b2: Vec3,
    b3: Vec3,
    reach: Vec4,
    threshold: float,
) -> bool:
    """Return whether a diagonal of the plane of axes i and j separates the sides on the path.

    The diagonals are the sum and the difference of the two axes, so |n|_1 = 2.
    """
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
def advance(
    is_edge_edge: bool,
    a1: Vec3,
    a2: Vec3,
    a3: Vec3,
    b1: Vec3,
    b2: Vec3,
    b3: Vec3,
    reach: Vec4,
    max_steps: int,
) -> tuple[int, float, Vec3, int]:
    """Prove a pair apart on its path, or find its first contact.

    Args:
        is_edge_edge: True for two edges, False for a vertex and a face.
        a1: Node 1 relative to node 0 at t = 0.
        a2: Node 2 relative to node 0 at t = 0.
        a3: Node 3 relative to node 0 at t = 0.
        b1: Node 1 relative to node 0 at t = 1.
        b2: Node 2 relative to node 0 at t = 1.
        b3: Node 3 relative to node 0 at t = 1.
        reach: How far from its given end position each of the nodes 0 to 3 may end, along each
            axis. APART then holds for all such end positions. The other results have a meaning for
            a reach of zero only.
        max_steps: Number of steps after which the pair is given up as UNDECIDED.

    Returns:
        The status, APART, CONTACT or UNDECIDED; the time of impact in [0, 1], until which the pair
        is proved apart; the last direction that separated the sides, which points from the second
        side to the first, or zero; and the number of steps.
    """
    e1, e2, e3 = reach[0] + reach[1], reach[0] + reach[2], reach[0] + reach[3]
    m1 = max(max_abs3(a1), max_abs3(b1)) + e1
    m2 = max(max_abs3(a2), max_abs3(b2)) + e2
    m3 = max(max_abs3(a3), max_abs3(b3)) + e3
    gap_error = GAP_ERROR * max(m1, max(m2, m3))
    # The relative motion is mostly small, however far the pair travels. So the axes, along which
    # the boxes were compared, and the diagonals of their planes, |n|_1 = 2, settle most pairs with
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
    # Scale the pair by a power of two to a size near 1. This is exact, except for entries that
    # underflow, which TINY covers. Products then neither overflow nor vanish.
    size = power_of_two_for(max(m1, max(m2, m3)))
    a1, a2, a3 = scale3(size, a1), scale3(size, a2), scale3(size, a3)
    b1, b2, b3 = scale3(size, b1), scale3(size, b2), scale3(size, b3)
    m1, m2, m3, gap_error = size * m1, size * m2, size * m3, size * gap_error
    e1, e2, e3 = size * e1, size * e2, size * e3
    reach = (size * reach[0], size * reach[1], size * reach[2], size * reach[3])
    cubic_error = COEFFICIENT_ERROR * (m1 * m2 * m3) + TINY
    # An end within reach changes column k of the determinant by at most e_k. Change one column
    # after the other: each change is a determinant whose other columns are at most m_k.
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
