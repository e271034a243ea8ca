"""Arrays in files of numpy's format, version 1.0, written and read without numpy.

So the bytes do not depend on any version of numpy. Arrays are flat: `<f8` or `<i4`, one dimension.

Source: the documentation of `numpy.lib.format`.
"""

from __future__ import annotations

import re
import struct

from izo_ref.base.errors import VectorsError

MAGIC = b"\x93NUMPY\x01\x00"
ALIGNED = 64  # bytes; the header is filled up with spaces to a multiple of this
HEADER = re.compile(r"\{'descr': '(<f8|<i4)', 'fortran_order': False, 'shape': \((\d+),\), \} *\n")
LETTERS = {"<f8": "d", "<i4": "i"}


def npy_bytes(numbers: list[float] | list[int]) -> bytes:
    """Return the content of a file with a flat array.

    Args:
        numbers: Floats, or integers of 32 bits.

    Raises:
        VectorsError: An integer has more than 32 bits.
    """
    dtype = "<f8" if all(isinstance(number, float) for number in numbers) else "<i4"
    text = f"{{'descr': '{dtype}', 'fortran_order': False, 'shape': ({len(numbers)},), }}"
    begin = len(MAGIC) + 2
    fill = -(begin + len(text) + 1) % ALIGNED
    header = f"{text}{' ' * fill}\n".encode("ascii")
    try:
        content = struct.pack(f"<{len(numbers)}{LETTERS[dtype]}", *numbers)
    except struct.error as error:
        raise VectorsError(f"expected integers of 32 bits: {error}") from None
    return MAGIC + struct.pack("<H", len(header)) + header + content


def npy_numbers(content: bytes) -> list[float] | list[int]:
    """Return the numbers of a flat array from the content of its file.

    Args:
        content: All bytes of the file.

    Raises:
        VectorsError: The file is not such an array.
    """
    begin = len(MAGIC) + 2
    length, found = 0, None
    if content[: len(MAGIC)] == MAGIC and len(content) >= begin:
        (length,) = struct.unpack("<H", content[len(MAGIC) : begin])
        found = HEADER.fullmatch(content[begin : begin + length].decode("latin-1"))
    if found is None:
        raise VectorsError("expected a flat array of numpy, <f8 or <i4, in format 1.0")
    numbers = content[begin + length :]
    letter, count = LETTERS[found[1]], found[2].lstrip("0") or "0"
    size = struct.calcsize(f"<{letter}")
    # compared as text, because a header can hold a count of thousands of digits
    if len(numbers) % size or str(len(numbers) // size) != count:
        raise VectorsError(
            f"expected {count[:20]} numbers of {size} bytes, found {len(numbers)} bytes"
        )
    return list(struct.unpack(f"<{count}{letter}", numbers))
