"""Judges `side` and `weights`: properties of a frame where the frame itself is not unique."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from izo_ref.porting.judge.geometry import at_time, combined, dot, vectors
from izo_ref.porting.judge.measure import number_at, ratio, relative_tolerance, tolerance
from izo_ref.porting.judge.outcome import Difference, Question


def judge_side(question: Question) -> list[Difference]:
    """Check a normal: unit length, and N . sum_k a_k x_k(0) >= least_gap - tol."""
    weights = question.replies.get("weights")
    if weights is None or len(weights) != 4:
        return [question.needs("weights")]
    found = []
    normal = [Fraction(number) for number in question.got]
    unit = relative_tolerance(question)
    length_sq = dot(normal, normal)
    if not (1 - unit) ** 2 <= length_sq <= (1 + unit) ** 2:
        length = float(length_sq) ** 0.5 if length_sq < 10**300 else float("inf")
        text = f"the normal has length {length!r}, expected 1"
        difference = question.difference(text, None, 1.0, length)
        found.append(difference._replace(quantity="the length of the normal"))
    inputs: Any = question.case.inputs
    start = vectors(inputs["start"])
    gap, tol = dot(normal, combined(weights, start)), tolerance(question)
    least = Fraction(number_at(question.expected["least_gap"], 0))
    if gap < least - tol:
        text = f"the gap at the start, N . sum a x: expected at least {float(least)!r}, got "
        text += f"{_float(gap)!r}"
        if gap < 0:
            text += "; the normal points to the wrong side"
        found.append(
            question.difference(text, None, float(least), _float(gap))._replace(
                tolerances=ratio(least - gap, tol), quantity="the gap at the start, at least"
            )
        )
    return found


def judge_weights(question: Question) -> list[Difference]:
    """Check weights: signs, sums of both sides, and that the two points are the closest ones."""
    weights = [Fraction(number) for number in question.got]
    small = relative_tolerance(question)
    n_first = 2 if question.case.inputs["is_edge_edge"] else 1
    found = []
    for i, weight in enumerate(weights):
        if (weight if i < n_first else -weight) < -small:
            sign = "positive" if i < n_first else "negative"
            text = f"got {_float(weight)!r}; weights of this side are {sign} or 0"
            found.append(question.difference(text, i, None, _float(weight)))
    for name, side, one in (("first", weights[:n_first], 1), ("second", weights[n_first:], -1)):
        total = sum(side, Fraction(0))
        if abs(total - one) > small:
            quantity = f"the sum of the weights of the {name} side"
            text = f"{quantity}: expected {one}, got {_float(total)!r}"
            difference = question.difference(text, None, one, _float(total))
            found.append(difference._replace(quantity=quantity))
    return found or _distance(question, weights)


def _distance(question: Question, weights: list[Fraction]) -> list[Difference]:
    """Check that the distance of the two points is the least one."""
    inputs: Any = question.case.inputs
    nodes = at_time(vectors(inputs["start"]), vectors(inputs["end"]), inputs["toi"])
    between = combined(weights, nodes)
    distance_sq = dot(between, between)
    tol, least = tolerance(question), Fraction(number_at(question.expected["distance"], 0))
    if max(least - tol, Fraction(0)) ** 2 <= distance_sq <= (least + tol) ** 2:
        return []
    distance = float(distance_sq) ** 0.5
    quantity = "the distance of the two points"
    text = f"{quantity}: expected {float(least)!r}, got {distance!r}"
    if distance_sq > least**2:
        text += "; they are not the closest points"
    return [
        question.difference(text, None, float(least), distance)._replace(
            tolerances=ratio(abs(Fraction(distance) - least), tol), quantity=quantity
        )
    ]


def _float(number: Fraction) -> float:
    """Return the nearest float; infinite if there is none."""
    try:
        return float(number)
    except OverflowError:
        return float("inf") if number > 0 else float("-inf")
