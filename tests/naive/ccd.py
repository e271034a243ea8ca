"""Does a pair meet on its path? Exactly, in rational arithmetic, where that is simple.

The coplanarity cubic has rational coefficients. Its rational roots are tried exactly; the
others are enclosed by bisection until the inside tests have one sign over the enclosure,
which they get unless the contact is exactly on the boundary. Then the answer is None.
"""

from fractions import Fraction as Q
from itertools import pairwise

BISECTIONS = 200


def _sub(a, b):
    return [x - y for x, y in zip(a, b, strict=True)]


def _cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def _poly_mul(a, b):
    result = [Q(0)] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            result[i + j] += x * y
    return result


def _poly_add(*polys):
    n = max(map(len, polys))
    return [sum((p[i] if i < len(p) else Q(0)) for p in polys) for i in range(n)]


def _value(poly, t):
    result = Q(0)
    for c in reversed(poly):
        result = result * t + c
    return result


def _at(p0, p1, t):
    return [a + t * (b - a) for a, b in zip(p0, p1, strict=True)]


def _cubic(p0, p1):
    """Coefficients of det(p1 - p0, p2 - p0, p3 - p0) in t."""
    e = []
    for k in (1, 2, 3):
        a = _sub(p0[k], p0[0])
        b = _sub(p1[k], p1[0])
        e.append([[x, y - x] for x, y in zip(a, b, strict=True)])
    total = [Q(0)]
    for i, j, k, sign in (
        (0, 1, 2, 1),
        (1, 2, 0, 1),
        (2, 0, 1, 1),
        (0, 2, 1, -1),
        (2, 1, 0, -1),
        (1, 0, 2, -1),
    ):
        term = _poly_mul(_poly_mul(e[0][i], e[1][j]), e[2][k])
        total = _poly_add(total, [sign * c for c in term])
    return total


def _inside(is_edge_edge, points):
    """1 inside, -1 outside, 0 on the boundary or degenerate, of coplanar points."""
    if is_edge_edge:
        u, v = _sub(points[1], points[0]), _sub(points[3], points[2])
        n = _cross(u, v)
        nn = _dot(n, n)
        if nn == 0:
            return 0
        w = _sub(points[2], points[0])
        s = _dot(_cross(w, v), n)
        r = _dot(_cross(w, u), n)
        values = [s, nn - s, r, nn - r]
    else:
        a, b, c = points[1:]
        n = _cross(_sub(b, a), _sub(c, a))
        if _dot(n, n) == 0:
            return 0
        values = [
            _dot(_cross(_sub(q, p), _sub(points[0], p)), n) for p, q in ((a, b), (b, c), (c, a))
        ]
    if any(x < 0 for x in values):
        return -1
    return 0 if any(x == 0 for x in values) else 1


def _sturm(poly):
    chain = [poly]
    derivative = [i * c for i, c in enumerate(poly)][1:]
    while derivative and any(derivative):
        while derivative and derivative[-1] == 0:
            derivative.pop()
        chain.append(derivative)
        remainder = list(chain[-2])
        while len(remainder) >= len(derivative):
            factor = remainder[-1] / derivative[-1]
            for i in range(len(derivative)):
                remainder[len(remainder) - len(derivative) + i] -= factor * derivative[i]
            remainder.pop()
        derivative = [-c for c in remainder]
    return chain


def _divide(a, b):
    a, quotient = list(a), [Q(0)] * (len(a) - len(b) + 1)
    for k in reversed(range(len(quotient))):
        quotient[k] = a[k + len(b) - 1] / b[-1]
        for i, c in enumerate(b):
            a[k + i] -= quotient[k] * c
    return quotient


def _changes(chain, t):
    signs = [v for v in (_value(p, t) for p in chain) if v != 0]
    return sum(a * b < 0 for a, b in pairwise(signs))


def _isolate(poly, chain, low, high):
    """Intervals (low, high] with one root each."""
    count = _changes(chain, low) - _changes(chain, high)
    if count == 0:
        return []
    if count == 1:
        return [(low, high)]
    middle = (low + high) / 2
    return _isolate(poly, chain, low, middle) + _isolate(poly, chain, middle, high)


def meets(is_edge_edge, start, end):
    """True, False, or None where this oracle cannot tell.

    Args:
        start, end: four points each, floats.
    """
    p0 = [[Q(float(x)) for x in p] for p in start]
    p1 = [[Q(float(x)) for x in p] for p in end]
    poly = _cubic(p0, p1)
    while poly and poly[-1] == 0:
        poly.pop()
    if not poly:
        return None  # coplanar all the time
    chain = _sturm(poly)
    if len(chain[-1]) > 1:  # the greatest common divisor with the derivative: multiple roots
        poly = _divide(poly, chain[-1])
        chain = _sturm(poly)
    answers = []
    if _value(poly, Q(0)) == 0:
        answers.append(_inside(is_edge_edge, p0))
    for low, high in _isolate(poly, chain, Q(0), Q(1)):
        answers.append(_at_root(is_edge_edge, p0, p1, poly, low, high))
    if any(answer == 1 for answer in answers):
        return True
    return None if any(answer == 0 for answer in answers) else False


def _at_root(is_edge_edge, p0, p1, poly, low, high):
    for _ in range(BISECTIONS):
        if _value(poly, high) == 0:
            return _inside(is_edge_edge, [_at(a, b, high) for a, b in zip(p0, p1, strict=True)])
        sides = {
            _inside(is_edge_edge, [_at(a, b, t) for a, b in zip(p0, p1, strict=True)])
            for t in (low, high)
        }
        width = float(high - low)
        # the inside tests are polynomials of degree 5 in t: over so short an interval one
        # sign at both ends is one sign in between, unless they nearly vanish there
        if len(sides) == 1 and 0 not in sides and width < 1e-9:
            return sides.pop()
        middle = (low + high) / 2
        if _value(poly, middle) == 0:
            low = high = middle
        elif _value(poly, low) != 0 and _value(poly, low) * _value(poly, middle) < 0:
            high = middle
        elif _value(poly, middle) * _value(poly, high) < 0:
            low = middle
        else:
            return 0  # a double root
    return 0
