"""Decide whether a pair meets on its path in exact arithmetic, and find when it first does.

Floats are rational numbers, so all coefficients below are rational, and no step is rounded.

**When a pair can meet.** Node 0 is the origin, and e_1, e_2, e_3 are the other nodes relative to
it, linear in t. Sides that meet have coplanar nodes, so the pair can meet only at roots of the
cubic det(e_1, e_2, e_3):

* If the cubic is not zero everywhere, it has at most three roots in [0, 1].
* If it is zero everywhere, the nodes are coplanar at all times. Whether the pair meets then depends
  on the signs of finitely many polynomials, so it can change only at their roots. The times at
  which the pair meets form a closed set, so the first of them is 0 or one of these roots.

In both cases a few algebraic times are left, which `algebraic.py` isolates. At each of them,
`_coplanar_meet` decides from the signs of polynomials whether the pair meets.

Source: docs/method section 8; S. Basu, R. Pollack, M.-F. Roy, Algorithms in Real Algebraic Geometry
(2006), 2.2 and 10.
"""

from typing import Any, TypeAlias

from izo_ref.base.algebraic import AlgebraicTime, float_below, roots_in_unit_interval, sign_at
from izo_ref.base.exact_vectors import integer_points, minus
from izo_ref.base.polynomials import Polynomial, add, cross, multiply, sign_of, trimmed

Vector: TypeAlias = list[Polynomial]  # three coordinates


def _relative_nodes(start: Any, end: Any) -> list[Vector]:
    """Return e_1, e_2, e_3: three coordinates each, linear polynomials in t.

    All coordinates are multiplied by one power of two that makes them integers. This changes no
    answer.
    """
    points = integer_points([*start, *end])
    first, *others = zip(points[: len(start)], points[len(start) :], strict=True)
    nodes = []
    for node in others:
        e_t0, e_t1 = (minus(p, q) for p, q in zip(node, first, strict=True))
        nodes.append([trimmed([a, b - a]) for a, b in zip(e_t0, e_t1, strict=True)])
    return nodes


def _collinear_meet(is_edge_edge: bool, nodes: list[Vector], time: AlgebraicTime) -> bool:
    """Return whether the pair meets at a time at which its nodes are collinear.

    Along an axis in which the nodes differ, the sides are intervals. They are apart if all ends of
    the second lie strictly on one side of all ends of the first.
    """
    for axis in range(3):
        x1, x2, x3 = (node[axis] for node in nodes)
        if not any(sign_at(x, time) for x in (x1, x2, x3)):
            continue
        # the ends of the second side relative to those of the first, which are 0, or 0 and x1
        differences = [x2, x3, add(x2, x1, -1), add(x3, x1, -1)] if is_edge_edge else [x1, x2, x3]
        signs = [sign_at(x, time) for x in differences]
        return min(signs) <= 0 <= max(signs)
    return True  # all nodes are in one point


def _coplanar_meet(
    is_edge_edge: bool,
    nodes: list[Vector],
    turns: list[Vector],
    time: AlgebraicTime,
) -> bool:
    """Return whether the pair meets at a time at which its nodes are coplanar.

    `turns` are the cross products that give twice the area of three nodes: of the nodes 0 1 2, of
    0 2 3, of 0 3 1, and their sum, of 1 2 3. At this time all of them are along the normal of the
    plane. Take an axis in which one of the first three is not zero. Seen along this axis, the plane
    is not edge-on, so the signs of these coordinates say on which side of a line a node lies.
    """
    for axis in range(3):
        s012, s023, s031 = (sign_at(turn[axis], time) for turn in turns[:3])
        if s012 == s023 == s031 == 0:
            continue
        s123 = sign_at(turns[3][axis], time)
        if is_edge_edge:  # the ends of neither edge are strictly on one side of the other edge
            return s012 * s031 >= 0 >= s023 * s123
        # the face has an area, and the vertex is strictly outside none of its edges
        return s123 != 0 and min(s012 * s123, s023 * s123, s031 * s123) >= 0
    return _collinear_meet(is_edge_edge, nodes, time)


def first_meeting(is_edge_edge: bool, start: Any, end: Any) -> float | None:
    """Find when the two sides of a pair first have a point in common, decided exactly.

    Args:
        is_edge_edge: True for two edges, False for a vertex and a face.
        start: (4, 3) f8 [m], finite positions of the nodes at t = 0: the vertex, then the face; or
            one edge, then the other. Sides may be degenerate.
        end: (4, 3) f8 [m], their positions at t = 1.

    Returns:
        A time in [0, 1] that is at most 2^-52 before the true one and never after it; None if the
        sides never meet.
    """
    nodes, turns, volume = _polynomials(start, end)
    if volume:
        times = roots_in_unit_interval(volume)
    else:
        deciding = _deciding_signs(nodes, turns)
        times = [AlgebraicTime([], 0, 0, 1)]
        times += [time for p in deciding if p for time in roots_in_unit_interval(p)]
    meeting = [float_below(t) for t in times if _coplanar_meet(is_edge_edge, nodes, turns, t)]
    return min(meeting, default=None)


def first_meeting_after_start(is_edge_edge: bool, start: Any, end: Any) -> float | None:
    """Find when the two sides of a pair first have a point in common after t = 0, exactly.

    Args:
        is_edge_edge: True for two edges, False for a vertex and a face.
        start: (4, 3) f8 [m], finite positions of the nodes at t = 0, as for `first_meeting`. The
            sides may touch there.
        end: (4, 3) f8 [m], their positions at t = 1.

    Returns:
        A time in [0, 1] that is at most 2^-52 before the true one and never after it; 0 if the
        sides also meet at times as close to 0 as one likes. None if they never meet after t = 0.
    """
    nodes, turns, volume = _polynomials(start, end)
    if volume:
        times = roots_in_unit_interval(_without_root_at_zero(volume))
    else:
        deciding = [_without_root_at_zero(p) for p in _deciding_signs(nodes, turns) if p]
        times = [time for p in deciding for time in roots_in_unit_interval(p)]
        # no sign changes between t = 0 and the first of these times
        if _coplanar_meet(is_edge_edge, nodes, turns, _before(times)):
            return 0.0
    meeting = [float_below(t) for t in times if _coplanar_meet(is_edge_edge, nodes, turns, t)]
    return min(meeting, default=None)


def crosses_after_start(start: Any, end: Any) -> bool:
    """Return whether an edge goes through a face right after t = 0, exactly.

    It does if, at all times close enough to 0, its ends are strictly on different sides of the
    plane of the face, and its line passes the three sides of the face strictly on one side.

    Args:
        start: (5, 3) f8 [m], finite positions of the ends of the edge and of the corners of the
            face at t = 0.
        end: (5, 3) f8 [m], their positions at t = 1.
    """
    q, a, b, c = _relative_nodes(start, end)
    turns = [_sign_after_start(_volume(q, x, y)) for x, y in ((a, b), (b, c), (c, a))]
    if not (turns[0] == turns[1] == turns[2] != 0):
        return False
    from_first = _sign_after_start(_volume(a, b, c))
    q_a, q_b, q_c = ([add(x, y, -1) for x, y in zip(node, q, strict=True)] for node in (a, b, c))
    return from_first * _sign_after_start(_volume(q_a, q_b, q_c)) < 0


def _polynomials(start: Any, end: Any) -> tuple[list[Vector], list[Vector], Polynomial]:
    """Return e_1, e_2, e_3, the cross products for `_coplanar_meet`, and det(e_1, e_2, e_3)."""
    nodes = e1, e2, e3 = _relative_nodes(start, end)
    turns = [cross(e1, e2), cross(e2, e3), cross(e3, e1)]
    turns.append([add(add(a, b), c) for a, b, c in zip(*turns, strict=True)])
    return nodes, turns, _dot(e1, turns[1])


def _deciding_signs(nodes: list[Vector], turns: list[Vector]) -> list[Polynomial]:
    """Return every polynomial whose sign `_coplanar_meet` may ask for."""
    e1, e2, e3 = nodes
    differences = [add(e[k], e1[k], -1) for e in (e2, e3) for k in range(3)]
    return [p for vector in (*turns, *nodes) for p in vector] + differences


def _dot(a: Vector, b: Vector) -> Polynomial:
    result: Polynomial = []
    for x, y in zip(a, b, strict=True):
        result = add(result, multiply(x, y))
    return result


def _volume(a: Vector, b: Vector, c: Vector) -> Polynomial:
    return _dot(a, cross(b, c))


def _without_root_at_zero(poly: Polynomial) -> Polynomial:
    """Return a polynomial that is not zero, divided by the power of t that divides it."""
    return poly[next(k for k, c in enumerate(poly) if c) :]


def _sign_after_start(poly: Polynomial) -> int:
    """Return the sign of a polynomial at all times after 0 that are close enough to 0."""
    return sign_of(next((c for c in poly if c), 0))


def _before(times: list[AlgebraicTime]) -> AlgebraicTime:
    """Return a time after 0 and before some times after 0, at most 1."""
    number, unit = 1, 1
    for time in times:
        while time.low == 0:
            time.halve()
        while number * time.unit >= time.low * unit:
            unit *= 2
    return AlgebraicTime([], number, number, unit)
