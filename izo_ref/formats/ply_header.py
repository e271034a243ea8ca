"""The header of a PLY file: its elements, their numbers and their properties.

Source: Greg Turk, "The PLY Polygon File Format", 1994.
"""

from __future__ import annotations

import re
from typing import Any, NamedTuple

import numpy as np

from izo_ref.base.errors import FileFormatError
from izo_ref.base.values import shown

LONGEST_HEADER = 1 << 20  # bytes; a header has some hundred
FORMATS = {b"ascii": "", b"binary_little_endian": "<", b"binary_big_endian": ">"}
TYPES = {
    b"char": "i1",
    b"uchar": "u1",
    b"short": "i2",
    b"ushort": "u2",
    b"int": "i4",
    b"uint": "u4",
    b"float": "f4",
    b"double": "f8",
    b"int8": "i1",
    b"uint8": "u1",
    b"int16": "i2",
    b"uint16": "u2",
    b"int32": "i4",
    b"uint32": "u4",
    b"float32": "f4",
    b"float64": "f8",
}
COUNT = re.compile(rb"[0-9]{1,18}")


class Property(NamedTuple):
    """One property of an element.

    Attributes:
        name: Its name.
        dtype: Type of its number, or of the numbers of its list.
        count_dtype: Type of the length of its list; None if it is no list.
    """

    name: str
    dtype: np.dtype[Any]
    count_dtype: np.dtype[Any] | None

    @property
    def least_bytes(self) -> int:
        """Number of bytes that it takes at least; a list can be empty."""
        return (self.count_dtype or self.dtype).itemsize


class Element(NamedTuple):
    """The rows of one kind: vertices, faces, or others.

    Attributes:
        name: Its name.
        n_rows: Number of rows.
        properties: What each row has.
    """

    name: str
    n_rows: int
    properties: tuple[Property, ...]

    @property
    def has_lists(self) -> bool:
        """Whether rows can have different lengths."""
        return any(each.count_dtype is not None for each in self.properties)

    @property
    def least_bytes(self) -> int:
        """Number of bytes that a row takes at least, in a binary file."""
        return sum(each.least_bytes for each in self.properties)


class Header(NamedTuple):
    """What a header declares.

    Attributes:
        order: Byte order of the numbers, `<` or `>`; empty if they are texts.
        elements: The elements, in the order of the file.
        size: Number of bytes of the header.
    """

    order: str
    elements: tuple[Element, ...]
    size: int


def read_header(content: bytes, where: str) -> Header:
    """Read the header of a PLY file.

    Args:
        content: The bytes of the file.
        where: Path and frame, which begin a message.

    Raises:
        FileFormatError: A line is not what it should be, or the end is missing.
    """
    begin = re.match(rb"ply[ \t]*(\r\n|\n|\r)", content)
    if begin is None:
        raise FileFormatError(
            f"{where}: expected 'ply' in the first line, found {_shown(content[:10])}"
        )
    end, at = begin[1], begin.end()
    order: str | None = None
    elements = list[Element]()
    for number in range(2, LONGEST_HEADER):
        stop = content.find(end, at, LONGEST_HEADER)
        if stop < 0:
            break
        line, at = content[at:stop], stop + len(end)
        words = line.split()
        if words == [b"end_header"] and order is not None:
            return Header(order, tuple(elements), at)
        if order is None and len(words) == 3 and words[0] == b"format":
            order = FORMATS.get(words[1]) if words[2] == b"1.0" else None
            is_read = order is not None
        else:
            is_read = words[:1] in ([b"comment"], [b"obj_info"]) or _adds(elements, words, order)
        if not is_read:
            raise FileFormatError(
                f"{where}: line {number} of the header: expected "
                f"{'element, property, comment or end_header' if order is not None else EXPECTED}, "
                f"found {_shown(line)}"
            )
    raise FileFormatError(f"{where}: expected 'end_header' at the end of the header, found none")


EXPECTED = "'format' with ascii, binary_little_endian or binary_big_endian, and 1.0"


def _shown(line: bytes) -> str:
    return shown(line.decode("utf-8", "backslashreplace"))


def _adds(elements: list[Element], words: list[bytes], order: str | None) -> bool:
    """Add an element, or a property to the last one; return whether the words say one of these."""
    if order is None:
        return False
    if len(words) == 3 and words[0] == b"element" and COUNT.fullmatch(words[2]):
        name = words[1].decode("utf-8", "backslashreplace")
        elements.append(Element(name, int(words[2]), ()))
        return name not in [each.name for each in elements[:-1]]
    is_list = len(words) == 5 and words[1] == b"list"
    if words[:1] != [b"property"] or not elements or (len(words) != 3 and not is_list):
        return False
    types = [TYPES.get(word) for word in words[2 if is_list else 1 : -1]]
    dtypes = [np.dtype(order + each if each else "V") for each in types]
    if None in types or (is_list and dtypes[0].kind == "f"):
        return False
    name = words[-1].decode("utf-8", "backslashreplace")
    last = elements[-1]
    new = Property(name, dtypes[-1], dtypes[0] if is_list else None)
    elements[-1] = last._replace(properties=(*last.properties, new))
    return name not in [each.name for each in last.properties]
