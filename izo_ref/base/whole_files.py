"""Write a file whole or not at all, whatever ends the process, and leave nothing else behind.

The content goes to a hidden file beside the target, `.NAME.XXXXXXXX.unfinished`, which then takes
the target's place in one step. A process that is killed while it writes leaves that file. It holds
a lock, which the system releases when the process dies. So the next write of the same target finds
out that nobody writes to the old file any more, and deletes it. Such files do not pile up.
"""

from __future__ import annotations

import errno
import os
import re
import shutil
import stat
import tempfile
import uuid
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import ModuleType
from typing import BinaryIO

FilePath = str | os.PathLike[str]
Content = bytes | memoryview

fcntl: ModuleType | None
try:
    import fcntl
except ImportError:  # Windows, where an open file cannot be deleted anyway
    fcntl = None

UNFINISHED = ".unfinished"
# A file name has at most 255 bytes on most systems; a character of UTF-8 has up to 4.
LONGEST = 48
BINARY = getattr(os, "O_BINARY", 0)


def write_whole(path: FilePath, content: Content) -> None:
    """Write a file, which appears whole or not at all.

    A link is followed, and a file that exists keeps its permissions. A device or a pipe, such as
    `/dev/null`, stays what it is, and the content is written to it.

    Args:
        path: The file to write or to replace.
        content: Its content.

    Raises:
        OSError: The file cannot be written; an old one is as it was.
    """
    path = os.path.realpath(path)
    old = _stat(path)
    if old is not None and not stat.S_ISREG(old.st_mode):
        _write_through(path, content)
        return
    if old is not None and not os.access(path, os.W_OK):
        raise PermissionError(errno.EACCES, "the file there is read-only", path)
    replace_whole(path, content, None if old is None else stat.S_IMODE(old.st_mode))


def replace_whole(path: FilePath, content: Content, mode: int | None) -> None:
    """Put a new file in the place of another one, or of a link.

    Args:
        path: The name of the file.
        content: Its content.
        mode: Its permissions; None takes those that new files have.

    Raises:
        OSError: The file cannot be written; an old one is as it was.
    """
    with open_whole(path) as file:
        if mode is not None and hasattr(os, "fchmod"):
            os.fchmod(file.fileno(), mode)
        _write_all(file.fileno(), content)


@contextmanager
def open_whole(path: FilePath) -> Iterator[BinaryIO]:
    """Open a new file, which takes the place of another one when the block ends without an error.

    Use it for content that is larger than memory.

    Args:
        path: The name of the file.

    Yields:
        The new file, to write bytes to.

    Raises:
        OSError: The file cannot be written; an old one is as it was.
    """
    delete_leftovers(path)
    handle, new = _open_new(path)
    try:
        with os.fdopen(handle, "wb") as file:
            yield file
            file.flush()
            os.fsync(handle)  # some file systems say only here that they are full
            if fcntl is not None:
                os.replace(new, path)  # before the lock ends
        if fcntl is None:
            os.replace(new, path)
    except BaseException:
        with suppress(OSError):
            os.unlink(new)
        raise


def delete_leftovers(path: FilePath) -> None:
    """Delete what earlier processes left that were killed while they wrote this file or folder.

    Args:
        path: The file or the folder, without links.
    """
    for name in leftovers(path):
        _delete_if_dead(name)


def leftovers(path: FilePath) -> list[str]:
    """Return the unfinished files of a file or a folder, those of living processes as well."""
    folder, begin = _folder_and_begin(path)
    ours = re.compile(re.escape(begin) + "[0-9a-f]{8}" + re.escape(UNFINISHED))
    try:
        return [os.path.join(folder, name) for name in os.listdir(folder) if ours.fullmatch(name)]
    except OSError:
        return []


def unfinished_name(path: FilePath) -> str:
    """Return a new name beside a file or folder, for what will take its place."""
    folder, begin = _folder_and_begin(path)
    return os.path.join(folder, f"{begin}{uuid.uuid4().hex[:8]}{UNFINISHED}")


def lock(handle: int) -> bool:
    """Lock an open file or folder until it is closed or the process dies.

    Returns:
        Whether nobody else has locked it. True if the system has no locks.
    """
    if fcntl is None:
        return True
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # a file system without locks
        return True
    return True


def _stat(path: str) -> os.stat_result | None:
    try:
        return os.stat(path)
    except FileNotFoundError:
        return None


def _write_through(path: str, content: Content) -> None:
    """Write to a device or a pipe."""
    handle = os.open(path, os.O_WRONLY | BINARY)
    try:
        _write_all(handle, content)
    finally:
        os.close(handle)


def _write_all(handle: int, content: Content) -> None:
    rest = memoryview(content)
    while rest:
        rest = rest[os.write(handle, rest) :]


def _folder_and_begin(path: FilePath) -> tuple[str, str]:
    folder, name = os.path.split(os.path.abspath(path))
    return folder, f".{name[:LONGEST]}."


def _open_new(path: FilePath) -> tuple[int, str]:
    """Open a new, locked file beside another one; return its handle and its name."""
    for _ in range(tempfile.TMP_MAX):
        new = unfinished_name(path)
        handle = os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL | BINARY, 0o666)
        # Between these lines, another process may take it for a leftover, and delete it.
        if lock(handle) and os.fstat(handle).st_nlink > 0:
            return handle, new
        os.close(handle)
        with suppress(OSError):
            os.unlink(new)
    raise FileExistsError(errno.EEXIST, "no free name for a new file", path)


def _delete_if_dead(path: str) -> None:
    """Delete an unfinished file or folder that no process has locked."""
    if fcntl is None:
        return
    try:
        handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    except OSError:
        return
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if stat.S_ISDIR(os.fstat(handle).st_mode):
            shutil.rmtree(path)
        else:
            os.unlink(path)
    except OSError:  # its process is alive, or the file system has no locks
        pass
    finally:
        os.close(handle)
