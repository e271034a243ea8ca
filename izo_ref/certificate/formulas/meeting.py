"""Does a pair certainly meet near a time? Floats with a bound; otherwise no answer.

On [t0, t1] the volume det(e1, e2, e3) of the nodes relative to node 0 changes its sign, so
at some time in between they are coplanar. Seen along a direction d that is not in their
plane, the signed areas
    A = d . (e1 x e2),  B = d . (e2 x e3),  C = d . (e3 x e1),  S = A + B + C
then say where they lie: a vertex is inside its face if A, B and C have one strict sign;
two edges cross if A and C have one, and B and S the opposite ones. Each is a quadratic in
t, enclosed by its Bernstein coefficients on [t0, t1]: one sign of all three is one sign
all the time, so also at the time that is meant.

Rounding. u = 2^-53; M_k bounds |e_k|_inf. e_k at t0 and t1 is off by 5 u M_k: the input,
1 - t, two products, a sum. A determinant of three of them is off by 3 * 6 * 5 u = 90 u
times M_1 M_2 M_3, and by 30 u for its evaluation (see `coplanar.py`); one of d, which is
exact, and two of them by 60 u + 30 u, and the mean of two of these by 18 u more. All are
below COEFFICIENT_ERROR = 192 u. S is a sum of three: three times that, less 3 (192 - 108)
= 252 u for two additions of at most 18 (4 u).
"""

from izo_ref.base.compile import compiled
from izo_ref.base.formulas.vec3 import det3, lerp3, max_abs3, power_of_two_for, scale3
from izo_ref.detection.formulas.coplanar import COEFFICIENT_ERROR, TINY
from izo_ref.detection.formulas.frame import plane_normal

# Half-widths of the intervals tried: from what rounding does to the time of a contact that
# is met head-on, by factors of 16.
NARROWEST = 2.0**-46
WIDEST = 2.0**-10


@compiled
def _areas(d, u0, v0, u1, v1):
    """Bernstein coefficients of d . (u x v) on an interval."""
    return (
        det3(d, u0, v0),
        0.5 * (det3(d, u0, v1) + det3(d, u1, v0)),
        det3(d, u1, v1),
    )


@compiled
def _sum3(a, b, c):
    return (a[0] + b[0] + c[0], a[1] + b[1] + c[1], a[2] + b[2] + c[2])


@compiled
def _sign3(coefficients, bound):
    """1 or -1 if all three are certain to have that sign, else 0."""
    low = min(coefficients[0], min(coefficients[1], coefficients[2]))
    high = max(coefficients[0], max(coefficients[1], coefficients[2]))
    if low > bound:
        return 1
    if high < -bound:
        return -1
    return 0


@compiled
def _meets_between(is_edge_edge, d, a1, a2, a3, b1, b2, b3, t0, t1):
    m1 = max(max_abs3(a1), max_abs3(b1))
    m2 = max(max_abs3(a2), max_abs3(b2))
    m3 = max(max_abs3(a3), max_abs3(b3))
    p1, p2, p3 = lerp3(a1, b1, t0), lerp3(a2, b2, t0), lerp3(a3, b3, t0)
    q1, q2, q3 = lerp3(a1, b1, t1), lerp3(a2, b2, t1), lerp3(a3, b3, t1)
    bound = COEFFICIENT_ERROR * (m1 * m2 * m3) + TINY
    volume0, volume1 = det3(p1, p2, p3), det3(q1, q2, q3)
    if not ((volume0 > bound and volume1 < -bound) or (volume0 < -bound and volume1 > bound)):
        return False
    bound12 = COEFFICIENT_ERROR * (m1 * m2) + TINY
    bound23 = COEFFICIENT_ERROR * (m2 * m3) + TINY
    bound31 = COEFFICIENT_ERROR * (m3 * m1) + TINY
    a = _areas(d, p1, p2, q1, q2)
    b = _areas(d, p2, p3, q2, q3)
    c = _areas(d, p3, p1, q3, q1)
    side_a, side_b, side_c = _sign3(a, bound12), _sign3(b, bound23), _sign3(c, bound31)
    if side_a == 0 or side_a != side_c:
        return False
    if is_edge_edge:
        side_s = _sign3(_sum3(a, b, c), bound12 + bound23 + bound31)
        return side_b * side_s == -1
    return side_a == side_b


@compiled
def certainly_meets(is_edge_edge, a1, a2, a3, b1, b2, b3, toi):
    """Whether the pair meets at a time near `toi`, for certain.

    False says nothing. a_k, b_k are nodes 1..3 relative to node 0 at t = 0, 1; `toi` is in
    [0, 1].
    """
    size = max(max_abs3(a1), max(max_abs3(a2), max_abs3(a3)))
    size = max(size, max(max_abs3(b1), max(max_abs3(b2), max_abs3(b3))))
    factor = power_of_two_for(size)
    a1, a2, a3 = scale3(factor, a1), scale3(factor, a2), scale3(factor, a3)
    b1, b2, b3 = scale3(factor, b1), scale3(factor, b2), scale3(factor, b3)
    # a unit vector, so 1 bounds its coordinates; its own rounding does not matter
    d = plane_normal(is_edge_edge, lerp3(a1, b1, toi), lerp3(a2, b2, toi), lerp3(a3, b3, toi))
    width = NARROWEST
    while width <= WIDEST:
        t0, t1 = max(0.0, toi - width), min(1.0, toi + width)
        if _meets_between(is_edge_edge, d, a1, a2, a3, b1, b2, b3, t0, t1):
            return True
        width *= 16.0
    return False
