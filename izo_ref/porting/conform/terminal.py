"""The report of a run for a terminal: the table by stage, and the first divergence."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from textwrap import TextWrapper
from typing import Any

from izo_ref.porting.conform.divergence import EVERY, first_divergence
from izo_ref.porting.conform.report import (
    COLUMNS,
    Report,
    stage_counts,
    unsupported_stages,
    verdict_line,
)
from izo_ref.porting.stages import STAGE

WIDTH = 100  # of the text
ALWAYS = ("requests", "passed", "failed")  # columns of the table
MOST_IDS = 20  # failing requests that are named

Entry = tuple[str, str]
# names of cases and of files stay whole, so that they can be copied
_WRAPPER = partial(TextWrapper, WIDTH, break_on_hyphens=False, break_long_words=False)


def report_text(report: Report) -> str:
    """Return the report for a terminal."""
    run = report.run
    parts = []
    if run.port is None:
        parts.append("The port did not introduce itself, so no case was asked.")
    else:
        port = run.port
        parts.append(
            f"{port.name} {port.version}: stages {', '.join(port.stages)}; types "
            f"{', '.join(port.dtypes)}\n\n{_table(stage_counts(report))}"
        )
    parts += [f"note: {note}" for note in run.notes]
    if run.restarts:
        times = "once" if run.restarts == 1 else f"{run.restarts} times"
        parts.append(f"The program was started again {times}.")
    parts += [f"known failures: {problem}" for problem in report.compared.problems]
    first = first_divergence(report)
    if first:
        parts.append("\n".join(_divergence_lines(first)))
    parts.append(verdict_line(report))
    return "\n\n".join(parts) + "\n"


def shown_columns(table: dict[str, dict[str, int]]) -> list[str]:
    """Return the columns of a table that are not 0 everywhere, and those of the results."""
    rows = [row for name, row in table.items() if name not in unsupported_stages(table)]
    return [name for name in COLUMNS if name in ALWAYS or any(row[name] for row in rows)]


def _table(table: dict[str, dict[str, int]]) -> str:
    """Return the counts by stage, with a line of sums; stages that are not supported are named."""
    absent = unsupported_stages(table)
    columns = shown_columns(table)
    rows = {f"{name} {STAGE[name].title}": row for name, row in table.items() if name not in absent}
    if len(rows) > 1:
        rows["all"] = {name: sum(row[name] for row in rows.values()) for name in columns}
    width = max(map(len, rows), default=0)
    names = [name.replace("_", " ") for name in columns]
    head = "  ".join(["stage".ljust(width), *names])
    lines = [head, "-" * len(head)] if rows else []
    for title, row in rows.items():
        cells = [str(row[name]).rjust(len(name)) for name in columns]
        lines.append("  ".join([title.ljust(width), *cells]))
    return "\n".join(lines + [f"not supported: {', '.join(absent)}"] * bool(absent))


def failing_text(first: dict[str, Any]) -> str:
    """Return the requests of the stage that fail, by case, the others as a count."""
    types: dict[str, list[str]] = {}
    for name, dtype in first["failing"]:
        types.setdefault(name, []).append(dtype)
    shown, left = [], len(first["failing"])
    for name, dtypes in types.items():
        if len(first["failing"]) - left + len(dtypes) > MOST_IDS:
            break
        shown.append(f"{name} {'+'.join(dtypes)}")
        left -= len(dtypes)
    text = ", ".join(shown)
    return f"{text}, and {left} more" if left else text


def divergence_entries(first: dict[str, Any]) -> Iterator[Entry]:
    """Yield what is known about the first divergence: a name and a text, line by line.

    Args:
        first: The record of the first divergence.
    """
    if first["every_case_fails"]:
        yield "first", EVERY
    yield "case", first["what"]
    yield "where", first["where"]
    yield "wrong", first["sentence"]
    yield from number_entries(first)
    if first["more"]:
        plural = "s" if first["more"] > 1 else ""
        yield "more", f"{first['more']} more difference{plural} in this case"
    for hint in first["hints"]:
        yield "hint", hint
    for suspect in first["suspects"]:
        share = _share(suspect["failed"], suspect["judged"])
        yield "mistake", f"{suspect['flag']} ({share}): {suspect['mistake']}"
        yield "harm", suspect["harm"]
    yield "formula", first["formula"]
    yield "read", first["reference"]
    yield "", first["method"]
    if len(first["failing"]) > 1:
        yield "failing", failing_text(first)


def _share(failed: int, judged: int) -> str:
    if failed < judged:
        return f"{failed} of the {judged} requests that catch it fail"
    return f"all {judged} requests that catch it fail" if judged > 1 else "its only request fails"


def number_entries(record: dict[str, Any]) -> Iterator[Entry]:
    """Yield the numbers of a difference that its sentence does not say."""
    for name in ("expected", "got"):
        text = record[name]
        if text is not None and text.partition(" (")[0] not in record["sentence"]:
            yield name, f"{record['quantity']}: {text}" if record["quantity"] else text


def _divergence_lines(first: dict[str, Any]) -> list[str]:
    lines = [
        f"First divergence: {first['stage']} {first['title']}, case {first['case']}, "
        f"{first['dtype']} ({first['grade']})"
    ]
    for name, text in divergence_entries(first):
        if text:
            begin = f"  {name:<9}"
            margin = " " * len(begin)
            lines += _WRAPPER(initial_indent=begin, subsequent_indent=margin).wrap(text)
        if name == "wrong" and first["error_output"]:
            lines.append("  the last lines of its error output:")
            lines += [f"    {line}" for line in first["error_output"].splitlines()]
    begins = ["next", *[""] * len(first["next"])]
    # commands are not wrapped, so that they can be copied
    return lines + [
        f"  {begin:<9}{command}" for begin, command in zip(begins, first["next"], strict=False)
    ]
