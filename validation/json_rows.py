"""Rows that do not fit a table, in JSON files, each with what made them."""

import json
from pathlib import Path
from typing import Any, NamedTuple

from izo_ref.app.files import save_json
from izo_ref.base.errors import FileFormatError
from izo_ref.base.input_files import read_text
from izo_ref.base.values import shown
from validation.provenance import Made


class MadeRows(NamedTuple):
    """The rows of a file, and what made them."""

    made: Made
    rows: Any  # a list of rows, or lists of rows by name


def save(path: Path, made: Made, rows: Any) -> None:
    """Write `{"made": ..., "rows": ...}`; the file appears whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    save_json(path, {"made": made._asdict(), "rows": rows})


def load(path: Path) -> MadeRows | None:
    """Read a file that `save` wrote; None if there is no such file.

    Raises:
        FileFormatError: It cannot be read, or is no such file.
    """
    if not path.is_file():
        return None
    try:
        content = json.loads(read_text(path))
        return MadeRows(Made(**content["made"]), content["rows"])
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise FileFormatError(
            f"{path}: expected JSON with `made` and `rows`: {shown(error)}; delete it, and the "
            "command that wrote it measures again"
        ) from None
