"""The cubic that is zero when the four nodes of a pair are coplanar, and how far it has no root.

**Symbols.** e_k(t) = (1 - t) e_k(0) + t e_k(1), for k = 1, 2, 3, are the second to fourth node
relative to the first. The nodes are coplanar at the roots of

    f(t) = det(e_1(t), e_2(t), e_3(t)),

a cubic in t. As long as f has no root, the pair cannot meet.

**Method.** f is held in Bernstein form, by four coefficients on [0, 1]. Its graph lies in the
convex hull of its control points, on [0, 1] and, after subdivision, on any part of it. A cubic of
lower degree, or one that is zero everywhere, needs no special case.

**Rounding.** Let u = 2^-53, let M_k bound |e_k|_inf at both ends, and let P = M_1 M_2 M_3. A
determinant has six terms, so |f| <= 6 P, and each coefficient is at most 6 P too. The errors, in
units of u P and up to terms in u^2, are:

    input         each e_k is a difference of floats, with a relative error u: 3 * 6          18
    cross         a component of a cross product is the difference of two products, with an
                  error of 2 u + 2 u times M_2 M_3; there are three, times M_1: 3 * 4         12
    dot           three terms of at most 2 P each, gamma_3: 3 * 6                             18
    mean          the two inner coefficients are a third of a sum of three determinants. The
                  two sums are at most 12 P and 18 P: 30; the float 1/3 and the product: 36;
                  a third of both                                                             22
    subdivision   twice, three levels each, of (1 - t) x + t y: six times 3 u |x| with
                  |x| <= 6 P: 6 * 18                                                         108
    lowering      c - error, where the hull is taken: 6                                        6

Together these are 184. COEFFICIENT_ERROR = 192 u leaves room for the terms in u^2. Averages do not
amplify the errors of the coefficients they start from, so the errors add up.

**Underflow.** The pair is scaled to a size near 1. A product that underflows is then off by at most
2^-1075. There are less than a hundred products, so TINY covers them.
"""

from izo_ref.base.arrays import Vec3, Vec4
from izo_ref.base.compile import compiled
from izo_ref.base.formulas.vec3 import det3

COEFFICIENT_ERROR = 192.0 * 2.0**-53
TINY = 1e-300
# Rounds of Bezier clipping. Each squares the distance to a simple root, so four or five suffice;
# the next step of `advance` continues at the time that they reach.
CLIPS = 6
# Steps of Newton's method to a root before clipping is tried. A root that they find takes 0.13 us,
# and clipping 0.2.
NEWTON_STEPS = 6
NEWTON_TOLERANCE = 1e-12
# A cubic that changes its sign within this time is taken to change it now.
SOON = 1e-9


@compiled
def coefficient_sums(a1: Vec3, a2: Vec3, a3: Vec3, b1: Vec3, b2: Vec3, b3: Vec3) -> Vec4:
    """Return the four Bernstein coefficients of f on [0, 1], the two inner ones times 3.

    a_k is e_k(0), b_k is e_k(1). There is no constant here, so float32 stays float32.
    """
    return (
        det3(a1, a2, a3),
        det3(b1, a2, a3) + det3(a1, b2, a3) + det3(a1, a2, b3),
        det3(a1, b2, b3) + det3(b1, a2, b3) + det3(b1, b2, a3),
        det3(b1, b2, b3),
    )


@compiled
def bernstein_coefficients(a1: Vec3, a2: Vec3, a3: Vec3, b1: Vec3, b2: Vec3, b3: Vec3) -> Vec4:
    """Return the four Bernstein coefficients of f on [0, 1]; a_k is e_k(0), b_k is e_k(1)."""
    third = 1.0 / 3.0
    c0, c1, c2, c3 = coefficient_sums(a1, a2, a3, b1, b2, b3)
    return (c0, third * c1, third * c2, c3)


@compiled
def split(c: Vec4, t: float) -> tuple[Vec4, Vec4]:
    """Return the coefficients of a cubic on [0, t] and on [t, 1], by de Casteljau's algorithm."""
    s = 1.0 - t
    d0 = s * c[0] + t * c[1]
    d1 = s * c[1] + t * c[2]
    d2 = s * c[2] + t * c[3]
    e0 = s * d0 + t * d1
    e1 = s * d1 + t * d2
    middle = s * e0 + t * e1
    return (c[0], d0, e0, middle), (middle, e1, d2, c[3])


@compiled
def _first_crossing(x0: float, y0: float, x1: float, y1: float) -> float:
    """Return where the segment from (x0, y0) to (x1, y1) goes from above 0 to 0; 2 if nowhere."""
    if y0 > 0.0 and not y1 > 0.0:
        return x0 + (x1 - x0) * (y0 / (y0 - y1))
    return 2.0


@compiled
def hull_root_bound(c: Vec4, sign: float, error: float) -> float:
    """Return a lower bound of the roots of a cubic in [0, 1]; 2 means that it has none there.

    The graph of the cubic, times `sign`, lies in the convex hull of the points (k / 3, sign c_k).
    Each point is lowered by `error`, and the result is where the lowered hull first goes down to
    zero. The result is 0 if the lowered hull does not begin above zero.
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


@compiled
def newton_root(c: Vec4, sign: float, error: float) -> float:
    """Return a time at which the cubic, times `sign`, falls to 2 `error`; 2 if none is found.

    This is where Newton's method from time 0 ends. It need not be the first such time.
    """
    c0 = sign * c[0] - 2.0 * error
    c1 = 3.0 * sign * (c[1] - c[0])
    c2 = 3.0 * sign * (c[2] - 2.0 * c[1] + c[0])
    c3 = sign * (c[3] - c[0] + 3.0 * (c[1] - c[2]))
    x = 0.0
    for _ in range(NEWTON_STEPS):
        slope = c1 + x * (2.0 * c2 + 3.0 * x * c3)
        change = (c0 + x * (c1 + x * (c2 + x * c3))) / slope
        x -= change
        if abs(change) < NEWTON_TOLERANCE:
            return x
    return 2.0


@compiled
def root_free_until(c: Vec4, t: float, error: float) -> float:
    """Return a time, not before t, such that the cubic has no root between t and this time.

    The result is 2 if the cubic has no root from t to 1. It is t if nothing is proved.

    At first the time that Newton's method finds is tried: the cubic has no root before it if all
    coefficients up to there have the sign at t. They are those of a subdivided part of a
    subdivision, as below.

    Otherwise each round clips the hull in a window that begins at the time reached so far. The
    first window ends at 1. Each later window is twice as long as the distance to the root that one
    step of Newton's method gives; it ends at 1 if that is nearer, or if there is no such root. In a
    short window the cubic is nearly straight, so the hull is nearly the graph.

    Rounding of the time: `low` is the time reached so far. A round computes it with an error of
    less than 16 u, so a root may lie in the sliver between the exact time and `low`. This root is
    not skipped, for two reasons:

    * If the cubic changes its sign once in the sliver, then its value at `low` is not certain to
      have `sign`, which is the sign at t, and the rounds end. The caller subtracts 16 u, so it
      stays before the root.
    * If the rounds go on after a sliver, the cubic has not changed its sign twice in it. For at
      both ends of the sliver its value, times `sign`, is then at least `error` less the rounding of
      its coefficients, that is 8 u P or more. And |f''| <= 6 * 4 * 6 P = 144 P, so in a width of
      16 u the graph is below its chord by at most 144 P (16 u)^2 / 8, which is far less.
    """
    low = t
    _, rest = split(c, low)
    sign = 1.0 if rest[0] > 0.0 else -1.0
    x = newton_root(rest, sign, error)
    if 0.0 < x < 1.0:
        head, _ = split(rest, x)
        if min(min(sign * head[0], sign * head[1]), min(sign * head[2], sign * head[3])) > error:
            return low + x * (1.0 - low)
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


@compiled
def crosses_soon(c: Vec4, t: float, error: float) -> bool:
    """Return whether the cubic certainly changes its sign within SOON after t.

    The cubic is evaluated where its tangent at t says that it is beyond zero by twice its error.
    """
    _, rest = split(c, t)
    slope = 3.0 * (rest[1] - rest[0])
    step = (abs(rest[0]) + 2.0 * error) / abs(slope)
    if not (step * (1.0 - t) < SOON and step < 1.0 and (rest[0] > 0.0) != (slope > 0.0)):
        return False
    _, after = split(rest, step)
    return after[0] < -error if rest[0] > 0.0 else after[0] > error
