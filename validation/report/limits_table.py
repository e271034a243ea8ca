"""The table of limits in `docs/limits.md`, computed from the rows of the study of stability."""

from pathlib import Path

from validation.ladders.ladder import RIGHT
from validation.provenance import ROOT
from validation.report.stability_rows import TITLES, Measured, all_measured
from validation.report.tables import NOT_MEASURED, cell_text, table
from validation.rows import Columns

PAGE = ROOT / "docs" / "limits.md"
ROWS = ROOT / "reports" / "stability" / "rows"
BEGIN, END = "<!-- borders:begin -->", "<!-- borders:end -->"
COLUMNS: Columns = {"what varies": "what", "holds": "holds", "beyond, the program says": "says"}


def borders(rows_folder: Path = ROWS) -> str:
    """Return a table for each family: how far it holds, and what is said beyond; Markdown."""
    parts = []
    for family, found in all_measured(rows_folder).items():
        lines = [
            {"what": f"{m.ladder.name} [{m.ladder.unit}]", "holds": _holds(m), "says": _says(m)}
            for m in found
            if m.own
        ]
        parts.append(f"### {TITLES[family]}\n\n{table(COLUMNS, lines)}")
    return "\n".join(parts) or f"{NOT_MEASURED}\n"


def with_borders(text: str, rows_folder: Path = ROWS) -> str:
    """Return a text whose tables, between the two marks, are those of the rows."""
    before, rest = text.split(BEGIN)
    _, after = rest.split(END)
    return f"{before}{BEGIN}\n{borders(rows_folder)}{END}{after}"


def _holds(m: Measured) -> str:
    if m.named:
        n = m.count(RIGHT)
        return f"all {n} kinds" if n == len(m.own) else f"{n} of {len(m.own)} kinds"
    last = m.border.last
    if last is None:
        return "nowhere"
    return f"to {cell_text(_number(last))}" + ("" if m.border.beyond else ", the end of the ladder")


def _number(rung: float | str) -> float | str:
    try:
        return float(rung)
    except ValueError:
        return rung


def _says(m: Measured) -> str:
    if not m.border.said:
        return ""
    words = ", ".join(f"`{status}`" for status in m.border.said)
    if m.named:
        kinds = [rung for rung, outcome in m.own if outcome.verdict != RIGHT]
        return f"{words} ({', '.join(kinds)})"
    return words
