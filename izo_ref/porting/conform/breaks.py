"""Broken replies: a right reply, changed in one place so that it is wrong."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import Any, TypeAlias

from izo_ref.porting.cases import INVALID, Case
from izo_ref.porting.judge.measure import number_at, tolerance, ulp_of
from izo_ref.porting.judge.outcome import Question
from izo_ref.porting.judge.verdict import REFUSED, STATUS, may_be_left_out, statuses
from izo_ref.porting.stages import FLAG, FLOAT, STAGE, TEXT, Field

Reply: TypeAlias = "dict[str, Any]"
Broken: TypeAlias = "tuple[str, Reply]"


def broken_replies(case: Case, reply: Reply, dtype: str) -> Iterator[Broken]:
    """Yield replies that must fail, each with the way in which it is broken.

    Args:
        case: The case.
        reply: A reply that passes.
        dtype: Type of floats for which it passes.
    """
    yield from _broken_statuses(case, reply)
    output = reply.get("output", {})
    if reply[STATUS] == "ok":
        yield "outputs are a list", {**reply, "output": list(output)}
        yield "unknown output", _with(reply, "not_an_output", 1)
    for field in STAGE[case.stage].outputs:
        if field.name not in case.expected or field.name not in output:
            continue
        if not may_be_left_out(case, field.name):
            rest = {name: value for name, value in output.items() if name != field.name}
            yield "missing output", {**reply, "output": rest}
        yield from _broken_kinds(field, reply)
        yield from _broken_values(case, field, reply, dtype)


def _broken_statuses(case: Case, reply: Reply) -> Iterator[Broken]:
    yield "unknown status", {**reply, STATUS: "fine"}
    yield "status is a number", {**reply, STATUS: 0}
    yield "no status", {name: value for name, value in reply.items() if name != STATUS}
    if REFUSED not in statuses(case):
        yield "refuses good input", {**reply, STATUS: REFUSED}
    if case.verdict == INVALID:
        yield "accepts bad input", {**reply, STATUS: "ok"}


def _with(reply: Reply, name: str, value: Any) -> Reply:
    return {**reply, "output": {**reply["output"], name: value}}


def _broken_kinds(field: Field, reply: Reply) -> Iterator[Broken]:
    """Yield replies whose values are of the wrong kind or number."""
    value = reply["output"][field.name]
    wrong: dict[str, Any] = {"null": None, "true": True, "an object": {}, "a list in a list": [1]}
    if field.kind != TEXT:
        wrong |= {"text": "much", "decimal text": "0.5"}
    if field.kind == FLOAT:
        wrong |= {"NaN": math.nan, "NaN as text": "nan", "infinite": "inf", "overflow": 10**400}
    else:
        wrong["a fraction"] = 0.5
    if not field.shape:
        yield "list for a single value", _with(reply, field.name, [value])
        for name, bad in wrong.items():
            yield f"{name} for a value", _with(reply, field.name, bad)
        return
    yield "value for a list", _with(reply, field.name, 1)
    yield "element added", _with(reply, field.name, [*value, *(value[-1:] or [0])])
    if value:
        yield "element dropped", _with(reply, field.name, value[:-1])
    for i in range(len(value)):
        for name, bad in wrong.items():
            if not isinstance(bad, float) or value[i] == value[i]:
                yield f"{name} for a value", _with(reply, field.name, _put(value, i, bad))


def _put(values: list[Any], i: int, value: Any) -> list[Any]:
    return [*values[:i], value, *values[i + 1 :]]


def _broken_values(case: Case, field: Field, reply: Reply, dtype: str) -> Iterator[Broken]:
    """Yield replies with a value that is wrong by more than the tolerance."""
    value = reply["output"][field.name]
    values = value if field.shape else [value]
    expected, replies = case.expected[field.name], reply["output"]
    question = Question(case, field.name, 1, expected, values, replies, dtype)
    for way, broken in _WAYS[question.expected["judge"]](question, field):
        yield way, _with(reply, field.name, broken if field.shape else broken[0])


Values: TypeAlias = "Iterator[tuple[str, list[Any]]]"


def _beyond(question: Question, i: int, number: float, sign: int) -> list[Any] | None:
    """Return the values with element i a little outside its tolerance; None if no float is."""
    margin = 2 * tolerance(question, i) + 2 * Fraction(ulp_of(number, "f8"))
    try:
        return _put(list(question.got), i, float(Fraction(number) + sign * margin))
    except OverflowError:
        return None


def _bounds(question: Question, i: int, low: float, high: float) -> Values:
    for number, sign in ((low, -1), (high, 1)):
        values = _beyond(question, i, number, sign)
        if values is not None:
            yield "beyond the tolerance", values


def _flipped(question: Question, i: int, low: float, high: float) -> Values:
    got = question.got[i]
    tol = tolerance(question, i)
    if not Fraction(low) - tol <= -Fraction(got) <= Fraction(high) + tol:
        yield "sign flipped", _put(list(question.got), i, -got)


def _break_values(question: Question, field: Field) -> Values:
    for i, value in enumerate(question.expected["values"]):
        if math.isfinite(value):
            yield from _bounds(question, i, value, value)
            yield from _flipped(question, i, value, value)
        else:
            yield "finite where it is not", _put(list(question.got), i, 0.0)


def _break_time(question: Question, field: Field) -> Values:
    time = number_at(question.expected["time"], 0)
    earliest = time * (1.0 - question.expected["early"])
    yield from _bounds(question, 0, earliest, time)
    yield from _flipped(question, 0, earliest, time)


def _break_range(question: Question, field: Field) -> Values:
    low, high = (number_at(question.expected[name], 0) for name in ("low", "high"))
    yield from _bounds(question, 0, low, high)
    yield from _flipped(question, 0, low, high)


def _break_equal(question: Question, field: Field) -> Values:
    for i, value in enumerate(question.expected["values"]):
        if field.kind == FLAG:
            other: Any = 1 - value
        else:
            other = f"{value}x" if isinstance(value, str) else value + 1
        yield "another value", _put(list(question.got), i, other)


def _break_superset(question: Question, field: Field) -> Values:
    pairs = list(question.got)
    for i in range(0, len(pairs), 4):
        yield "pair dropped", pairs[:i] + pairs[i + 4 :]
    faces: Any = question.case.inputs["faces"]
    if faces:
        a, b, c = faces[:3]
        common = [a, a, b, c] if question.expected["kind"] == "vertex-face" else [a, b, b, c]
        yield "pair with a common vertex", [*pairs, *common]
        yield "no vertex", [*pairs, -1, a, b, c]
        yield "no element of the mesh", [*pairs, a, b, 10**9, c]


def _break_partition(question: Question, field: Field) -> Values:
    values = list(question.got)
    fresh = max([0, *values]) + 1
    for i, value in enumerate(values):
        if value == -1:
            yield "group for none", _put(values, i, fresh)
            continue
        yield "none for a group", _put(values, i, -1)
        if values.count(value) > 1:
            yield "group split", _put(values, i, fresh)
        for other in {*values} - {value, -1}:
            yield "put into another group", _put(values, i, other)


def _break_side(question: Question, field: Field) -> Values:
    values = list(question.got)
    yield "longer than 1", [1.01 * value for value in values]
    yield "zero", [0.0] * 3
    least = Fraction(number_at(question.expected["least_gap"], 0))
    if least >= tolerance(question):
        yield "sign flipped", [-value for value in values]


def _break_weights(question: Question, field: Field) -> Values:
    values = list(question.got)
    yield "signs flipped", [-value for value in values]
    yield "order reversed", values[::-1]
    for i, value in enumerate(values):
        yield "sum is not 0", _put(values, i, value + 0.01)


def _break_kkt(question: Question, field: Field) -> Values:
    inputs: Any = question.case.inputs
    values = list(question.got)
    for j, value in enumerate(values):
        yield "negative", _put(values, j, -1.0 - value)
        nodes, weights = (inputs[name][4 * j : 4 * j + 4] for name in ("nodes", "weights"))
        if any(a and not inputs["pinned"][i] for i, a in zip(nodes, weights, strict=True)):
            yield "twice as large", _put(values, j, 1.0 + 2.0 * value)


def _break_free_path(question: Question, field: Field) -> Values:
    inputs: Any = question.case.inputs
    values, proposed = list(question.got), list(inputs["positions_t1"])
    if not question.replies.get("free"):
        return
    if values != proposed:
        yield "proposed path, said to be free", proposed
    for i, pinned in enumerate(inputs["pinned"]):
        if pinned:
            moved = values[3 * i] + 2 * ulp_of(values[3 * i], question.dtype)
            yield "pinned vertex moved", _put(values, 3 * i, moved)


_WAYS: Mapping[str, Any] = {
    "values": _break_values,
    "time": _break_time,
    "range": _break_range,
    "equal": _break_equal,
    "superset": _break_superset,
    "partition": _break_partition,
    "side": _break_side,
    "weights": _break_weights,
    "kkt": _break_kkt,
    "free-path": _break_free_path,
}
