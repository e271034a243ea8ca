"""Directions times line searches times families, as a table of words on colours."""

import html

from validation.report.measured import duration
from validation.study.own import DIRECTIONS, LINE_SEARCHES

# Lighter the less was reached, so that it can be told apart in grey.
COLORS = {1e-12: "#5f9fd6", 1e-9: "#8fbfe6", 1e-6: "#bcd9f0", 1e-3: "#e3f0fa", None: "#fbe6d9"}
HEAD = "position:sticky;left:0;background:#fff;padding-right:.8rem"
CELL = "padding:.25rem .6rem;border:1px solid #fff"


def outcomes(measured) -> dict:
    """{(family, direction, line search): rows of that cell, looser tolerances first}."""
    cells = {
        (str(family), direction, search): []
        for family in measured.families
        for direction in DIRECTIONS
        for search in LINE_SEARCHES
    }
    for row in measured.rows:
        key = row["family"], row["solver"], row["line_search"]
        plain = (row["update"], row["penalty"], row["precision"])
        if key in cells and plain == ("every-step", "fixed", "float64"):
            cells[key].append(row)
    for rows in cells.values():
        rows.sort(key=lambda row: -row["tolerance"])
    return cells


def cell_outcome(rows) -> tuple[str, float | None]:
    """What a cell says, and the tolerance that it reached, if any."""
    if not rows:
        return "missing", None
    failed = [row for row in rows if row["outcome"] == "failed"]
    if failed:
        return "failed", None
    reached = [row for row in rows if row["reached"] is not None]
    if not reached:
        return ("left out" if rows[0]["seconds"] is None else "not converged"), None
    best = min(row["reached"] for row in reached)
    fastest = min(row["seconds"] for row in reached if row["reached"] == best)
    return f"{best:.0e} in {duration(fastest)}".replace("e-0", "e-"), best


def cells_table(measured) -> str:
    """HTML; a row a direction and line search, a column a family."""
    cells = outcomes(measured)
    head = "".join(f'<th scope="col">{html.escape(f)}</th>' for f in measured.families)
    lines = []
    for direction in DIRECTIONS:
        for search in LINE_SEARCHES:
            parts = [f'<th scope="row" style="{HEAD}">{direction}, {search}</th>']
            for family in measured.families:
                says, reached = cell_outcome(cells[str(family), direction, search])
                color = COLORS[reached]
                parts.append(f'<td style="{CELL};background:{color}">{says}</td>')
            lines.append(f"<tr>{''.join(parts)}</tr>")
    return (
        '<div class="scroll" tabindex="0" role="group" aria-label="Outcomes of all cells">\n'
        f'<table><thead><tr><th style="{HEAD}"></th>{head}</tr></thead>\n<tbody>\n'
        + "\n".join(lines)
        + "\n</tbody></table></div>"
    )


def counts(measured) -> dict:
    """How many cells there are, and in how many something was reached."""
    cells = outcomes(measured)
    found = [cell_outcome(rows) for rows in cells.values()]
    asked = {row["tolerance"] for rows in cells.values() for row in rows}
    return {
        "asked": sorted(asked, reverse=True),
        "cells": len(found),
        "missing": sum(says == "missing" for says, _ in found),
        "failed": sum(says == "failed" for says, _ in found),
        "reached": {
            tolerance: sum(best is not None and best <= tolerance for _, best in found)
            for tolerance in (1e-3, 1e-6, 1e-9)
        },
    }
