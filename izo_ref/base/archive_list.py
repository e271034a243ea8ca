"""The list of contents of an .npz archive: how long it may be, and how many arrays it declares."""

from __future__ import annotations

import io
import struct
from typing import BinaryIO

from izo_ref.base.npy_header import HeaderError

LARGEST_LIST = 4 << 20  # bytes of an archive's list of contents
END, WIDE_END = b"PK\x05\x06", b"PK\x06\x06"  # records at the end of an archive
# bytes: the record, its comment, and the two records of large archives
LONGEST_END = 22 + 0xFFFF + 76


def declared_count(file: BinaryIO, size: int) -> int:
    """Return how many files the end of an archive says there are.

    Python's reader does not compare it with what it finds. So one wrong bit in the length of a
    comment would make the next array disappear without an error.

    Args:
        file: The archive.
        size: Number of its bytes.
    """
    file.seek(max(0, size - LONGEST_END))
    tail = file.read(LONGEST_END)
    at = tail.rfind(END)
    count = int(struct.unpack_from("<H", tail, at + 10)[0])
    wide = tail.rfind(WIDE_END, 0, at)
    if count == 0xFFFF and wide >= 0:
        count = int(struct.unpack_from("<Q", tail, wide + 32)[0])
    return count


class Bounded(io.BufferedIOBase):
    """A file of which one read takes at most the bytes of the largest list of contents."""

    def __init__(self, file: BinaryIO) -> None:
        """Keep the file, which is read through this one."""
        self._file = file

    def read(self, size: int | None = -1) -> bytes:
        """Return the next bytes; raise a HeaderError if more are asked for than a list may have."""
        if size is None or size > LARGEST_LIST:
            raise HeaderError(
                f"its list of contents has {size} bytes, expected at most {LARGEST_LIST}; save "
                "fewer arrays, or a folder of .npy files"
            )
        return self._file.read(LARGEST_LIST if size < 0 else size)

    def seek(self, offset: int, whence: int = 0) -> int:
        """Go to a place."""
        return self._file.seek(offset, whence)

    def tell(self) -> int:
        """Return the place."""
        return self._file.tell()

    def seekable(self) -> bool:
        """Return True."""
        return True

    def readable(self) -> bool:
        """Return True."""
        return True
