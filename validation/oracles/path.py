"""Whether a pair meets on its way from t = 0 to t = 1, exactly.

A pair is a point and a triangle, or two segments: the convex hulls of two sets of nodes,
four nodes p_0 .. p_3 together, each moving on a straight line at constant speed. Floats are
rationals; a common factor, which changes no answer, makes them integers, and every
quantity below is then a polynomial in t with integer coefficients, of degree 3 at most.

At one time. The hulls of A and B have a common point if and only if there are numbers l_i,
not all zero, with sum l_i = 0 and sum l_i p_i = 0, l_i >= 0 on A and l_i <= 0 on B (divide
by the sum over A, which is not zero). So the four nodes are coplanar,

    D = det(p_1 - p_0, p_2 - p_0, p_3 - p_0) = 0.

For coplanar nodes look along each coordinate axis, and let

    l_i = (-1)^i (twice the signed area of the projected triangle of the other three).

By Laplace's expansion sum l_i = 0 and sum l_i p_i = 0 in the projection. If the nodes are not
all on one line, the plane has an axis along which it is not seen as a line; there the
projection is affine and one to one on the plane, so l is a dependence of the nodes in space
too, not zero, and every other one is a multiple of it; along the remaining axes l is a multiple
of the same (perhaps zero). So the hulls meet if and only if

    (1) along each axis, the l_i on A and the -l_i on B have no two of opposite sign.

If the nodes are on one line, or at one point, every l is zero, and (1) holds idly. A coordinate
that differs at all is then one to one on the line, so the hulls meet if and only if

    (2) on each axis, the intervals spanned by A and by B overlap,

that is, the differences b - a for a in A, b in B are neither all positive nor all negative.
(2) is necessary in every case. Hence, whatever the shapes: coplanar hulls meet if and only
if (1) and (2), which are sign conditions on l (degree 2) and on the differences (degree 1).

On the path. The times of meeting are a closed set, since the hulls are compact and move
continuously. If D is not the zero polynomial they are among its roots. If it is, (1) and (2)
decide at every time, and between consecutive roots of those l and differences that do not
vanish identically no sign changes: the hulls meet throughout such an open interval or never,
and in the first case at its ends as well, since the set is closed. Each interval in [0, 1] has
0 or a root as its left end, so it is enough to try t = 0 and all roots in [0, 1].

Signs at a root. A root tau is kept as an irreducible factor f and a bracket of rationals with
no other root of f. q(tau) = 0 if and only if f divides q; if not, the values of q on a bracket
that is narrow enough exclude zero. So every sign is certain, and no tolerance is needed.
"""

from fractions import Fraction
from itertools import pairwise
from math import gcd, lcm

import numpy as np
from flint import arb, ctx, fmpq, fmpz_poly

FIRST_BITS = 64  # of the widest bracket; any value gives the same answers
TIME = fmpz_poly([0, 1])


class _Root:
    """The one root, in [low, high], of an irreducible polynomial; low == high if rational."""

    def __init__(self, polynomial, low, high):
        self.polynomial, self.low, self.high = polynomial, low, high
        self._rises = polynomial(high) > 0

    def refine(self, bits):
        """Halve the bracket until it is no wider than 2^-bits."""
        width = fmpq(1, 2**bits)
        while self.high - self.low > width:
            middle = (self.low + self.high) / 2
            if (self.polynomial(middle) > 0) == self._rises:
                self.high = middle
            else:
                self.low = middle

    def sign(self, polynomial):
        """-1, 0 or 1: the sign of another polynomial at this root."""
        bits = FIRST_BITS
        while True:
            self.refine(bits)
            with ctx.workprec(bits):
                value = polynomial(arb(self.low).union(arb(self.high)))
            if value != 0:  # true only if the whole ball is on one side
                return 1 if value > 0 else -1
            if bits == FIRST_BITS and self.polynomial.gcd(polynomial).degree() > 0:
                return 0
            bits *= 2


def _variations(polynomial):
    """Sign changes of (1 + x)^n p(1 / (1 + x)): Descartes' bound for p's roots in (0, 1).

    It exceeds their number by an even number, so 0 and 1 are exact.
    """
    coefficients = fmpz_poly(polynomial.coeffs()[::-1])(1 + TIME).coeffs()
    signs = [c > 0 for c in coefficients if c != 0]
    return sum(a != b for a, b in pairwise(signs))


def _real_roots(polynomial):
    """The roots in [0, 1] of an irreducible polynomial.

    If the degree is not 1 none is rational, and halving the interval separates them.
    """
    coefficients, degree = polynomial.coeffs(), polynomial.degree()
    if degree == 1:
        root = fmpq(-coefficients[0], coefficients[1])
        return [_Root(polynomial, root, root)] if 0 <= root <= 1 else []
    roots, work = [], [(polynomial, 0, 0)]
    while work:
        piece, k, m = work.pop()  # piece(x) is c f((k + x) / 2^m) with some c > 0
        count = _variations(piece)
        if count == 1:
            roots.append(_Root(polynomial, fmpq(k, 2**m), fmpq(k + 1, 2**m)))
        elif count > 1:
            left = fmpz_poly([c * 2 ** (degree - i) for i, c in enumerate(piece.coeffs())])
            work += [(left, 2 * k, m + 1), (left(1 + TIME), 2 * k + 1, m + 1)]
    return roots


def _roots_on_path(polynomials):
    """Each root in [0, 1] of each polynomial; none of them is zero."""
    tried = []
    for polynomial in polynomials:
        for factor, _ in polynomial.factor()[1]:
            if factor not in tried:
                tried.append(factor)
                yield from _real_roots(factor)


def _integers(values):
    """Finite floats times one positive rational, as integers without a common divisor."""
    ratios = [float(value).as_integer_ratio() for value in values]
    common = lcm(*(denominator for _, denominator in ratios))
    integers = [numerator * (common // denominator) for numerator, denominator in ratios]
    divisor = gcd(*integers) or 1
    return [integer // divisor for integer in integers]


def _nodes(start, end):
    """The four nodes: three polynomials of degree one in t each."""
    positions = np.array([start, end], np.float64)
    if positions.shape != (2, 4, 3) or not np.isfinite(positions).all():
        raise ValueError(
            f"start and end must be finite and of shape (4, 3), got {positions[0]}, {positions[1]}"
        )
    integers = _integers(positions.ravel())
    lines = [fmpz_poly([a, b - a]) for a, b in zip(integers[:12], integers[12:], strict=True)]
    return [lines[3 * i : 3 * i + 3] for i in range(4)]


def _area(p, q, r, j, k):
    """Twice the signed area of a triangle seen on the plane of the axes j and k."""
    return (q[j] - p[j]) * (r[k] - p[k]) - (q[k] - p[k]) * (r[j] - p[j])


def _volume(p, q, r, s):
    """det(q - p, r - p, s - p)."""
    return sum(
        (s[i] - p[i]) * _area(p, q, r, j, k) for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
    )


def _dependences(first, second):
    """Condition (1): along each axis l on the first side and -l on the second."""
    p, q, r, s = first + second
    for j, k in ((1, 2), (2, 0), (0, 1)):
        areas = (_area(q, r, s, j, k), -_area(p, r, s, j, k))
        areas += (_area(p, q, s, j, k), -_area(p, q, r, j, k))
        yield [area if i < len(first) else -area for i, area in enumerate(areas)]


def _differences(first, second):
    """Condition (2): on each axis all b - a."""
    for axis in range(3):
        yield [b[axis] - a[axis] for a in first for b in second]


def _coplanar_hulls_meet(root, dependences, differences):
    """Conditions (1) and (2) at one time at which the nodes are coplanar."""
    for group in differences:
        signs = [root.sign(difference) for difference in group]
        if min(signs) > 0 or max(signs) < 0:
            return False
    for group in dependences:
        signs = [root.sign(value) for value in group]
        if min(signs) < 0 < max(signs):
            return False
    return True


def _meetings(is_edge_edge, start, end):
    """Times of meeting, as roots, the first time of all among them; none if there is none."""
    nodes = _nodes(start, end)
    split = 2 if is_edge_edge else 1
    dependences = list(_dependences(nodes[:split], nodes[split:]))
    differences = list(_differences(nodes[:split], nodes[split:]))
    volume = _volume(*nodes)
    if volume != 0:
        watched = [volume]
    else:  # coplanar all the time; the root of TIME is t = 0
        watched = [TIME, *(q for group in dependences + differences for q in group if q != 0)]
    for root in _roots_on_path(watched):
        if _coplanar_hulls_meet(root, dependences, differences):
            yield root


def meets(is_edge_edge, start, end) -> bool:
    """Whether the two sides of a pair have a common point at some time in [0, 1].

    Args:
        is_edge_edge: whether the nodes are the ends of one edge, then of the other; if not,
            they are a vertex, then the corners of a face.
        start, end: (4, 3) float64, the nodes' positions at t = 0 and t = 1.

    Raises:
        ValueError: a shape is wrong or a number is not finite.
    """
    return any(True for _ in _meetings(is_edge_edge, start, end))


def first_meeting(is_edge_edge, start, end):
    """Fractions (lower, upper) around the first time of meeting, or None if there is none.

    Args: as of `meets`.
    """
    roots = list(_meetings(is_edge_edge, start, end))
    if not roots:
        return None
    for root in roots:
        root.refine(FIRST_BITS)
    first = [min(root.low for root in roots), min(root.high for root in roots)]
    return tuple(Fraction(int(time.p), int(time.q)) for time in first)
