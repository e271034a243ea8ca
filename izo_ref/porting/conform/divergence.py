"""The first divergence of a run: the first failure, and all that helps to find its cause."""

from __future__ import annotations

import shlex
from typing import Any

from izo_ref.porting.conform.hints import hints
from izo_ref.porting.conform.report import Report, difference_record, row_record, verdict_line
from izo_ref.porting.conform.report import stage_counts as counts_of
from izo_ref.porting.conform.run import Row
from izo_ref.porting.conform.suspects import shown_suspects
from izo_ref.porting.flags import FLAG
from izo_ref.porting.judge.outcome import FAILED, INCIDENT, NOT_RUN, PASSED, WRONG
from izo_ref.porting.reading import shown_lines, shown_page
from izo_ref.porting.stages import STAGE
from izo_ref.version import __version__

EVERY = (
    "Every case of this stage fails: check the order and the meaning of inputs and outputs first."
)
ENOUGH = 2  # cases; that a single one fails says nothing about all


def first_divergence(report: Report) -> dict[str, Any] | None:
    """Return the first failure that is not known, with what helps to find its cause."""
    rows = [row for row in report.failures if row.outcome.result == FAILED]
    if not rows:
        return None
    row = rows[0]
    stage, case, difference = STAGE[row.request.case.stage], row.request.case, _first(row)
    failing = [item for item in rows if item.request.case.stage == stage.name]
    is_wrong = difference.cause == WRONG
    return {
        "stage": stage.name,
        "title": stage.title,
        "formula": stage.formula,
        "case": case.id,
        "dtype": row.request.dtype,
        "what": case.what,
        "grade": case.grade,
        **difference_record(difference),
        "more": len(row.outcome.differences) - 1,
        "failing": [list(item.request.key) for item in failing],
        "every_case_fails": _every_case_fails(report, stage.name),
        "hints": hints(report.run.rows, stage.name, difference.output) if is_wrong else [],
        "flags": list(case.flags),
        "suspects": _suspects(report, stage.name) if is_wrong else [],
        "reference": shown_lines(stage),
        "method": shown_page(stage),
        "next": _next_commands(report, row),
    }


def _first(row: Row) -> Any:
    return row.outcome.differences[0]


def _every_case_fails(report: Report, stage: str) -> bool:
    """Return whether all replies of a stage are wrong; a crash is no reply."""
    rows = [
        row
        for row in report.judged
        if row.request.case.stage == stage
        and (row.outcome.result == PASSED or _first(row).cause != INCIDENT)
    ]
    cases = {row.request.case.id for row in rows}
    if any(r.outcome.result == NOT_RUN and r.request.case.stage == stage for r in report.run.rows):
        return False
    return len(cases) >= ENOUGH and all(row.outcome.result == FAILED for row in rows)


def _suspects(report: Report, stage: str) -> list[dict[str, Any]]:
    found = []
    for item in shown_suspects(report.run.rows, stage):
        entry = FLAG.get(item.flag)
        found.append(
            {
                "flag": item.flag,
                "failed": item.failed,
                "judged": item.judged,
                "mistake": entry.mistake if entry else "",
                "harm": entry.harm if entry else "",
            }
        )
    return found


def _next_commands(report: Report, row: Row) -> list[str]:
    """Return the commands with which to go on."""
    name, dtype = row.request.key
    where = ["--folder", report.vectors] if report.vectors else []
    commands = [shlex.join(["izo", "vectors", "show", name, *where])]
    if report.command:
        words = ["izo", "conform", *report.command, "--case", name, "--dtype", dtype]
        commands.append(shlex.join(words))
    return commands


def report_record(report: Report) -> dict[str, Any]:
    """Return the report as JSON holds it."""
    run = report.run
    return {
        "izo_ref": __version__,
        "vectors": "v1",
        "right": report.is_right,
        "complete": report.is_complete,
        "verdict": verdict_line(report),
        "port": run.port and run.port._asdict(),
        "stages": counts_of(report),
        "first_divergence": first_divergence(report),
        "notes": list(run.notes),
        "restarts": run.restarts,
        "known_failures": list(report.compared.problems),
        "cases": [row_record(report, row) for row in run.rows],
    }
