"""The augmented Lagrangian along a line, and the three line searches: stage S8.

phi(s) = L(x + s p) is convex and piecewise quadratic: impact j is active where t > s q, with
t = c + l / mu at x, and q = A p. So its derivative increases and is piecewise linear, and its
breakpoints are t / q. The references sort these. A port may search in any way.

phi(s) - phi(0) is the slope at 0 times s, plus terms that are not negative. Its rounding is that of
these terms. The difference of two values of L has the rounding of L, which can be larger than the
whole change.

Source: docs/method section 4.
"""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal
from typing import NamedTuple

from izo_ref.porting.reference.rounded import CONTEXT, EPS, ZERO, Plain, Rounded, total
from izo_ref.porting.reference.zone import Evaluation, Vector, ZoneNumbers, dot, products

NEAR = Decimal(4 * EPS["f4"])
SIDES = Decimal("0.999999"), Decimal("1.000001")


class Line(NamedTuple):
    """The line x + s p.

    Attributes:
        slope: phi'(0).
        curvature: The second derivative of phi without impacts.
        pushed: c + l / mu of each impact at x.
        along: A p of each impact.
        mu: The penalty.
    """

    slope: Rounded
    curvature: Rounded
    pushed: Sequence[Rounded]
    along: Sequence[Rounded]
    mu: Rounded


class Point(NamedTuple):
    """What `at` finds at a step s.

    Attributes:
        change: phi(s) - phi(0).
        rise: phi'(s).
        second: phi''(s), with the impacts that are active at s.
    """

    change: Rounded
    rise: Rounded
    second: Rounded


class Found(NamedTuple):
    """The result of a search.

    Attributes:
        step: The accepted step; 0 if no step was accepted.
        change: phi(step) - phi(0).
        tried: All steps tried, the accepted one last.
    """

    step: Rounded
    change: Rounded
    tried: list[Rounded]


def line_of(
    zone: ZoneNumbers,
    at_x: Evaluation,
    direction: Sequence[Vector],
    mu: Plain,
    w: Sequence[Rounded],
) -> Line:
    """Return the line from x along a direction, which is 0 at pinned vertices.

    Args:
        zone: The zone.
        at_x: What `lagrangian` computed at x.
        direction: p.
        mu: The penalty.
        w: The curvatures of the objective.
    """
    slope = total(dot(g, p) for g, p in zip(at_x.gradient, direction, strict=True))
    curvature = total(a * dot(p, p) for a, p in zip(w, direction, strict=True))
    return Line(slope, curvature, at_x.pushed, products(zone, direction), Rounded.of(mu))


def at(line: Line, step: Plain) -> Point:
    """Return the change of phi and its derivatives at a step; in its sums nothing cancels."""
    s, values, rises, seconds = Rounded.of(step), [], [], []
    for t, q in zip(line.pushed, line.along, strict=True):
        move = s * q
        if t.value > 0 and t.value > move.value:
            values.append(move * move)
            rises.append(move * q)
            seconds.append(q * q)
        elif t.value > 0:
            values.append(t * (2.0 * move - t))
            rises.append(t * q)
        elif t.value > move.value:
            values.append((t - move) * (t - move))
            rises.append((move - t) * q)
            seconds.append(q * q)
        rises.append(_at_kink(t, move) * q)
    return Point(
        s * (line.slope + 0.5 * line.curvature * s) + 0.5 * line.mu * total(values),
        line.slope + line.curvature * s + line.mu * total(rises),
        line.curvature + line.mu * total(seconds),
    )


def _at_kink(t: Rounded, move: Rounded) -> Rounded:
    """Return 0, with the error of a port that finds the constraint on the other side of a kink."""
    error = CONTEXT.add(t.error, move.error)
    closest = min(abs(t.value), abs(CONTEXT.subtract(t.value, move.value)))
    return Rounded(ZERO, error if closest <= CONTEXT.multiply(error, NEAR) else ZERO)


def backtrack(line: Line, first: Plain, armijo: Plain, shrink: Plain, smallest: Plain) -> Found:
    """Try first, shrink first, ... until the Armijo condition holds; `Decisions` note how clearly.

    Args:
        line: The line.
        first: The step to try first.
        armijo: c_1.
        shrink: Factor of a step that is too long.
        smallest: The search fails when it reaches a smaller step.
    """
    step, tried = Rounded.of(first), []
    while True:
        tried.append(step)
        change = at(line, step).change
        if change < armijo * step * line.slope:
            return Found(step, change, tried)
        step = step * shrink
        if step < smallest:
            return Found(Rounded(ZERO), Rounded(ZERO), tried)


def exact(line: Line) -> Found:
    """Return the minimum of phi; step 0 if phi does not fall."""
    if line.slope.value >= 0:
        return Found(Rounded(ZERO), Rounded(ZERO), [])
    step = _where_rise_is(line, Rounded(ZERO))
    return Found(step, _change_at(line, step), [step])


def wolfe_interval(line: Line, armijo: Plain, wolfe: Plain) -> tuple[Rounded, Rounded] | None:
    """Return the least and the largest step with the strong Wolfe conditions, or None.

    phi is convex. So the Armijo condition holds up to some step, and |phi'| is small enough between
    two steps.

    Args:
        line: The line.
        armijo: c_1.
        wolfe: c_2.
    """
    if line.slope.value >= 0:
        return None
    limit = abs(line.slope) * wolfe
    low, high = _where_rise_is(line, -limit), _where_rise_is(line, limit)
    high = min(high, _where_armijo_ends(line, Rounded.of(armijo)), key=lambda step: step.value)
    return (low, high) if low.value < high.value else None


def change_over(line: Line, low: Rounded, high: Rounded) -> tuple[Rounded, Rounded]:
    """Return the least and the largest phi(s) - phi(0) of the steps from low to high."""
    best = _where_rise_is(line, Rounded(ZERO))
    lowest = min(max(best, low, key=_value), high, key=_value)
    changes = [_change_at(line, step) for step in (low, lowest, high)]
    return changes[1], max(changes[0], changes[2], key=_value)


def _change_at(line: Line, step: Rounded) -> Rounded:
    """Return phi(s) - phi(0) for exactly this step: a port reports that of its own step."""
    return at(line, Rounded(step.value)).change


def _value(number: Rounded) -> Decimal:
    return number.value


def _pieces(line: Line) -> list[tuple[Point, Rounded, Rounded]]:
    """Return where each quadratic piece of phi begins, in order: the point, its step and phi''."""
    kinks = {ZERO}
    for t, q in zip(line.pushed, line.along, strict=True):
        if q.value != 0 and CONTEXT.divide(t.value, q.value) > 0:
            kinks.add(CONTEXT.divide(t.value, q.value))
    begins = sorted(kinks)
    ends = [*begins[1:], CONTEXT.fma(begins[-1], Decimal(2), Decimal(1))]
    pieces = []
    for begin, end in zip(begins, ends, strict=True):
        inside = CONTEXT.divide(CONTEXT.add(begin, end), Decimal(2))
        second = at(line, Rounded(inside)).second
        pieces.append((at(line, Rounded(begin)), Rounded(begin), second))
    return pieces


def _where_rise_is(line: Line, wanted: Rounded) -> Rounded:
    """Return the step at which phi' is `wanted`, which is more than phi'(0)."""
    pieces = _pieces(line)
    before = [piece for piece in pieces if piece[0].rise.value < wanted.value]
    point, begin, second = before[-1]
    step = begin + (wanted - point.rise) / second
    error = CONTEXT.add(at(line, Rounded(step.value)).rise.error, wanted.error)
    return _with_error(line, step, error, None)


def _where_armijo_ends(line: Line, armijo: Rounded) -> Rounded:
    """Return the step from which on the Armijo condition does not hold."""
    lower = armijo * line.slope  # slope of the line below which phi has to be
    pieces = _pieces(line)
    before = [p for p in pieces if p[1].value == 0 or p[0].change.value < (p[1] * lower).value]
    point, begin, second = before[-1]
    height, fall = point.change - begin * lower, point.rise - lower
    step = begin + ((fall * fall - 2.0 * second * height).sqrt() - fall) / second
    end = at(line, Rounded(step.value))
    error = (end.change - Rounded(step.value) * lower).error
    return _with_error(line, step, error, end.rise - lower)


def _with_error(line: Line, step: Rounded, error: Decimal, slope: Rounded | None) -> Rounded:
    """Return a root with the error that a function of this error and slope leaves to it.

    Without a slope, it is phi''. A port may stop on either side of a kink, so this is the smaller
    one of both sides.
    """
    if slope is None:
        sides = (at(line, Rounded(CONTEXT.multiply(step.value, side))).second for side in SIDES)
        slope = min(sides, key=_value)
    of_function = CONTEXT.divide(error, slope.value)
    return Rounded(step.value, CONTEXT.fma(Decimal("0.5"), abs(step.value), of_function))
