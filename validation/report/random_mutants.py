"""The page of the drawn faults, from the rows of `validation/mutants/random_run.py`."""

import html
from collections.abc import Iterable
from pathlib import Path

from validation import json_rows
from validation.mutants.survivors import reason_of
from validation.report.catalogue import Headline
from validation.report.tables import NOT_MEASURED, header, table, write_page
from validation.rows import Columns, Row

TITLE = "Do the tests notice faults that nobody chose?"
FILE = "random_mutants.json"
COLUMNS: Columns = {
    "number": "number",
    "place": lambda row: f"{row['file']}:{row['line']}",
    "operator": "operator",
    "line": lambda row: _code(row["old"]),
    "with the fault": lambda row: _code(row["new"]),
}
CAUGHT: Columns = {**COLUMNS, "caught by": "by", "seconds": lambda row: f"{row['seconds']:.0f}"}
OPEN: Columns = {**COLUMNS, "last stage": "stage"}
REASONS: Columns = {**COLUMNS, "why no input can show it": "reason"}
COUNTS: Columns = {
    "": "name",
    "drawn": "drawn",
    "caught": "caught",
    "survived with a reason": "reasoned",
    "survived": "open",
}
LONGEST = 160  # characters of a line of code in a table


def page(rows_folder: Path, output: Path) -> Path:
    """Write `random_mutants.md`: what became of the drawn faults, by group and by operator.

    Args:
        rows_folder: Folder of `random_mutants.json`.
        output: Folder of the page.

    Returns:
        Path of the page.
    """
    path, loaded = output / "random_mutants.md", json_rows.load(rows_folder / FILE)
    if loaded is None:
        return write_page(path, (f"# {TITLE}", NOT_MEASURED))
    rows = _with_reasons(loaded.rows)
    open_ = [row for row in rows if _fate(row) == "open"]
    reasoned = [row for row in rows if _fate(row) == "reasoned"]
    sections = (
        header(TITLE, [loaded.made]),
        f"{len(rows)} faults were drawn by operator with seed {rows[0]['seed'] if rows else ''}, "
        "each group of files with its share. Each was put alone into a copy of the repository. "
        "The tests that enter its function ran first, in pure Python, the fastest first; then the "
        "tests that are too slow for that, compiled; then the vectors. In pure Python, an index "
        "out of bounds and a quotient by zero end a test, which compiled code may not notice.",
        f"**{_share(rows)}** of those that an input can show were caught. {len(reasoned)} others "
        "cannot be shown by any input that is known; the table says why.",
        "## By group",
        table(COUNTS, _counts(rows, "group")),
        "## By operator",
        table(COUNTS, _counts(rows, "operator")),
        "## Faults that survived",
        table(OPEN, open_) if open_ else "None.",
        "## Faults that survived, with a reason",
        table(REASONS, reasoned) if reasoned else "None.",
        "## Faults that were caught",
        table(CAUGHT, [row for row in rows if row["caught"]]),
    )
    return write_page(path, sections)


def headlines(rows_folder: Path) -> list[Headline]:
    """Return the figures that stand for this report; an empty list if it was not measured."""
    loaded = json_rows.load(rows_folder / FILE)
    if loaded is None:
        return []
    rows = _with_reasons(loaded.rows)
    reasoned = sum(_fate(row) == "reasoned" for row in rows)
    sentence = (
        f"Of {len(rows)} faults that were drawn by operator, {reasoned} cannot be shown by any "
        "input that is known, for a reason that is stated."
    )
    return [Headline("Drawn faults that the tests notice", _share(rows), sentence)]


def _with_reasons(rows: Iterable[Row]) -> list[Row]:
    """Return rows with the reasons that are known by now."""
    return [
        row | {"reason": reason_of((row["file"], row["where"], row["old"], row["new"]))}
        for row in rows
    ]


def _fate(row: Row) -> str:
    """Return `caught`, `reasoned` or `open`."""
    if row["caught"]:
        return "caught"
    return "reasoned" if row["reason"] else "open"


def _share(rows: list[Row]) -> str:
    """Return how many faults were caught, and of how many that can be shown."""
    fates = [_fate(row) for row in rows]
    caught, shown = fates.count("caught"), len(fates) - fates.count("reasoned")
    return f"{caught} of {shown} ({100.0 * caught / max(shown, 1):.1f} %)"


def _counts(rows: list[Row], column: str) -> list[Row]:
    """Return the counts of fates for each value of a column, and for all rows."""
    names = sorted({row[column] for row in rows})
    parts = [(name, [row for row in rows if row[column] == name]) for name in names]
    counts: list[Row] = []
    for name, own in (*parts, ("all", rows)):
        fates = [_fate(row) for row in own]
        number = {fate: fates.count(fate) for fate in ("caught", "reasoned", "open")}
        counts.append({"name": name, "drawn": len(own), **number})
    return counts


def _code(line: str) -> str:
    """Return a line of code for a cell of a table."""
    short = line if len(line) <= LONGEST else f"{line[:LONGEST]} ..."
    return f"<code>{html.escape(short).replace('|', '&#124;')}</code>"
