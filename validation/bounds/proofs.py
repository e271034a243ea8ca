"""Bounds of the proofs of detection and of the certificate.

An input is an array of floats: four points at t = 0, then at t = 1, then times and directions. The
points are positions as the program gets them, so the error of their differences counts too.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import TypeAlias

import numpy as np
from flint import fmpq

from izo_ref.base.arrays import Floats, Vec3
from izo_ref.base.formulas.vec3 import det3, lerp3, max_abs3, sum_abs3
from izo_ref.certificate.formulas import meeting
from izo_ref.detection.formulas import advance, coplanar, margin, touching
from validation.bounds.search import Bound, bound_of_floats, hard_floats
from validation.oracles.rational import rational

Exact: TypeAlias = Sequence[fmpq]
Pair: TypeAlias = tuple[Vec3, Vec3, Vec3, Vec3, Vec3, Vec3]
ExactPair: TypeAlias = list[list[fmpq]]
ZERO = fmpq(0)
POINTS = 24  # numbers of an input that are coordinates of points


def _pair(x: Floats) -> Pair:
    """Return nodes 1 to 3 relative to node 0 at t = 0 and t = 1, as the program computes them."""
    points = x[:POINTS].reshape(2, 4, 3)
    relative = (points[:, 1:] - points[:, :1]).reshape(6, 3)
    a1, a2, a3, b1, b2, b3 = map(_vec3, relative)
    return a1, a2, a3, b1, b2, b3


def _vec3(row: Floats) -> Vec3:
    return float(row[0]), float(row[1]), float(row[2])


def _exact_pair(x: Floats) -> ExactPair:
    """Return the same without rounding."""
    points = [[rational(c) for c in p] for p in x[:POINTS].reshape(8, 3).tolist()]
    return [
        [c - d for c, d in zip(points[4 * end + k], points[4 * end], strict=True)]
        for end in range(2)
        for k in (1, 2, 3)
    ]


def _sizes(pair: Pair) -> tuple[float, float, float]:
    m1, m2, m3 = (max(max_abs3(pair[k]), max_abs3(pair[k + 3])) for k in range(3))
    return m1, m2, m3


def _det(a: Exact, b: Exact, c: Exact) -> fmpq:
    return (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )


def _dot(a: Exact, b: Exact) -> fmpq:
    return sum((p * q for p, q in zip(a, b, strict=True)), ZERO)


def _mix(a: Exact, b: Exact, t: fmpq) -> list[fmpq]:
    return [(1 - t) * p + t * q for p, q in zip(a, b, strict=True)]


def _exact_cubic(e: ExactPair) -> list[fmpq]:
    a1, a2, a3, b1, b2, b3 = e
    return [
        _det(a1, a2, a3),
        (_det(b1, a2, a3) + _det(a1, b2, a3) + _det(a1, a2, b3)) / 3,
        (_det(a1, b2, b3) + _det(b1, a2, b3) + _det(b1, b2, a3)) / 3,
        _det(b1, b2, b3),
    ]


def _largest(computed: Sequence[float], exact: Exact, bound: float) -> float:
    """Return the largest error over the bound."""
    errors = (abs(rational(c) - e) for c, e in zip(computed, exact, strict=True))
    return float(max(errors) / rational(bound))


def _cubic_bound(pair: Pair) -> float:
    m1, m2, m3 = _sizes(pair)
    return coplanar.COEFFICIENT_ERROR * (m1 * m2 * m3) + coplanar.TINY


def _sign_ratio(x: Floats) -> float:
    """The sign of one volume, in `crossing.py`."""
    a1, a2, a3, *_ = _pair(x)
    e1, e2, e3, *_ = _exact_pair(x)
    size = max_abs3(a1) * max_abs3(a2) * max_abs3(a3)
    bound = coplanar.COEFFICIENT_ERROR * size + coplanar.TINY
    return _largest([det3(a1, a2, a3)], [_det(e1, e2, e3)], bound)


def _cubic_ratio(x: Floats) -> float:
    """The four coefficients of the cubic, before they are subdivided."""
    pair = _pair(x)
    computed = coplanar.bernstein_coefficients(*pair)
    return _largest(computed, _exact_cubic(_exact_pair(x)), _cubic_bound(pair))


def _split_exact(c: Exact, t: fmpq) -> tuple[list[fmpq], list[fmpq]]:
    rows = [list(c)]
    while len(rows[-1]) > 1:
        rows.append([(1 - t) * p + t * q for p, q in zip(rows[-1], rows[-1][1:], strict=False)])
    return [row[0] for row in rows], [row[-1] for row in reversed(rows)]


def _subdivided_ratio(x: Floats) -> float:
    """The coefficients of a part of a part of the cubic: the whole of the derivation."""
    pair, (t, s) = _pair(x), (abs(v) % 1.0 for v in x[POINTS : POINTS + 2])
    _, rest = coplanar.split(coplanar.bernstein_coefficients(*pair), t)
    head, _ = coplanar.split(rest, s)
    _, exact = _split_exact(_exact_cubic(_exact_pair(x)), rational(t))
    exact, _ = _split_exact(exact, rational(s))
    return _largest(head, exact, _cubic_bound(pair))


def _gap_ratio(x: Floats) -> float:
    """How much of the threshold is used up where a direction is said to separate two nodes."""
    pair = _pair(x)
    n = _vec3(x[POINTS : POINTS + 3])
    threshold = advance.GAP_ERROR * max(_sizes(pair)) * sum_abs3(n) + coplanar.TINY
    until = advance.separated_until(False, n, *pair, 0.0, threshold)
    if until < 0.0:
        return 0.0
    e, time, direction = _exact_pair(x), rational(min(until, 1.0)), [rational(c) for c in n]
    gaps = (-_dot(direction, _mix(e[k], e[k + 3], time)) for k in range(3))
    return float(1 - min(gaps) / rational(threshold))


def _volume_ratio(x: Floats) -> float:
    """The volume at a time, in `meeting.py`."""
    pair, t = _pair(x), abs(x[POINTS]) % 1.0
    e, time = _exact_pair(x), rational(t)
    volume = det3(*(lerp3(pair[k], pair[k + 3], t) for k in range(3)))
    exact = _det(*(_mix(e[k], e[k + 3], time) for k in range(3)))
    return _largest([volume], [exact], _cubic_bound(pair))


def _area_ratio(x: Floats) -> float:
    """The Bernstein coefficients of a signed area between two times, in `meeting.py`."""
    pair, (t, s) = _pair(x), (abs(v) % 1.0 for v in x[POINTS : POINTS + 2])
    m1, m2, _ = _sizes(pair)
    d = _vec3(np.clip(x[POINTS + 2 : POINTS + 5], -1.0, 1.0))
    u0, v0 = lerp3(pair[0], pair[3], t), lerp3(pair[1], pair[4], t)
    u1, v1 = lerp3(pair[0], pair[3], s), lerp3(pair[1], pair[4], s)
    computed = meeting._areas(d, u0, v0, u1, v1)
    e, direction = _exact_pair(x), [rational(c) for c in d]
    ends = [[_mix(e[k], e[k + 3], rational(time)) for k in (0, 1)] for time in (t, s)]
    (p, q), (r, w) = ends
    middle = (_det(direction, p, w) + _det(direction, r, q)) / 2
    exact = [_det(direction, p, q), middle, _det(direction, r, w)]
    return _largest(computed, exact, coplanar.COEFFICIENT_ERROR * (m1 * m2) + coplanar.TINY)


def _slope_ratio(x: Floats) -> float:
    """The slope of a volume at the start, in `touching.py`."""
    *pair, error = touching._scaled(*_pair(x))
    a1, a2, a3, b1, b2, b3 = pair
    slope = (det3(b1, a2, a3) + det3(a1, b2, a3) + det3(a1, a2, b3)) / 3.0
    unit = max(abs(v) for row in pair for v in row) / max(abs(v) for row in _pair(x) for v in row)
    exact = _exact_cubic(_exact_pair(x))[1] * rational(unit) ** 3
    return _largest([slope], [exact], error)


def _axes_margin_ratio(x: Floats) -> float:
    """The margin of a direction over the exact one: above 1, a pair might meet within it."""
    pair = _pair(x)
    gap_error = advance.GAP_ERROR * max(_sizes(pair))
    claimed = margin.axes_margin(False, *pair, gap_error)
    if not claimed > 0.0:
        return 0.0
    e = _exact_pair(x)
    best = ZERO
    for direction in _axes_and_diagonals():
        gap = min(_dot(direction, e[k + 3]) for k in range(3))
        start = min(_dot(direction, e[k]) for k in range(3))
        if start > 0:
            # node 0 and the other node end nearer by r along each axis of the direction
            best = max(best, gap / (2 * sum(abs(c) for c in direction)))
    return float(rational(claimed) / best) if best > 0 else float("inf")


def _axes_and_diagonals() -> list[list[fmpq]]:
    found = []
    for i in range(3):
        for sign in (1, -1):
            axis = [ZERO] * 3
            axis[i] = fmpq(sign)
            found.append(axis)
            for other in (1, -1):
                diagonal = list(axis)
                diagonal[(i + 1) % 3] = fmpq(other)
                found.append(diagonal)
    return found


def _cubic_margin_ratio(x: Floats) -> float:
    """Change of a coefficient for ends that move by the margin, over what it may change."""
    pair = _pair(x)
    m1, m2, m3 = _sizes(pair)
    largest = max(m1, m2, m3)
    error = _cubic_bound(pair)
    cubic = coplanar.bernstein_coefficients(*pair)
    low = max(min(cubic), -max(cubic))
    if not low > error or largest > 1.0:
        return 0.0
    r = rational(margin.cubic_margin(low, m1, m2, m3))
    signs = [1 if v > 0.0 else -1 for v in x[POINTS : POINTS + 12]]
    e = _exact_pair(x)
    moved = [list(row) for row in e]
    for k in range(3):
        for axis in range(3):
            moved[k + 3][axis] += r * (signs[3 * k + axis] - signs[9 + axis])
    sign = 1 if cubic[0] > 0.0 else -1
    least = min(sign * c for c in _exact_cubic(moved))
    return float(1 - least / rational(low))


def _bound(
    name: str,
    file: str,
    sentence: str,
    ratio: Callable[[Floats], float],
    n: int,
    scale: float = 1.0,
) -> Bound:
    draw = partial(_drawn, POINTS + n, scale)
    return bound_of_floats(name, f"izo_ref/{file}", sentence, ratio, draw)


def _drawn(n: int, scale: float, rng: np.random.Generator) -> Floats:
    return scale * hard_floats(rng, n)


CUBIC, MEETING = "detection/formulas/coplanar.py", "certificate/formulas/meeting.py"
BOUNDS = [
    _bound(
        "sign of a volume",
        "detection/formulas/crossing.py",
        "Input, cross and dot are 48 of the 192 u.",
        _sign_ratio,
        0,
    ),
    _bound(
        "coefficients of the cubic", CUBIC, "All but the subdivision: 70 of 192 u.", _cubic_ratio, 0
    ),
    _bound(
        "coefficients of a part of the cubic",
        CUBIC,
        "All but the lowering: 178 of 192 u.",
        _subdivided_ratio,
        2,
    ),
    _bound(
        "gap along a direction",
        "detection/formulas/advance.py",
        "All of the derivation: 36 of 48 u.",
        _gap_ratio,
        3,
    ),
    _bound("volume at a time", MEETING, "120 of 192 u.", _volume_ratio, 1),
    _bound("signed area between two times", MEETING, "96 of 192 u.", _area_ratio, 5),
    _bound(
        "slope of a volume at the start",
        "detection/formulas/touching.py",
        "Input, cross, dot and mean: 70 of 192 u.",
        _slope_ratio,
        0,
    ),
    _bound(
        "margin of axes and diagonals",
        "detection/formulas/margin.py",
        "The margin over the largest one along the best of these directions.",
        _axes_margin_ratio,
        0,
    ),
    _bound(
        "margin of the cubic",
        "detection/formulas/margin.py",
        "The fall of a coefficient, if all nodes end elsewhere by the margin, over its value.",
        _cubic_margin_ratio,
        12,
        0.25,
    ),
]
