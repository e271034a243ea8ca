"""What studies measured: rows in CSV files that only grow, so that a run can be resumed."""

import csv
import io
import re
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from izo_ref.app.files import replacing
from validation import provenance

OUTCOMES = ("converged", "not converged", "failed")
RUNS = "runs"
RUN_COLUMNS = ("run", "command", "commit", "machine", "versions", "quick", "started")
INTEGER = re.compile(r"[+-]?\d+")
FLOAT = re.compile(r"[+-]?(\d+\.?\d*(e[+-]?\d+)?|inf|nan)")


class Rows:
    """The rows of one study, `<folder>/<study>.csv`: a line each, written as they come.

    Rows are dictionaries of bool, int, float, str or None. The file has the key columns
    first, then `run`, the id of a line of `runs.csv`, then the rest; a row with a new
    column adds it to the file. An empty string is read back as None.

    Args:
        folder: where the CSV files are; made with the first row.
        study: name of the file.
        keys: columns that say what a row is about.
    """

    def __init__(self, folder, study, keys):
        self.folder = Path(folder)
        self.path = self.folder / f"{study}.csv"
        self.keys = tuple(keys)
        _drop_half_line(self.path)
        self._columns, lines = _lines(self.path)
        known = runs(self.folder)
        self._run = known[-1]["run"] if known else None
        alike = {row["run"] for row in known if row["quick"] == known[-1]["quick"]}
        self._seen = {self._key(row) for row in lines if row["run"] in alike}

    def has(self, **key) -> bool:
        """Whether there is a row with this key, made as quick or full as the current run."""
        return self._key(key) in self._seen

    def add(self, **row):
        """Append a row; it is on the disk when this returns.

        Raises:
                ValueError: a key is missing, an outcome unknown, or a value of another type.
        """
        missing = [name for name in self.keys if name not in row]
        if missing:
            raise ValueError(f"expected the keys {self.keys}, {missing} missing")
        if row.get("outcome", OUTCOMES[0]) not in OUTCOMES:
            raise ValueError(f"outcome: expected one of {OUTCOMES}, got {row['outcome']!r}")
        if self._run is None:
            self._run = begin_run(self.folder, "python", False)
        row = {name: _plain(name, value) for name, value in row.items()} | {"run": self._run}
        self._make_room(row)
        _append(self.path, [_written(row.get(name)) for name in self._columns])
        self._seen.add(self._key(row))

    def all(self) -> list[dict]:
        """Every row, with its types."""
        return _lines(self.path)[1]

    def _key(self, row):
        return tuple(_written(_plain(name, row.get(name))) for name in self.keys)

    def _make_room(self, row):
        """Write the file anew if the row has columns that it has not."""
        first = (*self.keys, "run")
        columns = self._columns or list(first)
        new = [name for name in row if name not in columns]
        if self._columns and not new:
            return
        rows = self.all()
        self._columns = columns + new
        self.folder.mkdir(parents=True, exist_ok=True)
        lines = [self._columns, *([_written(r.get(c)) for c in self._columns] for r in rows)]
        with replacing(self.path) as file:
            file.write("".join(map(_line, lines)).encode())


def read(folder, study) -> list[dict]:
    """The rows of a study; none if it was not run."""
    return _lines(Path(folder) / f"{study}.csv")[1]


def runs(folder) -> list[dict]:
    """The runs that rows came from: RUN_COLUMNS, oldest first."""
    return read(folder, RUNS)


def begin_run(folder, command, quick) -> int:
    """Say what is about to make rows; a run like the last one continues it.

    Returns:
        Its id, which rows added from now on carry.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{RUNS}.csv"
    _drop_half_line(path)
    before = runs(folder)
    made = {
        "command": command,
        "commit": provenance.commit(),
        "machine": provenance.machine(),
        "versions": provenance.versions(),
        "quick": bool(quick),
    }
    if before and all(before[-1][name] == value for name, value in made.items()):
        return before[-1]["run"]
    if not before:
        _append(path, RUN_COLUMNS)
    started = datetime.now(UTC).isoformat(timespec="seconds")
    row = {"run": len(before) + 1, **made, "started": started}
    _append(path, [_written(_plain(name, row[name])) for name in RUN_COLUMNS])
    return row["run"]


def _plain(name, value):
    """A value that a line can hold; numpy's scalars as Python's."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, str):
        return " ".join(value.split())  # a row is a line
    if not isinstance(value, (bool, int, float, type(None))):
        raise ValueError(f"{name}: expected bool, int, float, str or None, got {value!r}")
    return value


def _written(value):
    """A cell; a text that would be read back as a number stands in quotes."""
    if value is None:
        return ""
    if isinstance(value, str):
        return value if value == "" or _parsed(value) == value else f'"{value}"'
    return repr(value)


def _parsed(text):
    if text in ("", "True", "False"):
        return {"": None, "True": True, "False": False}[text]
    if text[0] == text[-1] == '"' and len(text) > 1:
        return text[1:-1]
    if INTEGER.fullmatch(text):
        return int(text)
    return float(text) if FLOAT.fullmatch(text) else text


def _line(cells):
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerow(cells)
    return out.getvalue()


def _append(path, cells):
    with open(path, "a", encoding="utf-8", newline="") as file:
        file.write(_line(cells))


def _whole_lines(path):
    """The text up to the last line break: what is behind it was cut off while written."""
    text = path.read_bytes().decode(errors="replace") if path.is_file() else ""
    return text[: text.rfind("\n") + 1]


def _drop_half_line(path):
    if path.is_file():
        whole = path.read_bytes()
        end = whole.rfind(b"\n") + 1
        if end < len(whole):
            with open(path, "r+b") as file:
                file.truncate(end)


def _lines(path):
    """The columns, and a dictionary for each line."""
    lines = list(csv.reader(io.StringIO(_whole_lines(path))))
    if not lines:
        return [], []
    columns = lines[0]
    return columns, [dict(zip(columns, map(_parsed, cells), strict=True)) for cells in lines[1:]]
