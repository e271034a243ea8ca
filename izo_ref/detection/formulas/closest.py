"""Closest points of a vertex-face or edge-edge pair, as signed weights of its four nodes.

A pair is given by q1, q2, q3: its second to fourth node relative to the first, which is the origin.
The weights w are positive on the first side and negative on the second, and their sum is zero. The
vector sum_k w_k q_k points from the closest point of the second side to that of the first.

Nothing is proved with these weights. `detection/formulas/advance.py` takes them as a guess of a
separating direction and proves that direction by itself. So degenerate input (faces without area,
edges without length, parallel edges) need only give *some* pair of points that is closest up to
rounding.

Source: C. Ericson, Real-Time Collision Detection (2004), sections 5.1.5 and 5.1.9 (the Voronoi
regions of a triangle; two segments with clamping).
"""

from izo_ref.base.arrays import Vec3, Vec4
from izo_ref.base.compile import compiled
from izo_ref.base.formulas.vec3 import dot3, scale3, sub3


@compiled
def _clamp01(s: float) -> float:
    # written so that NaN (0 / 0 for an edge without length) becomes 0
    if s > 0.0:
        return min(s, 1.0)
    return 0.0


@compiled
def _segment_point(a: Vec3, b: Vec3) -> float:
    """Return the parameter in [0, 1] of the point of segment a b that is closest to the origin."""
    ab = sub3(b, a)
    return _clamp01(-dot3(a, ab) / dot3(ab, ab))


@compiled
def _segment_distance_sq(a: Vec3, b: Vec3, s: float) -> float:
    p = (a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1]), a[2] + s * (b[2] - a[2]))
    return dot3(p, p)


@compiled
def vertex_face_weights(q1: Vec3, q2: Vec3, q3: Vec3) -> Vec4:
    """Return the weights (1, -a1, -a2, -a3) of the vertex at the origin and the face q1 q2 q3."""
    ab = sub3(q2, q1)
    ac = sub3(q3, q1)
    d1 = -dot3(ab, q1)
    d2 = -dot3(ac, q1)
    d3 = -dot3(ab, q2)
    d4 = -dot3(ac, q2)
    d5 = -dot3(ab, q3)
    d6 = -dot3(ac, q3)
    va = d3 * d6 - d5 * d4
    vb = d5 * d2 - d1 * d6
    vc = d1 * d4 - d3 * d2
    total = va + vb + vc
    if va > 0.0 and vb > 0.0 and vc > 0.0 and total > 0.0:
        a2 = vb / total
        a3 = vc / total
        return (1.0, -(1.0 - a2 - a3), -a2, -a3)
    # the vertex is not above the face, or the face has no area: take the closest of its three edges
    s12 = _segment_point(q1, q2)
    s23 = _segment_point(q2, q3)
    s31 = _segment_point(q3, q1)
    e12 = _segment_distance_sq(q1, q2, s12)
    e23 = _segment_distance_sq(q2, q3, s23)
    e31 = _segment_distance_sq(q3, q1, s31)
    if e12 <= e23 and e12 <= e31:
        return (1.0, -(1.0 - s12), -s12, 0.0)
    if e23 <= e31:
        return (1.0, 0.0, -(1.0 - s23), -s23)
    return (1.0, -s31, 0.0, -(1.0 - s31))


@compiled
def edge_edge_weights(q1: Vec3, q2: Vec3, q3: Vec3) -> Vec4:
    """Return the weights (1-s, s, -(1-r), -r) of the edge from the origin to q1 and edge q2 q3."""
    d1 = q1
    d2 = sub3(q3, q2)
    a = dot3(d1, d1)
    e = dot3(d2, d2)
    b = dot3(d1, d2)
    c = -dot3(d1, q2)
    f = -dot3(d2, q2)
    s = _clamp01((b * f - c * e) / (a * e - b * b))
    r = (b * s + f) / e
    if not r > 0.0:
        r = 0.0
        s = _clamp01(-c / a)
    elif r > 1.0:
        r = 1.0
        s = _clamp01((b - c) / a)
    return (1.0 - s, s, -(1.0 - r), -r)


@compiled
def pair_weights(is_edge_edge: bool, q1: Vec3, q2: Vec3, q3: Vec3) -> Vec4:
    """Return the weights of a pair of either kind."""
    if is_edge_edge:
        return edge_edge_weights(q1, q2, q3)
    return vertex_face_weights(q1, q2, q3)


@compiled
def weighted_sum(weights: Vec4, q1: Vec3, q2: Vec3, q3: Vec3) -> Vec3:
    """Return the sum of w_k q_k, with the first node at the origin."""
    a = scale3(weights[1], q1)
    b = scale3(weights[2], q2)
    c = scale3(weights[3], q3)
    return (a[0] + b[0] + c[0], a[1] + b[1] + c[1], a[2] + b[2] + c[2])
