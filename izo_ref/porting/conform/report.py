"""The report of a run: the table by stage, the first divergence, and both as JSON."""

from __future__ import annotations

import math
import textwrap
from typing import Any, NamedTuple

from izo_ref.porting.cases import hexadecimal
from izo_ref.porting.conform.known import Compared
from izo_ref.porting.conform.run import Row, Run
from izo_ref.porting.conform.suspects import suspects
from izo_ref.porting.conform.text import clean
from izo_ref.porting.flags import FLAG
from izo_ref.porting.judge.outcome import (
    FAILED,
    NOT_RUN,
    PASSED,
    Difference,
    place,
)
from izo_ref.porting.reading import lines_of, method_page
from izo_ref.porting.stages import STAGE, STAGES, Stage
from izo_ref.version import __version__

COLUMNS = ("cases", "passed", "failed", "known", "not supported", "not run", "early times")
WIDTH = 100  # of the text
SUSPECTS = 3


class Report(NamedTuple):
    """A run beside the failures that are known.

    Attributes:
        run: The run.
        compared: Which failures are known, and which lines about them are not true any more.
    """

    run: Run
    compared: Compared = Compared(frozenset(), ())

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
    def conforms(self) -> bool:
        """Whether everything that was judged is right, and something was judged."""
        judged = any(row.outcome.result in (PASSED, FAILED) for row in self.run.rows)
        wrong = self.failures or self.run.notes or self.compared.problems
        return judged and not wrong


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
            counts = {name: results.count(name) for name in COLUMNS}
            counts["cases"] = len(rows)
            counts["early times"] = sum(row.outcome.early for row in rows)
            table[stage.name] = counts
    return table


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
        parts.append(f"The program was started again {run.restarts} times.")
    parts += [f"known failures: {problem}" for problem in report.compared.problems]
    first = first_divergence(report)
    if first:
        parts.append("\n".join(_divergence_lines(first)))
    parts.append(verdict_line(report))
    return "\n\n".join(parts) + "\n"


def verdict_line(report: Report) -> str:
    """Return one sentence that says whether the port conforms."""
    known, n = len(report.compared.known), len(report.failures)
    if report.conforms:
        plural = "" if known == 1 else "s"
        return f"The port conforms{f', but for {known} known failure{plural}' * bool(known)}."
    if n:
        return f"The port does not conform: {n} {'case is' if n == 1 else 'cases are'} wrong."
    if report.compared.problems:
        return "The list of known failures is not true any more."
    if report.run.notes:
        return "The port does not conform, because it breaks the protocol."
    return "Nothing was judged, so nothing is said about the port."


def _table(table: dict[str, dict[str, int]]) -> str:
    """Return the counts by stage, with a line of sums."""
    titles = [f"{name} {STAGE[name].title}" for name in table]
    width = max([len(title) for title in titles], default=5)
    head = "  ".join(["stage".ljust(width), *COLUMNS])
    lines = [head, "-" * len(head)]
    sums = {name: sum(counts[name] for counts in table.values()) for name in COLUMNS}
    for title, counts in [*zip(titles, table.values(), strict=True), ("all", sums)]:
        cells = [str(counts[name]).rjust(len(name)) for name in COLUMNS]
        lines.append("  ".join([title.ljust(width), *cells]))
    return "\n".join(lines)


def first_divergence(report: Report) -> dict[str, Any] | None:
    """Return the first failure that is not known, with what helps to find its cause."""
    rows = [row for row in report.failures if row.outcome.result == FAILED]
    if not rows:
        return None
    row = rows[0]
    stage, case = STAGE[row.request.case.stage], row.request.case
    return {
        "stage": stage.name,
        "title": stage.title,
        "formula": stage.formula,
        "case": case.id,
        "dtype": row.request.dtype,
        "what": case.what,
        "grade": case.grade,
        **difference_record(row.outcome.differences[0]),
        "more": len(row.outcome.differences) - 1,
        "flags": list(case.flags),
        "suspects": [
            {"flag": item.flag, "failed": item.failed, "judged": item.judged}
            for item in suspects(report.run.rows, stage.name)
        ],
        "reference": where_to_read(stage),
        "method": method_page(stage),
    }


def explained(flag: str) -> str:
    """Return what the dictionary of flags says about a mistake; empty if it does not know it."""
    entry = FLAG.get(flag)
    return "" if entry is None else f"{entry.mistake} {entry.harm}"


def where_to_read(stage: Stage) -> str:
    """Return file, lines and name of our own implementation; no lines without its source."""
    try:
        return str(lines_of(stage))
    except (OSError, LookupError):
        return stage.source


def suspect_lines(first: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the most likely mistakes of the first divergence, and what each of them is."""
    return [
        (
            suspect["flag"],
            f"{suspect['failed']} of {suspect['judged']} cases fail. {explained(suspect['flag'])}",
        )
        for suspect in first["suspects"][:SUSPECTS]
    ]


def _divergence_lines(first: dict[str, Any]) -> list[str]:
    entries = [
        ("case", first["what"]),
        ("where", first["where"]),
        ("wrong", first["sentence"]),
        ("expected", first["expected"]),
        ("got", first["got"]),
        *(("mistake", f"{flag}: {text}") for flag, text in suspect_lines(first)),
        ("formula", first["formula"]),
        ("read", first["reference"]),
        ("", first["method"]),
        ("more", f"{first['more']} more differences in this case" if first["more"] else None),
    ]
    lines = [
        f"First divergence: {first['stage']} {first['title']}, case {first['case']}, "
        f"{first['dtype']} ({first['grade']})"
    ]
    for name, text in entries:
        if text is not None:
            begin = f"  {name:<9}"
            lines += textwrap.wrap(
                text, WIDTH, initial_indent=begin, subsequent_indent=" " * len(begin)
            )
    return lines


def difference_record(difference: Difference) -> dict[str, Any]:
    """Return a difference as JSON holds it; what came from the port is made safe."""
    return {
        "output": clean(difference.output, 80),
        "element": None if difference.element is None else list(difference.element),
        "where": clean(place(difference), 120),
        "sentence": clean(difference.sentence, 800),
        "expected": _shown(difference.expected),
        "got": _shown(difference.got),
        "ulps": _finite(difference.ulps),
        "tolerances": _finite(difference.tolerances),
    }


def _shown(value: Any) -> str | None:
    """Return a value as text: floats in decimal and in hexadecimal notation."""
    if isinstance(value, float):
        return f"{value!r} ({hexadecimal(value)})" if math.isfinite(value) else repr(value)
    return None if value is None else clean(value)


def _finite(number: float | None) -> float | str | None:
    """Return a number that JSON can hold."""
    return number if number is None or math.isfinite(number) else repr(number)


def report_record(report: Report) -> dict[str, Any]:
    """Return the report as JSON holds it."""
    run = report.run
    return {
        "izo_ref": __version__,
        "vectors": "v1",
        "conforms": report.conforms,
        "verdict": verdict_line(report),
        "port": run.port and run.port._asdict(),
        "stages": stage_counts(report),
        "first_divergence": first_divergence(report),
        "notes": list(run.notes),
        "restarts": run.restarts,
        "known_failures": list(report.compared.problems),
        "cases": [row_record(report, row) for row in run.rows],
    }


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
