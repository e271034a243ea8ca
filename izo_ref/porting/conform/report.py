"""The report of a run: its verdict, and everything that it found as JSON."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from izo_ref.porting.cases import DTYPES, hexadecimal
from izo_ref.porting.conform.known import Compared
from izo_ref.porting.conform.run import Row, Run
from izo_ref.porting.conform.text import clean
from izo_ref.porting.judge.outcome import (
    FAILED,
    NOT_RUN,
    PASSED,
    Difference,
    place,
)
from izo_ref.porting.stages import STAGES

# Counts of a stage. The words of the text have spaces in the place of underscores.
COLUMNS = ("requests", "passed", "failed", "known", "not_supported", "not_run", "early_times")


class Report(NamedTuple):
    """A run beside the failures that are known.

    Attributes:
        run: The run.
        compared: Which failures are known, and which lines about them are not true any more.
        command: The words of `izo conform` that run this port; empty if there are none.
        vectors: The folder of the vectors, if it is not the one of izo_ref.
    """

    run: Run
    compared: Compared = Compared(frozenset(), ())
    command: tuple[str, ...] = ()
    vectors: str | None = None

    @property
    def failures(self) -> list[Row]:
        """The rows that failed or were not asked, without those that are known."""
        return [
            row
            for row in self.run.rows
            if row.outcome.result in (FAILED, NOT_RUN)
            and row.request.key not in self.compared.known
        ]

    @property
    def judged(self) -> list[Row]:
        """The rows that passed or failed."""
        return [row for row in self.run.rows if row.outcome.result in (PASSED, FAILED)]

    @property
    def is_right(self) -> bool:
        """Whether everything that was judged is right, and something was judged."""
        wrong = self.failures or self.run.notes or self.compared.problems
        return bool(self.judged) and not wrong

    @property
    def is_complete(self) -> bool:
        """Whether every stage was judged."""
        return {row.request.case.stage for row in self.judged} == {stage.name for stage in STAGES}


def stage_counts(report: Report) -> dict[str, dict[str, int]]:
    """Return the counts of COLUMNS of each stage that has rows; a known failure is not failed."""
    table: dict[str, dict[str, int]] = {}
    for stage in STAGES:
        rows = [row for row in report.run.rows if row.request.case.stage == stage.name]
        if rows:
            results = [
                "known" if row.request.key in report.compared.known else row.outcome.result
                for row in rows
            ]
            counts = {name: results.count(name.replace("_", " ")) for name in COLUMNS}
            counts["requests"] = len(rows)
            counts["early_times"] = sum(row.outcome.early for row in rows)
            table[stage.name] = counts
    return table


def unsupported_stages(table: dict[str, dict[str, int]]) -> list[str]:
    """Return the stages of which no request is supported."""
    return [name for name, row in table.items() if row["not_supported"] == row["requests"]]


def verdict_line(report: Report) -> str:
    """Return one sentence that says whether everything that was judged is right."""
    if report.is_right:
        return _right_line(report)
    wrong = sum(row.outcome.result == FAILED for row in report.failures)
    left = len(report.failures) - wrong
    parts = [_number(wrong, "is", "are") + " wrong"] if wrong else []
    parts += [_number(left, "was", "were") + " not run"] if left else []
    if parts:
        return f"The port does not conform: {', '.join(parts)}."
    if report.compared.problems:
        return "The list of known failures is out of date."
    if report.run.notes:
        return "The port does not conform, because it breaks the protocol."
    return "Nothing was judged, so nothing is said about the port."


def _number(n: int, one: str, many: str) -> str:
    return f"1 request {one}" if n == 1 else f"{n} requests {many}"


def _right_line(report: Report) -> str:
    """Return the verdict about a port that is right, and what it says nothing about."""
    known = len(report.compared.known)
    but = f", but for {known} known failure{'s' * (known != 1)}" if known else ""
    if report.is_complete:
        dtypes = [name for name in DTYPES if any(r.request.dtype == name for r in report.judged)]
        return f"The port conforms{but}." + f" Only {dtypes[0]} was judged." * (len(dtypes) == 1)
    table = stage_counts(report)
    absent = unsupported_stages(table)
    stages = ", ".join(name for name in table if name not in absent)
    n, of = len(report.judged), len(report.run.rows)
    line = f"Everything that was judged is right{but}: {stages} ({n} of {of} requests)"
    if absent:
        line += f"; {len(absent)} stage{'s are' if len(absent) > 1 else ' is'} not supported"
    return f"{line}."


def difference_record(difference: Difference) -> dict[str, Any]:
    """Return a difference as JSON holds it; what came from the port is made safe."""
    return {
        "output": clean(difference.output, 80),
        "element": None if difference.element is None else list(difference.element),
        "where": clean(place(difference), 120),
        "cause": difference.cause,
        "sentence": clean(difference.sentence, 800),
        "quantity": difference.quantity or None,
        "expected": _shown(difference.expected),
        "got": _shown(difference.got),
        "ulps": _finite(difference.ulps),
        "tolerances": _finite(difference.tolerances),
        "error_output": difference.error_output or None,
    }


def _shown(value: Any) -> str | None:
    """Return a value as text: floats in decimal and in hexadecimal notation."""
    if isinstance(value, float):
        return f"{value!r} ({hexadecimal(value)})" if math.isfinite(value) else repr(value)
    return None if value is None else clean(value)


def _finite(number: float | None) -> float | str | None:
    """Return a number that JSON can hold."""
    return number if number is None or math.isfinite(number) else repr(number)


def row_record(report: Report, row: Row) -> dict[str, Any]:
    """Return a row as JSON holds it."""
    return {
        "id": row.request.case.id,
        "stage": row.request.case.stage,
        "dtype": row.request.dtype,
        "result": row.outcome.result,
        "known": row.request.key in report.compared.known,
        "early": row.outcome.early,
        "seconds": round(row.seconds, 6),
        "differences": [difference_record(item) for item in row.outcome.differences],
    }
