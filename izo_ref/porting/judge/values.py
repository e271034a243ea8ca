"""Judges `values`, `equal` and `range`: each element by itself."""

from __future__ import annotations

import math
from fractions import Fraction

from izo_ref.porting.judge.measure import measured, number_at, outside, tolerance
from izo_ref.porting.judge.outcome import Difference, Question


def judge_values(question: Question) -> list[Difference]:
    """Compare floats: |got - value| <= multiple * eps * scale for each element."""
    found = []
    for i, got in enumerate(question.got):
        value = question.expected["values"][i]
        if not math.isfinite(value):
            continue  # `check_finite` has seen that they are the same
        tol = tolerance(question, i)
        error = abs(Fraction(got) - Fraction(value))
        if error > tol:
            found.append(measured(question, i, value, error, tol))
    return found


def judge_equal(question: Question) -> list[Difference]:
    """Compare integers or texts, which must be equal."""
    return [
        question.difference(f"expected {value!r}, got {got!r}", i, value, got)
        for i, (value, got) in enumerate(
            zip(question.expected["values"], question.got, strict=True)
        )
        if value != got and not (value != value and got != got)
    ]


def judge_range(question: Question) -> list[Difference]:
    """Compare floats with bounds: low - tol <= got <= high + tol."""
    expected = question.expected
    found = [
        outside(
            question,
            i,
            number_at(expected["low"], i),
            number_at(expected["high"], i),
            tolerance(question, i),
        )
        for i in range(len(question.got))
    ]
    return [difference for difference in found if difference is not None]
