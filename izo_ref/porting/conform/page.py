"""The report of a run as one HTML page without anything from outside."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from typing import Any

from izo_ref.porting.conform.divergence import first_divergence
from izo_ref.porting.conform.report import (
    Report,
    row_record,
    stage_counts,
    unsupported_stages,
    verdict_line,
)
from izo_ref.porting.conform.terminal import divergence_entries, shown_columns
from izo_ref.porting.judge.outcome import FAILED
from izo_ref.porting.stages import STAGE
from izo_ref.version import __version__

SHOWN = 20  # differences of one case

STYLE = """
:root { color-scheme: light dark; --line: #8884; --bad: #c0392b; --good: #1e8449; }
@media (prefers-color-scheme: dark) { :root { --bad: #ff8a7a; --good: #6fd79a; } }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 0 auto; padding: 1rem; }
h1 { font-size: 1.5rem; line-height: 1.25; }
h2 { font-size: 1.2rem; margin-top: 2rem; }
.verdict { font-size: 1.1rem; font-weight: 600; border-left: .3rem solid; padding-left: .7rem; }
.bad { color: var(--bad); }
.good { color: var(--good); }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { border-bottom: 1px solid var(--line); padding: .25rem .6rem; text-align: right; }
th { font-weight: 600; vertical-align: bottom; }
th:first-child { text-align: left; min-width: 9rem; }
tbody th { font-weight: normal; }
dl { display: grid; grid-template-columns: max-content minmax(0, 1fr); gap: .2rem 1rem; }
dt { opacity: .7; }
dd { margin: 0; overflow-wrap: anywhere; }
code { font: .9em ui-monospace, monospace; overflow-wrap: anywhere; }
details { border-bottom: 1px solid var(--line); padding: .4rem 0; }
summary { cursor: pointer; overflow-wrap: anywhere; }
li { overflow-wrap: anywhere; white-space: pre-line; }
pre { overflow-x: auto; }
@media (max-width: 40rem) {
  th, td { padding: .25rem .35rem; }
  th:first-child { min-width: 6.5rem; padding-left: 0; }
  dl { grid-template-columns: minmax(0, 1fr); }
  dd { margin: 0 0 .5rem; }
}
"""


def page_text(report: Report) -> str:
    """Return the page. Every text that came from the port is escaped."""
    port = report.run.port
    name = f"{port.name} {port.version}" if port else "a port that did not introduce itself"
    colour = "good" if report.is_right else "bad"
    parts = [
        "<!doctype html>",
        '<html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>Conformance of {escape(name)}</title><style>{STYLE}</style></head><body>",
        f"<h1>Conformance of {escape(name)}</h1>",
        f'<p class="verdict {colour}">{escape(verdict_line(report))}</p>',
    ]
    if port:
        text = f"Stages {', '.join(port.stages)}; types of floats {', '.join(port.dtypes)}. "
        parts.append(f"<p>{escape(text)}Vectors v1, izo_ref {escape(__version__)}.</p>")
    parts += [*_messages(report), *_table(report), *_divergence(report), *_failures(report)]
    return "\n".join([*parts, "</body></html>", ""])


def _messages(report: Report) -> Iterable[str]:
    """Yield the notes of the run, and what is not true in the list of known failures."""
    run = report.run
    notes = [*run.notes, *(f"Known failures: {text}" for text in report.compared.problems)]
    if run.restarts:
        notes.append(f"The program was started again {run.restarts} times.")
    if notes:
        yield "<ul>" + "".join(f"<li>{escape(note)}</li>" for note in notes) + "</ul>"


def _table(report: Report) -> Iterable[str]:
    """Yield the table by stage."""
    table = stage_counts(report)
    # a phone has room for four columns: what is 0 everywhere is left out, except the results
    columns, absent = shown_columns(table), unsupported_stages(table)
    head = "".join(f'<th scope="col">{name.replace("_", " ")}</th>' for name in columns)
    yield '<h2>By stage</h2><div class="scroll"><table><thead>'
    yield f'<tr><th scope="col">stage</th>{head}</tr></thead><tbody>'
    for name, counts in table.items():
        if name in absent:
            continue
        cells = "".join(_cell(column, counts[column]) for column in columns)
        title = escape(f"{name} {STAGE[name].title}")
        yield f'<tr><th scope="row">{title}</th>{cells}</tr>'
    yield "</tbody></table></div>"
    if absent:
        yield f"<p>Not supported: {', '.join(absent)}.</p>"


def _cell(column: str, count: int) -> str:
    bad = ' class="bad"' if count and column in ("failed", "not_run") else ""
    return f"<td{bad}>{count}</td>"


def _divergence(report: Report) -> Iterable[str]:
    """Yield the first divergence."""
    first = first_divergence(report)
    if first is None:
        return
    title = f"First divergence: {first['stage']} {first['title']}"
    yield f"<h2>{escape(title)}</h2><dl>"
    yield f"<dt>name</dt><dd>{escape(first['case'])}, {first['dtype']}, {first['grade']}</dd>"
    for name, text in divergence_entries(first):
        if text:
            yield f"<dt>{escape(name)}</dt><dd>{escape(text)}</dd>"
        if name == "wrong" and first["error_output"]:
            yield f"<dt>error output</dt><dd><pre>{escape(first['error_output'])}</pre></dd>"
    for command in first["next"]:
        yield f"<dt>next</dt><dd><code>{escape(command)}</code></dd>"
    yield "</dl>"


def _failures(report: Report) -> Iterable[str]:
    """Yield every request that failed, to be opened; those that were not asked are counted."""
    rows = [row for row in report.run.rows if row.outcome.differences]
    failed = [row_record(report, row) for row in rows if row.outcome.result == FAILED]
    if not rows:
        return
    yield f"<h2>All {len(failed)} failures</h2>"
    yield from (_failure(row) for row in failed)
    if len(failed) < len(rows):
        yield f"<p>Not run: {len(rows) - len(failed)} requests.</p>"


def _failure(row: dict[str, Any]) -> str:
    differences = row["differences"]
    known = " (known)" if row["known"] else ""
    first = f"{differences[0]['where']}: {differences[0]['sentence']}"
    items = [
        f"<li><b>{escape(item['where'])}</b>: {escape(item['sentence'])}</li>"
        for item in differences[:SHOWN]
    ]
    if len(differences) > SHOWN:
        items.append(f"<li>{len(differences) - SHOWN} more; the JSON report has all</li>")
    name = escape(f"{row['id']} {row['dtype']}")
    return (
        f"<details><summary><code>{name}</code>{known} {escape(first)}</summary>"
        f"<ul>{''.join(items)}</ul></details>"
    )
