"""Decide whether a pair meets on its path in exact arithmetic, and find when it first does.

Floats are rational numbers, so all coefficients below are rational, and no step is rounded.

**When a pair can meet.** Node 0 is the origin, and e_1, e_2, e_3 are the other nodes relative to
it, linear in t. Sides that meet have coplanar nodes, so the pair can meet only at roots of the
cubic det(e_1, e_2, e_3):

* If the cubic is not zero everywhere, it has at most three roots in [0, 1].
* If it is zero everywhere, the nodes are coplanar at all times. Whether the pair meets then depends
  on the signs of finitely many polynomials, so it can change only at their roots. The times at
  which the pair meets form a closed set, so the first of them is 0 or one of these roots.

In both cases a few algebraic times are left. At each of them, `_coplanar_meet` decides from the
signs of polynomials whether the pair meets.

**Algebraic times.** An algebraic time is a polynomial without multiple roots, and an interval
(low, high] that holds exactly one of its roots, by Sturm's theorem.

**Signs at an algebraic time.** The Bernstein coefficients of a polynomial on the interval enclose
its values there. Once they have one strict sign, this is the sign at the time. Until then the
interval is halved. If the polynomial is zero at the time, this never ends. So `sign_at` tests for
that case once the interval is narrow: the polynomial is zero at the time if and only if its
greatest common divisor with the polynomial of the time has a root in the interval.

Source: docs/method section 8; S. Basu, R. Pollack, M.-F. Roy, Algorithms in Real Algebraic Geometry
(2006), 2.2 and 10.
"""

from fractions import Fraction
from math import nextafter
from typing import Any

from izo_ref.base.polynomials import (
    Polynomial,
    add,
    bernstein,
    common_divisor,
    count_roots,
    cross,
    derivative,
    multiply,
    primitive,
    quotient,
    sign_of,
    sturm_chain,
    trimmed,
    value,
)

# The time of a meeting is enclosed in an interval of width 2^-54, half the spacing of floats just
# below 1.
TIME_BITS = 54
# A sign that is not certain on an interval of width 2^-40 is tested for zero.
ZERO_BITS = 40


class AlgebraicTime:
    """A root of a polynomial without multiple roots, enclosed in an interval.

    The root is the only one in (low / unit, high / unit]; if low = high, it is that number. Whoever
    needs a narrower interval calls `halve`.

    Args:
        polynomial: A polynomial without multiple roots.
        low: Numerator of the lower end of the interval.
        high: Numerator of the upper end.
        unit: Denominator of both, a power of two.

    Attributes:
        polynomial: As passed in.
        low: Numerator of the lower end of the interval, so far.
        high: Numerator of the upper end.
        unit: Denominator of both.
    """

    def __init__(self, polynomial: Polynomial, low: int, high: int, unit: int) -> None:
        """Take a polynomial and an interval with one of its roots."""
        self.polynomial = polynomial
        self.low, self.high, self.unit = low, high, unit
        self._settle()

    def _settle(self) -> None:
        """Shrink the interval to its upper end if the root is there."""
        if value(self.polynomial, self.high, self.unit) == 0:
            self.low = self.high

    def is_narrower(self, bits: int) -> bool:
        """Return whether the interval is not wider than 2^-bits."""
        return (self.high - self.low) << bits <= self.unit

    def halve(self) -> None:
        """Keep the half of the interval that has the root."""
        middle = self.low + self.high
        self.low, self.high, self.unit = 2 * self.low, 2 * self.high, 2 * self.unit
        # The root is simple, so the polynomial changes its sign there, and nowhere else inside the
        # interval.
        at_middle = sign_of(value(self.polynomial, middle, self.unit))
        if at_middle in (0, sign_of(value(self.polynomial, self.high, self.unit))):
            self.high = middle
            self._settle()
        else:
            self.low = middle


def roots_in_unit_interval(poly: Polynomial) -> list[AlgebraicTime]:
    """Return the different roots in [0, 1] of a polynomial that is not zero, in ascending order."""
    poly = primitive(poly)
    if len(poly) > 2:
        poly = quotient(poly, common_divisor(poly, derivative(poly)))
    chain = sturm_chain(poly)
    found = []
    if poly[0] == 0:
        found.append(AlgebraicTime(poly, 0, 0, 1))
    parts = [(0, 1, 1)]
    while parts:
        low, high, unit = parts.pop()
        count = count_roots(chain, low, high, unit)
        if count == 1:
            found.append(AlgebraicTime(poly, low, high, unit))
        elif count > 1:
            middle = low + high
            parts += [(middle, 2 * high, 2 * unit), (2 * low, middle, 2 * unit)]
    return found


def sign_at(poly: Polynomial, time: AlgebraicTime) -> int:
    """Return the sign of a polynomial at an algebraic time: -1, 0 or 1."""
    if not poly:
        return 0
    may_be_zero = True
    while time.low != time.high:
        coefficients = bernstein(poly, time.low, time.high, time.unit)
        if min(coefficients) > 0 or max(coefficients) < 0:
            return sign_of(coefficients[0])
        if may_be_zero and time.is_narrower(ZERO_BITS):
            common = common_divisor(time.polynomial, poly)
            if len(common) > 1:
                # it divides a polynomial without multiple roots, so it has none either
                chain = sturm_chain(common)
                if count_roots(chain, time.low, time.high, time.unit):
                    return 0
            may_be_zero = False
        time.halve()
    return sign_of(value(poly, time.high, time.unit))


def _relative_nodes(start: Any, end: Any) -> list[list[Polynomial]]:
    """Return e_1, e_2, e_3: three coordinates each, linear polynomials in t.

    All coordinates are multiplied by one power of two that makes them integers. This changes no
    answer.
    """
    ratios = [
        [float(x).as_integer_ratio() for x in (*p, *q)] for p, q in zip(start, end, strict=True)
    ]
    unit = max(denominator for row in ratios for _, denominator in row)
    rows = [[n * (unit // d) for n, d in row] for row in ratios]
    nodes = []
    for row in rows[1:]:
        offset = [x - x0 for x, x0 in zip(row, rows[0], strict=True)]
        nodes.append([trimmed([a, b - a]) for a, b in zip(offset[:3], offset[3:], strict=True)])
    return nodes


def _collinear_meet(is_edge_edge: bool, nodes: list[list[Polynomial]], time: AlgebraicTime) -> bool:
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
    nodes: list[list[Polynomial]],
    turns: list[list[Polynomial]],
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
    nodes = e1, e2, e3 = _relative_nodes(start, end)
    turns = [cross(e1, e2), cross(e2, e3), cross(e3, e1)]
    turns.append([add(add(a, b), c) for a, b, c in zip(*turns, strict=True)])
    volume: Polynomial = []
    for x, turn in zip(e1, turns[1], strict=True):
        volume = add(volume, multiply(x, turn))
    if volume:
        times = roots_in_unit_interval(volume)
    else:
        # every polynomial whose sign `_coplanar_meet` may ask for
        differences = [add(e[k], e1[k], -1) for e in (e2, e3) for k in range(3)]
        deciding = [p for vector in (*turns, *nodes) for p in vector] + differences
        times = [AlgebraicTime([], 0, 0, 1)]
        times += [time for p in deciding if p for time in roots_in_unit_interval(p)]
    meeting = [_float_below(t) for t in times if _coplanar_meet(is_edge_edge, nodes, turns, t)]
    return min(meeting, default=None)


def _float_below(time: AlgebraicTime) -> float:
    """Return a float that is not after the time, and at most 2^-52 before it."""
    while not time.is_narrower(TIME_BITS):
        time.halve()
    number = Fraction(time.low, time.unit)
    result = float(number)
    return result if result <= number else nextafter(result, 0.0)
