"""How far the nodes of a pair may end from where a proof says that they end.

The symbols, u and M are those of `detection/formulas/advance.py`.

A proof of `detection/formulas/advance.py` also holds for other ends, if they are not far from the
given ones. Let every node end within r of p_k(1), along each axis; the margin is such an r. The gap
of two nodes at t = 1 then falls by at most 2 r |n|_1, and at time t by t times that, while M grows
by at most 2 r, and the threshold by 48 u |n|_1 2 r. So a direction that separates the sides on the
whole path still does, if

    h1 - threshold >= 2 r |n|_1 (1 + 48 u)    and    h0 - threshold >= 48 u |n|_1 2 r

at the smallest gaps h0 and h1. With r = MARGIN_SHARE * slack / |n|_1, where the slack is the
smaller one of h1 - threshold and START_SHARE * (h0 - threshold), both hold: MARGIN_SHARE is below
1/2 by 2^-12, and START_SHARE * 48 u is 2^-27. The same 2^-12 covers the rounding of r, and that of
the differences by which a caller counts moves. If one direction separates the sides until some
time, and another one from there on, the gaps of both at this time take the place of h1 and h0. A
gap at a time between falls by less than 2 r |n|_1.

The cubic has no root on the whole path as long as its coefficients exceed the error by more than
they change. A column of the determinant changes by at most 2 r. Change one column after the other:
each change is a determinant whose other columns are at most M_k + 2 r. Proofs in other pieces get a
margin of zero.
"""

from izo_ref.base.arrays import Vec3
from izo_ref.base.compile import compiled
from izo_ref.base.formulas.vec3 import dot3, sum_abs3
from izo_ref.detection.formulas.coplanar import COEFFICIENT_ERROR, TINY

# |det(x, y, z)| <= 6 |x|_inf |y|_inf |z|_inf, because it has six terms. The part above 6 covers the
# rounding of the products.
DETERMINANT_BOUND = 6.0 + 2.0**-40
# Largest margin over the slack of the gaps, by |n|_1. See above for these two numbers.
MARGIN_SHARE = 0.5 - 2.0**-12
START_SHARE = 2.0**20
# Largest margin that a cubic gives, over the size of the pair. Without a bound, the margin would be
# the root of a cubic.
CUBIC_MARGIN = 2.0**-4


@compiled
def _slack(
    is_edge_edge: bool,
    s1: float,
    s2: float,
    s3: float,
    r1: float,
    r2: float,
    r3: float,
    threshold: float,
) -> float:
    """Return the slack of a direction n, or of -n: how much the gap at the end may fall.

    s_k and r_k are the projections of nodes 1 to 3 on n at t = 0 and t = 1; those of node 0 are 0.
    A slack that is not positive says that neither n nor -n separates the sides on the whole path.
    """
    if is_edge_edge:
        low, low_t1 = min(s2, s3) - max(0.0, s1), min(r2, r3) - max(0.0, r1)
        high, high_t1 = min(0.0, s1) - max(s2, s3), min(0.0, r1) - max(r2, r3)
    else:
        low, low_t1 = min(s1, min(s2, s3)), min(r1, min(r2, r3))
        high, high_t1 = -max(s1, max(s2, s3)), -max(r1, max(r2, r3))
    return max(
        min(START_SHARE * (low - threshold), low_t1 - threshold),
        min(START_SHARE * (high - threshold), high_t1 - threshold),
    )


@compiled
def axes_margin(
    is_edge_edge: bool,
    a1: Vec3,
    a2: Vec3,
    a3: Vec3,
    b1: Vec3,
    b2: Vec3,
    b3: Vec3,
    gap_error: float,
) -> float:
    """Return the largest margin of the three axes and of the diagonals of their planes.

    The diagonals are the sum and the difference of two axes, so |n|_1 = 2. They are tried only if
    no axis separates the sides. The result is not positive if no direction separates them.
    """
    slack = -1.0
    for k in range(3):
        s = _slack(is_edge_edge, a1[k], a2[k], a3[k], b1[k], b2[k], b3[k], gap_error + TINY)
        slack = max(slack, s)
    if slack > 0.0:
        return MARGIN_SHARE * slack
    for i in range(3):
        j = (i + 1) % 3
        slack = max(
            slack,
            max(
                _slack(
                    is_edge_edge,
                    a1[i] + a1[j],
                    a2[i] + a2[j],
                    a3[i] + a3[j],
                    b1[i] + b1[j],
                    b2[i] + b2[j],
                    b3[i] + b3[j],
                    2.0 * gap_error + TINY,
                ),
                _slack(
                    is_edge_edge,
                    a1[i] - a1[j],
                    a2[i] - a2[j],
                    a3[i] - a3[j],
                    b1[i] - b1[j],
                    b2[i] - b2[j],
                    b3[i] - b3[j],
                    2.0 * gap_error + TINY,
                ),
            ),
        )
    return 0.5 * MARGIN_SHARE * slack


@compiled
def _gap_at(
    is_edge_edge: bool,
    n: Vec3,
    a1: Vec3,
    a2: Vec3,
    a3: Vec3,
    b1: Vec3,
    b2: Vec3,
    b3: Vec3,
    t: float,
) -> float:
    """Return the smallest gap along n between a node of the first side and one of the second."""
    s1 = (1.0 - t) * dot3(n, a1) + t * dot3(n, b1)
    s2 = (1.0 - t) * dot3(n, a2) + t * dot3(n, b2)
    s3 = (1.0 - t) * dot3(n, a3) + t * dot3(n, b3)
    if is_edge_edge:
        return min(0.0, s1) - max(s2, s3)
    return -max(s1, max(s2, s3))


@compiled
def margin_along(
    is_edge_edge: bool,
    n: Vec3,
    a1: Vec3,
    a2: Vec3,
    a3: Vec3,
    b1: Vec3,
    b2: Vec3,
    b3: Vec3,
    begin: float,
    end: float,
    gap_error: float,
) -> float:
    """Return the margin of a direction n that separates the sides from one time to another."""
    size = sum_abs3(n)
    threshold = gap_error * size + TINY
    slack_begin = _gap_at(is_edge_edge, n, a1, a2, a3, b1, b2, b3, begin) - threshold
    slack_end = _gap_at(is_edge_edge, n, a1, a2, a3, b1, b2, b3, end) - threshold
    if begin == 0.0:
        slack_begin *= START_SHARE
    return max(0.0, MARGIN_SHARE * min(slack_begin, slack_end) / size)


@compiled
def cubic_margin(low: float, m1: float, m2: float, m3: float) -> float:
    """Return the margin of a cubic whose absolute value is at least `low` on the whole path.

    m_k bounds |e_k|_inf, and the largest of them is at most 1.
    """
    m1, m2, m3 = m1 + 2.0 * CUBIC_MARGIN, m2 + 2.0 * CUBIC_MARGIN, m3 + 2.0 * CUBIC_MARGIN
    slack = low - COEFFICIENT_ERROR * (m1 * m2 * m3) - TINY
    change = 2.0 * DETERMINANT_BOUND * (m2 * m3 + m1 * m3 + m1 * m2)
    return max(0.0, min(CUBIC_MARGIN, (1.0 - 2.0**-40) * slack / change))
