"""The rows of a PLY file: where the vertices are, and the lists of the faces."""

from __future__ import annotations

import struct
from typing import Any, NamedTuple

import numpy as np

from izo_ref.base.arrays import Indices
from izo_ref.base.errors import FileFormatError
from izo_ref.base.values import shown
from izo_ref.formats.frames import count_that_fits
from izo_ref.formats.ply_header import Element, Header, Property

VERTEX, FACE, STRIPS = "vertex", "face", "tristrips"
CORNERS = ("vertex_indices", "vertex_index")
NONE = np.empty(0, np.int64)


class Faces(NamedTuple):
    """The polygons of a file.

    Attributes:
        block: What the file has for them: bytes, or lines of a text.
        counts: (k,) i8, corners of each polygon.
        corners: (sum of counts,) i8, their vertices.
    """

    block: bytes | list[bytes]
    counts: Indices
    corners: Indices


def corners_of(element: Element, where: str) -> int | None:
    """Return which property of an element has the corners of polygons; None if none has.

    Args:
        element: The element.
        where: Path and frame, which begin a message.

    Raises:
        FileFormatError: There are faces without corners, or triangle strips.
    """
    if element.name == STRIPS and element.n_rows:
        raise FileFormatError(
            f"{where}: expected faces, found triangle strips; convert them to faces"
        )
    if element.name != FACE:
        return None
    found = [i for i, each in enumerate(element.properties) if each.name in CORNERS]
    own = element.properties[found[0]] if len(found) == 1 else None
    if own is not None and own.count_dtype is not None and own.dtype.kind in "iu":
        return found[0]
    if element.n_rows == 0:
        return None
    raise FileFormatError(
        f"{where}: element 'face': expected one list {' or '.join(CORNERS)} of integers, found "
        f"{shown([each.name for each in element.properties])}"
    )


def binary_rows(
    content: bytes, header: Header, where: str, known: Faces | None
) -> tuple[int, Faces]:
    """Find the rows of a binary file.

    Args:
        content: The bytes of the file.
        header: Its header; its vertices have no lists.
        where: Path and frame, which begin a message.
        known: The faces of another file with the same header; they are returned if the bytes are
            the same. None if there is none.

    Returns:
        Where the vertices begin, and the faces.

    Raises:
        FileFormatError: The file has fewer bytes than it declares, or more.
    """
    at, place, faces = header.size, 0, Faces(b"", NONE, NONE)
    for element in header.elements:
        least, here = element.least_bytes, f"{where}: element {shown(element.name)}"
        _check_properties(element, here)
        count_that_fits(where, element.n_rows, least, len(content) - at, f"rows of {element.name}")
        target = corners_of(element, where)
        if element.name == VERTEX:
            place = at
        if not element.has_lists or element.n_rows == 0:
            at += element.n_rows * least
            continue
        block = known.block if known is not None and target is not None else None
        if isinstance(block, bytes) and content[at : at + len(block)] == block and known:
            faces, at = known, at + len(block)
            continue
        end, counts, corners = _lists(content, at, element, target, here)
        if target is not None:
            faces = Faces(content[at:end], counts, corners)
        at = end
    if at != len(content):
        raise FileFormatError(
            f"{where}: expected {at} bytes, as its header declares, found {len(content)}"
        )
    return place, faces


def _check_properties(element: Element, here: str) -> None:
    if element.n_rows and not element.properties:
        raise FileFormatError(f"{here}: expected properties, found none")


def _lists(
    content: bytes, at: int, element: Element, target: int | None, here: str
) -> tuple[int, Indices, Indices]:
    """Return where rows with lists end, and lengths and numbers of the lists of one property."""
    end, lists = _walk_row(content, at, element.properties, here)
    lengths = [length for _, length in lists]
    row = _row_type(element.properties, lengths)
    if element.n_rows * row.itemsize <= len(content) - at:
        rows = np.frombuffer(content, row, element.n_rows, at)
        if all((rows[f"n{i}"] == length).all() for i, length in enumerate(lengths) if length >= 0):
            end = at + element.n_rows * row.itemsize
            if target is None:
                return end, NONE, NONE
            counts = np.full(element.n_rows, lengths[target])
            return end, counts, rows[f"p{target}"].astype(np.int64).ravel()
    starts, counts, end = list[int](), list[int](), at
    for _ in range(element.n_rows):
        end, lists = _walk_row(content, end, element.properties, here)
        if target is not None:
            starts.append(lists[target][0])
            counts.append(lists[target][1])
    if target is None:
        return end, NONE, NONE
    dtype = element.properties[target].dtype
    return end, np.array(counts, np.int64), _gathered(content, starts, counts, dtype)


def _walk_row(
    content: bytes, at: int, properties: tuple[Property, ...], here: str
) -> tuple[int, list[tuple[int, int]]]:
    """Return where a row ends, and where each list begins and its length, which is -1 for none."""
    lists = list[tuple[int, int]]()
    for each in properties:
        if each.count_dtype is None:
            lists.append((at, -1))
            at += each.dtype.itemsize
            continue
        if at + each.count_dtype.itemsize > len(content):
            raise FileFormatError(f"{here}: expected more rows, found the end of the file")
        order = each.count_dtype.str[0].replace("|", "<")  # one byte has no order
        (length,) = struct.unpack_from(order + each.count_dtype.char, content, at)
        at += each.count_dtype.itemsize
        room = len(content) - at
        count_that_fits(here, length, each.dtype.itemsize, room, "numbers of a list")
        lists.append((at, length))
        at += length * each.dtype.itemsize
    if at > len(content):
        raise FileFormatError(f"{here}: expected more rows, found the end of the file")
    return at, lists


def _row_type(properties: tuple[Property, ...], lengths: list[int]) -> np.dtype[Any]:
    """Return the type of a row whose lists have these lengths: `p0` is its first property."""
    fields = list[Any]()
    for i, (each, length) in enumerate(zip(properties, lengths, strict=True)):
        if each.count_dtype is None:
            fields.append((f"p{i}", each.dtype))
        else:
            fields += [(f"n{i}", each.count_dtype), (f"p{i}", each.dtype, (length,))]
    return np.dtype(fields)


def _gathered(content: bytes, starts: list[int], counts: list[int], dtype: Any) -> Indices:
    """Return the numbers of lists that begin anywhere, one list after the other."""
    sizes = np.array(counts, np.int64) * dtype.itemsize
    before = np.cumsum(sizes) - sizes
    places = np.arange(sizes.sum()) + (np.array(starts, np.int64) - before).repeat(sizes)
    return np.frombuffer(content, np.uint8)[places].view(dtype).astype(np.int64)


def text_rows(
    lines: list[bytes], header: Header, where: str, known: Faces | None
) -> tuple[int, int, Faces]:
    """Find the rows of a text.

    Args:
        lines: The lines behind the header that are not empty.
        header: The header; vertices have no lists.
        where: Path and frame, which begin a message.
        known: As for `binary_rows`.

    Returns:
        Which line has the first vertex, how many words are before it, and the faces.

    Raises:
        FileFormatError: There are other lines than the header declares.
    """
    declared = sum(element.n_rows for element in header.elements)
    if declared != len(lines):
        raise FileFormatError(
            f"{where}: expected {declared} lines behind the header, as it declares, found "
            f"{len(lines)}"
        )
    at, place, n_words, faces = 0, 0, 0, Faces([], NONE, NONE)
    for element in header.elements:
        rows, here = lines[at : at + element.n_rows], f"{where}: element {shown(element.name)}"
        _check_properties(element, here)
        target = corners_of(element, where)
        if element.name == VERTEX:
            place, n_words = at, sum(len(line.split()) for line in lines[:at])
        if not element.has_lists:
            _check_words(rows, len(element.properties), here)
        elif known is not None and target is not None and rows == known.block:
            faces = known
        else:
            counts, corners = _text_lists(rows, element, target, here)
            if target is not None:
                faces = Faces(rows, counts, corners)
        at += element.n_rows
    return place, n_words, faces


def _check_words(rows: list[bytes], count: int, here: str) -> None:
    for number, row in enumerate(rows):
        if len(row.split()) != count:
            raise FileFormatError(
                f"{here}: row {number}: expected {count} numbers, found {_shown(row)}"
            )


def _text_lists(
    rows: list[bytes], element: Element, target: int | None, here: str
) -> tuple[Indices, Indices]:
    """Return lengths and numbers of the lists of one property."""
    counts, corners = list[int](), list[int]()
    for number, row in enumerate(rows):
        words, at = row.split(), 0
        try:
            for i, each in enumerate(element.properties):
                length = 1 if each.count_dtype is None else _integer(words[at])
                at += each.count_dtype is not None
                if i == target:
                    corners += map(_integer, words[at : at + length])
                    counts.append(length)
                at += length
            is_whole = at == len(words)
        except (IndexError, ValueError):
            is_whole = False
        if not is_whole:
            raise FileFormatError(
                f"{here}: row {number}: expected lists that begin with their length, found "
                f"{_shown(row)}"
            )
    return np.array(counts, np.int64), np.array(corners, np.int64)


def _integer(word: bytes) -> int:
    """Return an integer from 0 to below 2^32, as the widest type of the format has it."""
    if not word.isdigit() or len(word) > 10:
        raise ValueError
    return int(word)


def _shown(row: bytes) -> str:
    return shown(row.decode("utf-8", "backslashreplace"))


def row_type(element: Element) -> np.dtype[Any]:
    """Return the type of a row without lists in a binary file; `p0` is its first property.

    Args:
        element: The element.
    """
    return _row_type(element.properties, [-1] * len(element.properties))
