"""Steps in and out of files.

A step is a numpy `.npz` archive with `positions_t0`, `positions_t1` (n, 3) [m], `faces`
(m, 3), and optionally `masses` (n,) [kg] and `pinned` (n,) bool. A result is an `.npz`
archive with `positions` (n, 3) [m]; those of `izo resolve` also hold what it takes to judge
the zones again: `thickness` [m], `multipliers` (k,) [kg] and the impacts, `impact_nodes`
(k, 4), `impact_is_edge_edge` (k,), `impact_toi` (k,), `impact_weights` (k, 4) and
`impact_normals` (k, 3).
"""

import json
import os
import tempfile
import zipfile
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np

from izo_ref.base.errors import FileFormatError
from izo_ref.base.records import Impacts
from izo_ref.scene import Scene

REQUIRED = ("positions_t0", "positions_t1", "faces")
OPTIONAL = ("masses", "pinned")


def load_scene(path, initial_intersections="raise") -> Scene:
    """Read a step.

    Raises:
        FileFormatError: the file cannot be read, or lacks an array; and what `Scene` raises.
    """
    arrays = _load(path, REQUIRED)
    optional = {name: arrays[name] for name in OPTIONAL if name in arrays}
    required = [arrays[name] for name in REQUIRED]
    return Scene(*required, **optional, initial_intersections=initial_intersections)


class SavedResult(NamedTuple):
    """A result as it is in a file; None for what is not in it."""

    positions: np.ndarray  # (n, 3) f8 [m]
    thickness: float | None  # [m]
    impacts: Impacts | None
    multipliers: np.ndarray | None  # (n_impacts,) f8 [kg]


def load_result(path) -> SavedResult:
    """Read a result, anybody's: only its positions have to be there.

    Raises:
        FileFormatError: the file cannot be read, or lacks an array; or some of the arrays
            that describe the zones are there and others are not.
    """
    arrays = _load(path, ("positions",))
    names = ("thickness", "multipliers", *(f"impact_{name}" for name in Impacts._fields))
    missing = [name for name in names if name not in arrays]
    if missing == list(names) or missing == list(names)[1:]:
        return SavedResult(arrays["positions"], _thickness(path, arrays), None, None)
    if missing:
        raise FileFormatError(f"{path}: holds impacts, but {', '.join(missing)} is missing")
    impacts = Impacts(*(arrays[name] for name in names[2:]))
    if len({column.shape[:1] for column in (*impacts, arrays["multipliers"])}) != 1:
        raise FileFormatError(f"{path}: the arrays of its impacts differ in length")
    return SavedResult(
        arrays["positions"], _thickness(path, arrays), impacts, arrays["multipliers"]
    )


def _thickness(path, arrays):
    if "thickness" not in arrays:
        return None
    if arrays["thickness"].shape != () or arrays["thickness"].dtype.kind not in "fiu":
        raise FileFormatError(f"{path}: expected thickness to be one number")
    return float(arrays["thickness"])


def save_result(path, result: SavedResult):
    """Write a result; the file appears whole or not at all.

    Args:
        result: anything with positions, thickness, impacts and multipliers, as `Result` and
            `SavedResult`; all but the positions may be None.
    """
    arrays = {"positions": result.positions}
    if result.thickness is not None:
        arrays["thickness"] = result.thickness
    if result.impacts is not None:
        arrays["multipliers"] = result.multipliers
        columns = result.impacts._asdict().items()
        arrays |= {f"impact_{name}": column for name, column in columns}
    with replacing(path) as file:
        np.savez_compressed(file, **arrays)


def save_scene(path, scene: Scene):
    """Write a step; the file appears whole or not at all."""
    arrays = {name: getattr(scene, name) for name in REQUIRED + OPTIONAL}
    with replacing(path) as file:
        np.savez_compressed(file, **arrays)


def save_json(path, content):
    """Write a report; the file appears whole or not at all."""
    with replacing(path) as file:
        file.write((json.dumps(content, indent=1) + "\n").encode())


def check_writable(path):
    """Before work is done that would be lost: whether a file can be made there.

    Raises:
        FileFormatError.
    """
    folder = Path(path).parent
    if not os.access(folder, os.W_OK) or Path(path).is_dir():
        raise FileFormatError(f"{path}: cannot be written")


def _load(path, names):
    try:
        archive = np.load(path, allow_pickle=False)
        if isinstance(archive, np.ndarray):
            raise FileFormatError(f"{path}: expected an .npz archive, got a single array")
        with archive:
            arrays = {name: archive[name] for name in archive.files}
    except OSError as error:
        raise FileFormatError(f"{path}: cannot be read: {error.strerror or error}") from None
    except (ValueError, zipfile.BadZipFile, EOFError) as error:
        raise FileFormatError(f"{path}: expected an .npz archive: {error}") from None
    missing = [name for name in names if name not in arrays]
    if missing:
        raise FileFormatError(
            f"{path}: expected arrays {', '.join(names)}; {', '.join(missing)} missing, "
            f"found {', '.join(arrays) or 'none'}"
        )
    return arrays


@contextmanager
def replacing(path):
    """Open a file beside `path` that takes its place once it is written."""
    path = Path(path)
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=path.name)
    except OSError as error:
        raise FileFormatError(f"{path}: cannot be written: {error.strerror}") from None
    try:
        with os.fdopen(handle, "wb") as file:
            yield file
        os.chmod(name, 0o666 & ~_umask())
        os.replace(name, path)
    except BaseException:
        os.unlink(name)
        raise


def _umask():
    mask = os.umask(0)
    os.umask(mask)
    return mask
