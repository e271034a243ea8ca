"""Prove in float32 that a pair stays apart on its path; a pair without a proof is left open.

On many GPUs float64 runs at 1/64 of the speed of float32. So a GPU tries these two proofs before
those of `detection/formulas/advance.py`. A pair that they settle is done. Nothing is said about any
other pair: it goes to `advance`, which decides it as if there were no filter. So the impacts are
the same with and without the filter, bit for bit.

**Symbols.** Node k moves on a straight line from y_k(0) to y_k(1), in the coordinates of boxes
(`detection/serial/boxes.py:vertex_box`): the distance from a common origin, times a power of two
that brings the extent of the mesh near 1. That is a shift and one factor for all axes, so a pair
meets in these coordinates if and only if it meets. The numbers y are exact. The functions get p_k,
which is y_k in float32. Let U = 2^-24, and let P bound |p_k|_inf of the four nodes at both ends.

**Method.** Two proofs are tried on the whole path, from t = 0 to t = 1:

* *A direction that separates the sides.* w_ij = y_i - y_j is the difference of a node of the first
  side and one of the second. If n . w_ij > 0 for all of them at both ends, then also in between,
  because each is linear in time, and the sides are apart. This is sound for any n. There is such an
  n if and only if the origin is outside the convex hull of all these differences. Gilbert's
  algorithm looks for it: n is a point of the hull, at first the mean of all differences. In each
  step, n becomes the point nearest to the origin on the segment from n to the difference that is
  lowest along n.
* *No coplanar time.* The four coefficients of the cubic of `detection/formulas/coplanar.py` have
  the same sign, so the cubic has no root in [0, 1]. This settles sides that are close to each
  other, where the search takes many steps.

Source of the search: E. G. Gilbert, An iterative procedure for computing the minimum of a quadratic
form on a convex set (1966), SIAM Journal on Control 4(1).

**Rounding of the positions.** `vertex_box` computes (x - origin) * scale in float64 and rounds it
to float32. The difference has a relative error of 2^-53, the product none. A float32 has an error
of at most U |p|. So |p - y| <= U P (1 + 2^-28), up to underflow. It does not matter how far the
scene is from the origin of its coordinates.

**Rounding of the first proof.** The direction n needs no error: the computed n is the direction
itself. Let W bound the |w_ij|_inf that are computed from p, at both ends. The errors of a computed
n . w_ij, in units of U |n|_1 and up to terms in U^2, are:

    positions        of two nodes, U P each                                          2 P
    difference       relative error U                                                  W
    dot product      three terms, gamma_3                                            3 W

So the exact value is positive if the computed one exceeds U |n|_1 (4 W + 2 P). The
threshold is GAP_ERROR (2 W + P) |n|_1, and GAP_ERROR is larger than 2 U by a sixteenth. This covers
the terms in U^2, and the roundings of the threshold itself: eight of them are 2^-21. A GPU
contracts a product and a sum to one rounding, which is no more roundings than here.

**Rounding of the second proof.** e_k = y_k - y_0. Let M_k bound the computed |e_k|_inf at both
ends. A computed coordinate is off by at most d_k = U (M_k + 2 P), up to terms in U^2. Here d_k can
be as large as M_k, where a small element is far from the origin. So it is not of first order. With
N_k = M_k + 4 U P, both the exact and the computed coordinates are at most N_k (1 + U). Replace one
column after the other. A determinant has six terms, so the exact determinant differs from that of
the computed columns by at most 6 (d_1 N_2 N_3 + N_1 d_2 N_3 + N_1 N_2 d_3). The errors, in units of
U and with N = N_1 N_2 N_3 and Q = N_2 N_3 + N_1 N_3 + N_1 N_2, are:

    input            6 (M_k + 2 P) for each column                           18 N + 12 P Q
    cross            as in `coplanar.py`                                     12 N
    dot              as in `coplanar.py`                                     18 N
    sum              three determinants, sums of at most 12 N and 18 N       30 N

An outer coefficient is one determinant, with an error of 48 N + 12 P Q. An inner one is computed as
three times itself, with an error of 3 * 48 N + 3 * 12 P Q + 30 N = 3 (58 N + 12 P Q). So an error
of 58 N + 12 P Q is allowed for an outer one, and three times that for an inner one. The
constants 64 and 13 are larger than 58 and 12 by a twelfth. This covers the factors 1 + U of N_k,
the terms in U^2 and the roundings of the bound itself.

**Overflow.** A pair with |p_k| beyond LARGEST = 2^20 is left open. Its coordinates may have been
clamped, and such a node is a million times farther out than the mesh extends. So each difference is
at most 2^21 and each sum of determinants at most 18 * 2^63.

**Underflow.** A result that underflows is off by at most 2^-126, also on a GPU that flushes it to
zero. A position or a difference that is off by that much changes n . w by at most 3 * 2^-126 |n|_1
<= 2^-101, because n stays near the hull. In a determinant it is multiplied by two other columns, in
six terms: 18 * 2^42 * 3 * 2^-126 < 2^-78. Products and sums inside of the formulas are off by less.
TINY = 2^-70 covers all of them. Where proofs succeed, their values are far larger: P is about 1, so
the threshold of the gaps is about 2^-23 |n|_1.

**Numbers that are not finite.** Every comparison that leads to a proof is false for NaN, and each
proof depends on every coordinate. An infinite one is beyond LARGEST.
"""

from typing import Any, TypeAlias

import numpy as np

from izo_ref.base.arrays import Vec3
from izo_ref.base.compile import compiled
from izo_ref.base.formulas.vec3 import dot3, max_abs3, scale3, sub3, sum_abs3
from izo_ref.detection.formulas.coplanar import coefficient_sums

# Four vectors: the nodes of a pair at one time, or differences of these.
FourVec3: TypeAlias = tuple[Vec3, Vec3, Vec3, Vec3]

# All constants are float32, because a plain number would turn each product with it into float64.
U = 2.0**-24
GAP_ERROR: Any = np.float32(2.0 * U * (1.0 + 2.0**-4))
CUBIC_ERROR_N: Any = np.float32(64.0 * U)
CUBIC_ERROR_Q: Any = np.float32(13.0 * U)
INPUT_SHARE: Any = np.float32(4.0 * U)
TINY: Any = np.float32(2.0**-70)
LARGEST: Any = np.float32(2.0**20)
ZERO: Any = np.float32(0.0)
EIGHTH: Any = np.float32(0.125)
ONE: Any = np.float32(1.0)
THREE: Any = np.float32(3.0)
# Steps of the search. With these and the cubic, 96 % of the pairs of cloth-ball-clean that stay
# apart are settled (`reports/cuda/`).
SEARCH_STEPS = 16


@compiled
def _largest(p: FourVec3) -> float:
    """Return the largest absolute coordinate of four vectors."""
    return max(max(max_abs3(p[0]), max_abs3(p[1])), max(max_abs3(p[2]), max_abs3(p[3])))


@compiled
def differences(is_edge_edge: bool, p: FourVec3) -> FourVec3:
    """Return each node of the first side less each node of the second.

    A vertex and a face have three such differences; the third one comes twice.
    """
    if is_edge_edge:
        return sub3(p[0], p[2]), sub3(p[0], p[3]), sub3(p[1], p[2]), sub3(p[1], p[3])
    last = sub3(p[0], p[3])
    return sub3(p[0], p[1]), sub3(p[0], p[2]), last, last


@compiled
def _lower(n: Vec3, w: Vec3, gap: float, at: Vec3) -> tuple[float, Vec3]:
    """Return the lower one of the gap of w along n and another gap, and where it is."""
    own = dot3(n, w)
    if own < gap:
        return own, w
    return gap, at


@compiled
def lowest_gap(n: Vec3, a: FourVec3, b: FourVec3) -> tuple[float, Vec3]:
    """Return the smallest gap along n of the differences at both ends, and its difference."""
    gap, at = dot3(n, a[0]), a[0]
    gap, at = _lower(n, a[1], gap, at)
    gap, at = _lower(n, a[2], gap, at)
    gap, at = _lower(n, a[3], gap, at)
    gap, at = _lower(n, b[0], gap, at)
    gap, at = _lower(n, b[1], gap, at)
    gap, at = _lower(n, b[2], gap, at)
    return _lower(n, b[3], gap, at)


@compiled
def is_separated(a: FourVec3, b: FourVec3, gap_error: float) -> bool:
    """Return whether the search finds a direction along which all differences are positive.

    Args:
        a: Differences of the nodes of both sides at t = 0.
        b: The same at t = 1.
        gap_error: Bound of the error of a gap, by |n|_1.
    """
    first, second = _sum(a), _sum(b)
    n = scale3(EIGHTH, (first[0] + second[0], first[1] + second[1], first[2] + second[2]))
    for _ in range(SEARCH_STEPS):
        gap, at = lowest_gap(n, a, b)
        if gap > gap_error * sum_abs3(n) + TINY:
            return True
        d = sub3(at, n)
        nearer, length_sq = -dot3(n, d), dot3(d, d)
        if not (nearer > ZERO and length_sq > ZERO):
            return False
        share = min(nearer / length_sq, ONE)
        n = (n[0] + share * d[0], n[1] + share * d[1], n[2] + share * d[2])
    return False


@compiled
def _sum(p: FourVec3) -> Vec3:
    """Return the sum of four vectors."""
    return (
        (p[0][0] + p[1][0]) + (p[2][0] + p[3][0]),
        (p[0][1] + p[1][1]) + (p[2][1] + p[3][1]),
        (p[0][2] + p[1][2]) + (p[2][2] + p[3][2]),
    )


@compiled
def is_never_coplanar(p: FourVec3, q: FourVec3, farthest: float) -> bool:
    """Return whether the nodes are certainly not in one plane at any time of the path.

    Args:
        p: Nodes at t = 0.
        q: Nodes at t = 1.
        farthest: Largest absolute coordinate of all of them.
    """
    a1, a2, a3 = sub3(p[1], p[0]), sub3(p[2], p[0]), sub3(p[3], p[0])
    b1, b2, b3 = sub3(q[1], q[0]), sub3(q[2], q[0]), sub3(q[3], q[0])
    m1 = max(max_abs3(a1), max_abs3(b1)) + INPUT_SHARE * farthest
    m2 = max(max_abs3(a2), max_abs3(b2)) + INPUT_SHARE * farthest
    m3 = max(max_abs3(a3), max_abs3(b3)) + INPUT_SHARE * farthest
    faces = m2 * m3 + m1 * m3 + m1 * m2
    outer = CUBIC_ERROR_N * (m1 * m2 * m3) + CUBIC_ERROR_Q * (farthest * faces) + TINY
    inner = THREE * outer
    c0, c1, c2, c3 = coefficient_sums(a1, a2, a3, b1, b2, b3)
    if c0 > outer:
        return c1 > inner and c2 > inner and c3 > outer
    return c0 < -outer and c1 < -inner and c2 < -inner and c3 < -outer


@compiled
def is_surely_apart(is_edge_edge: bool, p: FourVec3, q: FourVec3) -> bool:
    """Return whether a pair is proved apart on its path; False says nothing.

    Args:
        is_edge_edge: True for two edges, False for a vertex and a face.
        p: The four nodes at t = 0, in float32, in the coordinates of boxes.
        q: The same at t = 1.
    """
    farthest = max(_largest(p), _largest(q))
    if not farthest <= LARGEST:
        return False
    a, b = differences(is_edge_edge, p), differences(is_edge_edge, q)
    size = max(_largest(a), _largest(b))
    if is_separated(a, b, GAP_ERROR * (size + size + farthest)):
        return True
    return is_never_coplanar(p, q, farthest)
