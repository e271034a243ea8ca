"""Normal and weights of an impact, frozen at its time of impact.

A pair is given by q1, q2, q3, nodes 1 to 3 relative to node 0.

Source: docs/method section 1, page equations 2 and 3.
"""

from izo_ref.base.arrays import Vec3, Vec4
from izo_ref.base.compile import compiled
from izo_ref.base.formulas.vec3 import cross3, dot3, lerp3, max_abs3, scale3, sub3, unit3
from izo_ref.detection.formulas.closest import pair_weights, weighted_sum

# Below this number, two things count as zero: the gap at t = 0 over the size of the pair, and the
# sine of the angle between the two edges, or between two sides of the face. The normal of the plane
# then does not say from which side the pair came. Rounding alone gives about 1e-15. A wrong choice
# here gives a poorer half-space, and costs no safety.
FLAT = 1e-10


@compiled
def plane_normal(is_edge_edge: bool, q1: Vec3, q2: Vec3, q3: Vec3) -> Vec3:
    """Return the unit normal of the face, or of both edges; zero where that is not defined.

    Three functions use it. `impact_frame` below takes it as the normal of an impact.
    `feature_normal` below gives it to `advance` (`detection/formulas/advance.py`) as a direction to
    try. `certainly_meets` (`certificate/formulas/meeting.py`) projects the pair along it. The last
    two prove their answers for any direction, so there it decides only how often a proof succeeds.
    """
    if is_edge_edge:
        u, v = q1, sub3(q3, q2)
    else:
        u, v = sub3(q2, q1), sub3(q3, q1)
    n = cross3(u, v)
    if not dot3(n, n) > (FLAT * FLAT) * dot3(u, u) * dot3(v, v):
        return (0.0, 0.0, 0.0)
    return unit3(n)


@compiled
def feature_normal(
    is_edge_edge: bool, weights: Vec4, q1: Vec3, q2: Vec3, q3: Vec3, n: Vec3
) -> Vec3:
    """Return the normal of the features on which the closest points lie, on the side of n.

    n is the unit vector between the closest points. Close to contact n is mostly rounding: its
    error is about u s / g, where s is the size of the pair and g the gap. The normal of the face,
    or of the two edges, does not have this error. Where a closest point is inside an edge, n is
    made orthogonal to that edge; otherwise the far end of the edge would be on the wrong side of n.
    """
    if is_edge_edge:
        first_inside = weights[0] > 0.0 and weights[1] > 0.0
        second_inside = weights[2] < 0.0 and weights[3] < 0.0
        both = first_inside and second_inside
        edge = q1 if first_inside else sub3(q3, q2)
        one = first_inside or second_inside
    else:
        both = weights[1] < 0.0 and weights[2] < 0.0 and weights[3] < 0.0
        one = True
        if weights[3] == 0.0:
            edge = sub3(q2, q1)
        elif weights[1] == 0.0:
            edge = sub3(q3, q2)
        else:
            edge = sub3(q1, q3)
    if both:
        m = plane_normal(is_edge_edge, q1, q2, q3)
        if dot3(m, n) < 0.0:
            return scale3(-1.0, m)
        return m
    length_sq = dot3(edge, edge)
    if not one or length_sq == 0.0:
        return n
    for _ in range(2):
        n = unit3(sub3(n, scale3(dot3(n, edge) / length_sq, edge)))
    return n


@compiled
def impact_frame(
    is_edge_edge: bool,
    a1: Vec3,
    a2: Vec3,
    a3: Vec3,
    b1: Vec3,
    b2: Vec3,
    b3: Vec3,
    toi: float,
    direction: Vec3,
) -> tuple[Vec4, Vec3]:
    """Return the weights and the unit normal of an impact.

    a_k and b_k are nodes 1 to 3 relative to node 0 at t = 0 and t = 1. `direction` is the last
    direction that separated the sides before `toi`.

    The normal is that of the face, or of the two edges. In two cases it is `direction`: the face or
    the edges are degenerate, or the pair moves in one plane, where its gap along that normal is
    always zero. The frozen gap is linear in time and zero at `toi`, so its sign at t = 0 says from
    which side the pair came: the normal is turned so that this gap is positive.
    """
    q1, q2, q3 = lerp3(a1, b1, toi), lerp3(a2, b2, toi), lerp3(a3, b3, toi)
    weights = pair_weights(is_edge_edge, q1, q2, q3)
    normal = plane_normal(is_edge_edge, q1, q2, q3)
    gap_t0 = dot3(normal, weighted_sum(weights, a1, a2, a3))
    size = max(max_abs3(a1), max(max_abs3(a2), max_abs3(a3)))
    if not abs(gap_t0) > FLAT * size:
        if max_abs3(direction) == 0.0:  # none was needed, or the pair is in contact from the start
            start = pair_weights(is_edge_edge, a1, a2, a3)
            direction = unit3(weighted_sum(start, a1, a2, a3))
        return weights, direction
    if gap_t0 < 0.0:
        normal = scale3(-1.0, normal)
    return weights, normal


@compiled
def closest_frame(is_edge_edge: bool, q1: Vec3, q2: Vec3, q3: Vec3) -> tuple[Vec4, Vec3]:
    """Return the weights and the unit normal of the closest points of a pair at rest.

    At the end of a free path the sides have not passed through each other, so the vector between
    the closest points has the right sign.

    Source: docs/method section 6.
    """
    weights = pair_weights(is_edge_edge, q1, q2, q3)
    return weights, unit3(weighted_sum(weights, q1, q2, q3))
