"""Say what is true of all wrong answers of an output, such as that they are minus the right ones.

The rules are in `guesses.py`; each looks at one answer. This module asks them about all answers of
the first stage that fails, and writes a sentence if a rule holds for all of them, or for most.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

from izo_ref.porting.conform.guesses import (
    Answer,
    answers_of,
    factor_of,
    is_float32,
    is_zero,
    length_of,
    offset_of,
    orders_of,
    right_parts,
    same_inputs,
    short_digits,
)
from izo_ref.porting.conform.run import Row
from izo_ref.porting.judge.outcome import PASSED
from izo_ref.porting.stages import FLAG, FLOAT

MOST = 0.75  # of the answers
SAME = 1e-5  # how near numbers are that are the same in float32
SHOWN = 2  # hints
LARGEST_NAMED = 1000  # a factor of 1/1000 is named as such
AXES = "xyz"


def hints(rows: Sequence[Row], stage: str, output: str) -> list[str]:
    """Return sentences about the wrong answers of an output; none if they have nothing in common.

    Args:
        rows: The rows of a run.
        stage: The stage.
        output: The output.
    """
    answers = answers_of(rows, stage, output)
    if not answers:
        return []
    if answers[0].field.kind == FLAG:
        return _flags(answers, rows)
    found = _zeros(answers) or _factor(answers)
    for rule in () if found else (_digits, _inputs, _orders, _lengths, _offset, _constant):
        found += rule(answers)
    found = found or _parts(answers)
    return found[:SHOWN]


def _in(count: int, answers: Sequence[Answer]) -> str:
    """Return for how many answers something holds."""
    n = len(answers)
    if n == 1:
        return "in the only request that fails"
    return (
        f"in all {n} requests that fail"
        if count == n
        else f"in {count} of the {n} requests that fail"
    )


def _most(
    answers: Sequence[Answer], rule: Callable[[Answer], Sequence[Any]]
) -> tuple[Any, int] | None:
    """Return what a rule says about most answers, and about how many; None if there is no such."""
    found = Counter(key for answer in answers for key in dict.fromkeys(rule(answer)))
    if not found:
        return None
    key, count = found.most_common(1)[0]
    return (key, count) if count >= MOST * len(answers) else None


def _flags(answers: Sequence[Answer], rows: Sequence[Row]) -> list[str]:
    """Say that flags are all 0 or all 1, of the answers that are right too."""
    field, stage = answers[0].field, answers[0].request.case.stage
    values = {value for answer in answers for value in answer.got}
    if len(values) != 1:
        return []
    (value,) = values
    right = [
        row.request.case.expected.get(field.name, {}).get("values", [])
        for row in rows
        if row.request.case.stage == stage and row.outcome.result == PASSED
    ]
    if {flag for flags in right for flag in flags} <= values:
        return [f"{field.name} is {value} in every reply of this stage, right or wrong."]
    if len(answers) == 1:
        return []
    return [f"{field.name} is {value} {_in(len(answers), answers)}, and never wrongly {1 - value}."]


def _zeros(answers: Sequence[Answer]) -> list[str]:
    found = _most(answers, lambda answer: [True] if is_zero(answer) else [])
    return [f"The answer is zero {_in(found[1], answers)}."] if found else []


def _factor(answers: Sequence[Answer]) -> list[str]:
    """Say that answers are the expected ones times a factor: one for all, or one for each."""
    factors = [(answer, factor) for answer in answers if (factor := factor_of(answer)) is not None]
    if len(factors) < MOST * len(answers):
        return []
    middle = sorted(factor for _, factor in factors)[len(factors) // 2]
    count = sum(math.isclose(factor, middle, rel_tol=SAME) for _, factor in factors)
    name = _named(middle)
    if count >= MOST * len(answers):
        # one number is always some multiple of another one
        is_chance = len(answers) == 1 and len(answers[0].got) == 1 and not name[1]
        if is_chance:
            return []
        if math.isclose(middle, -1.0, rel_tol=SAME):
            return [f"The answer is minus the expected one {_in(count, answers)}."]
        return [f"The answer is {name[0]} the expected one {_in(count, answers)}."]
    rows = [factor for answer, factor in factors if answer.is_row]
    if len(rows) < 2 or len(rows) < MOST * len(answers):
        return []
    low, high = min(rows), max(rows)
    text = f"The answer is a multiple of the expected one {_in(len(rows), answers)}, by factors "
    return [f"{text}from {low:.4g} to {high:.4g}: the direction is right and the size is not."]


def _named(factor: float) -> tuple[str, bool]:
    """Return a factor in words, and whether it is a simple one."""
    for number, form in ((factor, "{} times"), (1.0 / factor, "1/{} of")):
        if not math.isfinite(number):  # the inverse of a number near the least float
            continue
        whole = round(number)
        if 0 < abs(whole) <= LARGEST_NAMED and math.isclose(number, whole, rel_tol=SAME):
            text = form.format(abs(whole))
            return (text if whole > 0 else f"minus {text}"), True
    return f"{factor:.6g} times", False


def _digits(answers: Sequence[Answer]) -> list[str]:
    """Say that numbers were rounded: to few decimal digits, or to a float32."""
    found = _most(answers, short_digits)
    if found:
        text = f"The answer has only {found[0]} decimal digits {_in(found[1], answers)}; print "
        return [f"{text}17 for a float64 and 9 for a float32, or hexadecimal."]
    found = _most(answers, lambda answer: [True] if is_float32(answer) else [])
    if not found:
        return []
    text = f"The answer has only the digits of a float32 {_in(found[1], answers)}: "
    return [f"{text}somewhere a number is kept, computed or read in single precision."]


def _inputs(answers: Sequence[Answer]) -> list[str]:
    found = _most(answers, same_inputs)
    if not found or (len(answers[0].got) == 1 and len(answers) == 1):
        return []
    name = found[0]
    text = f"The answer is the input {name} as it was {_in(found[1], answers)}"
    return [f"{text}: nothing has changed." if name == answers[0].field.name else f"{text}."]


def _orders(answers: Sequence[Answer]) -> list[str]:
    """Say that elements are the expected ones in another order."""
    found = _most(answers, orders_of)
    if not found:
        return []
    order, count = found
    text = "The elements are the expected ones in another order"
    if order == ():
        return [f"{text} {_in(count, answers)}."]
    if answers[0].field.shape[-1] == len(AXES):
        order = "".join(AXES[k] for k in order)
        return [f"{text} {_in(count, answers)}: ({', '.join(order)}) for (x, y, z)."]
    last = ", ".join(map(str, order))
    return [f"{text} {_in(count, answers)}: expected elements {last}, counted from 0."]


def _lengths(answers: Sequence[Answer]) -> list[str]:
    if not answers[0].field.what.startswith("unit vector"):
        return []
    lengths = [length for answer in answers if (length := length_of(answer)) is not None]
    if len(lengths) < MOST * len(answers):
        return []
    low, high = min(lengths), max(lengths)
    size = f"{low:.6g}" if math.isclose(low, high, rel_tol=SAME) else f"{low:.4g} to {high:.4g}"
    return [f"The vector has length {size}, and not 1, {_in(len(lengths), answers)}."]


def _offset(answers: Sequence[Answer]) -> list[str]:
    """Say that times are late or early by the same amount."""
    offsets = [(offset, room) for answer in answers for offset, room in offset_of(answer)]
    if len(answers) < 2 or len(offsets) < MOST * len(answers):
        return []
    middle = sorted(offset for offset, _ in offsets)[len(offsets) // 2]
    count = sum(abs(offset - middle) <= SAME * abs(middle) + room for offset, room in offsets)
    if count < max(2.0, MOST * len(answers)):
        return []
    word = "late" if middle > 0 else "early"
    return [f"The time is {word} by {abs(middle):.6g} {_in(count, answers)}."]


def _constant(answers: Sequence[Answer]) -> list[str]:
    """Say that a number is always the same."""
    field = answers[0].field
    if len(answers) < 2 or field.shape or field.kind != FLOAT:
        return []
    found = _most(answers, lambda answer: [answer.got[0]])
    if not found or len({answer.expected[0] for answer in answers if answer.expected}) < 2:
        return []
    return [f"The answer is {found[0]!r} {_in(found[1], answers)}."] if found[1] > 1 else []


def _parts(answers: Sequence[Answer]) -> list[str]:
    """Say that one element, row or column is right, and the others are wrong."""
    found = _most(answers, right_parts)
    if not found:
        return []
    (kind, index), count = found
    name = {"column": f"{AXES[index % 3]} of each row", "row": f"row {index}"}.get(kind)
    name = name or f"element {index}"
    counted = ", counted from 0" * (kind != "column")
    return [f"Only {name} is right {_in(count, answers)}{counted}."]
