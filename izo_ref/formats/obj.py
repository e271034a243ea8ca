"""Animations in Wavefront OBJ: a folder with one file for each frame, or a single file.

A file is a text. Only the coordinates in its `v` lines are changed when it is written; each other
byte stays where it is.

Source: the appendix "Object Files (.obj)" of the manual of Wavefront's Advanced Visualizer.
"""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import AnyInts, Indices, Positions
from izo_ref.base.errors import FileFormatError
from izo_ref.base.values import shown
from izo_ref.formats.animation import Mesh
from izo_ref.formats.files import FileFrame, FilesAnimation
from izo_ref.formats.texts import floats_of, with_numbers

VERTEX = re.compile(rb"^[ \t]*v(?![^ \t\n])", re.M)
COORDINATES = re.compile(
    rb"^[ \t]*v[ \t]++([^ \t\n]++)[ \t]++([^ \t\n]++)[ \t]++([^ \t\n]++)", re.M
)
# Lines of faces (`fo` is an old word for the same), objects and groups.
STRUCTURE = re.compile(rb"^[ \t]*(fo?|o|g)(?![^ \t\n])([^\n]*)", re.M)
CORNERS = re.compile(rb"(?:[ \t]++-?[0-9]{1,18}+(?:/-?[0-9]*+){0,2}+)++[ \t]*")
CONTINUED = re.compile(rb"\\(\r\n|\n|\r)")
BYTE_ORDER_MARK = b"\xef\xbb\xbf"


class ObjAnimation(FilesAnimation):
    """An animation of OBJ files.

    Objects (`o`) are meshes; without objects, groups (`g`) are. Neighbours whose polygons share
    vertices are one mesh, with the name of the first. Comments, texture coordinates, normals
    (which are not computed anew), materials, colours behind the coordinates and line endings stay
    as they are. A changed coordinate is written with as many digits as it takes to read it back
    exactly. Material libraries (.mtl) in a folder are copied; textures are not, and neither is
    anything beside a single file.

    The attributes are those of `FilesAnimation`; `precision` is `float64`.
    """

    suffix = ".obj"
    copied = (".mtl",)

    def _parse(self, content: bytes, where: str, first: FileFrame | None) -> FileFrame:
        return parse_obj(content, where, self.path.stem, first)


class _Structure(NamedTuple):
    """The lines that make meshes and polygons.

    Attributes:
        lines: The word of each line and what follows it.
        places: (k,) i8, how many vertices there are before each line.
        starts: (k,) i8, where each line begins.
        n_vertices: Number of vertices of the file.
    """

    lines: list[tuple[bytes, bytes]]
    places: Indices
    starts: Indices
    n_vertices: int

    def equals(self, other: _Structure) -> bool:
        """Return whether another file has the same meshes and polygons."""
        return (
            self.n_vertices == other.n_vertices
            and self.lines == other.lines
            and np.array_equal(self.places, other.places)
        )


class ObjFile(NamedTuple):
    """What an OBJ file holds.

    Attributes:
        content: All of its bytes.
        text: The same, in which each line has one end and is not continued.
        positions: (n, 3) f8 [m].
        structure: The lines that make the meshes.
        meshes: The meshes.
    """

    content: bytes
    text: bytes
    positions: Positions
    structure: _Structure
    meshes: tuple[Mesh, ...]

    def replaced(self, positions: Positions) -> bytes:
        """Return the bytes of the file with other positions.

        Args:
            positions: (n, 3) f8 [m]. The text of a coordinate that is equal is kept.
        """
        spans = np.array([line.regs[1:] for line in COORDINATES.finditer(self.text)], np.int64)
        return with_numbers(self.content, spans, self.positions, positions)


def parse_obj(content: bytes, where: str, name: str, first: FileFrame | None = None) -> ObjFile:
    """Return what an OBJ file holds.

    Args:
        content: Its bytes.
        where: Path and frame, which begin a message.
        name: Name of the mesh of vertices before the first object.
        first: The first frame; its meshes are returned where they are the same.

    Raises:
        FileFormatError: The file has no vertices, or a line is not what it should be.
    """
    text = _plain_lines(content, where)
    begins, positions = _vertices(content, text, where)
    found = list(STRUCTURE.finditer(text))
    starts = np.array([match.start() for match in found], np.int64)
    lines = [(match[1], match[2]) for match in found]
    structure = _Structure(lines, np.searchsorted(begins, starts), starts, len(positions))
    if isinstance(first, ObjFile) and structure.equals(first.structure):
        meshes = first.meshes
    else:
        meshes = _meshes(content, structure, where, name)
    return ObjFile(content, text, positions, structure, meshes)


def _plain_lines(content: bytes, where: str) -> bytes:
    """Return a text of the same length, in which each line has one end and is not continued."""
    is_continued = CONTINUED.search(content) is not None
    lines = re.split(rb"\r\n|\n|\r", content) if is_continued else []
    for number, line in enumerate(lines, 1):
        if line.endswith(b"\\") and b"#" in line:
            raise FileFormatError(
                f"{where}: line {number}: expected a comment without a backslash at its end, "
                "which says that the next line belongs to it"
            )
    text = CONTINUED.sub(lambda match: b" " * len(match[0]), content)
    if text.startswith(BYTE_ORDER_MARK):
        text = b"   " + text[3:]
    return text.replace(b"\r", b"\n")


def _line(where: str, content: bytes, at: int) -> str:
    """Return path, frame and number of the line, for a message."""
    end = b"\n" if b"\n" in content else b"\r"
    return f"{where}: line {content.count(end, 0, at) + 1}"


def _vertices(content: bytes, text: bytes, where: str) -> tuple[Indices, Positions]:
    """Return where the lines of vertices begin, (n,) i8, and their coordinates, (n, 3) f8."""
    lines = [match.start() for match in VERTEX.finditer(text)]
    found = COORDINATES.findall(text)
    if not lines:
        raise FileFormatError(f"{where}: expected vertices, found no line that begins with 'v '")
    if len(found) != len(lines):
        whole = {match.start() for match in COORDINATES.finditer(text)}
        bad = next(at for at in lines if at not in whole)
        raise FileFormatError(
            f"{_line(where, content, bad)}: expected 'v X Y Z', found {_shown_line(text, bad)}"
        )
    tokens = [token for line in found for token in line]
    numbers = floats_of(tokens)
    if isinstance(numbers, int):
        bad = lines[numbers // 3]
        raise FileFormatError(
            f"{_line(where, content, bad)}: expected three numbers, found {_shown_line(text, bad)}"
        )
    return np.array(lines), np.array(numbers).reshape(-1, 3)


def _shown_line(text: bytes, at: int) -> str:
    end = text.find(b"\n", at)
    return shown(text[at : None if end < 0 else end].decode("utf-8", "backslashreplace"))


def _meshes(content: bytes, structure: _Structure, where: str, name: str) -> tuple[Mesh, ...]:
    """Return the meshes that objects or groups make."""
    counts, corners = _polygons(content, structure, where)
    words = [word for word, _ in structure.lines]
    word = b"o" if b"o" in words else b"g"
    firsts, names = [0], [name]
    for (own, rest), place in zip(structure.lines, structure.places.tolist(), strict=True):
        if own != word:
            continue
        if place == firsts[-1]:  # no vertex since the last one
            names.pop()
            firsts.pop()
        firsts.append(place)
        names.append(rest.strip().decode("utf-8", "backslashreplace"))
    if firsts[-1] == structure.n_vertices:
        firsts.pop()
        names.pop()
    return _grouped(np.array(firsts), names, structure.n_vertices, counts, corners)


def _polygons(content: bytes, structure: _Structure, where: str) -> tuple[Indices, Indices]:
    """Return the corners of each polygon, (k,) i8, and their vertices one after the other."""
    counts, corners, n_vertices = list[int](), list[int](), structure.n_vertices
    lines = zip(structure.lines, structure.places.tolist(), structure.starts.tolist(), strict=True)
    for (word, rest), place, start in lines:
        if not word.startswith(b"f"):
            continue
        if b"#" in rest:
            rest = rest[: rest.index(b"#")]
        if not CORNERS.fullmatch(rest):
            raise FileFormatError(
                f"{_line(where, content, start)}: expected 'f' and corners such as 1, 1/2, 1//3 "
                f"or 1/2/3, found {shown(rest.decode('utf-8', 'backslashreplace').strip())}"
            )
        numbers = [int(corner.partition(b"/")[0]) for corner in rest.split()]
        # numbers below zero count back from the last vertex above this line
        own = [number - 1 if number > 0 else place + number for number in numbers]
        if 0 in numbers or min(own) < 0 or max(own) >= n_vertices:
            raise FileFormatError(
                f"{_line(where, content, start)}: expected vertices from 1 to {n_vertices}, found "
                f"{shown(rest.decode().strip())}"
            )
        counts.append(len(own))
        corners += own
    return np.array(counts, np.int64), np.array(corners, np.int64)


def _grouped(
    firsts: AnyInts, names: list[str], n_vertices: int, counts: Indices, corners: Indices
) -> tuple[Mesh, ...]:
    """Return meshes of neighbouring vertices; polygons over several join them.

    Args:
        firsts: (k,) i8, first vertex of each part, from 0 on.
        names: Its name.
        n_vertices: Number of vertices.
        counts: (m,) i8, corners of each polygon, at least 1.
        corners: (sum of counts,) i8, their vertices.
    """
    begins = np.cumsum(counts) - counts
    lowest = np.minimum.reduceat(corners, begins) if len(counts) else corners
    highest = np.maximum.reduceat(corners, begins) if len(counts) else corners
    low = np.searchsorted(firsts, lowest, "right") - 1
    high = np.searchsorted(firsts, highest, "right") - 1
    over = np.zeros(len(firsts) + 1, np.int64)  # polygons that go over the end of each part
    np.add.at(over, low, 1)
    np.add.at(over, high, -1)
    is_joined = np.cumsum(over)[: len(firsts) - 1] > 0
    is_first = np.concatenate(([True], ~is_joined))
    firsts, names = firsts[is_first], [names[part] for part in np.flatnonzero(is_first)]
    own = np.searchsorted(firsts, lowest, "right") - 1
    order = np.argsort(own, kind="stable")
    counts, ends = counts[order], np.cumsum(counts[order])
    within = np.arange(ends[-1] if len(ends) else 0) - (ends - counts).repeat(counts)
    corners = corners[begins[order].repeat(counts) + within]
    cuts = np.searchsorted(own[order], np.arange(len(firsts) + 1))
    ends = np.concatenate(([0], ends))
    lasts = np.append(firsts[1:], n_vertices)
    return tuple(
        Mesh(
            names[part],
            int(first),
            int(lasts[part] - first),
            counts[cuts[part] : cuts[part + 1]],
            corners[ends[cuts[part]] : ends[cuts[part + 1]]] - first,
        )
        for part, first in enumerate(firsts)
    )
