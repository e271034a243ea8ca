"""Open files that users name: regular files only, and no more than a stated number of bytes.

A named pipe would wait for ever, and a device such as /dev/zero has no end.
"""

from __future__ import annotations

import os
import stat
from pathlib import Path
from typing import BinaryIO, TypeAlias

from izo_ref.base.errors import FileFormatError

FilePath: TypeAlias = str | os.PathLike[str]
# Largest text that is read: an index of a trace, vectors, replies, known failures, rows. All
# vectors together have 2 MB.
LARGEST_TEXT = 256 << 20
PIECE = 1 << 20  # bytes that are read at once
KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


def open_input(path: FilePath) -> BinaryIO:
    """Open a regular file to read its bytes.

    Args:
        path: The file; a link to a file is one.

    Raises:
        FileFormatError: It is no file, or cannot be read; says why.
    """
    try:
        # opening a pipe without O_NONBLOCK waits until somebody writes to it
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | _BINARY)
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        reason = getattr(error, "strerror", None) or error
        raise FileFormatError(f"{_name(path)}: cannot be read: {reason}") from None
    mode = os.fstat(handle).st_mode
    if stat.S_ISREG(mode):
        return os.fdopen(handle, "rb")
    os.close(handle)
    found = next((word for is_kind, word in KINDS if is_kind(mode)), "something else")
    raise FileFormatError(
        f"{_name(path)}: cannot be read: expected a file, found {found}; name a file"
    )


_BINARY = getattr(os, "O_BINARY", 0)  # of Windows


def _name(path: FilePath) -> str:
    """Return a path as a message can print it, whatever bytes it has."""
    return os.fspath(path).encode("utf-8", "backslashreplace").decode()


def read_bytes(path: FilePath, largest: int = LARGEST_TEXT) -> bytes:
    """Return the content of a regular file.

    Args:
        path: The file.
        largest: Largest number of bytes that is read.

    Raises:
        FileFormatError: It is no file, cannot be read, or is larger.
    """
    content = bytearray()
    with open_input(path) as file:
        try:
            # in pieces, because `read` takes the memory for all that it is asked for
            while len(content) <= largest and (piece := file.read(PIECE)):
                content += piece
        except OSError as error:
            raise FileFormatError(
                f"{_name(path)}: cannot be read: {error.strerror or error}"
            ) from None
    if len(content) > largest:
        raise FileFormatError(
            f"{_name(path)}: cannot be read: expected at most {largest} bytes, found more"
        )
    return bytes(content)


def read_text(path: FilePath, encoding: str = "utf-8", largest: int = LARGEST_TEXT) -> str:
    """Return the content of a regular file as text.

    Args:
        path: The file.
        encoding: How its characters are written.
        largest: Largest number of bytes that is read.

    Raises:
        FileFormatError: It is no file, cannot be read, is larger, or has other characters.
    """
    try:
        return read_bytes(path, largest).decode(encoding)
    except UnicodeDecodeError as error:
        raise FileFormatError(
            f"{_name(Path(path))}: expected a text in {encoding.upper()}, found the byte "
            f"{error.object[error.start]:#04x} at {error.start}"
        ) from None
