"""Run a study of several parts, each of which adds the rows that are missing."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeAlias

Say: TypeAlias = Callable[[str], object]  # is called with a line of text as the work goes on
Part: TypeAlias = Callable[[Path, Say], None]  # adds the missing rows to a CSV file of a folder


def run_parts(parts: Mapping[str, Part], folder: Path, only: str | None, say: Say) -> None:
    """Run the parts of a study one after the other.

    Args:
        parts: `{name: part}`.
        folder: Folder of the CSV files, one for each part.
        only: Name of the only part to run; None runs all.
        say: Is called with a line of text as the work goes on.
    """
    for name, part in parts.items():
        if only in (None, name):
            part(folder, say)
