"""What becomes of nodes that are coplanar at t = 0; an answer is certain, or there is none.

Exactly coplanar nodes make the first Bernstein coefficient of the cubic of
`detection/formulas/coplanar.py` zero. On (0, 1], the cubic has the sign of the other three if they
have one, because it is their combination with positive weights. Right after t = 0 it has the sign
of the second coefficient, which is a third of its slope there. The bound of the rounding is that of
`coplanar.py`: these coefficients are not even subdivided.
"""

from izo_ref.base.arrays import Vec3
from izo_ref.base.compile import compiled
from izo_ref.base.formulas.vec3 import det3, max_abs3, power_of_two_for, scale3
from izo_ref.detection.formulas.coplanar import COEFFICIENT_ERROR, TINY, bernstein_coefficients

# A sign that rounding could have changed.
UNKNOWN = 2


@compiled
def _scaled(
    a1: Vec3, a2: Vec3, a3: Vec3, b1: Vec3, b2: Vec3, b3: Vec3
) -> tuple[Vec3, Vec3, Vec3, Vec3, Vec3, Vec3, float]:
    """Return the nodes times a power of two that brings them near 1, and the cubic's error."""
    m1 = max(max_abs3(a1), max_abs3(b1))
    m2 = max(max_abs3(a2), max_abs3(b2))
    m3 = max(max_abs3(a3), max_abs3(b3))
    unit = power_of_two_for(max(m1, max(m2, m3)))
    a1, a2, a3 = scale3(unit, a1), scale3(unit, a2), scale3(unit, a3)
    b1, b2, b3 = scale3(unit, b1), scale3(unit, b2), scale3(unit, b3)
    error = COEFFICIENT_ERROR * (unit * m1) * (unit * m2) * (unit * m3) + TINY
    return a1, a2, a3, b1, b2, b3, error


@compiled
def is_apart_after_start(a1: Vec3, a2: Vec3, a3: Vec3, b1: Vec3, b2: Vec3, b3: Vec3) -> bool:
    """Return whether a pair whose nodes are coplanar at t = 0 is certainly apart on (0, 1].

    a_k and b_k are nodes 1 to 3 relative to node 0 at t = 0 and t = 1.
    """
    a1, a2, a3, b1, b2, b3, error = _scaled(a1, a2, a3, b1, b2, b3)
    _, c1, c2, c3 = bernstein_coefficients(a1, a2, a3, b1, b2, b3)
    return min(c1, min(c2, c3)) > error or max(c1, max(c2, c3)) < -error


@compiled
def volume_sign_after_start(
    sign_t0: int, a1: Vec3, a2: Vec3, a3: Vec3, b1: Vec3, b2: Vec3, b3: Vec3
) -> int:
    """Return the sign of det(e_1, e_2, e_3) right after t = 0, or UNKNOWN.

    `sign_t0` is its exact sign at t = 0; a_k and b_k are e_k at t = 0 and t = 1.
    """
    if sign_t0 != 0:
        return sign_t0
    a1, a2, a3, b1, b2, b3, error = _scaled(a1, a2, a3, b1, b2, b3)
    slope = (det3(b1, a2, a3) + det3(a1, b2, a3) + det3(a1, a2, b3)) / 3.0
    if slope > error:
        return 1
    if slope < -error:
        return -1
    return UNKNOWN
