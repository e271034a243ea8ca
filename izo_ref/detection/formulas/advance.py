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
* CONTACT: the pair is proved apart until `toi`, and neither proof reaches a later time, or the
  cubic changes its sign just after `toi` while the closest points are well inside their features,
  so the sides pass through each other there. Most contacts end so at the first root of the cubic,
  before any direction is tried; without that end they take 6 or 7 steps. Nearly always the pair
  touches at `toi` as far as rounding can tell: its distance is about 1e-14 of the size of a
  well-shaped pair, and larger for slivers. There is one exception. A vertex that slides in the
  plane of a face just past a corner may be a CONTACT although it stays apart: the squared distances
  to the edges differ by less than their rounding there, so the closest points may be taken on the
  wrong edge, and no direction that the step tries separates the sides. Distances of up to 1e-7 of
  the size were measured, and up to 7e-5 for a face without area, in 14 of 44,400 constructed pairs
  (`validation/scenes/queries.py`). Such a pair costs an impact, and no correctness.
* UNDECIDED: `MAX_STEPS` steps were not enough. The pair is proved apart until `toi`.

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

How far a proof holds for other ends is derived in `detection/formulas/margin.py`.
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
    crosses_soon,
    root_free_until,
)
from izo_ref.detection.formulas.frame import feature_normal
from izo_ref.detection.formulas.margin import axes_margin, cubic_margin, margin_along

APART = 0
CONTACT = 1
UNDECIDED = 2

GAP_ERROR = 48.0 * 2.0**-53
# A pair that is not decided within so many steps counts as a contact.
MAX_STEPS = 400
# The second direction of a proof takes over at this fraction of the time that the first one
# reaches. There both directions still have some slack.
SWITCH = 0.75
# A closest point is well inside its face or edge if all of its weights are at least this large.
INSIDE = 1e-6
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
    t: float,
    threshold: float,
) -> float:
    """Return the largest time until which the direction n keeps the sides apart, from t on.

    The result is 2 if it keeps them apart until time 1, and -1 if it does not separate them at t.
    """
    s1, s2, s3 = dot3(n, a1), dot3(n, a2), dot3(n, a3)
    r1, r2, r3 = dot3(n, b1), dot3(n, b2), dot3(n, b3)
    until = min(_gap_until(-s2, -r2, t, threshold), _gap_until(-s3, -r3, t, threshold))
    if is_edge_edge:
        t12 = _gap_until(s1 - s2, r1 - r2, t, threshold)
        t13 = _gap_until(s1 - s3, r1 - r3, t, threshold)
        return min(until, min(t12, t13))
    return min(until, _gap_until(-s1, -r1, t, threshold))


@compiled
def _is_inside(is_edge_edge: bool, weights: Vec4) -> bool:
    """Return whether both closest points are well inside their face or edges."""
    second = max(weights[2], weights[3]) < -INSIDE
    if is_edge_edge:
        return second and min(weights[0], weights[1]) > INSIDE
    return second and weights[1] < -INSIDE


@compiled
def _passes_through(
    is_edge_edge: bool,
    a1: Vec3,
    a2: Vec3,
    a3: Vec3,
    b1: Vec3,
    b2: Vec3,
    b3: Vec3,
    t: float,
    cubic: Vec4,
    error: float,
) -> bool:
    """Return whether the sides pass through each other just after t, well inside their features."""
    if not 0.0 < t < 1.0:
        return False
    q1, q2, q3 = lerp3(a1, b1, t), lerp3(a2, b2, t), lerp3(a3, b3, t)
    weights = pair_weights(is_edge_edge, q1, q2, q3)
    return _is_inside(is_edge_edge, weights) and crosses_soon(cubic, t, error)


@compiled
def _first_contact(
    is_edge_edge: bool,
    a1: Vec3,
    a2: Vec3,
    a3: Vec3,
    b1: Vec3,
    b2: Vec3,
    b3: Vec3,
    gap_error: float,
    cubic: Vec4,
    cubic_error: float,
) -> tuple[int, float, Vec3, int, float]:
    """Prove a pair of a size near 1 apart, piece by piece; return what `advance` returns."""
    direction = (0.0, 0.0, 0.0)
    first, first_until = direction, 0.0  # the direction of the first step, and its time
    root = -1.0  # time until which the cubic has no root from the start, if it is known
    if (cubic[0] > 0.0) != (cubic[3] > 0.0):
        root = root_free_until(cubic, 0.0, cubic_error)
        if _passes_through(
            is_edge_edge, a1, a2, a3, b1, b2, b3, root - MIN_STEP, cubic, cubic_error
        ):
            return CONTACT, root - MIN_STEP, direction, 1, 0.0
    t = 0.0
    for step in range(1, MAX_STEPS + 1):
        q1, q2, q3 = lerp3(a1, b1, t), lerp3(a2, b2, t), lerp3(a3, b3, t)
        weights = pair_weights(is_edge_edge, q1, q2, q3)
        if step > 1 and _is_inside(is_edge_edge, weights) and crosses_soon(cubic, t, cubic_error):
            return CONTACT, t, direction, step, 0.0
        n = unit3(weighted_sum(weights, q1, q2, q3))
        threshold = gap_error * sum_abs3(n) + TINY
        until = separated_until(is_edge_edge, n, a1, a2, a3, b1, b2, b3, t, threshold)
        if until >= 0.0:
            direction = n
        if not until > 1.0:
            m = feature_normal(is_edge_edge, weights, q1, q2, q3, n)
            threshold = gap_error * sum_abs3(m) + TINY
            until_m = separated_until(is_edge_edge, m, a1, a2, a3, b1, b2, b3, t, threshold)
            if until_m > until:
                until = until_m
                direction = m
        if until > 1.0:
            margin = 0.0
            if step == 1:
                margin = margin_along(
                    is_edge_edge, direction, a1, a2, a3, b1, b2, b3, 0.0, 1.0, gap_error
                )
            elif step == 2 and first_until > 0.0:
                switch = SWITCH * first_until
                margin = min(
                    margin_along(
                        is_edge_edge, first, a1, a2, a3, b1, b2, b3, 0.0, switch, gap_error
                    ),
                    margin_along(
                        is_edge_edge, direction, a1, a2, a3, b1, b2, b3, switch, 1.0, gap_error
                    ),
                )
            return APART, 1.0, direction, step, margin
        if step == 1:
            first, first_until = direction, until
        if step > 1 or root < 0.0:
            root = root_free_until(cubic, t, cubic_error)
        until = max(until, root)
        if until > 1.0:
            return APART, 1.0, direction, step, 0.0
        # the proofs hold up to here; rounded down so that they hold for the float too
        until -= MIN_STEP
        if not until > t + MIN_STEP:
            return CONTACT, t, direction, step, 0.0
        t = until
    return UNDECIDED, t, direction, MAX_STEPS, 0.0


@compiled
def advance(
    is_edge_edge: bool, a1: Vec3, a2: Vec3, a3: Vec3, b1: Vec3, b2: Vec3, b3: Vec3
) -> tuple[int, float, Vec3, int, float]:
    """Prove a pair apart on its path, or find its first contact.

    Args:
        is_edge_edge: True for two edges, False for a vertex and a face.
        a1: Node 1 relative to node 0 at t = 0.
        a2: Node 2 relative to node 0 at t = 0.
        a3: Node 3 relative to node 0 at t = 0.
        b1: Node 1 relative to node 0 at t = 1.
        b2: Node 2 relative to node 0 at t = 1.
        b3: Node 3 relative to node 0 at t = 1.

    Returns:
        The status, APART, CONTACT or UNDECIDED; the time of impact in [0, 1], until which the pair
        is proved apart; the last direction that separated the sides, which points from the second
        side to the first, or zero; the number of steps; and the margin: a pair that is APART stays
        so if each node ends elsewhere by at most this much along each axis.
    """
    m1 = max(max_abs3(a1), max_abs3(b1))
    m2 = max(max_abs3(a2), max_abs3(b2))
    m3 = max(max_abs3(a3), max_abs3(b3))
    gap_error = GAP_ERROR * max(m1, max(m2, m3))
    # The relative motion is mostly small, however far the pair travels. So the axes, along which
    # the boxes were compared, and the diagonals of their planes, settle most pairs with next to no
    # product. Without the diagonals armadillo-rollers takes 993,475 proofs, with them 449,144,
    # which its certificate counts.
    margin = axes_margin(is_edge_edge, a1, a2, a3, b1, b2, b3, gap_error)
    if margin > 0.0:
        return APART, 1.0, (0.0, 0.0, 0.0), 0, margin
    # Scale the pair by a power of two to a size near 1. This is exact, except for entries that
    # underflow, which TINY covers. Products then neither overflow nor vanish.
    size = power_of_two_for(max(m1, max(m2, m3)))
    a1, a2, a3 = scale3(size, a1), scale3(size, a2), scale3(size, a3)
    b1, b2, b3 = scale3(size, b1), scale3(size, b2), scale3(size, b3)
    m1, m2, m3, gap_error = size * m1, size * m2, size * m3, size * gap_error
    cubic_error = COEFFICIENT_ERROR * (m1 * m2 * m3) + TINY
    # a pair that is never coplanar needs no closest points
    cubic = bernstein_coefficients(a1, a2, a3, b1, b2, b3)
    low = max(
        min(min(cubic[0], cubic[1]), min(cubic[2], cubic[3])),
        -max(max(cubic[0], cubic[1]), max(cubic[2], cubic[3])),
    )
    if low > cubic_error:
        return APART, 1.0, (0.0, 0.0, 0.0), 1, cubic_margin(low, m1, m2, m3) / size
    status, toi, direction, steps, margin = _first_contact(
        is_edge_edge, a1, a2, a3, b1, b2, b3, gap_error, cubic, cubic_error
    )
    return status, toi, direction, steps, margin / size
