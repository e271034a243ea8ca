"""Steps in and out of files.

A step is a numpy `.npz` archive with `positions_t0`, `positions_t1` (n, 3) [m], `faces`
(m, 3), and optionally `masses` (n,) [kg] and `pinned` (n,) bool. A result is an `.npz`
archive with `positions` (n, 3) [m].
"""

import json
import os
import tempfile
import zipfile
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from izo_ref.errors import FileFormatError
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


def load_positions(path) -> np.ndarray:
    """Read the end positions of a result."""
    return _load(path, ("positions",))["positions"]


def save_positions(path, positions):
    """Write the end positions of a result; the file appears whole or not at all."""
    with replacing(path) as file:
        np.savez_compressed(file, positions=positions)


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
