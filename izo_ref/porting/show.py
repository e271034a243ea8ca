"""A case of the vectors as a person reads it."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from izo_ref.porting.cases import VERDICTS, Case, hexadecimal
from izo_ref.porting.flags import FLAG
from izo_ref.porting.parameters import JUDGES, STATUS
from izo_ref.porting.reading import shown_lines, shown_page
from izo_ref.porting.reference.rounded import EPS
from izo_ref.porting.stages import STAGE, Field

WIDTH = 96
ROWS = 12  # of an array; the others are counted
WORDS = {"f": "floats", "i": "integers", "b": "flags", "s": "texts"}


def case_text(case: Case, rows: int | None = ROWS) -> str:
    """Return a description of a case: what it catches, its arrays, its answer, where to read.

    Args:
        case: The case.
        rows: Largest number of rows of an array that are shown; all if None.
    """
    stage = STAGE[case.stage]
    limits = {dtype: EPS[dtype] for dtype in case.dtypes}
    fields = {field.name: field for field in stage.outputs}
    lines = [
        f"{case.id}: {stage.title} ({case.grade}, {case.verdict}, {' and '.join(case.dtypes)})",
        *_wrapped(case.what),
        *_wrapped(f"{case.verdict}: {VERDICTS[case.verdict]}."),
        *_wrapped(f"{stage.name}: {stage.formula}"),
        "",
        "mistakes that it catches",
    ]
    for name in case.flags:
        lines += [f"  {name}", *_flag_lines(name)]
    lines += ["", "input"]
    for field in stage.inputs:
        if field.name in case.inputs:
            lines += _input_lines(field, case.inputs[field.name], rows)
    lines += ["", "expected"]
    for name, members in case.expected.items():
        lines += _expected_lines(name, fields.get(name), members, limits, rows)
    lines += ["", "read", f"  {shown_page(stage)}", f"  {shown_lines(stage)}"]
    return "\n".join(lines)


def _wrapped(text: str, indent: int = 0) -> list[str]:
    margin = " " * indent
    return textwrap.wrap(text, WIDTH, initial_indent=margin, subsequent_indent=margin)


def _flag_lines(name: str) -> list[str]:
    flag = FLAG[name]
    texts = (f"Mistake: {flag.mistake}", f"Harm: {flag.harm}", f"Seen: {flag.seen}")
    return [line for text in texts for line in _wrapped(text, 4)]


def _input_lines(field: Field, value: Any, rows: int | None) -> list[str]:
    """Return the lines of an input: what it is, then its numbers in decimals and as they are."""
    head = f"  {field.name}{_shape(field, value)}{_unit(field)}: {field.what}"
    if not isinstance(value, list):
        return [head, f"    {_single(value)}"]
    return [head, *_at_most(_number_lines(value, _width(field)), rows)]


def _single(value: Any) -> str:
    """Return a number in decimals and as it is in the files."""
    return f"{value:.17g}  {hexadecimal(value)}" if isinstance(value, float) else str(value)


def _unit(field: Field) -> str:
    return f" [{field.unit}]" if field.unit else ""


def _shape(field: Field, value: Any) -> str:
    """Return the shape of an array with its counts, or nothing for a single value."""
    if not field.shape:
        return ""
    letters = " x ".join(map(str, field.shape))
    width = _width(field)
    if len(value) % width or not isinstance(field.shape[0], str):
        return f" ({letters}, {len(value)} {WORDS[field.kind]})"
    return f" ({letters}, {field.shape[0]} = {len(value) // width})"


def _width(field: Field) -> int:
    """Return how many numbers belong into one row."""
    last = field.shape[-1] if field.shape else 1
    return last if isinstance(last, int) else 1


def _number_lines(items: Sequence[Any], width: int) -> list[str]:
    """Return one line a row: decimals, then floats in hexadecimal."""
    if not any(isinstance(item, float) for item in items) and width == 1:
        return _wrapped(" ".join(map(str, items)) or "none", 4)
    texts = [f"{item:.9g}" if isinstance(item, float) else str(item) for item in items]
    size = max(map(len, texts), default=0)
    lines = []
    for begin in range(0, len(items), width):
        row = slice(begin, begin + width)
        line = "    " + " ".join(text.rjust(size) for text in texts[row])
        if isinstance(items[begin], float):
            line += "   " + " ".join(hexadecimal(item) for item in items[row])
        lines.append(line)
    return lines or ["    none"]


def _at_most(lines: list[str], rows: int | None) -> list[str]:
    if rows is None or len(lines) <= rows:
        return lines
    return [*lines[:rows], f"    ... and {len(lines) - rows} more rows, which --all shows"]


def _expected_lines(
    name: str,
    field: Field | None,
    members: Mapping[str, Any],
    limits: Mapping[str, float],
    rows: int | None,
) -> list[str]:
    """Return the lines of an expected output: its judge, its values, and the tolerances."""
    judge = JUDGES[members["judge"]]
    if field is None or name == STATUS:
        return [f"  {name}: {members['values'][0]}"]
    values = members.get("values")
    shape = _shape(field, values) if isinstance(values, list) else ""
    lines = [f"  {name}{shape}{_unit(field)}: {field.what}"]
    lines += _wrapped(f"passes if: {judge.what}", 4)
    if members["judge"] == "values":
        return lines + _at_most(list(_toleranced(members, limits)), rows)
    for member, value in members.items():
        if member == "judge":
            continue
        if isinstance(value, list):
            width = 4 if member == "pairs" else _width(field)
            lines += [f"    {member}", *_at_most(_number_lines(value, width), rows)]
        else:
            lines.append(f"    {member}: {_single(value)}")
    return lines


def _toleranced(members: Mapping[str, Any], limits: Mapping[str, float]) -> Iterator[str]:
    """Yield one line a value: decimal, hexadecimal, and the tolerance for each type of floats."""
    values, scale = members["values"], members["scale"]
    scales = scale if isinstance(scale, list) else [scale]
    if len(scales) == 1:
        scales = scales * len(values)
    decimals = [f"{value:.17g}" for value in values]
    exact = [hexadecimal(value) for value in values]
    widths = [max(map(len, texts), default=0) for texts in (decimals, exact)]
    for k, (text, digits, size) in enumerate(zip(decimals, exact, scales, strict=True)):
        tolerances = ", ".join(
            f"{_multiple(members, dtype) * eps * size:.2g} ({dtype})"
            for dtype, eps in limits.items()
        )
        yield f"    {k:>4}  {text.rjust(widths[0])}  {digits.ljust(widths[1])}  +- {tolerances}"


def _multiple(members: Mapping[str, Any], dtype: str) -> int:
    """Return the multiple of eps and scale that is allowed for a type of floats."""
    return members.get(f"multiple_{dtype}", members["multiple"])
