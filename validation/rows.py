"""Rows that studies measured, in CSV files that only grow, so that a run can be resumed."""

import csv
import io
import re
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from izo_ref.app.files import replacing
from izo_ref.base.errors import FileFormatError
from izo_ref.base.input_files import read_bytes
from izo_ref.base.whole_files import lock
from validation import provenance

# A line of measured evidence by column: bool, int, float, str or None; in JSON files lists too.
Row: TypeAlias = dict[str, Any]
# Columns of a table: by heading, a key of the row or a function that computes the cell.
Columns: TypeAlias = dict[str, str | Callable[[Row], Any]]

OUTCOMES = ("converged", "not converged", "failed")
RUNS = "runs"
RUN_COLUMNS = ("run", "command", "commit", "machine", "versions", "quick", "started")
INTEGER = re.compile(r"[+-]?\d+")
DIGITS = 4000  # Python reads integers of up to 4300; a longer one stays a text
FLOAT = re.compile(r"[+-]?(\d+\.?\d*(e[+-]?\d+)?|inf|nan)")
PAUSE_S = 0.01  # between two tries to get a lock, which others hold for milliseconds
# The run that this process began last, by folder. Another process may have begun one since.
_begun: dict[Path, int] = {}


class Rows:
    """The rows of one study in `<folder>/<study>.csv`; each is written as soon as it is added.

    A row is a dictionary of bool, int, float, str or None. The file has the key columns first,
    then `run`, which is the id of a line of `runs.csv`, then all other columns. A row with a new
    column adds that column to the file. An empty string is read back as None.

    Attributes:
        folder: Folder of the CSV files.
        path: The CSV file of this study.
        keys: Columns that say what a row is about.
    """

    def __init__(self, folder: Path | str, study: str, keys: Iterable[str]) -> None:
        """Open the rows of a study.

        Args:
            folder: Folder of the CSV files; the first row creates it.
            study: Name of the file, without `.csv`.
            keys: Columns that say what a row is about.
        """
        self.folder = Path(folder)
        self.path = self.folder / f"{study}.csv"
        self.keys = tuple(keys)
        _drop_half_line(self.path)
        self._columns, lines = _lines(self.path)
        missing = {*self.keys, "run"} - {*self._columns} if self._columns else ()
        if missing:
            raise _damaged(self.path, 1, f"the columns {sorted(missing)} are missing")
        known = runs(self.folder)
        begun = _begun.get(self.folder.resolve())
        own = [row for row in known if row["run"] == begun] or known[-1:]
        self._run = own[-1]["run"] if own else None
        alike = {row["run"] for row in known if row["quick"] == own[-1]["quick"]}
        self._seen = {self._key(row) for row in lines if row["run"] in alike}

    def has(self, **key: Any) -> bool:
        """Return whether a run that was quick or full like the current one has this row."""
        return self._key(key) in self._seen

    def add(self, **row: Any) -> None:
        """Append a row; it is on the disk when this returns.

        Raises:
            ValueError: A key is missing, the outcome is unknown, or a value has another type.
        """
        missing = [name for name in self.keys if name not in row]
        if missing:
            raise ValueError(f"expected the keys {self.keys}, but {missing} are missing")
        if row.get("outcome", OUTCOMES[0]) not in OUTCOMES:
            raise ValueError(f"outcome: expected one of {OUTCOMES}, got {row['outcome']!r}")
        if self._run is None:
            self._run = begin_run(self.folder, "python", False)
        row = {name: _plain(name, value) for name, value in row.items()} | {"run": self._run}
        self._make_room(row)
        _append(self.path, [_written(row.get(name)) for name in self._columns])
        self._seen.add(self._key(row))

    def all(self) -> list[Row]:
        """Return every row, each value with its type."""
        return _lines(self.path)[1]

    def _key(self, row: Row) -> tuple[str, ...]:
        return tuple(_written(_plain(name, row.get(name))) for name in self.keys)

    def _make_room(self, row: Row) -> None:
        """Write the file again if the row has columns that the file does not have."""
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


def read(folder: Path | str, study: str) -> list[Row]:
    """Return the rows of a study; an empty list if the study was not run."""
    return _lines(Path(folder) / f"{study}.csv")[1]


def runs(folder: Path | str) -> list[Row]:
    """Return the runs that measured the rows, with RUN_COLUMNS, the oldest first."""
    found = read(folder, RUNS)
    if found and not set(RUN_COLUMNS) <= found[0].keys():
        raise _damaged(Path(folder) / f"{RUNS}.csv", 1, f"expected the columns {RUN_COLUMNS}")
    return found


def runs_of(folder: Path, rows: Iterable[Row]) -> list[Row]:
    """Return the runs that measured these rows, the oldest first."""
    used = {row["run"] for row in rows}
    return [run for run in runs(folder) if run["run"] in used]


def begin_run(folder: Path | str, command: str, quick: bool) -> int:
    """Record the command, commit, machine and versions that are about to measure rows.

    If all of them, and `quick`, are those of the last run, that run is continued. Processes that
    begin runs in one folder at the same moment do so one after the other, so that each has its own
    id. A process that is killed meanwhile blocks nobody: the system releases its lock.

    Args:
        folder: Folder of the CSV files; created if it does not exist.
        command: The command that measures.
        quick: Whether it measures fewer and smaller cases.

    Returns:
        The id of the run, which every row that is added from now on carries.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{RUNS}.csv"
    made = {**provenance.made_by(command)._asdict(), "quick": bool(quick)}
    with _alone(path):
        _drop_half_line(path)
        before = runs(folder)
        if before and all(before[-1][name] == value for name, value in made.items()):
            number = before[-1]["run"]
        else:
            number = 1 + max((row["run"] for row in before), default=0)
            if not _lines(path)[0]:
                _append(path, RUN_COLUMNS)
            started = datetime.now(UTC).isoformat(timespec="seconds")
            row = {"run": number, **made, "started": started}
            _append(path, [_written(_plain(name, row[name])) for name in RUN_COLUMNS])
    _begun[folder.resolve()] = number
    return number


@contextmanager
def _alone(path: Path) -> Iterator[None]:
    """Wait until no other process is between the lines of this block with the same file."""
    with open(path, "ab") as file:
        while not lock(file.fileno()):
            time.sleep(PAUSE_S)
        yield


def _plain(name: str, value: Any) -> Any:
    """Return a value that a line can hold: a scalar of numpy as one of Python."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, str):
        return " ".join(value.split())  # a row is one line
    if not isinstance(value, (bool, int, float, type(None))):
        raise ValueError(f"{name}: expected bool, int, float, str or None, got {value!r}")
    return value


def _written(value: Any) -> str:
    """Return the text of a cell; a string that would be read back as a number gets quotes."""
    if value is None:
        return ""
    if isinstance(value, str):
        return value if value == "" or _parsed(value) == value else f'"{value}"'
    return repr(value)


def _parsed(text: str) -> Any:
    """Return the value of a cell; the inverse of `_written`."""
    if text in ("", "True", "False"):
        return {"": None, "True": True, "False": False}[text]
    if text[0] == text[-1] == '"' and len(text) > 1:
        return text[1:-1]
    if INTEGER.fullmatch(text) and len(text) < DIGITS:
        return int(text)
    return float(text) if FLOAT.fullmatch(text) else text


def _line(cells: Iterable[str]) -> str:
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerow(cells)
    return out.getvalue()


def _append(path: Path, cells: Iterable[str]) -> None:
    """Add a line to a file; if that fails, the file is as it was.

    Raises:
        OSError: The line cannot be written, for example because the disk is full.
    """
    with open(path, "ab", buffering=0) as file:
        before = file.tell()
        try:
            line = memoryview(_line(cells).encode())
            while line:
                line = line[file.write(line) :]
        except OSError as error:
            file.truncate(before)
            raise OSError(error.errno, error.strerror, str(path)) from None


def _whole_lines(path: Path) -> str:
    """Return the text up to the last line break; a line without one was cut off while written."""
    text = read_bytes(path).decode(errors="replace") if path.is_file() else ""
    return text[: text.rfind("\n") + 1]


def _drop_half_line(path: Path) -> None:
    """Remove a last line that was cut off while it was written."""
    if path.is_file():
        whole = path.read_bytes()
        end = whole.rfind(b"\n") + 1
        if end < len(whole):
            with open(path, "r+b") as file:
                file.truncate(end)


def _lines(path: Path) -> tuple[list[str], list[Row]]:
    """Return the columns of a file, and a row for each of its lines."""
    try:
        lines = list(csv.reader(io.StringIO(_whole_lines(path)), strict=True))
    except csv.Error as error:
        raise _damaged(path, 1, str(error)) from None
    if not lines:
        return [], []
    columns = lines[0]
    if len(set(columns)) != len(columns):
        raise _damaged(path, 1, "a column is there twice")
    rows = []
    for number, cells in enumerate(lines[1:], 2):
        if len(cells) != len(columns):
            raise _damaged(path, number, f"expected {len(columns)} cells, found {len(cells)}")
        rows.append(dict(zip(columns, map(_parsed, cells), strict=True)))
    return columns, rows


def _damaged(path: Path, line: int, found: str) -> FileFormatError:
    return FileFormatError(
        f"{path}, line {line}: {found}; correct it, or delete the file to measure its rows again"
    )
