"""Decide whether an edge crosses a face at one time; the answer is certain, or there is none."""

from izo_ref.base.arrays import Vec3
from izo_ref.base.compile import compiled
from izo_ref.base.formulas.vec3 import (
    det3,
    dot3,
    max_abs3,
    power_of_two_for,
    scale3,
    sub3,
    sum_abs3,
    unit3,
)
from izo_ref.detection.formulas.advance import APART, CONTACT, GAP_ERROR, UNDECIDED
from izo_ref.detection.formulas.closest import edge_edge_weights, vertex_face_weights, weighted_sum
from izo_ref.detection.formulas.coplanar import COEFFICIENT_ERROR, TINY


@compiled
def certain_sign(a: Vec3, b: Vec3, c: Vec3) -> int:
    """Return the sign of det(a, b, c), or 0 if rounding could have changed it.

    Each argument is a difference of floats, times one power of two that brings all of them to a
    size of at most 2. COEFFICIENT_ERROR bounds the error of such a determinant
    (`detection/formulas/coplanar.py`: input, cross and dot are 48 u of its 192 u), also on a GPU,
    which contracts a product and a sum to one rounding. Nothing overflows, and TINY covers what
    underflows.
    """
    value = det3(a, b, c)
    bound = COEFFICIENT_ERROR * (max_abs3(a) * max_abs3(b) * max_abs3(c)) + TINY
    if value > bound:
        return 1
    if value < -bound:
        return -1
    return 0


@compiled
def _closer(best: Vec3, candidate: Vec3) -> Vec3:
    if dot3(candidate, candidate) < dot3(best, best):
        return candidate
    return best


@compiled
def _closest_vector(p: Vec3, q: Vec3, a: Vec3, b: Vec3, c: Vec3) -> Vec3:
    """Return the shortest vector from face a b c to edge p q, over all vertices and edges."""
    n = (0.0, 0.0, 0.0)
    for end in range(2):
        v = p if end == 0 else q
        x, y, z = sub3(a, v), sub3(b, v), sub3(c, v)
        candidate = weighted_sum(vertex_face_weights(x, y, z), x, y, z)
        n = candidate if end == 0 else _closer(n, candidate)
    for side in range(3):
        v = a if side == 0 else (b if side == 1 else c)
        w = b if side == 0 else (c if side == 1 else a)
        x, y, z = sub3(q, p), sub3(v, p), sub3(w, p)
        n = _closer(n, weighted_sum(edge_edge_weights(x, y, z), x, y, z))
    return n


@compiled
def edge_face_status(p: Vec3, q: Vec3, a: Vec3, b: Vec3, c: Vec3) -> int:
    """Return APART or CONTACT if that is certain for edge p q and face a b c, else UNDECIDED.

    They are certainly apart in three cases: both ends of the edge are strictly on the same side of
    the plane of the face; or the line of the edge passes two edges of the face on strictly
    different sides, so that it misses the face; or a direction separates them.

    They certainly meet if the ends are strictly on different sides of the plane, and the line of
    the edge passes all three edges of the face strictly on the same side.
    """
    ap, aq, ab, ac = sub3(p, a), sub3(q, a), sub3(b, a), sub3(c, a)
    size = max(max(max_abs3(ap), max_abs3(aq)), max(max_abs3(ab), max_abs3(ac)))
    unit = power_of_two_for(size)
    ap, aq, ab, ac = scale3(unit, ap), scale3(unit, aq), scale3(unit, ab), scale3(unit, ac)
    side_p = certain_sign(ab, ac, ap)
    side_q = certain_sign(ab, ac, aq)
    if side_p * side_q > 0:
        return APART
    pq, pb, pc = scale3(unit, sub3(q, p)), scale3(unit, sub3(b, p)), scale3(unit, sub3(c, p))
    pa = scale3(-1.0, ap)
    turn_ab = certain_sign(pq, pa, pb)
    turn_bc = certain_sign(pq, pb, pc)
    turn_ca = certain_sign(pq, pc, pa)
    if min(turn_ab, min(turn_bc, turn_ca)) < 0 < max(turn_ab, max(turn_bc, turn_ca)):
        return APART
    if side_p * side_q < 0 and turn_ab == turn_bc == turn_ca != 0:
        return CONTACT
    n = unit3(_closest_vector(p, q, a, b, c))
    edge_low = min(dot3(n, ap), dot3(n, aq))
    face_high = max(0.0, max(dot3(n, ab), dot3(n, ac)))
    if edge_low - face_high > GAP_ERROR * (unit * size) * sum_abs3(n) + TINY:
        return APART
    return UNDECIDED
