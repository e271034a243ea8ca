"""Rows to Markdown, with what they were measured on. The only writer of reports."""

import math
from pathlib import Path

from izo_ref.app.files import replacing, save_json
from validation.provenance import commit, machine, versions


def header(title, command) -> str:
    """The first lines of a report: title, command, commit, machine, versions."""
    lines = (
        f"# {title}",
        "",
        f"Made by `{command}` from commit {commit()} on {machine()}, {versions()}. Times are "
        "wall-clock seconds of that machine, which other work may have shared; compile time is "
        "not in them.",
        "",
    )
    return "\n".join(lines)


def table(columns, rows) -> str:
    """A Markdown table.

    Args:
        columns: {heading: function of a row, or key}.
        rows: dictionaries.
    """
    lines = ["| " + " | ".join(columns) + " |", "|" + "---|" * len(columns)]
    for row in rows:
        cells = [row.get(c) if isinstance(c, str) else c(row) for c in columns.values()]
        lines.append("| " + " | ".join(text(cell) for cell in cells) + " |")
    return "\n".join(lines) + "\n"


def text(value) -> str:
    """A cell: numbers with the digits that matter."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        if math.isinf(value):
            return "none"
        if value == 0.0 or 1e-3 <= abs(value) < 1e5:
            return f"{value:.4g}"
        return f"{value:.1e}"
    if isinstance(value, int):
        return f"{value:,}"
    return str(value).replace("|", "/")


def write(path, content, rows=None):
    """Write a report, and beside it its rows as JSON."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as file:
        file.write(content.encode())
    if rows is not None:
        save_json(path.with_suffix(".json"), rows)
