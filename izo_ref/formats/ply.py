"""Animations in PLY: a folder with one file for each frame, or a single file."""

from __future__ import annotations

import re
from itertools import islice
from typing import Any, NamedTuple

import numpy as np

from izo_ref.base.arrays import AnyFloats, Positions
from izo_ref.base.errors import FileFormatError
from izo_ref.base.values import shown
from izo_ref.formats.animation import Mesh
from izo_ref.formats.files import FileFrame, FilesAnimation
from izo_ref.formats.frames import kept_bits
from izo_ref.formats.ply_header import Element, Header, read_header
from izo_ref.formats.ply_rows import VERTEX, Faces, binary_rows, row_type, text_rows
from izo_ref.formats.texts import floats_of, with_numbers

AXES = ("x", "y", "z")
FLOATS = ("float32", "float64")
WORD = re.compile(rb"\S+")


class PlyAnimation(FilesAnimation):
    """An animation of PLY files: texts, or binary of either byte order.

    A file is one mesh. All properties but x, y and z, which are `float` or `double`, and all
    elements but `vertex` and `face` stay as they are, normals too: they are not computed anew. In a
    text, a changed coordinate is written with as many digits as it takes to read it back exactly.
    Triangle strips, lists in vertices, and bytes behind the last row are refused.

    The attributes are those of `FilesAnimation`; `precision` is the type of x, y and z.
    """

    suffix, up = ".ply", "z"

    def _parse(self, content: bytes, where: str, first: FileFrame | None) -> FileFrame:
        return parse_ply(content, where, self.path.stem, first)


class PlyFile(NamedTuple):
    """What a PLY file holds.

    Attributes:
        content: All of its bytes.
        header: Its header.
        columns: Which properties of a vertex are x, y and z.
        place: Where the vertices begin: the byte, or the word behind the header in a text.
        positions: (n, 3) f4 or f8 [m], in the byte order of the file.
        faces: Its polygons.
        meshes: Its mesh.
    """

    content: bytes
    header: Header
    columns: list[int]
    place: int
    positions: AnyFloats
    faces: Faces
    meshes: tuple[Mesh, ...]

    def replaced(self, positions: Positions) -> bytes:
        """Return the bytes of the file with other positions.

        Args:
            positions: (n, 3) f8 [m], floats of the type of the file.
        """
        vertex = _vertex_of(self.header)
        if self.header.order:
            content = bytearray(self.content)
            rows = np.frombuffer(content, row_type(vertex), vertex.n_rows, self.place)
            kept = kept_bits(self.positions, positions)
            for axis, column in enumerate(self.columns):
                rows[f"p{column}"] = kept[:, axis]
            return bytes(content)
        n_columns = len(vertex.properties)
        words = WORD.finditer(self.content, self.header.size)
        words = islice(words, self.place, self.place + vertex.n_rows * n_columns)
        spans = np.array([word.span() for word in words], np.int64).reshape(-1, n_columns, 2)
        order = np.argsort(self.columns)  # as they follow each other in a row
        spans = spans[:, np.array(self.columns)[order]]
        return with_numbers(self.content, spans, self.positions[:, order], positions[:, order])


def parse_ply(content: bytes, where: str, name: str, first: FileFrame | None = None) -> PlyFile:
    """Return what a PLY file holds.

    Args:
        content: Its bytes.
        where: Path and frame, which begin a message.
        name: Name of the mesh.
        first: The first frame; its meshes are returned where they are the same.

    Raises:
        FileFormatError: The file is damaged, or has no vertices.
    """
    header = read_header(content, where)
    vertex = _checked_vertex(header, where)
    columns = [[each.name for each in vertex.properties].index(axis) for axis in AXES]
    like_first = first if isinstance(first, PlyFile) else None
    if like_first is not None and header[:2] != like_first.header[:2]:
        like_first = None
    known = None if like_first is None else like_first.faces
    if header.order:
        place, faces = binary_rows(content, header, where, known)
        rows = np.frombuffer(content, row_type(vertex), vertex.n_rows, place)
        positions = np.stack([rows[f"p{column}"] for column in columns], axis=1)
    else:
        lines = [line for line in content[header.size :].splitlines() if line.strip()]
        line, place, faces = text_rows(lines, header, where, known)
        positions = _text_positions(lines[line : line + vertex.n_rows], vertex, columns, where)
    if like_first is not None and faces is known:
        meshes = like_first.meshes
    else:
        meshes = (_mesh(name, vertex.n_rows, faces, where),)
    return PlyFile(content, header, columns, place, positions, faces, meshes)


def _vertex_of(header: Header) -> Element:
    return next(each for each in header.elements if each.name == VERTEX)


def _checked_vertex(header: Header, where: str) -> Element:
    """Return the element of vertices, which has to have coordinates of one type, and no lists."""
    names = [each.name for each in header.elements]
    if VERTEX not in names or not _vertex_of(header).n_rows:
        raise FileFormatError(f"{where}: expected vertices, found {shown(names)}")
    vertex = _vertex_of(header)
    if vertex.has_lists:
        raise FileFormatError(f"{where}: element 'vertex': expected numbers, found a list")
    types = {each.name: each.dtype.name for each in vertex.properties}
    found = [types.get(axis) for axis in AXES]
    if found[0] not in FLOATS or len(set(found)) != 1:
        raise FileFormatError(
            f"{where}: element 'vertex': expected x, y and z, all float or all double, found "
            f"{shown(types)}"
        )
    return vertex


def _text_positions(
    rows: list[bytes], vertex: Element, columns: list[int], where: str
) -> AnyFloats:
    """Return the coordinates in the rows of a text."""
    words = [row.split() for row in rows]
    numbers = floats_of([word[column] for word in words for column in columns])
    if isinstance(numbers, int):
        row = numbers // 3
        raise FileFormatError(
            f"{where}: element 'vertex': row {row}: expected numbers, found "
            f"{shown(rows[row].decode('utf-8', 'backslashreplace'))}"
        )
    dtype: Any = vertex.properties[columns[0]].dtype
    with np.errstate(over="ignore"):  # too large for a float is infinite, and refused
        return np.array(numbers).reshape(-1, 3).astype(dtype)


def _mesh(name: str, n_vertices: int, faces: Faces, where: str) -> Mesh:
    """Return the mesh, whose polygons have to have vertices that exist."""
    bad = (faces.corners < 0) | (faces.corners >= n_vertices)
    if bad.any():
        at = int(bad.argmax())
        face = int(np.searchsorted(np.cumsum(faces.counts), at, "right"))
        raise FileFormatError(
            f"{where}: mesh {shown(name)}: expected vertices from 0 to {n_vertices - 1}, found "
            f"{faces.corners[at]} in face {face}"
        )
    return Mesh(name, 0, n_vertices, faces.counts, faces.corners)
