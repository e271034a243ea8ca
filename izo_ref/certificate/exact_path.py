"""Does a pair meet on its path? Exactly: floats are rationals, and so are all coefficients.

Node 0 is the origin; e_1, e_2, e_3 are the others, linear in t. The pair can meet only
where its nodes are coplanar, at roots of the cubic det(e_1, e_2, e_3). If that vanishes
identically, the pair is coplanar all the time. Whether it meets then depends on the signs
of finitely many polynomials, so it changes only at their roots; and because the times at
which it meets are a closed set, the first of them is 0 or such a root. Either way a few
algebraic times are left to look at.

An algebraic time is a square-free polynomial and an interval (low, high] with one of its
roots, found by Sturm's theorem. The sign of another polynomial there is certain once its
Bernstein coefficients on the interval have one sign; until then the interval is halved. If
it is zero there, that never happens, but then the greatest common divisor of the two has a
root in the interval, and that is tested once.

Polynomials are lists of integers, the constant first, without zeros at the end; factors
that are positive do not matter and are taken out. Fractions would be several times slower.

Source: SPEC section 8; S. Basu, R. Pollack, M.-F. Roy, Algorithms in Real Algebraic
Geometry (2006), 2.2 and 10.
"""

from fractions import Fraction
from itertools import pairwise
from math import comb, gcd, lcm, nextafter

# The time of a meeting is enclosed this closely, half an ulp of 1 and less.
TIME_BITS = 54
# Width from which on a sign that is still not certain may be zero.
ZERO_BITS = 40


class AlgebraicTime:
    """The root of a square-free polynomial in (low / unit, high / unit], or low if low = high.

    The interval is made narrower by whoever needs it to be.
    """

    def __init__(self, polynomial, low, high, unit):
        self.polynomial = polynomial
        self.low, self.high, self.unit = low, high, unit
        self._settle()

    def _settle(self):
        if _value(self.polynomial, self.high, self.unit) == 0:
            self.low = self.high

    def is_narrower(self, bits):
        return (self.high - self.low) << bits <= self.unit

    def halve(self):
        middle = self.low + self.high
        self.low, self.high, self.unit = 2 * self.low, 2 * self.high, 2 * self.unit
        # a simple root: the polynomial changes its sign there, and nowhere else in between
        at_middle = _sign(_value(self.polynomial, middle, self.unit))
        if at_middle in (0, _sign(_value(self.polynomial, self.high, self.unit))):
            self.high = middle
            self._settle()
        else:
            self.low = middle


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


def _value(poly, number, unit):
    """Of the polynomial at number / unit, times a power of unit."""
    result, power = 0, 1
    for coefficient in reversed(poly):
        result = result * number + coefficient * power
        power *= unit
    return result


def _sign(number):
    return (number > 0) - (number < 0)


def _primitive(poly):
    divisor = gcd(*poly)
    return [c // divisor for c in poly] if divisor > 1 else poly


def _remainder(a, b):
    """Of a by b, times a positive factor."""
    rest, size, sign = list(a), abs(b[-1]), _sign(b[-1])
    while len(rest) >= len(b):
        factor = sign * rest[-1]
        shift = len(rest) - len(b)
        rest = [size * c for c in rest]
        for i, c in enumerate(b):
            rest[shift + i] -= factor * c
        rest.pop()
    return _primitive(_trimmed(rest))


def _quotient(a, b):
    """Of a by a primitive divisor of it: integers again (Gauss's lemma)."""
    rest, quotient = list(a), []
    while len(rest) >= len(b):
        quotient.append(rest[-1] // b[-1])
        for i in range(1, len(b) + 1):
            rest[-i] -= quotient[-1] * b[-i]
        rest.pop()
    return quotient[::-1]


def _common(a, b):
    """Greatest common divisor, but for a factor."""
    while b:
        a, b = b, _remainder(a, b)
    return _primitive(a)


def _derivative(poly):
    return [i * c for i, c in enumerate(poly)][1:]


def _sturm_chain(square_free):
    chain = [square_free, _derivative(square_free)]
    while chain[-1]:
        chain.append([-c for c in _remainder(chain[-2], chain[-1])])
    return chain[:-1]


def _roots_between(chain, low, high, unit):
    """How many roots in (low / unit, high / unit]."""
    counts = []
    for number in (low, high):
        signs = [s for s in (_sign(_value(p, number, unit)) for p in chain) if s]
        counts.append(sum(a != b for a, b in pairwise(signs)))
    return counts[0] - counts[1]


def roots_in_unit_interval(poly) -> list[AlgebraicTime]:
    """The different roots of a polynomial that is not zero in [0, 1], in order."""
    poly = _primitive(poly)
    if len(poly) > 2:
        poly = _quotient(poly, _common(poly, _derivative(poly)))
    chain = _sturm_chain(poly)
    found = []
    if poly[0] == 0:
        found.append(AlgebraicTime(poly, 0, 0, 1))
    parts = [(0, 1, 1)]
    while parts:
        low, high, unit = parts.pop()
        count = _roots_between(chain, low, high, unit)
        if count == 1:
            found.append(AlgebraicTime(poly, low, high, unit))
        elif count > 1:
            middle = low + high
            parts += [(middle, 2 * high, 2 * unit), (2 * low, middle, 2 * unit)]
    return found


def _bernstein(poly, low, high, unit):
    """Bernstein coefficients on [low, high] / unit, times a positive factor."""
    degree, width = len(poly) - 1, high - low
    powers = [
        sum(
            poly[k] * comb(k, i) * low ** (k - i) * unit ** (degree - k)
            for k in range(i, degree + 1)
        )
        * width**i
        for i in range(degree + 1)
    ]
    binomials = [comb(degree, i) for i in range(degree + 1)]
    factor = lcm(*binomials)
    return [
        sum(comb(j, i) * powers[i] * (factor // binomials[i]) for i in range(j + 1))
        for j in range(degree + 1)
    ]


def sign_at(poly, time: AlgebraicTime) -> int:
    """Sign of a polynomial at an algebraic time."""
    if not poly:
        return 0
    may_be_zero = True
    while time.low != time.high:
        coefficients = _bernstein(poly, time.low, time.high, time.unit)
        if min(coefficients) > 0 or max(coefficients) < 0:
            return _sign(coefficients[0])
        if may_be_zero and time.is_narrower(ZERO_BITS):
            common = _common(time.polynomial, poly)
            if len(common) > 1:
                chain = _sturm_chain(common)  # of a divisor of a square-free one
                if _roots_between(chain, time.low, time.high, time.unit):
                    return 0
            may_be_zero = False
        time.halve()
    return _sign(_value(poly, time.high, time.unit))


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
        times = [AlgebraicTime([], 0, 0, 1)]
        times += [time for p in deciding if p for time in roots_in_unit_interval(p)]
    meeting = [_lower(t) for t in times if _coplanar_meet(is_edge_edge, nodes, turns, t)]
    return min(meeting, default=None)


def _lower(time):
    """A float that is at most the time, and at most 2^-52 before it."""
    while not time.is_narrower(TIME_BITS):
        time.halve()
    number = Fraction(time.low, time.unit)
    result = float(number)
    return result if result <= number else nextafter(result, 0.0)
