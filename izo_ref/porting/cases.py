"""The format of the vectors: cases in JSON, floats in hexadecimal, sums beside them.

A file holds the cases of one stage, one case a line:

    {"version": 1, "stage": "S9", "cases": [
    {"id": "S9-multipliers-not-clamped-01", "stage": "S9", "flags": ["multipliers-not-clamped"],
     "verdict": "valid", "grade": "easy", "dtypes": ["f8", "f4"], "what": "...",
     "input": {"multipliers": ["0x1p+0"], ...},
     "expected": {"multipliers": {"judge": "values", "values": [...], ...}}},
    ...]}

Arrays are flat lists, row by row; `stages.py` has their shapes. A float is a string in C's
hexadecimal notation, which `strtod` reads ("0x1.8p+0", "inf", "nan"); integers and flags are JSON
integers. An array of more than `LARGE` numbers is a file of its own: {"npy": "name.npy"}.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias

Value: TypeAlias = "float | int | str | list[float] | list[int]"

VALID, INVALID, ACCEPTABLE = "valid", "invalid", "acceptable"
VERDICTS = {
    VALID: "the port must answer, and its answer must pass",
    INVALID: "the input is bad, and a port must refuse it",
    ACCEPTABLE: "several answers are right, or the case is too near to a tie for floats: a port "
    "may refuse, and any other answer must have the stated properties",
}
GRADES = ("easy", "medium", "hard")
DTYPES = ("f8", "f4")
LARGE = 2000  # numbers; a longer array is a file of its own
HEX = re.compile(r"-?(0x[01](\.[0-9a-f]+)?p[+-]\d+|inf)|nan")


class Case(NamedTuple):
    """One case of a stage.

    Attributes:
        id: `S7-kink-below-01`: the stage, words, a number.
        stage: Name of the stage.
        flags: Names of the mistakes that the case catches (`flags.py`), the most likely one first.
        verdict: VALID, INVALID or ACCEPTABLE.
        grade: `easy`, `medium` or `hard`.
        dtypes: Types of floats for which the case has a meaning.
        what: A sentence that says what is special about the case.
        inputs: Value of each input of the stage; arrays are flat lists.
        expected: For each output, `{"judge": name, ...}` with what the judge needs. The name
            `status` stands for whether the port answers (`ok`) or refuses (`refused`).
    """

    id: str
    stage: str
    flags: tuple[str, ...]
    verdict: str
    grade: str
    dtypes: tuple[str, ...]
    what: str
    inputs: Mapping[str, Value]
    expected: Mapping[str, Mapping[str, Any]]


def hexadecimal(number: float) -> str:
    """Return a float in C's hexadecimal notation, without trailing zeros."""
    if not math.isfinite(number):
        return "nan" if math.isnan(number) else ("inf" if number > 0 else "-inf")
    head, _, exponent = number.hex().partition("p")
    if "." in head:
        head = head.rstrip("0").rstrip(".")
    return f"{head}p{exponent}"


def encode(value: Any) -> Any:
    """Return a value as JSON holds it: floats in hexadecimal, everything else as it is."""
    if isinstance(value, bool):
        raise TypeError("flags are written as 0 and 1")
    if isinstance(value, float):
        return hexadecimal(value)
    if isinstance(value, list | tuple):
        return [encode(item) for item in value]
    if isinstance(value, Mapping):
        return {name: encode(item) for name, item in value.items()}
    if isinstance(value, int | str):
        return value
    raise TypeError(f"expected a float, an integer, a text or a list, got {value!r}")


def decode(value: Any) -> Any:
    """Return a value from what JSON holds: the opposite of `encode`."""
    if isinstance(value, str):
        return float.fromhex(value) if HEX.fullmatch(value) else value
    if isinstance(value, list):
        return [decode(item) for item in value]
    if isinstance(value, dict):
        return {name: decode(item) for name, item in value.items()}
    return value


def case_line(case: Case) -> str:
    """Return a case as one line of JSON."""
    record = {
        "id": case.id,
        "stage": case.stage,
        "flags": list(case.flags),
        "verdict": case.verdict,
        "grade": case.grade,
        "dtypes": list(case.dtypes),
        "what": case.what,
        "input": encode(case.inputs),
        "expected": encode(case.expected),
    }
    return json.dumps(record, allow_nan=False, separators=(",", ":"))


def require_cases(cases: Sequence[Case], stage: str) -> None:
    """Check the members of cases that every reader relies on.

    Args:
        cases: The cases that were read from the file of a stage.
        stage: Name of the stage.

    Raises:
        ValueError: A member has another type or value; names the first case.
    """
    seen: set[str] = set()
    for i, case in enumerate(cases):
        texts = (case.id, case.stage, case.verdict, case.grade, case.what, *case.flags)
        if not all(isinstance(text, str) for text in (*texts, *case.dtypes)):
            raise ValueError(f"case {i}: expected texts in all members but input and expected")
        if case.stage != stage or case.id.partition("-")[0] != stage or case.id in seen:
            raise ValueError(f"case {i}: expected a new id of {stage}, got {case.id!r}")
        seen.add(case.id)
        known = case.verdict in VERDICTS and case.grade in GRADES
        if not known or not case.dtypes or not set(case.dtypes) <= set(DTYPES):
            raise ValueError(f"{case.id}: verdict, grade or dtypes are none of the known ones")
        if not isinstance(case.inputs, dict) or not isinstance(case.expected, dict):
            raise ValueError(f"{case.id}: expected objects as input and expected")
        for name, judge in case.expected.items():
            if not isinstance(judge, dict) or not isinstance(judge.get("judge"), str):
                raise ValueError(f"{case.id}: {name}: expected an object that names its judge")


def case_of(record: Mapping[str, Any]) -> Case:
    """Return the case that a record of JSON describes."""
    return Case(
        record["id"],
        record["stage"],
        tuple(record["flags"]),
        record["verdict"],
        record["grade"],
        tuple(record["dtypes"]),
        record["what"],
        decode(record["input"]),
        decode(record["expected"]),
    )
