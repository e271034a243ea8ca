"""Let a library write a file by its path, and give the file its name when it is complete."""

from __future__ import annotations

import os
import shutil
import stat
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from izo_ref.base import whole_files
from izo_ref.base.arrays import Positions
from izo_ref.base.errors import FileFormatError
from izo_ref.formats.animation import FilePath
from izo_ref.formats.frames import check_suffix, refuse_inputs


@contextmanager
def named_output(path: FilePath, suffix: str, inputs: Iterable[FilePath]) -> Iterator[str]:
    """Give a name in a new folder beside a file; what is written there takes the file's place.

    The folder is locked while this process lives, so that the next write of the same file deletes
    what a process left that was killed.

    Args:
        path: The file to write or to replace. A link is followed.
        suffix: The suffix that it has to have, in small letters.
        inputs: Files that are being read, which must not be replaced.

    Yields:
        The name to write to.

    Raises:
        FileFormatError: The suffix is another one, the file is one of the inputs, or it cannot be
            written.
    """
    check_suffix(path, suffix)
    real = os.path.realpath(path)
    refuse_inputs(Path(real), map(Path, inputs))
    folder = whole_files.unfinished_name(real)
    handle = None
    try:
        mode = _mode_of_old(real)
        whole_files.delete_leftovers(real)
        os.mkdir(folder, 0o700)
        handle = os.open(folder, os.O_RDONLY) if whole_files.fcntl is not None else None
        if handle is not None:
            whole_files.lock(handle)
        new = os.path.join(folder, "new" + suffix)
        yield new
        if mode is not None:
            os.chmod(new, mode)
        os.replace(new, real)
    except OSError as error:
        raise FileFormatError(f"{path}: cannot be written: {error.strerror or error}") from None
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        if handle is not None:
            os.close(handle)


def _mode_of_old(real: str) -> int | None:
    try:
        old = os.stat(real)
    except FileNotFoundError:
        return None
    if not stat.S_ISREG(old.st_mode):
        raise OSError("expected the name of a file")
    if not os.access(real, os.W_OK):
        raise OSError("the file there is read-only")
    return stat.S_IMODE(old.st_mode)


def checked_frames(
    frames: Iterable[Positions], n_vertices: int, n_frames: int, path: FilePath
) -> Iterator[tuple[int, Positions]]:
    """Yield the number and the positions of each frame that is to be written.

    Args:
        frames: (n_vertices, 3) f8 each.
        n_vertices: Number of vertices that each has to have.
        n_frames: The largest number of frames.
        path: Where they are written, for the message.

    Raises:
        FileFormatError: There is no frame, there are too many, or one has another shape or a number
            that is not finite.
    """
    n_written = 0
    for number, frame in enumerate(frames):
        if number == n_frames:
            raise FileFormatError(f"{path}: expected at most {n_frames} frames, found more")
        positions = np.asarray(frame, np.float64)
        if positions.shape != (n_vertices, 3):
            raise FileFormatError(
                f"{path}: frame {number}: expected the shape {(n_vertices, 3)}, found "
                f"{positions.shape}"
            )
        if not np.isfinite(positions).all():
            raise FileFormatError(f"{path}: frame {number}: expected finite positions")
        yield number, positions
        n_written += 1
    if not n_written:
        raise FileFormatError(f"{path}: expected at least one frame, found none")


def split(positions: Positions, sizes: Sequence[int]) -> list[Positions]:
    """Cut the positions of all meshes into those of each mesh.

    Args:
        positions: (sum of sizes, 3) f8.
        sizes: Number of vertices of each mesh.
    """
    return np.split(positions, np.cumsum(sizes)[:-1])
