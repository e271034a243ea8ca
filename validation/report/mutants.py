"""The page of the deliberate faults, from the rows of `validation/mutants/run.py`."""

from pathlib import Path

from validation import json_rows
from validation.report.catalogue import Headline
from validation.report.tables import NOT_MEASURED, header, table, write_page
from validation.rows import Columns, Row

TITLE = "Do the tests notice deliberate faults?"
FILE = "mutants.json"
COLUMNS: Columns = {
    "fault": "name",
    "file": "file",
    "what is wrong": "what",
    "where it was found before": "origin",
    "caught": "caught",
    "by": "by",
    "seconds": lambda row: f"{row['seconds']:.0f}",
}


def page(rows_folder: Path, output: Path) -> Path:
    """Write `mutants.md`: how many faults were caught, which were not, and which test caught each.

    Args:
        rows_folder: Folder of `mutants.json`.
        output: Folder of the page.

    Returns:
        Path of the page.
    """
    path, loaded = output / "mutants.md", json_rows.load(rows_folder / FILE)
    if loaded is None:
        return write_page(path, (f"# {TITLE}", NOT_MEASURED))
    rows = loaded.rows
    survivors = [row for row in rows if not row["caught"]]
    sections = (
        header(TITLE, [loaded.made]),
        "Each deliberate fault was put alone into a copy of the repository. The tests that are "
        "named for the fault ran first; the rest of the suite ran only if those passed. Without "
        "any fault, these tests pass.",
        f"**{caught(rows)}** faults were caught, {_by_whole_suite(rows)} of them only by the "
        "whole suite.",
        "## Faults that no test noticed",
        table(COLUMNS, survivors) if survivors else "None.",
        "## All faults",
        table(COLUMNS, rows),
    )
    return write_page(path, sections)


def headlines(rows_folder: Path) -> list[Headline]:
    """Return the figures that stand for this report; an empty list if it was not measured."""
    loaded = json_rows.load(rows_folder / FILE)
    if loaded is None:
        return []
    only = f"{_by_whole_suite(loaded.rows)} of them only by the whole suite; all others by the"
    sentence = f"{only} tests that are named for the fault."
    return [Headline("Deliberate faults that the tests notice", caught(loaded.rows), sentence)]


def caught(rows: list[Row]) -> str:
    """Return how many faults were caught, and of how many."""
    return f"{sum(row['caught'] for row in rows)} of {len(rows)}"


def _by_whole_suite(rows: list[Row]) -> int:
    return sum(row["caught"] and row["whole"] for row in rows)
