"""Errors in multiples of the tolerance and in units of the last place, without rounding."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from izo_ref.porting.judge.outcome import Difference, Question

MOST_ULPS = 1e6  # more of them say nothing


def number_at(numbers: Any, i: int) -> float:
    """Return entry i of a list, the only entry of a list, or a number that stands for all."""
    if not isinstance(numbers, Sequence):
        return numbers
    return numbers[0] if len(numbers) == 1 else numbers[i]


def relative_tolerance(question: Question) -> Fraction:
    """Return multiple * eps; `multiple_f8` and `multiple_f4` come before `multiple`."""
    expected = question.expected
    multiple = expected.get(f"multiple_{question.dtype}", expected.get("multiple"))
    return Fraction(multiple) * Fraction(question.eps)


def tolerance(question: Question, i: int = 0, name: str = "scale") -> Fraction:
    """Return multiple * eps * scale for an element.

    Args:
        question: The question.
        i: The element.
        name: Name of the scale in what the case says about the output.
    """
    return relative_tolerance(question) * Fraction(number_at(question.expected[name], i))


def ulp_of(number: float, dtype: str) -> float:
    """Return the unit of the last place of a number in a type of floats."""
    if dtype == "f8":
        return math.ulp(number)
    return 2.0 ** max(math.frexp(number)[1] - 24, -149)


def ratio(a: Fraction, b: Fraction) -> float:
    """Return a / b as a float; infinite if b is 0 or the quotient is too large."""
    if b == 0:
        return math.inf if a else 0.0
    try:
        return float(a / b)
    except OverflowError:
        return math.inf


def measured(question: Question, i: int, expected: float, error: Fraction, tol: Fraction) -> Any:
    """Return the difference for a number that misses its tolerance."""
    got = question.got[i]
    ulps = None
    if expected != 0:
        ulps = ratio(error, Fraction(ulp_of(expected, question.dtype)))
    tolerances = ratio(error, tol)
    sentence = f"expected {expected!r}, got {got!r}: "
    sentence += f"{tolerances:.3g} times the tolerance" if tol else "no error is allowed here"
    if ulps is not None and ulps <= MOST_ULPS:
        sentence += f", {ulps:.3g} ulps"
    if error and expected and Fraction(got) == -Fraction(expected):
        sentence += "; the sign is wrong"
    return Difference(
        question.output, sentence, question.element(i), expected, got, ulps, tolerances
    )


def outside(question: Question, i: int, low: float, high: float, tol: Fraction) -> Any:
    """Return the difference for a number outside [low - tol, high + tol], or None."""
    got = Fraction(question.got[i])
    if got < Fraction(low) - tol:
        return measured(question, i, low, Fraction(low) - got, tol)
    if got > Fraction(high) + tol:
        return measured(question, i, high, got - Fraction(high), tol)
    return None
