"""Checks of new cases against the table of the stages. The message names the first offender."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

from izo_ref.base.errors import VectorsError
from izo_ref.porting import parameters
from izo_ref.porting.cases import DTYPES, GRADES, INVALID, VERDICTS, Case
from izo_ref.porting.flags import FLAG
from izo_ref.porting.parameters import JUDGES, STATUS, STATUSES
from izo_ref.porting.stages import FLAG as BIT
from izo_ref.porting.stages import FLOAT, INTEGER, STAGE, TEXT, Field

ID = r"(-[a-z0-9]+)+-[0-9]{2,}"  # what follows the stage in the id of a case
WRONG_SHAPES = "bad-shape"  # cases of this flag may have any lengths
KINDS = {FLOAT: "a float", INTEGER: "an integer", BIT: "0 or 1", TEXT: "a text"}


def check_cases(cases: Iterable[Case], stage: str) -> None:
    """Check all cases of a stage.

    Args:
        cases: The cases.
        stage: Name of the stage.

    Raises:
        VectorsError: A case is wrong; the message says which one and why.
    """
    seen: set[str] = set()
    for case in cases:
        if case.id in seen:
            raise VectorsError(f"{case.id}: expected ids that are unique, found this one twice")
        seen.add(case.id)
        try:
            _check_labels(case, stage)
            counts = _check_inputs(case)
            _check_expected(case, counts)
        except VectorsError as error:
            raise VectorsError(f"{case.id}: {error}") from None


def _require(good: bool, expected: str, found: object) -> None:
    if not good:
        raise VectorsError(f"expected {expected}, found {found!r}")


def _check_labels(case: Case, stage: str) -> None:
    _require(case.stage == stage, f"the stage {stage}", case.stage)
    _require(bool(re.fullmatch(stage + ID, case.id)), f"an id like {stage}-word-01", case.id)
    for flag in case.flags:
        _require(flag in FLAG and FLAG[flag].stages != (), "a flag with stages", flag)
    _require(len(set(case.flags)) == len(case.flags) > 0, "different flags, at least one", case[2])
    _require(case.verdict in VERDICTS, f"a verdict of {', '.join(VERDICTS)}", case.verdict)
    _require(case.grade in GRADES, f"a grade of {', '.join(GRADES)}", case.grade)
    dtypes = [dtype for dtype in DTYPES if dtype in case.dtypes]
    _require(list(case.dtypes) == dtypes != [], "dtypes f8, f4 or both in this order", case.dtypes)
    good = case.what.isascii() and case.what.endswith(".") and "\n" not in case.what
    _require(good, "a sentence of ASCII letters as `what`", case.what)


def _check_inputs(case: Case) -> dict[str, int]:
    """Check the inputs, and return the counts that the letters of shapes stand for."""
    fields = STAGE[case.stage].inputs
    unknown = case.inputs.keys() - {field.name for field in fields}
    _require(not unknown, f"inputs of {case.stage}", ", ".join(sorted(unknown)))
    counts: dict[str, int] = {}
    for field in fields:
        if field.name not in case.inputs:
            _require(field.optional, f"the input {field.name}", "none")
            continue
        value = case.inputs[field.name]
        _check_value(field, value)
        if WRONG_SHAPES not in case.flags:
            _check_length(field, len(value) if isinstance(value, list) else 1, counts)
    return counts


def _check_value(field: Field, value: Any) -> None:
    """Check that a value is a list of the right kind, or one of it where the shape is ()."""
    is_list = field.shape != ()
    what = "a flat list" if is_list else "a single value"
    _require(isinstance(value, list) == is_list, f"{field.name} to be {what}", value)
    for item in value if is_list else [value]:
        good = _is_of_kind(field.kind, item)
        _require(good, f"{KINDS[field.kind]} in {field.name}", item)


def _is_of_kind(kind: str, item: object) -> bool:
    if kind == BIT:
        return type(item) is int and item in (0, 1)
    return type(item) is {FLOAT: float, INTEGER: int, TEXT: str}[kind]


def _check_length(field: Field, length: int, counts: dict[str, int]) -> None:
    """Check a length against a shape, and note the count of a letter that is not known yet."""
    known, letter = 1, ""
    for size in field.shape:
        if isinstance(size, str) and size not in counts:
            letter = size
        else:
            known *= counts[size] if isinstance(size, str) else size
    shape = " x ".join(map(str, field.shape)) or "1"
    if letter:
        _require(length % known == 0, f"{field.name} to have the shape {shape}", length)
        counts[letter] = length // known
    sizes = ", ".join(f"{name} = {count}" for name, count in counts.items())
    where = f"{field.name} to have the shape {shape}{' with ' if sizes else ''}{sizes}"
    _require(letter != "" or length == known, f"{known} elements, for {where}", length)


def _check_expected(case: Case, counts: dict[str, int]) -> None:
    """Check that every expected output is of the stage, and that its judge can judge it."""
    fields = {field.name: field for field in STAGE[case.stage].outputs}
    _require(bool(case.expected), "something to expect", "nothing")
    for name, members in case.expected.items():
        if name == STATUS:
            good = members in [{"judge": "equal", "values": [status]} for status in STATUSES]
            _require(good, "the status ok or refused", members)
            continue
        _require(name in fields, f"an output of {case.stage}", name)
        _check_judge(case.stage, fields[name], members)
        if "values" in members and WRONG_SHAPES not in case.flags:
            _check_length(fields[name], len(members["values"]), counts)
    refused = case.expected.get(STATUS, {}).get("values") == ["refused"]
    _require(refused == (case.verdict == INVALID), "to be refused if and only if invalid", refused)


def _check_judge(stage: str, field: Field, members: Mapping[str, Any]) -> None:
    """Check the members of an expected output."""
    judge = JUDGES.get(members.get("judge", ""))
    if judge is None:
        raise VectorsError(
            f"{field.name}: expected a judge of {', '.join(JUDGES)}, found {members.get('judge')!r}"
        )
    good = judge.judges(stage, field.name, field.kind)
    _require(good, f"a judge that can judge {field.name}", members["judge"])
    names = members.keys() - {"judge"}
    known = judge.parameters | judge.optional
    good = judge.parameters.keys() <= names <= known.keys()
    _require(good, f"members {', '.join(known)} of {field.name}", ", ".join(sorted(names)))
    for name in names:
        what = f"{field.name}.{name} to be {known[name]}"
        _require(_is_parameter(known[name], members[name]), what, members[name])
    if members["judge"] == "values":
        n, scales = len(members["values"]), members["scale"]
        n_scales = len(scales) if isinstance(scales, list) else 1
        _require(n_scales in (1, n), f"1 or {n} scales of {field.name}", n_scales)
    if members["judge"] == "equal":
        for item in members["values"]:
            _require(_is_of_kind(field.kind, item), f"{KINDS[field.kind]} in {field.name}", item)


def _is_parameter(kind: str, value: object) -> bool:
    """Return whether a member of an expected output is of its kind."""
    if kind == parameters.COUNT:
        return type(value) is int and value > 0
    if kind == parameters.PAIR_KIND:
        return value in parameters.PAIR_KINDS
    types = {parameters.INTEGERS: (int,), parameters.WORDS: (int, str)}.get(kind, (float,))
    if isinstance(value, list):
        return kind != parameters.NUMBER and all(type(item) in types for item in value)
    return kind in (parameters.NUMBER, parameters.SCALE) and type(value) is float
