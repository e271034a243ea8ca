"""The page of the faults that the vectors notice (`validation/mutants/vectors.py`)."""

from pathlib import Path

from validation import json_rows
from validation.mutants.faults import FAULTS
from validation.report.catalogue import Headline
from validation.report.mutants import caught
from validation.report.tables import NOT_MEASURED, header, table, write_page
from validation.rows import Columns

TITLE = "Do the vectors alone notice deliberate faults?"
FILE = "vectors.json"
COLUMNS: Columns = {
    "fault": "name",
    "file": "file",
    "what is wrong": "what",
    "flag": "flag",
    "first stage that fails": lambda row: row["stages"][0] if row["stages"] else "",
    "by its own flag": "by_flag",
    "seconds": lambda row: f"{row['seconds']:.0f}",
}
REASONS: Columns = {"fault": "name", "flag": "flag", "why no vector can notice it": "why"}


def page(rows_folder: Path, output: Path) -> Path:
    """Write `vectors.md`: which faults the vectors notice, at which stage, and which they cannot.

    Args:
        rows_folder: Folder of `vectors.json`.
        output: Folder of the page.

    Returns:
        Path of the page.
    """
    path, loaded = output / "vectors.md", json_rows.load(rows_folder / FILE)
    if loaded is None:
        return write_page(path, (f"# {TITLE}", NOT_MEASURED))
    rows = loaded.rows
    survivors = [row for row in rows if not row["caught"]]
    excused = [
        {"name": fault.name, "flag": fault.flag, "why": fault.not_by_vectors}
        for fault in FAULTS
        if fault.not_by_vectors
    ]
    sections = (
        header(TITLE, [loaded.made]),
        "Each deliberate fault was put alone into a copy of the repository. Our own port, "
        "`tests/ports/own`, then answered the vectors from this copy, in pure Python. The harness "
        "and the judge ran from a copy without the fault.",
        f"**{caught(rows)}** faults were caught. {len(excused)} other faults are in code that no "
        "answer of a stage shows, and the last table says why.",
        "## Faults that no vector noticed",
        table(COLUMNS, survivors) if survivors else "None.",
        "## Faults that the vectors noticed",
        table(COLUMNS, [row for row in rows if row["caught"]]),
        "## Faults that no vector can notice",
        table(REASONS, excused),
    )
    return write_page(path, sections)


def headlines(rows_folder: Path) -> list[Headline]:
    """Return the figures that stand for this report; an empty list if it was not measured."""
    loaded = json_rows.load(rows_folder / FILE)
    if loaded is None:
        return []
    sentence = "The others of the list are in code that no answer of a stage shows."
    return [Headline("Deliberate faults that the vectors notice", caught(loaded.rows), sentence)]
