"""A coloured table of the outcomes of each direction and line search in each family of zones."""

import html
from typing import NamedTuple, TypeAlias

from validation.report.measured import Measured, duration
from validation.report.tables import scientific
from validation.rows import Row
from validation.study.own import DIRECTIONS, LINE_SEARCHES

# Lighter means less accurate; the shades differ in greyscale.
COLORS = {1e-12: "#5f9fd6", 1e-9: "#8fbfe6", 1e-6: "#bcd9f0", 1e-3: "#e3f0fa", None: "#fbe6d9"}
HEAD = "position:sticky;left:0;background:#fff;padding-right:.8rem"
CELL = "padding:.25rem .6rem;border:1px solid #fff"
PLAIN = ("every-step", "fixed", "float64")  # update, penalty and precision of the table

CellKey: TypeAlias = tuple[str, str, str]  # family, direction, line search


class Counts(NamedTuple):
    """How many cells there are, and how many of them reached something."""

    asked: list[float]  # tolerances, the loosest first
    cells: int
    missing: int
    failed: int
    reached: dict[float, int]  # cells by the tolerance that they reached


def outcomes(measured: Measured) -> dict[CellKey, list[Row]]:
    """Return the rows of each cell, the loosest tolerance first."""
    cells: dict[CellKey, list[Row]] = {
        (str(family), direction, search): []
        for family in measured.families
        for direction in DIRECTIONS
        for search in LINE_SEARCHES
    }
    for row in measured.rows:
        key = row["family"], row["solver"], row["line_search"]
        if key in cells and (row["update"], row["penalty"], row["precision"]) == PLAIN:
            cells[key].append(row)
    for rows in cells.values():
        rows.sort(key=lambda row: -row["tolerance"])
    return cells


def cell_outcome(rows: list[Row]) -> tuple[str, float | None]:
    """Return the text of a cell, and the tolerance that it reached, or None."""
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
    return f"{scientific(best)} in {duration(fastest)}", best


def cells_table(measured: Measured) -> str:
    """Return HTML with a row for each direction and line search, and a column for each family."""
    cells = outcomes(measured)
    head = "".join(f'<th scope="col">{html.escape(name)}</th>' for name in measured.families)
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


def counts(measured: Measured) -> Counts:
    """Return how many cells there are, and how many of them reached each tolerance."""
    cells = outcomes(measured)
    found = [cell_outcome(rows) for rows in cells.values()]
    asked = {row["tolerance"] for rows in cells.values() for row in rows}
    return Counts(
        asked=sorted(asked, reverse=True),
        cells=len(found),
        missing=sum(says == "missing" for says, _ in found),
        failed=sum(says == "failed" for says, _ in found),
        reached={
            tolerance: sum(best is not None and best <= tolerance for _, best in found)
            for tolerance in (1e-3, 1e-6, 1e-9)
        },
    )
