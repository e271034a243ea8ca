"""Markdown: tables of rows, and the sentence that says what measured them."""

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from izo_ref.app.files import replacing
from validation.provenance import Made
from validation.rows import Columns, Row

NOT_MEASURED = "Not measured yet."


def header(title: str, made: Iterable[Made]) -> str:
    """Return the first lines of a page: its title, and what measured its rows.

    Args:
        title: Plain text.
        made: What made each of the files that the page shows; repetitions are left out.
    """
    sentences = [
        f"Measured by `{command}` at commit {commit} on {machine}, with {versions}."
        for command, commit, machine, versions in dict.fromkeys(made)
    ]
    times = (
        "Times are wall-clock seconds of that machine, which may have done other work at the same "
        "time; they do not include the time to compile."
    )
    return f"# {title}\n\n{' '.join((*sentences, times))}\n"


def run_table(runs: Iterable[Row]) -> str:
    """Return a Markdown table of the runs that measured the rows of a page."""
    columns: Columns = {"run": "run", "commit": "commit", "machine": "machine", "begun": "started"}
    return table(columns, runs)


def table(columns: Columns, rows: Iterable[Row]) -> str:
    """Return a Markdown table.

    Args:
        columns: By heading, a key of the row or a function that computes the cell.
        rows: One for each line.
    """
    lines = ["| " + " | ".join(columns) + " |", "|" + "---|" * len(columns)]
    for row in rows:
        cells = [row.get(c) if isinstance(c, str) else c(row) for c in columns.values()]
        lines.append("| " + " | ".join(cell_text(cell) for cell in cells) + " |")
    return "\n".join(lines) + "\n"


def section(heading: str, intro: str, columns: Columns, rows: list[Row]) -> str:
    """Return a section with one table; if there are no rows, it says so."""
    if not rows:
        return f"## {heading}\n\n{NOT_MEASURED}"
    return f"## {heading}\n\n{intro}\n\n{table(columns, rows)}"


def met(value: float | None, limit: float) -> str:
    """Return a value, and whether it is as low as wanted; an empty string for None."""
    if value is None:
        return ""
    return f"{value:.3g} {'met' if value <= limit else 'MISSED'}"


def cell_text(value: Any) -> str:
    """Return the text of a cell; a number is written with the digits that matter."""
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


def scientific(value: float) -> str:
    """Return a power of ten in the shortest form, such as 1e-9."""
    return f"{value:.0e}".replace("e-0", "e-").replace("e+0", "e").replace("e+", "e")


def write_page(path: Path, sections: Iterable[str]) -> Path:
    """Write the sections of a Markdown page, with an empty line between them; return its path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as file:
        file.write(("\n\n".join(section.strip() for section in sections) + "\n").encode())
    return path
