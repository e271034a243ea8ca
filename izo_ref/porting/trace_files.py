"""The folder of a trace: one .npy file for each array, and `index.json`, which is written last.

Each file appears whole or not at all.

A trace of a run, and the dump that a porter writes, have the same layout and the same names, those
of `stages.py`:

    scene/              positions_t0, positions_t1, faces, masses, pinned, thickness
    iteration-0001/     positions_t1: end of the path that was examined
      found/            nodes, edge_edge_impacts, toi, weights, normals: the impacts of that path;
                        hopeful: those that a solver could mend; deep: those of deep zones;
                        selected: those that enter zones
      zones/            nodes, edge_edge_impacts, toi, weights, normals of all impacts in zones;
                        zone_of_impact
                        positions, multipliers, objective: after the zones were solved
    iteration-0002/     ...
    result/             positions, objective, free, and the impacts in zones as above

The kinds of iterations are in KINDS. `index.json` says of which kind each one is. A dump needs no
`index.json`.
"""

from __future__ import annotations

import io
import json
import math
import os
from pathlib import Path
from typing import Any

import numpy as np

from izo_ref.base.archives import read_archive, read_array
from izo_ref.base.errors import FileFormatError
from izo_ref.base.input_files import read_text
from izo_ref.base.values import plain_text, shown
from izo_ref.base.whole_files import write_whole

INDEX = "index.json"
VERSION = 1  # of the layout
DEPTH = 3  # folders below that of a trace or a dump; a trace has two
MOST_FILES = 200_000  # a trace of 5,000 iterations has 130,000
MODES = {"initial_intersections", "prescribed", "weld"}  # arguments of `Scene` in an index
KINDS = {
    "detect": "a path is examined, impacts are selected, and the zones that changed are solved",
    "relinearize": "tight impacts get new weights and normals at the answer, and all zones are "
    "solved again from the proposed positions",
    "restore": "the last round of new normals ended farther away, so its positions are given up",
    "scale-back": "the fail-safe moves vertices back toward the start",
}
UNITS = {
    "positions_t0": "m",
    "positions_t1": "m",
    "positions": "m",
    "masses": "kg",
    "welded_masses": "kg",
    "thickness": "m",
    "multipliers": "kg",
    "objective": "m^2",
}


class TraceFolder:
    """A new folder with the arrays of a trace.

    Args:
        path: The folder; it is created if it does not exist.

    Raises:
        FileFormatError: The folder is not empty, or cannot be written.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        """Create the folder."""
        check_folder(path)
        self.path = Path(path)
        self._arrays: dict[str, dict[str, Any]] = {}
        self._make(self.path)

    def write(self, place: str, **arrays: Any) -> None:
        """Write arrays.

        Args:
            place: The folder inside of the trace, such as `iteration-0001/found`.
            arrays: The arrays, or numbers, by name.

        Raises:
            FileFormatError: An array cannot be written.
        """
        self._make(self.path / place)
        for name, values in arrays.items():
            array, key = np.asarray(values), f"{place}/{name}"
            content = io.BytesIO()
            np.save(content, array, allow_pickle=False)
            self._write_file(f"{key}.npy", content.getbuffer())
            what = {"dtype": array.dtype.str, "shape": list(array.shape)}
            self._arrays[key] = what | ({"unit": UNITS[name]} if name in UNITS else {})

    def finish(self, facts: dict[str, Any]) -> None:
        """Write `index.json`, which says that the trace is complete.

        Args:
            facts: What it says besides the version and the list of arrays.

        Raises:
            FileFormatError: It cannot be written.
        """
        content = {"trace": VERSION, **facts, "kinds": KINDS, "arrays": self._arrays}
        text = json.dumps(_plain(content), indent=1, allow_nan=False)
        self._write_file(INDEX, (text + "\n").encode())

    def _write_file(self, name: str, content: bytes | memoryview) -> None:
        try:
            write_whole(self.path / name, content)
        except OSError as error:
            raise _cannot_write(self.path, error) from None

    def _make(self, folder: Path) -> None:
        try:
            folder.mkdir(exist_ok=True, parents=folder != self.path)
        except OSError as error:
            raise _cannot_write(self.path, error) from None


def check_folder(path: str | os.PathLike[str]) -> None:
    """Check that a folder can take a trace: it is empty, or is in a folder that exists.

    Raises:
        FileFormatError: It cannot; says why.
    """
    folder = Path(path)
    if folder.exists() and not folder.is_dir():
        raise FileFormatError(f"{path}: expected a folder for the trace, found a file")
    if folder.is_dir() and any(folder.iterdir()):
        raise FileFormatError(
            f"{path}: expected an empty folder for the trace, or the name of a new one, found a "
            "folder with files in it; delete them, or name another folder"
        )
    if not folder.is_dir() and not folder.absolute().parent.is_dir():
        raise FileFormatError(
            f"{path}: cannot be created: there is no folder {folder.parent}; create it"
        )


def load_arrays(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Read the arrays of a trace or of a dump.

    Args:
        path: A folder of .npy files, or one .npz archive whose names contain the same slashes.

    Returns:
        The arrays by name, such as `scene/positions_t0`.

    Raises:
        FileFormatError: There is no such folder or archive, a file is damaged, or a trace was not
            finished.
    """
    where = Path(path)
    if not os.path.isdir(where):  # unlike the method of a Path, no name makes it raise an error
        if not os.path.lexists(where):
            raise FileFormatError(f"{path}: there is no such folder or .npz archive")
        return read_archive(where)
    arrays: dict[str, Any] = {}
    for file in _files_of(where):
        place = file.relative_to(where).with_suffix("").as_posix()
        if file.suffix == ".npz":
            inner = "" if file.parent == where else f"{file.parent.relative_to(where).as_posix()}/"
            found = {f"{inner}{name}": values for name, values in read_archive(file).items()}
        else:
            found = {place: read_array(file)}
        twice = sorted(found.keys() & arrays.keys())
        if twice:
            raise FileFormatError(f"{path}: the array {twice[0]} is in two files")
        arrays |= found
    return arrays


def _files_of(folder: Path) -> list[Path]:
    """Return the files of arrays in a folder and up to `DEPTH` folders below it, sorted."""
    found, seen, level = [], 0, [folder]
    for _ in range(DEPTH + 1):
        below = []
        for parent in level:
            try:
                entries = list(parent.iterdir())
            except OSError as error:
                raise FileFormatError(f"{parent}: cannot be read: {error.strerror}") from None
            seen += len(entries)
            if seen > MOST_FILES:
                raise FileFormatError(
                    f"{folder}: expected at most {MOST_FILES} files, found more; name the folder "
                    "of one trace or dump"
                )
            found += [entry for entry in entries if entry.suffix in (".npy", ".npz")]
            below += [e for e in entries if e.is_dir() and not e.is_symlink()]
        level = below
    return sorted(found)


def load_index(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Return what `index.json` says; nothing if there is none, as in the dump of a port.

    Raises:
        FileFormatError: It is damaged.
    """
    file = Path(path) / INDEX
    if not os.path.isfile(file):
        return {}
    try:
        content = json.loads(read_text(file))
    except (ValueError, RecursionError) as error:
        raise FileFormatError(f"{file}: expected JSON: {plain_text(error)}") from None
    if not isinstance(content, dict):
        raise FileFormatError(f"{file}: expected an object of JSON, found {shown(content)}")
    scene, iterations = content.get("scene", {}), content.get("iterations", [])
    if not isinstance(scene, dict) or not scene.keys() <= MODES:
        raise FileFormatError(
            f"{file}: scene: expected an object with members of {sorted(MODES)}, found "
            f"{shown(scene)}"
        )
    rows = iterations if isinstance(iterations, list) else [None]
    other = [row for row in rows if not (isinstance(row, dict) and _has_texts(row))]
    if other:
        raise FileFormatError(
            f"{file}: iterations: expected a list of objects with the text `folder`, found "
            f"{shown(other[0])}"
        )
    return content


def _has_texts(row: dict[str, Any]) -> bool:
    """Return whether a record of an iteration names its folder, and its rule if it has one."""
    return isinstance(row.get("folder"), str) and isinstance(row.get("selection", ""), str)


def _plain(value: Any) -> Any:
    """Return a value that JSON can hold; infinite numbers become texts."""
    if isinstance(value, dict):
        return {name: _plain(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    value = value.item() if isinstance(value, np.generic) else value
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value


def _cannot_write(path: Path, error: OSError) -> FileFormatError:
    return FileFormatError(f"{path}: cannot be written: {error.strerror or error}")
