"""The header of an array in numpy's format: shape, type and order, and what may be there.

Nothing in a header is believed before it is checked: the sizes that it declares are compared with
the bytes that are there, so that a few bytes cannot ask for terabytes. Objects, which numpy would
have to unpickle, are refused: a pickle can run any program.

Source: the documentation of `numpy.lib.format`.
"""

from __future__ import annotations

import ast
import math
import re
import struct
import warnings
from typing import Any, BinaryIO, NamedTuple

import numpy as np

from izo_ref.base.values import shown

MAGIC = b"\x93NUMPY"
LONGEST_HEADER = 10_000  # bytes, as in numpy; a header of an array of numbers has 128
LARGEST_SIDE = 2**31 - 1  # rows of an array: indices are int32
DIMENSIONS = 3
NUMBERS = re.compile(r"[<>|=]?(b1|[iu][1248]|f[248])")  # types of arrays that are read
TEXT = re.compile(r"[<>|=]?U([1-9]\d{0,2})")  # a text of at most 999 characters
OBJECTS = re.compile(r"[<>|=]?O\d?")
LONG = re.compile(r"(?<=\d)L\b")  # as Python 2 wrote integers


class HeaderError(Exception):
    """What follows is no array that is read; the message says what was expected and found."""


class Header(NamedTuple):
    """What a header declares.

    Attributes:
        dtype: Type of the numbers.
        shape: Shape of the array.
        is_fortran: Whether columns are written first.
    """

    dtype: np.dtype[Any]
    shape: tuple[int, ...]
    is_fortran: bool

    @property
    def n_bytes(self) -> int:
        """Number of bytes of the numbers."""
        return math.prod(self.shape) * self.dtype.itemsize


def read_header(file: BinaryIO) -> tuple[Header, int]:
    """Read the header of an array.

    Args:
        file: Is at the beginning of the array.

    Returns:
        The header, and how many bytes it took.

    Raises:
        HeaderError: There is no header, or one of an array that is not read.
    """
    begin = file.read(len(MAGIC) + 2)
    if begin[: len(MAGIC)] != MAGIC or len(begin) < len(MAGIC) + 2:
        raise HeaderError("expected an array of numpy, found something else")
    version = begin[len(MAGIC)]
    if version not in (1, 2, 3) or begin[-1] != 0:
        raise HeaderError(f"expected format 1.0, 2.0 or 3.0, found {version}.{begin[-1]}")
    packed = "<H" if version == 1 else "<I"
    size = file.read(struct.calcsize(packed))
    if len(size) < struct.calcsize(packed):
        raise HeaderError("the header is cut off")
    (length,) = struct.unpack(packed, size)
    if length > LONGEST_HEADER:
        raise HeaderError(f"expected a header of at most {LONGEST_HEADER} bytes, found {length}")
    text = file.read(length)
    if len(text) < length:
        raise HeaderError("the header is cut off")
    return _header_of(text.decode("utf-8" if version == 3 else "latin-1", "replace")), (
        len(begin) + len(size) + length
    )


def _header_of(text: str) -> Header:
    """Return what the text of a header declares."""
    try:
        with warnings.catch_warnings():  # hostile texts can make the parser of Python warn
            warnings.simplefilter("ignore")
            fields = ast.literal_eval(LONG.sub("", text).strip())
    except Exception:  # the parser of Python can raise anything, MemoryError included
        raise HeaderError(f"the header cannot be read: {shown(text)}") from None
    if not isinstance(fields, dict) or set(fields) != {"descr", "fortran_order", "shape"}:
        raise HeaderError(f"expected descr, fortran_order and shape, found {shown(fields)}")
    shape, is_fortran = fields["shape"], fields["fortran_order"]
    if not isinstance(is_fortran, bool):
        raise HeaderError(f"fortran_order: expected True or False, found {shown(is_fortran)}")
    if not isinstance(shape, tuple) or len(shape) > DIMENSIONS or not all(map(_is_side, shape)):
        raise HeaderError(
            f"shape: expected up to {DIMENSIONS} numbers from 0 to {LARGEST_SIDE}, found "
            f"{shown(shape)}"
        )
    return Header(_dtype_of(fields["descr"]), shape, is_fortran)


def _is_side(number: Any) -> bool:
    return type(number) is int and 0 <= number <= LARGEST_SIDE


def _dtype_of(description: Any) -> np.dtype[Any]:
    """Return a type of plain numbers, or of one text."""
    plain = isinstance(description, str)
    if plain and (NUMBERS.fullmatch(description) or TEXT.fullmatch(description)):
        return np.dtype(description)
    if plain and OBJECTS.fullmatch(description):
        raise HeaderError(
            "expected plain numbers, found objects of Python, which are never read because they "
            "can run a program; convert the array with astype before it is saved"
        )
    raise HeaderError(
        f"expected integers, flags or floats of 16, 32 or 64 bits, found the type "
        f"{shown(description)}"
    )


def array_of(header: Header, content: bytearray) -> np.ndarray[Any, Any]:
    """Return an array in the byte order of this machine.

    Args:
        header: Its header.
        content: Its bytes, as many as the header declares.

    Raises:
        HeaderError: A flag is neither 0 nor 1, or a text has a character that does not exist.
    """
    flat = np.frombuffer(content, header.dtype)
    if header.dtype.kind == "b" and (flat.view(np.uint8) > 1).any():
        raise HeaderError("expected flags of 0 or 1, found another byte")
    if header.dtype.kind == "U" and (flat.view(f"{header.dtype.str[0]}u4") > 0x10FFFF).any():
        raise HeaderError("expected a text, found a character that does not exist")
    array = flat.reshape(header.shape, order="F" if header.is_fortran else "C")
    return np.asarray(array, header.dtype.newbyteorder("="))
