"""Whether a pair meets on its way from t = 0 to t = 1, exactly.

Question: do the two sides of a pair have a common point at some time in [0, 1], and when first?

Method: rational arithmetic and the signs of polynomials at their real roots, by python-flint. The
argument below proves that the answer is right for every input, degenerate shapes included.

Independent of `izo_ref`: the package decides the same question in `base/exact_path.py`, by
Sturm's theorem and Bernstein coefficients on Python's integers. This module factorises polynomials
and evaluates them on intervals by FLINT, isolates roots by Descartes' rule, and derives its
conditions anew.

Limits: the motion is straight, at constant speed, and positions are finite floats. There is no
tolerance and no limit on the coordinates. It decides one pair at a time.

The argument
------------
A pair is a point and a triangle, or two segments. Its sides are the convex hulls of two sets of
nodes, A and B. Together they have four nodes p_0 .. p_3, each of which moves on a straight line at
constant speed. Floats are rationals. A common factor makes them integers and changes no answer, so
every quantity below is a polynomial in t with integer coefficients, of degree 3 at most.

At one time. The hulls of A and B have a common point if and only if there are numbers l_i, not all
zero, with sum l_i = 0, sum l_i p_i = 0, l_i >= 0 on A and l_i <= 0 on B (divide by the sum over A,
which is not zero). Then the four nodes are coplanar:

    D = det(p_1 - p_0, p_2 - p_0, p_3 - p_0) = 0.

For coplanar nodes, project along each coordinate axis and let

    l_i = (-1)^i (twice the signed area of the projected triangle of the other three nodes).

By Laplace's expansion, sum l_i = 0 and sum l_i p_i = 0 hold in the projection.

First case: the nodes are not all on one line. Then their plane does not project to a line along at
least one of the axes. The projection along such an axis is affine and one to one on the plane. So
this l is not zero, it satisfies sum l_i p_i = 0 in space too, and every other such set of numbers
is a multiple of it. Along the remaining axes, l is a multiple of the same set, perhaps zero. So the
hulls meet if and only if

    (1) along each axis, the l_i on A and the -l_i on B include no two of opposite sign.

Second case: the nodes are on one line or at one point. Then every l is zero, and (1) is always
true. A coordinate that is not the same for all nodes is one to one on the line. So the hulls meet
if and only if

    (2) on each axis, the intervals spanned by A and by B overlap,

that is, the differences b - a for a in A and b in B are neither all positive nor all negative.

(2) is necessary in the first case, too. Hence, whatever the shapes are, coplanar hulls meet if and
only if (1) and (2) hold. Both are conditions on signs: of l (degree 2) and of differences (degree
1).

On the path. The times at which the hulls meet are a closed set, since the hulls are compact and
move continuously. If D is not the zero polynomial, these times are among its roots. If D is zero,
(1) and (2) decide at every time. Consider all l and all differences that do not vanish identically.
Between two consecutive roots of these polynomials no sign changes, so the hulls meet either
throughout that open interval or never in it. In the first case they also meet at the ends of the
interval, since the set is closed. Each interval in [0, 1] has 0 or a root as its left end, so it is
enough to test t = 0 and all roots in [0, 1].

Signs at a root. A root tau is kept as an irreducible factor f and an interval with rational ends
that has no other root of f. q(tau) = 0 if and only if f divides q. Otherwise the values of q on an
interval that is narrow enough exclude zero. So every sign is certain, and no tolerance is needed.
"""

from collections.abc import Iterable, Iterator
from fractions import Fraction
from itertools import pairwise
from math import gcd, lcm
from typing import TypeAlias

import numpy as np
from flint import arb, ctx, fmpq, fmpz_poly
from numpy.typing import ArrayLike

Node: TypeAlias = list[fmpz_poly]  # three coordinates, polynomials of degree one in t

FIRST_BITS = 64  # the first intervals are at most 2^-64 wide; any value gives the same answers
TIME = fmpz_poly([0, 1])


class _Root:
    """The one root of an irreducible polynomial in [low, high]; low == high if it is rational."""

    def __init__(self, polynomial: fmpz_poly, low: fmpq, high: fmpq) -> None:
        self.polynomial, self.low, self.high = polynomial, low, high
        self._rises = polynomial(high) > 0

    def refine(self, bits: int) -> None:
        """Halve the interval until it is no wider than 2^-bits."""
        width = fmpq(1, 2**bits)
        while self.high - self.low > width:
            middle = (self.low + self.high) / 2
            if (self.polynomial(middle) > 0) == self._rises:
                self.high = middle
            else:
                self.low = middle

    def sign(self, polynomial: fmpz_poly) -> int:
        """Return the sign of another polynomial at this root: -1, 0 or 1."""
        bits = FIRST_BITS
        while True:
            self.refine(bits)
            with ctx.workprec(bits):
                value = polynomial(arb(self.low).union(arb(self.high)))
            if value != 0:  # true only if the whole ball is on one side of zero
                return 1 if value > 0 else -1
            if bits == FIRST_BITS and self.polynomial.gcd(polynomial).degree() > 0:
                return 0
            bits *= 2


def _variations(polynomial: fmpz_poly) -> int:
    """Count the sign changes of (1 + x)^n p(1 / (1 + x)), Descartes' bound for p's roots in (0, 1).

    The bound exceeds the number of roots by an even number, so a bound of 0 or 1 is exact.
    """
    coefficients = fmpz_poly(polynomial.coeffs()[::-1])(1 + TIME).coeffs()
    signs = [c > 0 for c in coefficients if c != 0]
    return sum(a != b for a, b in pairwise(signs))


def _real_roots(polynomial: fmpz_poly) -> list[_Root]:
    """Return the roots in [0, 1] of an irreducible polynomial.

    If the degree is not 1, no root is rational, and halving the interval separates them.
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


def _roots_on_path(polynomials: Iterable[fmpz_poly]) -> Iterator[_Root]:
    """Yield each root in [0, 1] of some polynomials, none of which is the zero polynomial."""
    tried = []
    for polynomial in polynomials:
        for factor, _ in polynomial.factor()[1]:
            if factor not in tried:
                tried.append(factor)
                yield from _real_roots(factor)


def _integers(values: Iterable[float]) -> list[int]:
    """Multiply finite floats by one positive rational: integers without a common divisor."""
    ratios = [float(value).as_integer_ratio() for value in values]
    common = lcm(*(denominator for _, denominator in ratios))
    integers = [numerator * (common // denominator) for numerator, denominator in ratios]
    divisor = gcd(*integers) or 1
    return [integer // divisor for integer in integers]


def _nodes(start: ArrayLike, end: ArrayLike) -> list[Node]:
    """Return the four nodes, each as three polynomials of degree one in t.

    Raises:
        ValueError: A shape is wrong or a number is not finite.
    """
    positions = np.array([start, end], np.float64)
    if positions.shape != (2, 4, 3) or not np.isfinite(positions).all():
        raise ValueError(
            f"start and end must be finite and of shape (4, 3), got {positions[0]}, {positions[1]}"
        )
    integers = _integers(positions.ravel())
    lines = [fmpz_poly([a, b - a]) for a, b in zip(integers[:12], integers[12:], strict=True)]
    return [lines[3 * i : 3 * i + 3] for i in range(4)]


def _area(p: Node, q: Node, r: Node, j: int, k: int) -> fmpz_poly:
    """Compute twice the signed area of a triangle projected on the plane of the axes j and k."""
    return (q[j] - p[j]) * (r[k] - p[k]) - (q[k] - p[k]) * (r[j] - p[j])


def _volume(p: Node, q: Node, r: Node, s: Node) -> fmpz_poly:
    """Compute det(q - p, r - p, s - p)."""
    terms = [(s[i] - p[i]) * _area(p, q, r, j, k) for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1))]
    return terms[0] + terms[1] + terms[2]


def _dependences(first: list[Node], second: list[Node]) -> Iterator[list[fmpz_poly]]:
    """Yield, for condition (1) and each axis, l on the first side and -l on the second."""
    p, q, r, s = first + second
    for j, k in ((1, 2), (2, 0), (0, 1)):
        areas = (_area(q, r, s, j, k), -_area(p, r, s, j, k))
        areas += (_area(p, q, s, j, k), -_area(p, q, r, j, k))
        yield [area if i < len(first) else -area for i, area in enumerate(areas)]


def _differences(first: list[Node], second: list[Node]) -> Iterator[list[fmpz_poly]]:
    """Yield, for condition (2) and each axis, all differences b - a."""
    for axis in range(3):
        yield [b[axis] - a[axis] for a in first for b in second]


def _coplanar_hulls_meet(
    root: _Root, dependences: list[list[fmpz_poly]], differences: list[list[fmpz_poly]]
) -> bool:
    """Return whether (1) and (2) hold at a time at which the nodes are coplanar."""
    for group in differences:
        signs = [root.sign(difference) for difference in group]
        if min(signs) > 0 or max(signs) < 0:
            return False
    for group in dependences:
        signs = [root.sign(value) for value in group]
        if min(signs) < 0 < max(signs):
            return False
    return True


def _meetings(
    is_edge_edge: bool, start: ArrayLike, end: ArrayLike, after_start: bool = False
) -> Iterator[_Root]:
    """Yield times at which the pair meets; the first of all is among them, if there is one.

    With `after_start`, the time 0 itself does not count. If the pair meets at all times close
    enough to 0, one of these is yielded.
    """
    nodes = _nodes(start, end)
    split = 2 if is_edge_edge else 1
    dependences = list(_dependences(nodes[:split], nodes[split:]))
    differences = list(_differences(nodes[:split], nodes[split:]))
    volume = _volume(*nodes)
    if volume != 0:
        watched = [volume]
    else:  # the nodes are coplanar all the time; the root of TIME is t = 0
        watched = [TIME, *(q for group in dependences + differences for q in group if q != 0)]
    roots = list(_roots_on_path(watched))
    if after_start:
        roots = [root for root in roots if root.high > 0]
        if volume == 0:
            roots.append(_soon(roots))
    for root in roots:
        if _coplanar_hulls_meet(root, dependences, differences):
            yield root


def _soon(roots: list[_Root]) -> _Root:
    """Return a rational time after 0, before some roots that are after 0."""
    bits = FIRST_BITS
    for root in roots:
        while root.low <= 0:
            root.refine(bits)
            bits *= 2
    time = min([fmpq(1), *(root.low for root in roots)]) / 2
    return _Root(fmpz_poly([-int(time.p), int(time.q)]), time, time)


def meets(is_edge_edge: bool, start: ArrayLike, end: ArrayLike) -> bool:
    """Return whether the two sides of a pair have a common point at some time in [0, 1].

    Args:
        is_edge_edge: Whether the nodes are the ends of one edge and of the other; otherwise they
            are a vertex and the corners of a face.
        start: (4, 3) float64, positions of the nodes at t = 0.
        end: (4, 3) float64, positions of the nodes at t = 1.

    Raises:
        ValueError: A shape is wrong or a number is not finite.
    """
    return any(True for _ in _meetings(is_edge_edge, start, end))


def meets_after_start(is_edge_edge: bool, start: ArrayLike, end: ArrayLike) -> bool:
    """Return whether the two sides of a pair have a common point at some time in (0, 1].

    Args:
        is_edge_edge: As for `meets`.
        start: As for `meets`.
        end: As for `meets`.

    Raises:
        ValueError: A shape is wrong or a number is not finite.
    """
    return any(True for _ in _meetings(is_edge_edge, start, end, after_start=True))


def goes_through_after_start(start: ArrayLike, end: ArrayLike) -> bool:
    """Return whether an edge goes through the inside of a face at all times close enough to 0.

    It does if, at a time before every root after 0 of the five volumes below, its ends are strictly
    on different sides of the plane of the face, and the three edges of the face turn the same way
    around its line.

    Args:
        start: (5, 3) float64, the ends of the edge and the corners of the face at t = 0.
        end: (5, 3) float64, the same at t = 1.
    """
    integers = _integers(np.array([start, end], np.float64).ravel())
    lines = [fmpz_poly([a, b - a]) for a, b in zip(integers[:15], integers[15:], strict=True)]
    p, q, a, b, c = (lines[3 * i : 3 * i + 3] for i in range(5))
    ends = _volume(a, b, c, p), _volume(a, b, c, q)
    turns = _volume(p, q, a, b), _volume(p, q, b, c), _volume(p, q, c, a)
    if any(volume == 0 for volume in (*ends, *turns)):
        return False
    soon = _soon([root for root in _roots_on_path((*ends, *turns)) if root.high > 0]).low
    sides = [volume(soon) > 0 for volume in ends]
    return sides[0] != sides[1] and len({volume(soon) > 0 for volume in turns}) == 1


def first_meeting(
    is_edge_edge: bool, start: ArrayLike, end: ArrayLike
) -> tuple[Fraction, Fraction] | None:
    """Return an interval around the first time at which a pair meets.

    Args:
        is_edge_edge: As for `meets`.
        start: As for `meets`.
        end: As for `meets`.

    Returns:
        The lower and the upper end, at most 2^-64 apart; None if the pair does not meet.

    Raises:
        ValueError: A shape is wrong or a number is not finite.
    """
    roots = list(_meetings(is_edge_edge, start, end))
    if not roots:
        return None
    for root in roots:
        root.refine(FIRST_BITS)
    low, high = min(root.low for root in roots), min(root.high for root in roots)
    return Fraction(int(low.p), int(low.q)), Fraction(int(high.p), int(high.q))
