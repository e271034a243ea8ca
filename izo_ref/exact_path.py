"""Does a pair meet on its path? Exactly: floats are rationals, and so are all coefficients.

Node 0 is the origin; e_1, e_2, e_3 are the others, linear in t. The pair can meet only
where its nodes are coplanar, at roots of the cubic det(e_1, e_2, e_3). If that vanishes
identically, the pair is coplanar all the time. Whether it meets then depends on the signs
of finitely many polynomials, so it changes only at their roots; and because the times at
which it meets are a closed set, the first of them is 0 or such a root. Either way a few
algebraic times are left to look at.

An algebraic time is a square-free polynomial and an interval (low, high] with one of its
roots, found by Sturm's theorem. Another polynomial is zero there if their greatest common
divisor has a root in the interval; if not, the interval is halved until it has no root of
that polynomial, and the sign is that at `high`.

Polynomials are lists of coefficients, the constant first, without zeros at the end.

Source: SPEC section 8; S. Basu, R. Pollack, M.-F. Roy, Algorithms in Real Algebraic
Geometry (2006), 2.2 and 10.
"""

from fractions import Fraction
from itertools import pairwise
from math import nextafter
from typing import NamedTuple

# The time of a meeting is enclosed this closely, half an ulp of 1 and less.
TIME_WIDTH = Fraction(1, 2**54)


class AlgebraicTime(NamedTuple):
    """The root of a square-free polynomial in (low, high], or low itself if low = high."""

    polynomial: list
    low: Fraction
    high: Fraction


def _trimmed(poly):
    while poly and poly[-1] == 0:
        poly.pop()
    return poly


def _add(a, b, sign=1):
    n = max(len(a), len(b))
    a, b = a + [0] * (n - len(a)), b + [0] * (n - len(b))
    return _trimmed([x + sign * y for x, y in zip(a, b, strict=True)])


def _times(a, b):
    product = [0] * max(len(a) + len(b) - 1, 0)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            product[i + j] += x * y
    return _trimmed(product)


def _cross(a, b):
    return [_add(_times(a[j], b[k]), _times(a[k], b[j]), -1) for j, k in ((1, 2), (2, 0), (0, 1))]


def _value(poly, t):
    result = 0
    for coefficient in reversed(poly):
        result = result * t + coefficient
    return result


def _sign(number):
    return (number > 0) - (number < 0)


def _divided(a, b):
    """Quotient and remainder."""
    rest, quotient = [Fraction(x) for x in a], []
    while len(rest) >= len(b):
        factor = rest[-1] / b[-1]
        quotient.append(factor)
        for i in range(1, len(b) + 1):
            rest[-i] -= factor * b[-i]
        rest.pop()
    return quotient[::-1], _trimmed(rest)


def _common(a, b):
    """Greatest common divisor, but for a factor."""
    while b:
        a, b = b, _divided(a, b)[1]
    return a


def _derivative(poly):
    return [i * c for i, c in enumerate(poly)][1:]


def _square_free(poly):
    return _divided(poly, _common(poly, _derivative(poly)))[0] if len(poly) > 1 else poly


def _sturm_chain(square_free):
    chain = [square_free, _derivative(square_free)]
    while chain[-1]:
        chain.append([-c for c in _divided(chain[-2], chain[-1])[1]])
    return chain[:-1]


def _roots_between(chain, low, high):
    """How many roots in (low, high]."""
    counts = []
    for t in (low, high):
        signs = [s for s in (_sign(_value(p, t)) for p in chain) if s]
        counts.append(sum(a != b for a, b in pairwise(signs)))
    return counts[0] - counts[1]


def roots_in_unit_interval(poly) -> list[AlgebraicTime]:
    """The different roots of a polynomial that is not zero in [0, 1], in order."""
    poly = _square_free(poly)
    chain = _sturm_chain(poly)
    found = []
    if _value(poly, 0) == 0:
        found.append(AlgebraicTime(poly, Fraction(0), Fraction(0)))
    parts = [(Fraction(0), Fraction(1))]
    while parts:
        low, high = parts.pop()
        count = _roots_between(chain, low, high)
        if count == 1:
            found.append(_settled(AlgebraicTime(poly, low, high)))
        elif count > 1:
            middle = (low + high) / 2
            parts += [(middle, high), (low, middle)]
    return found


def _settled(time):
    return time._replace(low=time.high) if _value(time.polynomial, time.high) == 0 else time


def _halved(time):
    poly, low, high = time
    middle = (low + high) / 2
    # a simple root: the polynomial changes its sign there, and nowhere else in between
    if _sign(_value(poly, middle)) in (0, _sign(_value(poly, high))):
        return _settled(AlgebraicTime(poly, low, middle))
    return AlgebraicTime(poly, middle, high)


def sign_at(poly, time: AlgebraicTime) -> int:
    """Sign of a polynomial at an algebraic time."""
    if poly and time.low != time.high:
        common = _common(time.polynomial, poly)
        if len(common) > 1 and _roots_between(_sturm_chain(common), time.low, time.high):
            return 0
        chain = _sturm_chain(_square_free(poly))
        while time.low != time.high and _roots_between(chain, time.low, time.high):
            time = _halved(time)
    return _sign(_value(poly, time.high))


def _relative_nodes(start, end):
    """e_1, e_2, e_3: three coordinates each, linear polynomials in t with integers.

    All coordinates times one power of two, which changes no answer.
    """
    ratios = [
        [float(x).as_integer_ratio() for x in (*p, *q)] for p, q in zip(start, end, strict=True)
    ]
    unit = max(denominator for row in ratios for _, denominator in row)
    rows = [[n * (unit // d) for n, d in row] for row in ratios]
    nodes = []
    for row in rows[1:]:
        offset = [x - x0 for x, x0 in zip(row, rows[0], strict=True)]
        nodes.append([_trimmed([a, b - a]) for a, b in zip(offset[:3], offset[3:], strict=True)])
    return nodes


def _collinear_meet(is_edge_edge, nodes, time):
    """Whether collinear nodes meet: intervals on an axis along which the nodes differ."""
    for axis in range(3):
        x1, x2, x3 = (node[axis] for node in nodes)
        if not any(sign_at(x, time) for x in (x1, x2, x3)):
            continue
        ends_of_second = [x2, x3, _add(x2, x1, -1), _add(x3, x1, -1)]  # seen from the first's
        differences = ends_of_second if is_edge_edge else [x1, x2, x3]
        signs = [sign_at(x, time) for x in differences]
        return min(signs) <= 0 <= max(signs)
    return True  # all nodes in one point


def _coplanar_meet(is_edge_edge, nodes, turns, time):
    """Whether the pair meets at a time at which its nodes are coplanar.

    Turns are twice the areas of three nodes, as vectors: (0 1 2), (0 2 3), (0 3 1), and
    their sum (1 2 3). All are along the normal of the plane; seen along an axis in which
    one is not zero, the plane is not seen edge-on, and signs are sides.
    """
    for axis in range(3):
        s012, s023, s031 = (sign_at(turn[axis], time) for turn in turns[:3])
        if s012 == s023 == s031 == 0:
            continue
        s123 = sign_at(turns[3][axis], time)
        if is_edge_edge:  # the ends of each edge not strictly on one side of the other
            return s012 * s031 >= 0 >= s023 * s123
        # the vertex on no wrong side of the face, which has an area
        return s123 != 0 and min(s012 * s123, s023 * s123, s031 * s123) >= 0
    return _collinear_meet(is_edge_edge, nodes, time)


def first_meeting(is_edge_edge, start, end) -> float | None:
    """When the two sides first have a point in common, exactly decided; None if never.

    Args:
        is_edge_edge: two edges, or a vertex and a face.
        start, end: positions of the four nodes at t = 0 and 1, finite floats: vertex then
            face, or edge then edge. Sides may be degenerate.

    Returns:
        A time in [0, 1], at most 2^-52 before the true one and never after it.
    """
    nodes = e1, e2, e3 = _relative_nodes(start, end)
    turns = [_cross(e1, e2), _cross(e2, e3), _cross(e3, e1)]
    turns.append([_add(_add(a, b), c) for a, b, c in zip(*turns, strict=True)])
    volume = []
    for x, turn in zip(e1, turns[1], strict=True):
        volume = _add(volume, _times(x, turn))
    if volume:
        times = roots_in_unit_interval(volume)
    else:
        differences = [_add(e[k], e1[k], -1) for e in (e2, e3) for k in range(3)]
        deciding = [p for vector in (*turns, *nodes) for p in vector] + differences
        times = [AlgebraicTime([], Fraction(0), Fraction(0))]
        times += [time for p in deciding if p for time in roots_in_unit_interval(p)]
    meeting = [_enclosed(t).low for t in times if _coplanar_meet(is_edge_edge, nodes, turns, t)]
    return _rounded_down(min(meeting)) if meeting else None


def _enclosed(time):
    while time.high - time.low > TIME_WIDTH:
        time = _halved(time)
    return time


def _rounded_down(number):
    result = float(number)
    return result if result <= number else nextafter(result, 0.0)
