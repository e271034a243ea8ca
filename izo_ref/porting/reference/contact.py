"""The first meeting of a pair, and how well a float can know its time.

Whether a pair meets, and when first, is decided in integers (`izo_ref.base.exact_path`). What is
added here is the scale of the tolerance of the time.

**Scale of the time.** A pair meets at a root t of the cubic f(t) = det(e_1, e_2, e_3), or of a
polynomial of lower degree where f is zero everywhere. A port computes f in floats: from the nodes
relative to the first one, by products and sums. Let E eps bound the rounding of f at t; the running
errors of `Rounded` give E as the sum of the sizes of all intermediate results, with the
coefficients in powers of t, which is the form with the largest terms. A port cannot see a value of
f below E eps. Near a root of multiplicity m,

    f(t + h) = f^(m)(t) h^m / m! + ...,

so all times with |h| <= (m! E eps / |f^(m)(t)|)^(1/m) look like the root. For a simple root, m = 1,
this is eps times the scale E / |f'(t)|. For a double or triple root it falls more slowly than eps,
so the scale depends on eps: it is given for float64, and float32 does not take part. To the first
order in h these are bounds, not estimates; `Meeting.dtypes` leaves out a type of floats if the next
order may matter.
"""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal
from fractions import Fraction
from math import factorial, lcm
from typing import Any, NamedTuple, TypeAlias

from izo_ref.base.algebraic import AlgebraicTime, roots_in_unit_interval, sign_at
from izo_ref.base.exact_path import first_meeting
from izo_ref.porting.reference.rounded import CONTEXT, EPS, Rounded, is_float32

Point: TypeAlias = tuple[float, float, float]
Numbers: TypeAlias = list[Any]  # Fractions, or Rounded

# A time is narrowed to 2^-200, far below the 60 digits of `Rounded`.
TIME_BITS = 200
# `first_meeting` returns a float that is not after the time, and at most 2^-52 before it. Which one
# depends on how narrow the time was enclosed on the way.
NEXT_BELOW = Fraction(1, 2**52)
# A port whose tolerance is larger than this part of the time is not judged.
USELESS = 1e-2
# The time is a number up to 1, so a port rounds it, or 1 minus it, by up to half a unit.
LEAST_SCALE = 0.5


class Pair(NamedTuple):
    """Four nodes on their path: a vertex and a face, or an edge and an edge."""

    is_edge_edge: bool
    start: Sequence[Point]
    end: Sequence[Point]


class Meeting(NamedTuple):
    """The first time at which a pair meets.

    Attributes:
        time: The time, exact up to 2^-200.
        scale: Scale of its tolerance.
        dtypes: Types of floats for which the scale holds and is of use.
    """

    time: Fraction
    scale: float
    dtypes: tuple[str, ...]


def meeting(pair: Pair, multiple: int) -> Meeting | None:
    """Return when a pair first meets, or None.

    Args:
        pair: The pair.
        multiple: The multiple of eps times the scale that a port may be off.
    """
    below = first_meeting(*pair)
    if below is None:
        return None
    exact, rounded = _deciding(pair, Fraction), _deciding(pair, exact_input)
    scale, power, curvature = LEAST_SCALE, 1, 0.0
    at, found = Fraction(below), False
    for polynomial, terms in zip(exact, rounded, strict=True):
        for time in _roots(polynomial):
            root = _narrowed(time)
            if not 0 <= root - Fraction(below) <= NEXT_BELOW:
                continue
            at, found = root, True
            own, m = _scale_at(polynomial, terms, time, at)
            curvature = max(curvature, _curvature(polynomial, at) if m == 1 else 0.0)
            scale, power = max(scale, own), max(power, m)
    if not found and below != 0.0:
        raise AssertionError("the time of a meeting is 0 or a root")
    names = ("f8",) if power > 1 else input_dtypes(pair)
    most = USELESS * min(float(at) or 1.0, 1 / max(curvature, 1.0))
    return Meeting(at, scale, tuple(n for n in names if multiple * EPS[n] * scale < most))


def exact_input(number: float) -> Rounded:
    """Return an input of a case as it is: `input_dtypes` leaves out float32 if that rounds it."""
    return Rounded(Decimal(number))


def input_dtypes(pair: Pair) -> tuple[str, ...]:
    """Return the types of floats that hold all coordinates of a pair."""
    points = [*pair.start, *pair.end]
    return ("f8", "f4") if all(is_float32(x) for p in points for x in p) else ("f8",)


def cubic(pair: Pair) -> list[Fraction]:
    """Return the coefficients of det(e_1, e_2, e_3), the constant first, without rounding."""
    e = _relative(pair, Fraction)
    return _trimmed(_dot(e[0], _cross(e[1], e[2])))


def _relative(pair: Pair, number: Any) -> list[list[Numbers]]:
    """Return e_1, e_2, e_3: three coordinates each, [value at 0, change] of each."""
    start = [[number(float(x)) for x in point] for point in pair.start]
    end = [[number(float(x)) for x in point] for point in pair.end]
    result = []
    for k in (1, 2, 3):
        ends = [(start[k][i] - start[0][i], end[k][i] - end[0][i]) for i in range(3)]
        result.append([[a, b - a] for a, b in ends])
    return result


def _deciding(pair: Pair, number: Any) -> list[Numbers]:
    """Return the polynomials one of which is zero when a pair first meets after t = 0.

    This is the cubic. If it is zero everywhere, the nodes stay coplanar; then these are twice the
    areas of any three of them along each axis, and last the differences of their coordinates.
    """
    e = _relative(pair, number)
    volume = _dot(e[0], _cross(e[1], e[2]))
    if cubic(pair):
        return [volume]
    turns = [_cross(e[0], e[1]), _cross(e[1], e[2]), _cross(e[2], e[0])]
    turns.append(_cross(_minus(e[1], e[0]), _minus(e[2], e[0])))
    areas = [area for turn in turns for area in turn]
    if any(_trimmed(area) for turn in _exact_turns(pair) for area in turn):
        return areas
    return [x for vector in (*e, _minus(e[1], e[0]), _minus(e[2], e[0])) for x in vector]


def _exact_turns(pair: Pair) -> list[list[Numbers]]:
    e = _relative(pair, Fraction)
    return [_cross(e[0], e[1]), _cross(e[1], e[2]), _cross(e[2], e[0])]


def _roots(polynomial: list[Fraction]) -> list[AlgebraicTime]:
    integers = _integers(polynomial)
    return roots_in_unit_interval(integers) if integers else []


def _integers(polynomial: list[Fraction]) -> list[int]:
    """Return a polynomial times the common denominator of its coefficients."""
    unit = lcm(*(c.denominator for c in polynomial))
    return [int(c * unit) for c in _trimmed(polynomial)]


def _narrowed(time: AlgebraicTime) -> Fraction:
    while not time.is_narrower(TIME_BITS):
        time.halve()
    return Fraction(time.high, time.unit)


def _scale_at(
    exact: list[Fraction], rounded: Numbers, time: AlgebraicTime, at: Fraction
) -> tuple[float, int]:
    """Return the scale of a root of a polynomial, and its multiplicity."""
    moment = Rounded(decimal_of(at))
    computed = Rounded(Decimal(0))
    for coefficient in reversed(rounded):
        computed = computed * moment + coefficient
    error = Fraction(computed.error)
    slope, m = _derivative(exact), 1
    while sign_at(_integers(slope), time) == 0:
        slope, m = _derivative(slope), m + 1
    size = error * factorial(m) / abs(_value(slope, at))
    if m == 1 or size == 0:  # without an error, t = 0 and f starts with zeros: floats see that
        return float(size), m
    width, eps = Fraction(1), Fraction(EPS["f8"])
    while (width / 2) ** m > size * eps:  # a power of two, so no root has to be taken
        width /= 2
    return float(width / eps), m


def _curvature(polynomial: list[Fraction], at: Fraction) -> float:
    """Return how fast the slope changes, relative to itself."""
    slope = _derivative(polynomial)
    return float(abs(_value(_derivative(slope), at) / _value(slope, at)))


def decimal_of(number: Fraction) -> Decimal:
    """Return a fraction to 60 digits."""
    return CONTEXT.divide(Decimal(number.numerator), Decimal(number.denominator))


def _value(polynomial: list[Fraction], at: Fraction) -> Fraction:
    return sum((c * at**k for k, c in enumerate(polynomial)), Fraction(0))


def _derivative(polynomial: list[Fraction]) -> list[Fraction]:
    return [k * c for k, c in enumerate(polynomial)][1:]


def _trimmed(polynomial: list[Fraction]) -> list[Fraction]:
    while polynomial and polynomial[-1] == 0:
        polynomial = polynomial[:-1]
    return polynomial


def _times(p: Numbers, q: Numbers) -> Numbers:
    result: Numbers = [0] * (len(p) + len(q) - 1)
    for i, x in enumerate(p):
        for j, y in enumerate(q):
            result[i + j] = x * y + result[i + j]
    return result


def _minus(p: list[Numbers], q: list[Numbers]) -> list[Numbers]:
    """Return the difference of two vectors of polynomials of one degree."""
    return [[x - y for x, y in zip(a, b, strict=True)] for a, b in zip(p, q, strict=True)]


def _cross(p: list[Numbers], q: list[Numbers]) -> list[Numbers]:
    axes = ((1, 2), (2, 0), (0, 1))
    return _minus([_times(p[j], q[k]) for j, k in axes], [_times(p[k], q[j]) for j, k in axes])


def _dot(p: list[Numbers], q: list[Numbers]) -> Numbers:
    x, y, z = (_times(a, b) for a, b in zip(p, q, strict=True))
    return [a + b + c for a, b, c in zip(x, y, z, strict=True)]
