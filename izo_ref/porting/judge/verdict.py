"""The verdict about a reply: reads its outputs and asks the judge of each.

Nothing that a port writes raises an exception here; each mistake is a difference with a sentence.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from izo_ref.porting.cases import ACCEPTABLE, INVALID, Case
from izo_ref.porting.judge import reading
from izo_ref.porting.judge.frame import judge_side, judge_weights
from izo_ref.porting.judge.free_path import judge_free_path
from izo_ref.porting.judge.kkt import judge_kkt
from izo_ref.porting.judge.outcome import (
    FAILED,
    MALFORMED,
    NOT_SUPPORTED,
    PASSED,
    Difference,
    Outcome,
    Question,
)
from izo_ref.porting.judge.partition import judge_partition
from izo_ref.porting.judge.superset import judge_superset
from izo_ref.porting.judge.times import is_early, judge_time
from izo_ref.porting.judge.values import judge_equal, judge_range, judge_values
from izo_ref.porting.stages import STAGE, Field

OK, REFUSED, UNSUPPORTED = "ok", "refused", "unsupported"
STATUS = "status"

JUDGES: dict[str, Callable[[Question], list[Difference]]] = {
    "values": judge_values,
    "equal": judge_equal,
    "superset": judge_superset,
    "time": judge_time,
    "partition": judge_partition,
    "range": judge_range,
    "side": judge_side,
    "weights": judge_weights,
    "kkt": judge_kkt,
    "free-path": judge_free_path,
}
# Optional outputs that may be missing although the case has a value for them: a port may have no
# such thing. All other optional outputs are left out where they have no meaning.
MAY_BE_LEFT_OUT = {("S8", "tried"), ("S10", "step_sizes"), ("S11", "multipliers")}
MAY_BE_LEFT_OUT |= {("S13", "offender")}


def judge(case: Case, reply: Mapping[str, Any], dtype: str) -> Outcome:
    """Judge a reply.

    Args:
        case: The case.
        reply: What the port answered, as JSON holds it: `status`, and `output` with a value for
            each output.
        dtype: Type of floats of the port, `f8` or `f4`.

    Returns:
        The outcome.
    """
    status = reply.get(STATUS)
    if status == UNSUPPORTED:
        return Outcome(NOT_SUPPORTED)
    problem = _status_problem(case, status, reply.get("message"))
    if problem:
        return Outcome(FAILED, (problem,))
    outputs = reply.get("output", {})
    if not isinstance(outputs, Mapping):
        text = f"expected an object with the outputs, got {reading.shown(outputs)}"
        return Outcome(FAILED, (Difference("output", text, cause=MALFORMED),))
    return _judge_outputs(case, outputs, dtype, status == REFUSED)


def statuses(case: Case) -> set[str]:
    """Return the statuses with which a port may answer a case."""
    stated = case.expected.get(STATUS)
    if stated is not None:
        wanted = set(stated["values"])
    else:
        wanted = {REFUSED} if case.verdict == INVALID else {OK}
    return wanted | ({REFUSED} if case.verdict == ACCEPTABLE else set())


def may_be_left_out(case: Case, name: str) -> bool:
    """Return whether a reply is complete without an output for which the case has a value."""
    return case.verdict == INVALID or (case.stage, name) in MAY_BE_LEFT_OUT


def _status_problem(case: Case, status: Any, message: Any) -> Difference | None:
    """Return what is wrong with a status, or None."""
    if not isinstance(status, str) or status not in (OK, REFUSED):
        text = f"expected status 'ok', 'refused' or 'unsupported', got {reading.shown(status)}"
        got = reading.shown(status)
        return Difference(STATUS, text, (), None, got, cause=MALFORMED)
    wanted = statuses(case)
    if status in wanted:
        return None
    if status == REFUSED:
        text = "the port refuses an input that it must answer"
        if message:
            text += f", and says {reading.shown(message)}"
    else:
        text = "the port answers an input that it must refuse"
    return Difference(STATUS, text, (), " or ".join(sorted(wanted)), status)


def _judge_outputs(case: Case, outputs: Mapping[str, Any], dtype: str, refused: bool) -> Outcome:
    """Judge the outputs of a reply with a status that is right."""
    fields = {field.name: field for field in STAGE[case.stage].outputs}
    unknown = [] if refused else [name for name in outputs if name not in fields]
    differences = [
        Difference(
            name,
            f"{case.stage} has no such output; it has {', '.join(fields)}",
            cause=MALFORMED,
        )
        for name in unknown
    ]
    if refused and case.verdict != INVALID:
        return Outcome(PASSED)
    read = {name: _read(case, fields[name], outputs[name]) for name in outputs if name in fields}
    replies = {name: part.values for name, part in read.items() if part.values is not None}
    early = False
    for name, expected in case.expected.items():
        if name == STATUS:
            continue
        found, is_early_time = _judge_output(case, fields[name], expected, read, replies, dtype)
        differences += found
        early = early or is_early_time
    return Outcome(FAILED, tuple(differences)) if differences else Outcome(PASSED, (), early)


def _read(case: Case, field: Field, value: Any) -> reading.Reading:
    """Return the values of an output if they are of the right kind, number and size."""
    expected = case.expected.get(field.name, {})
    length = reading.known_length(case, STAGE[case.stage].inputs, field)
    if isinstance(expected.get("values"), list):
        length = len(expected["values"])
    read = reading.read_output(field, value)
    if read.values is not None:
        read = reading.check_length(field, read.values, length)
    if read.values is not None:
        read = reading.check_finite(field, read.values, expected)
    return read


def _judge_output(
    case: Case,
    field: Field,
    expected: Mapping[str, Any],
    read: Mapping[str, reading.Reading],
    replies: Mapping[str, Sequence[Any]],
    dtype: str,
) -> tuple[Sequence[Difference], bool]:
    """Return the differences of one output, and whether it is an early time."""
    if field.name not in read:
        if may_be_left_out(case, field.name):
            return (), False
        text = "the reply does not have this output"
        return (Difference(field.name, text, cause=MALFORMED),), False
    values = replies.get(field.name)
    if values is None:
        return read[field.name].differences, False
    columns = reading.columns_of(field)
    question = Question(case, field.name, columns, expected, values, replies, dtype)
    found = JUDGES[expected["judge"]](question)
    early = expected["judge"] == "time" and not found and is_early(question)
    return found, early
