"""The cubic whose roots are the times at which the four nodes of a pair are coplanar.

f(t) = det(e1(t), e2(t), e3(t)), with e_k(t) = (1 - t) e_k(0) + t e_k(1) the second to
fourth node relative to the first. As long as f has no root the pair cannot meet. It is
held in Bernstein form: a cubic is enclosed by its control polygon, on [0, 1] and, after
subdivision, on any part of it. A cubic of lower degree, or one that is zero, needs no care.

Rounding. u = 2^-53; M_k bounds |e_k|_inf at both ends; P = M_1 M_2 M_3, so |f| <= 6 P.
    input     e_k are differences of floats: relative error u each              18 u P
    cross     4 u M_2 M_3 a component, times 3 M_1                              12 u P
    dot       three terms of at most 2 P each, gamma_3                          18 u P
    b1, b2    sum of three determinants, up to 18 P, a third of it              22 u P
    subdivide at both ends: six levels of (1 - t) x + t y, 3 u |x| <= 18 u P   108 u P
    lowering  c - error, when the hull is taken                                  6 u P
Together 184 u P, plus terms in u^2: COEFFICIENT_ERROR = 192 u. With the pair scaled to a
size near 1, a product that underflows is off by at most 2^-1075, and there are less than a
hundred: TINY covers them.
"""

from izo_ref.base.compile import compiled
from izo_ref.base.formulas.vec3 import det3

COEFFICIENT_ERROR = 192.0 * 2.0**-53
TINY = 1e-300


@compiled
def bernstein_coefficients(a1, a2, a3, b1, b2, b3):
    """Four coefficients of f on [0, 1]; a_k = e_k(0), b_k = e_k(1)."""
    third = 1.0 / 3.0
    return (
        det3(a1, a2, a3),
        third * (det3(b1, a2, a3) + det3(a1, b2, a3) + det3(a1, a2, b3)),
        third * (det3(a1, b2, b3) + det3(b1, a2, b3) + det3(b1, b2, a3)),
        det3(b1, b2, b3),
    )


@compiled
def split(c, t):
    """Coefficients on [0, t] and on [t, 1] of a cubic on [0, 1] (de Casteljau)."""
    s = 1.0 - t
    d0 = s * c[0] + t * c[1]
    d1 = s * c[1] + t * c[2]
    d2 = s * c[2] + t * c[3]
    e0 = s * d0 + t * d1
    e1 = s * d1 + t * d2
    middle = s * e0 + t * e1
    return (c[0], d0, e0, middle), (middle, e1, d2, c[3])


@compiled
def _first_crossing(x0, y0, x1, y1):
    """Where the segment from (x0, y0 > 0) to (x1, y1) meets zero; 2 if it does not."""
    if y0 > 0.0 and not y1 > 0.0:
        return x0 + (x1 - x0) * (y0 / (y0 - y1))
    return 2.0


@compiled
def hull_root_bound(c, sign, error):
    """A number in [0, 2] below every root of the cubic in [0, 1]; 2 means no root.

    The graph, times `sign`, lies in the convex hull of (k / 3, sign c_k); each is lowered
    by `error`. 0 when the graph is not certain to begin above zero.
    """
    y0 = sign * c[0] - error
    y1 = sign * c[1] - error
    y2 = sign * c[2] - error
    y3 = sign * c[3] - error
    if not y0 > 0.0:
        return 0.0
    third = 1.0 / 3.0
    x = _first_crossing(0.0, y0, third, y1)
    x = min(x, _first_crossing(0.0, y0, 2.0 * third, y2))
    x = min(x, _first_crossing(0.0, y0, 1.0, y3))
    x = min(x, _first_crossing(third, y1, 2.0 * third, y2))
    x = min(x, _first_crossing(third, y1, 1.0, y3))
    return min(x, _first_crossing(2.0 * third, y2, 1.0, y3))


# Bezier clipping squares the distance to a simple root, so four or five suffice; what is
# left after that is taken up by the next step of `advance`.
CLIPS = 6


@compiled
def root_free_until(c, t, error):
    """A time from which on there may be a root; until there, from t, there is none.

    2 if there is none up to 1; t if nothing can be said. Each round clips the hull on a
    window that ends at twice the distance of Newton's root: there the cubic is nearly
    straight and the hull nearly the graph.

    `low` is rounded, by less than 16 u in all rounds: the caller steps back by that much.
    A root inside that sliver is not skipped, because the sign of the first round is kept:
    once the cubic has changed it, nothing is certain and the rounds end.
    """
    low = t
    _, rest = split(c, low)
    sign = 1.0 if rest[0] > 0.0 else -1.0
    window = 1.0
    for _ in range(CLIPS):
        head, _ = split(rest, window)
        x = hull_root_bound(head, sign, error)
        if x > 1.0 and window == 1.0:
            return 2.0
        step = min(x, 1.0) * window
        if not step > 0.0:
            return low
        low = low + step * (1.0 - low)
        _, rest = split(c, low)
        newton = rest[0] / (3.0 * (rest[0] - rest[1]))
        window = min(1.0, 2.0 * newton) if newton > 0.0 else 1.0
    return low
