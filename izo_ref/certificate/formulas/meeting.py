"""Decide whether a pair certainly meets near a given time, in floats with a rounding bound.

**Symbols.** e_1(t), e_2(t), e_3(t) are nodes 1 to 3 of the pair relative to node 0, linear in t.
d is a fixed direction, a unit vector. The signed areas of the four triangles, seen along d, are

    A = d . (e_1 x e_2),  B = d . (e_2 x e_3),  C = d . (e_3 x e_1),  S = A + B + C

for the nodes 0 1 2, 0 2 3, 0 3 1 and 1 2 3, each times two.

**Claim.** Let the volume det(e_1, e_2, e_3) have different strict signs at t0 and at t1. Then the
pair meets at some time in [t0, t1] in these two cases:

* vertex and face: A, B and C have the same strict sign on all of [t0, t1];
* two edges: A and C have the same strict sign on all of [t0, t1], and B and S have different ones.

**Proof.** The volume is continuous, so it is zero at some t* in [t0, t1]: the nodes are coplanar
then. A is not zero at t*, so d is not in their plane, and the projection along d maps the plane
one to one. In the projection, the vertex 0 is inside the triangle 1 2 3 if A, B and C have one
sign. Nodes 2 and 3 are on different sides of the line 0 1 if A and -C have different signs, and
nodes 0 and 1 are on different sides of the line 2 3 if B and S have different signs; together the
edges cross.

A, B, C and S are quadratic in t. The three Bernstein coefficients of a quadratic on [t0, t1]
enclose it. If they have one strict sign, it has this sign on all of [t0, t1], so at t* too.

**Rounding.** Let u = 2^-53, and let M_k bound |e_k|_inf. The errors, up to terms in u^2, are:

    e_k at t0 or t1     the input, 1 - t, two products and a sum: 5 u M_k
    volume              in units of u M_1 M_2 M_3: 3 * 6 * 5 = 90 for the three e_k; 30 to evaluate
                        the determinant (cross and dot in `coplanar.py`). Together 120
    coefficient of A    in units of u M_1 M_2; d has no error, because any d is sound, and
                        |d|_inf <= 1: 2 * 6 * 5 = 60 for two e_k; 30 to evaluate; 6 for the middle
                        one, half the sum of two determinants that are at most 6 M_1 M_2 each.
                        Together 96. B and C likewise
    coefficient of S    in units of u (M_1 M_2 + M_2 M_3 + M_3 M_1): 96 for A, B and C; two
                        additions whose results are at most 6 (M_1 M_2 + M_2 M_3 + M_3 M_1): 12.
                        Together 108

All of them are below COEFFICIENT_ERROR = 192 u, with these products of the M_k. TINY covers
underflow, as in `coplanar.py`.
"""

from izo_ref.base.arrays import Vec3
from izo_ref.base.compile import compiled
from izo_ref.base.formulas.vec3 import det3, lerp3, max_abs3, power_of_two_for, scale3
from izo_ref.detection.formulas.coplanar import COEFFICIENT_ERROR, TINY
from izo_ref.detection.formulas.frame import plane_normal

# Half-widths of the intervals that are tried. The first is the rounding of the time of a contact
# that is met head-on; each further one is 16 times as wide.
NARROWEST = 2.0**-46
WIDEST = 2.0**-10


@compiled
def _areas(d: Vec3, u0: Vec3, v0: Vec3, u1: Vec3, v1: Vec3) -> Vec3:
    """Return the Bernstein coefficients of d . (u x v) on [t0, t1]; u0 is u(t0), u1 is u(t1)."""
    return (
        det3(d, u0, v0),
        0.5 * (det3(d, u0, v1) + det3(d, u1, v0)),
        det3(d, u1, v1),
    )


@compiled
def _sum3(a: Vec3, b: Vec3, c: Vec3) -> Vec3:
    return (a[0] + b[0] + c[0], a[1] + b[1] + c[1], a[2] + b[2] + c[2])


@compiled
def _sign3(coefficients: Vec3, bound: float) -> int:
    """Return 1 or -1 if all three coefficients certainly have that sign, else 0."""
    low = min(coefficients[0], min(coefficients[1], coefficients[2]))
    high = max(coefficients[0], max(coefficients[1], coefficients[2]))
    if low > bound:
        return 1
    if high < -bound:
        return -1
    return 0


@compiled
def _meets_between(
    is_edge_edge: bool,
    d: Vec3,
    a1: Vec3,
    a2: Vec3,
    a3: Vec3,
    b1: Vec3,
    b2: Vec3,
    b3: Vec3,
    t0: float,
    t1: float,
) -> bool:
    """Return True if the pair certainly meets in [t0, t1]; False says nothing."""
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
def certainly_meets(
    is_edge_edge: bool,
    a1: Vec3,
    a2: Vec3,
    a3: Vec3,
    b1: Vec3,
    b2: Vec3,
    b3: Vec3,
    toi: float,
) -> bool:
    """Return True if the pair certainly meets at a time near `toi`; False says nothing.

    a_k and b_k are nodes 1 to 3 relative to node 0 at t = 0 and t = 1; `toi` is in [0, 1].
    """
    size = max(max_abs3(a1), max(max_abs3(a2), max_abs3(a3)))
    size = max(size, max(max_abs3(b1), max(max_abs3(b2), max_abs3(b3))))
    factor = power_of_two_for(size)
    a1, a2, a3 = scale3(factor, a1), scale3(factor, a2), scale3(factor, a3)
    b1, b2, b3 = scale3(factor, b1), scale3(factor, b2), scale3(factor, b3)
    # a unit vector, so 1 bounds its coordinates; any d is sound, so its rounding is no error
    d = plane_normal(is_edge_edge, lerp3(a1, b1, toi), lerp3(a2, b2, toi), lerp3(a3, b3, toi))
    width = NARROWEST
    while width <= WIDEST:
        t0, t1 = max(0.0, toi - width), min(1.0, toi + width)
        if _meets_between(is_edge_edge, d, a1, a2, a3, b1, b2, b3, t0, t1):
            return True
        width *= 16.0
    return False
