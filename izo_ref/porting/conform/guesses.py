"""Rules that look at one wrong answer: is it minus the right one, a multiple, an input, ...?

Each rule compares the answer with the expected one within a few tolerances of the case.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Sequence
from itertools import permutations
from typing import Any, NamedTuple

from izo_ref.porting.conform.protocol import Request
from izo_ref.porting.conform.run import Row
from izo_ref.porting.judge.measure import number_at, relative_tolerance
from izo_ref.porting.judge.outcome import FAILED, WRONG, Question
from izo_ref.porting.judge.reading import columns_of, read_output
from izo_ref.porting.reference.rounded import EPS, to_float32
from izo_ref.porting.stages import FLOAT, STAGE, Field

ROOM = 4.0  # tolerances within which numbers count as the same
CLEAR = 1e3  # tolerances from zero to a number that says something
SHORT = (6, 7, 8)  # digits of %f, %g and of careful float32s
WIDER = EPS["f4"] / EPS["f8"]  # tolerances of float32 in those of float64
BETTER = 2.0**12  # how much better than its tolerance a computation in float32 may be
FLOAT32_AT_MOST = 1e-4  # relative error of a float32
LARGEST = sys.float_info.max
WIDE = 3  # a row of a vector
FEW = 4  # elements of which every order is tried


class Answer(NamedTuple):
    """What a port answers for one output of a request, beside what is expected.

    Attributes:
        request: The request.
        field: The output.
        got: The answer, a flat list.
        expected: The expected answer; empty if the case states properties instead.
        tolerances: The tolerance of each element; empty if there is none.
    """

    request: Request
    field: Field
    got: Sequence[Any]
    expected: Sequence[Any]
    tolerances: Sequence[float]

    @property
    def columns(self) -> int:
        """Length of a row; 0 for a single value."""
        return columns_of(self.field)

    @property
    def is_row(self) -> bool:
        """Whether at least two expected elements are clearly not zero."""
        return sum(map(self.is_clear, range(len(self.expected)))) > 1

    def is_clear(self, i: int) -> bool:
        """Return whether an expected element is clearly not zero."""
        return abs(self.expected[i]) > CLEAR * self.tolerances[i]

    def is_same(self, i: int, number: float) -> bool:
        """Return whether a number is the expected element i."""
        return abs(number - self.expected[i]) <= ROOM * self.tolerances[i]


def answers_of(rows: Sequence[Row], stage: str, output: str) -> list[Answer]:
    """Return the wrong answers of an output that can be read and that are finite.

    Args:
        rows: The rows of a run.
        stage: The stage.
        output: The output.
    """
    fields = {field.name: field for field in STAGE[stage].outputs}
    if output not in fields:
        return []
    return [
        answer
        for row in rows
        if row.request.case.stage == stage and row.outcome.result == FAILED
        if any(d.output == output and d.cause == WRONG for d in row.outcome.differences)
        if (answer := _answer_of(row, fields[output])) is not None
    ]


def _answer_of(row: Row, field: Field) -> Answer | None:
    outputs = row.reply.get("output", {}) if row.reply else {}
    got = read_output(field, outputs.get(field.name)).values
    case, dtype = row.request
    members = case.expected.get(field.name)
    if members is None or got is None or not _finite(got):
        return None
    wanted = members.get("values") if members["judge"] in ("values", "equal") else None
    wanted = [number_at(members["time"], 0)] if members["judge"] == "time" else wanted or []
    if wanted and (len(wanted) != len(got) or not _finite(wanted)):
        return None
    tolerances = [0.0] * len(wanted)
    if "scale" in members:
        question = Question(case, field.name, 0, members, got, {}, dtype)
        relative = float(relative_tolerance(question))
        tolerances = [relative * number_at(members["scale"], i) for i in range(len(wanted))]
    return Answer(row.request, field, got, wanted, tolerances)


def _finite(values: Sequence[Any]) -> bool:
    """Return whether all values are finite numbers that a float can hold."""
    return all(isinstance(value, float | int) and abs(value) <= LARGEST for value in values)


def is_zero(answer: Answer) -> bool:
    """Return whether an answer is zero and must not be."""
    n = len(answer.expected)
    return not any(answer.got) and bool(n) and any(map(answer.is_clear, range(n)))


def factor_of(answer: Answer) -> float | None:
    """Return by what all expected elements are multiplied in the answer; None if by nothing."""
    indices = range(len(answer.expected))
    if answer.field.kind != FLOAT or not answer.expected:
        return None
    top = max(indices, key=lambda i: abs(answer.expected[i]))
    if not answer.is_clear(top):
        return None
    factor = answer.got[top] / answer.expected[top]
    if factor == 0.0 or not math.isfinite(factor) or math.isclose(factor, 1.0, rel_tol=1e-6):
        return None
    slack = abs(factor) * ROOM + ROOM
    for i in indices:
        if abs(answer.got[i] - factor * answer.expected[i]) > slack * answer.tolerances[i]:
            return None
    return factor


def is_float32(answer: Answer) -> bool:
    """Return whether an answer in float64 is as near to the expected one as a float32 is.

    The tolerance of a case is the error of a computation in float64. One in float32 makes an error
    that is larger by the quotient of the two epsilons.
    """
    if answer.request.dtype != "f8" or not answer.expected or answer.field.kind != FLOAT:
        return False
    if all(to_float32(number) == number for number in answer.expected):
        return False
    largest = max(map(abs, answer.expected))
    ratios = []
    for got, expected, tol in zip(answer.got, answer.expected, answer.tolerances, strict=True):
        error = abs(got - expected)
        if tol and error > tol:
            ratios.append(error / tol)
        if error > FLOAT32_AT_MOST * largest or (not tol and error):
            return False
    all_short = all(to_float32(number) == number for number in answer.got)
    worst = max(ratios, default=0.0)
    return worst < ROOM * WIDER and (all_short or worst > WIDER / BETTER)


def short_digits(answer: Answer) -> list[int]:
    """Return how many decimal digits an answer has, if they are those of the right one."""
    if not answer.expected or answer.field.kind != FLOAT:
        return []
    return [
        digits
        for digits in SHORT
        if all(float(f"{number:.{digits}g}") == number for number in answer.got)
        and all(
            abs(got - expected) <= 0.6 * 10.0 ** (1 - digits) * abs(expected) + ROOM * tol
            for got, expected, tol in zip(
                answer.got, answer.expected, answer.tolerances, strict=True
            )
        )
    ][:1]


def same_inputs(answer: Answer) -> list[str]:
    """Return the names of the inputs that the answer repeats; one of the same name comes first."""
    case, dtype = answer.request
    found = []
    for field in STAGE[case.stage].inputs:
        value: Any = case.inputs.get(field.name)
        if field.kind != FLOAT or value is None:
            continue
        numbers = value if isinstance(value, list) else [value]
        if dtype == "f4":
            numbers = [to_float32(number) for number in numbers]
        if any(numbers) and numbers == [*answer.got]:
            found.append(field.name)
    return sorted(found, key=lambda name: name != answer.field.name)


def orders_of(answer: Answer) -> list[tuple[int, ...]]:
    """Return the orders of the expected elements, or of each row, that give the answer.

    The empty order stands for some order of many elements.
    """
    n = len(answer.expected)
    if n < 2 or answer.field.kind != FLOAT:
        return []
    width = answer.columns if answer.columns == WIDE else n
    if width <= FEW:
        return [
            order
            for order in permutations(range(width))
            if order != tuple(range(width))
            and all(
                answer.is_same(i - i % width + order[i % width], answer.got[i]) for i in range(n)
            )
        ]
    by_size = sorted(range(n), key=lambda i: answer.expected[i])
    pairs = zip(by_size, sorted(answer.got), strict=True)
    return [()] if all(answer.is_same(i, number) for i, number in pairs) else []


def length_of(answer: Answer) -> float | None:
    """Return the length of a vector that is not of length 1 and not zero; None otherwise."""
    length = math.hypot(*answer.got)
    return None if length < 1e-300 or math.isclose(length, 1.0, rel_tol=1e-4) else length


def offset_of(answer: Answer) -> list[tuple[float, float]]:
    """Return by how much a time is late, and the room for rounding; nothing for other outputs."""
    case = answer.request.case
    if case.expected[answer.field.name]["judge"] != "time":
        return []
    return [(answer.got[0] - answer.expected[0], ROOM * answer.tolerances[0])]


def right_parts(answer: Answer) -> list[tuple[str, int]]:
    """Return the elements, rows or columns that are right while all others are wrong."""
    n, width = len(answer.expected), answer.columns
    if not n or answer.field.kind != FLOAT:
        return []
    kinds = ("column", "row") if width == WIDE else ("element",)
    return [part for kind in kinds for part in _right_part(answer, kind, width)]


def _right_part(answer: Answer, kind: str, width: int) -> Iterator[tuple[str, int]]:
    """Yield the only part of a kind that is right, if no other is and there are enough others."""
    key = {"column": lambda i: i % width, "row": lambda i: i // width}.get(kind, lambda i: i)
    parts: dict[int, list[bool]] = {}
    for i, number in enumerate(answer.got):
        if answer.is_clear(i) or not answer.is_same(i, number):
            parts.setdefault(key(i), []).append(answer.is_same(i, number))
    right = [part for part, same in parts.items() if all(same)]
    if len(right) == 1 and len(parts) > 1:
        yield kind, right[0]
