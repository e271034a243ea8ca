"""Read the values of a reply: numbers, hexadecimal floats, flags and texts, in flat lists."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from izo_ref.porting.cases import Case
from izo_ref.porting.judge.outcome import MALFORMED, Difference, element_of
from izo_ref.porting.stages import FLAG, FLOAT, INTEGER, Field

# What printf("%a") writes, with any first digit and in capitals or not.
HEX_FLOAT = re.compile(
    r"[-+]?(0x([0-9a-f]+(\.[0-9a-f]*)?|\.[0-9a-f]+)(p[-+]?\d{1,6})?|inf(inity)?|nan(\(\w*\))?)",
    re.I | re.A,
)
LONGEST = 60  # characters of a value that a sentence shows


class Unreadable(Exception):  # it is raised and caught here alone
    """A value is of the wrong kind; the message says what was expected and what was found."""


class Reading(NamedTuple):
    """The values of an output, or what is wrong with them; `values` is None then."""

    values: Sequence[Any] | None
    differences: tuple[Difference, ...] = ()


def shown(value: Any) -> str:
    """Return a value of a reply as JSON would write it, shortened."""
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    if isinstance(value, list):
        return f"a list of {len(value)}"
    if isinstance(value, dict):
        return "an object"
    try:
        text = repr(value)
    except ValueError:  # Python does not print integers of thousands of digits
        return "an integer that is too large to print"
    return text if len(text) <= LONGEST else text[:LONGEST] + "..."


def read_float(value: Any) -> float:
    """Return the float that a JSON number or a hexadecimal text is.

    Raises:
        Unreadable: It is something else.
    """
    if value is None:
        raise Unreadable("expected a number, got null; write NaN as the text 'nan'")
    try:
        if isinstance(value, int | float) and not isinstance(value, bool):
            return float(value)
        if isinstance(value, str) and HEX_FLOAT.fullmatch(value):
            return math.nan if "nan" in value.lower() else float.fromhex(value)
    except OverflowError:
        raise Unreadable(f"{shown(value)} is larger than any float64") from None
    except ValueError:
        pass
    raise Unreadable(
        f"expected a number, or a text in C's hexadecimal notation such as '0x1.8p+0', got "
        f"{shown(value)}"
    )


def read_value(field: Field, value: Any) -> float | int | str:
    """Return one value of an output.

    Raises:
        Unreadable: It is of the wrong kind.
    """
    if field.kind == FLOAT:
        return read_float(value)
    if field.kind in (INTEGER, FLAG):
        if not isinstance(value, int) or isinstance(value, bool):
            raise Unreadable(f"expected an integer, got {shown(value)}")
        if field.kind == FLAG and value not in (0, 1):
            raise Unreadable(f"expected 0 or 1, got {shown(value)}")
        return value
    if not isinstance(value, str):
        raise Unreadable(f"expected a text, got {shown(value)}")
    return value


def columns_of(field: Field) -> int:
    """Return the length of a row of an array, 1 for a vector, 0 for a single value."""
    if not field.shape:
        return 0
    if len(field.shape) == 1:
        return 1
    columns = field.shape[1]
    assert isinstance(columns, int), field
    return columns


def read_output(field: Field, value: Any) -> Reading:
    """Return the values of an output as a flat list, or what is wrong with them."""
    columns = columns_of(field)
    if columns == 0:
        if isinstance(value, list):
            return _wrong(field, f"expected a single value, got {shown(value)}")
        value = [value]
    elif not isinstance(value, list):
        return _wrong(field, f"expected a flat list, got {shown(value)}")
    values, differences = [], []
    for i, item in enumerate(value):
        try:
            values.append(read_value(field, item))
        except Unreadable as error:
            advice = "; arrays are flat, row by row" if isinstance(item, list) else ""
            element = element_of(i, columns)
            text, got = f"{error}{advice}", shown(item)
            found = Difference(field.name, text, element, got=got, cause=MALFORMED)
            differences.append(found)
    return Reading(None, tuple(differences)) if differences else Reading(values)


def _wrong(field: Field, sentence: str) -> Reading:
    return Reading(None, (Difference(field.name, sentence, cause=MALFORMED),))


def known_length(case: Case, fields: Sequence[Field], field: Field) -> int | None:
    """Return how many values an output has by its shape; None if a case does not fix that.

    Args:
        case: The case, whose inputs fix the counts n and m.
        fields: The inputs of the stage.
        field: The output.
    """
    counts: dict[str | int, int] = {}
    for given in fields:
        value = case.inputs.get(given.name)
        if given.shape and isinstance(value, list):
            counts.setdefault(given.shape[0], len(value) // columns_of(given))
    if not field.shape:
        return 1
    first = field.shape[0]
    rows = first if isinstance(first, int) else counts.get(first)
    return None if rows is None else rows * columns_of(field)


def check_length(field: Field, values: Sequence[Any], length: int | None) -> Reading:
    """Return the values if there are as many as expected."""
    columns = columns_of(field)
    if length is not None and len(values) != length:
        return _wrong(field, f"expected {length} values, got {len(values)}")
    if columns > 1 and len(values) % columns:
        return _wrong(field, f"expected rows of {columns} values, got {len(values)} values in all")
    return Reading(values)


def check_finite(field: Field, values: Sequence[Any], expected: Mapping[str, Any]) -> Reading:
    """Return the values if all are finite, except where the same NaN or infinity is expected."""
    wanted = expected.get("values")
    differences = []
    for i, value in enumerate(values):
        if not isinstance(value, float) or math.isfinite(value):
            continue
        target = wanted[i] if isinstance(wanted, list) and i < len(wanted) else None
        same = isinstance(target, float) and (value == target or (value != value != target))
        if not (same and not math.isfinite(target or 0.0)):
            at = element_of(i, columns_of(field))
            text = f"got {value!r} where a finite number is expected"
            found = Difference(field.name, text, at, target, value, cause=MALFORMED)
            differences.append(found)
    return Reading(None, tuple(differences)) if differences else Reading(values)
