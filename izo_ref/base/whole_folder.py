"""Write a folder of files whole or not at all, whatever ends the process.

It is written beside the target, and locked, as `whole_files.py` does it with files. Linux and macOS
can exchange two folders in one step, so at each moment the name has the old files or the new ones.
Elsewhere two steps are needed; a process that is killed between them leaves the old files in the
hidden folder, and nothing under the name.
"""

from __future__ import annotations

import ctypes
import errno
import os
import shutil
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from izo_ref.base.whole_files import delete_leftovers, lock, replace_whole, unfinished_name

HERE = -100  # AT_FDCWD of Linux: names are relative to the working folder
EXCHANGE = 2  # RENAME_EXCHANGE of Linux, and RENAME_SWAP of macOS


def replace_folder(files: Mapping[str, bytes], folder: Path) -> None:
    """Write files into a new folder that takes the place of another one.

    Args:
        files: The content of each file, by its name.
        folder: The folder, without links. If it exists, it is deleted with all that is in it.

    Raises:
        OSError: The folder cannot be written; an old one is as it was.
    """
    with open_folder(folder) as new:
        for name, content in files.items():
            replace_whole(os.path.join(new, name), content, None)


@contextmanager
def open_folder(folder: Path) -> Iterator[Path]:
    """Make a new folder, which takes the place of another one when the block ends without an error.

    Use it for files that are larger than memory in all.

    Args:
        folder: The folder, without links. If it exists, it is deleted with all that is in it.

    Yields:
        The new folder, to write files into.

    Raises:
        OSError: The folder cannot be written; an old one is as it was.
    """
    delete_leftovers(folder)
    new = unfinished_name(folder)
    os.mkdir(new)
    handle = _open_locked(new)
    try:
        yield Path(new)
        if folder.exists():
            _exchange(new, str(folder))
        else:
            os.rename(new, folder)
    finally:
        shutil.rmtree(new, ignore_errors=True)  # the old folder, or what was written so far
        if handle is not None:
            os.close(handle)


def _open_locked(folder: str) -> int | None:
    """Lock a folder until its handle is closed; None where folders cannot be opened."""
    if os.name == "nt":
        return None
    handle = os.open(folder, os.O_RDONLY)
    lock(handle)
    return handle


def _exchange(one: str, other: str) -> None:
    """Exchange the names of two folders, in one step if the system can do that."""
    if _exchange_at_once(one, other):
        return
    between = one + ".old"
    os.rename(other, between)
    try:
        os.rename(one, other)
    except BaseException:
        os.rename(between, other)
        raise
    os.rename(between, one)


def _exchange_at_once(one: str, other: str) -> bool:
    """Exchange two names in one step; False if the system or the file system cannot do that."""
    names = os.fsencode(one), os.fsencode(other)
    try:
        library = ctypes.CDLL(None, use_errno=True)
        if sys.platform == "darwin":
            failed = library.renamex_np(*names, EXCHANGE)
        else:
            failed = library.renameat2(HERE, names[0], HERE, names[1], EXCHANGE)
    except (AttributeError, OSError, TypeError):  # a C library without such a function
        return False
    if failed and ctypes.get_errno() not in (errno.EINVAL, errno.ENOSYS, errno.ENOTSUP):
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()), other)
    return not failed
