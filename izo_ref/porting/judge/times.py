"""Judge `time`: a time of impact may be early by a stated fraction, and never late."""

from __future__ import annotations

from fractions import Fraction

from izo_ref.porting.judge.measure import measured, number_at, tolerance
from izo_ref.porting.judge.outcome import Difference, Question


def judge_time(question: Question) -> list[Difference]:
    """Compare a time: time * (1 - early) - tol <= got <= time + tol."""
    time, tol = number_at(question.expected["time"], 0), tolerance(question)
    late = Fraction(question.got[0]) - Fraction(time)
    if late > tol:
        found = measured(question, 0, time, late, tol)
        return [found._replace(sentence=f"the time is late: {found.sentence}")]
    early = Fraction(time) * Fraction(question.expected["early"])
    if -late > early + tol:
        found = measured(question, 0, time, -late - early, tol)
        return [found._replace(sentence=f"the time is too early: {found.sentence}")]
    return []


def is_early(question: Question) -> bool:
    """Return whether a time is earlier than its rounding explains."""
    time = number_at(question.expected["time"], 0)
    return Fraction(time) - Fraction(question.got[0]) > tolerance(question)
