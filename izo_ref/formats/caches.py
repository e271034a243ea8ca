"""Animations in point caches, which hold positions alone: PC2 of Blender and MDD of LightWave.

The polygons come from an OBJ or PLY file with the same vertices.

A PC2 file, little-endian: the text `POINTCACHE2` and a zero byte; i4 version, which is 1; i4 number
of points; f4 first frame; f4 frames from sample to sample; i4 number of samples; then x, y and z of
each point of each sample, f4.

An MDD file, big-endian: i4 number of frames; i4 number of points; f4 time of each frame [s]; then
x, y and z of each point of each frame, f4.
"""

from __future__ import annotations

import os
import shutil
import struct
import tempfile
from abc import ABC, abstractmethod
from collections.abc import Iterable
from pathlib import Path
from typing import Any, BinaryIO, ClassVar, NamedTuple

import numpy as np

from izo_ref.base.arrays import AnyArray, Positions
from izo_ref.base.errors import FileFormatError
from izo_ref.base.input_files import open_input
from izo_ref.formats.animation import FilePath, Mesh
from izo_ref.formats.files import FilesAnimation
from izo_ref.formats.frames import (
    check_finite,
    check_number,
    check_suffix,
    checked_frames,
    count_that_fits,
    kept_bits,
    whole_output,
)
from izo_ref.formats.obj import ObjAnimation
from izo_ref.formats.ply import PlyAnimation

BYTES = 4  # of a float32
PIECE = 1 << 16  # bytes that are copied at once
MAGIC = b"POINTCACHE2\0"
PC2_HEADER = struct.Struct("<12siiffi")
MDD_HEADER = struct.Struct(">ii")
TOPOLOGIES: dict[str, type[FilesAnimation]] = {".obj": ObjAnimation, ".ply": PlyAnimation}


class _Header(NamedTuple):
    """What the beginning of a cache declares.

    Attributes:
        content: Its bytes.
        n_frames: Number of frames.
        n_vertices: Number of points.
    """

    content: bytes
    n_frames: int
    n_vertices: int


class PointCache(ABC):
    """An animation in a point cache; the base of both formats.

    Positions are those of the cache, in the coordinates of its object; a program that shows it may
    move the object elsewhere. So caches of several objects meet in the right places only if none of
    them is moved.

    Attributes:
        path: The cache.
        meshes: The meshes of the file with the polygons.
        n_frames: Number of frames.
        precision: `float32`.
        up: `y`, the custom of programs that write point caches.
        suffix: Suffix of the format.
        dtype: Type of its floats.
    """

    up = "y"
    suffix: ClassVar[str]
    dtype: ClassVar[np.dtype[Any]]

    def __init__(self, path: FilePath, topology: FilePath | None = None) -> None:
        """Open a cache, and read the file with its polygons.

        Args:
            path: The cache.
            topology: The OBJ or PLY file with the polygons. None takes the file of the same name
                beside it.

        Raises:
            FileFormatError: One of them cannot be read, or they have different numbers of points.
        """
        self.path, self.precision = Path(path), "float32"
        with open_input(path) as file:
            self._header = self._read_header(file, os.fstat(file.fileno()).st_size)
        self.n_frames = self._header.n_frames
        self._topology = _beside(self.path) if topology is None else Path(topology)
        self.meshes = _meshes_of(self._topology)
        n_vertices = sum(mesh.n_vertices for mesh in self.meshes)
        if n_vertices != self._header.n_vertices:
            raise FileFormatError(
                f"{self.path}: expected the {n_vertices} vertices of {self._topology}, found "
                f"{self._header.n_vertices}"
            )

    def frame(self, number: int) -> Positions:
        """Read the positions of a frame; `Animation.frame` has the contract.

        Args:
            number: From 0 to n_frames - 1.

        Returns:
            (n, 3) f8 [m].

        Raises:
            FileFormatError: There is no such frame, or it holds a number that is not finite.
        """
        return self._read(number).astype(np.float64)

    def write(self, path: FilePath, frames: Iterable[Positions]) -> None:
        """Write the cache with other positions; `Animation.write` has the contract.

        Times and rates stay as they are. The file with the polygons is not copied.

        Args:
            path: The file to write.
            frames: (n, 3) f8 each, floats of `precision`.

        Raises:
            FileFormatError: It cannot be written there, or the frames do not fit.
        """
        check_suffix(path, self.suffix)
        count = 0
        with (
            whole_output(path, [self.path, self._topology]) as file,
            # The header is in front and says how many frames follow, so they wait on the disk.
            tempfile.TemporaryFile(dir=os.path.dirname(os.path.realpath(path))) as waiting,
        ):
            for number, positions in checked_frames(self, frames):
                waiting.write(kept_bits(self._read(number), positions).tobytes())
                count += 1
            waiting.seek(0)
            file.write(self._new_header(count))
            shutil.copyfileobj(waiting, file, PIECE)

    def _read(self, number: int) -> AnyArray:
        """Return the positions of a frame as the file has them, (n, 3) f4."""
        check_number(self, number)
        where = f"{self.path}: frame {number}"
        size = self._header.n_vertices * 3 * BYTES
        with open_input(self.path) as file:
            try:
                file.seek(len(self._header.content) + number * size)
                content = file.read(size)
            except OSError as error:
                raise FileFormatError(
                    f"{where}: cannot be read: {error.strerror or error}"
                ) from None
            except MemoryError:
                raise FileFormatError(f"{where}: needs more memory than is free") from None
        if len(content) != size:
            raise FileFormatError(f"{where}: expected {size} bytes, found {len(content)}")
        array = np.frombuffer(content, self.dtype).reshape(-1, 3)
        check_finite(where, array, self.meshes)
        return array

    def _checked(self, content: bytes, n_frames: int, n_vertices: int, size: int) -> _Header:
        """Return a header, whose counts have to fit the number of bytes behind it."""
        room = size - len(content)
        if n_frames < 1 or n_vertices < 1:
            raise FileFormatError(
                f"{self.path}: expected at least one frame and one point, found {n_frames} frames "
                f"of {n_vertices} points"
            )
        count_that_fits(self.path, n_frames, n_vertices * 3 * BYTES, room, "frames")
        expected = n_frames * n_vertices * 3 * BYTES
        if room != expected:
            raise FileFormatError(
                f"{self.path}: {n_frames} frames of {n_vertices} points take {expected} bytes, "
                f"but there are {room}"
            )
        return _Header(content, n_frames, n_vertices)

    def _begin(self, file: BinaryIO, size: int) -> bytes:
        """Return the next bytes of a file that is not cut off there."""
        content = file.read(size)
        if len(content) != size:
            raise FileFormatError(f"{self.path}: the header is cut off")
        return content

    @abstractmethod
    def _read_header(self, file: BinaryIO, size: int) -> _Header:
        """Read the header of a file of a number of bytes."""

    @abstractmethod
    def _new_header(self, n_frames: int) -> bytes:
        """Return the header for another number of frames."""


class PointCache2(PointCache):
    """An animation in a PC2 file; first frame and sample rate stay as they are."""

    suffix = ".pc2"
    dtype = np.dtype("<f4")

    def _read_header(self, file: BinaryIO, size: int) -> _Header:
        content = self._begin(file, PC2_HEADER.size)
        magic, version, n_vertices, _, _, n_frames = PC2_HEADER.unpack(content)
        if magic != MAGIC or version != 1:
            raise FileFormatError(
                f"{self.path}: expected {MAGIC!r} and version 1, found {magic!r} and {version}"
            )
        return self._checked(content, n_frames, n_vertices, size)

    def _new_header(self, n_frames: int) -> bytes:
        return self._header.content[:-4] + struct.pack("<i", n_frames)


class Mdd(PointCache):
    """An animation in an MDD file; the times of its frames stay as they are."""

    suffix = ".mdd"
    dtype = np.dtype(">f4")

    def _read_header(self, file: BinaryIO, size: int) -> _Header:
        begin = self._begin(file, MDD_HEADER.size)
        n_frames, n_vertices = MDD_HEADER.unpack(begin)
        # compared with the bytes that are there before the times are read
        count_that_fits(self.path, n_frames, BYTES, size - len(begin), "frames")
        times = self._begin(file, n_frames * BYTES)
        return self._checked(begin + times, n_frames, n_vertices, size)

    def _new_header(self, n_frames: int) -> bytes:
        begin = MDD_HEADER.pack(n_frames, self._header.n_vertices)
        return begin + self._header.content[len(begin) :][: n_frames * BYTES]


def _beside(path: Path) -> Path:
    """Return the OBJ or PLY file that has the same name as a cache."""
    found = [path.with_suffix(suffix) for suffix in TOPOLOGIES]
    found = [file for file in found if file.exists()]
    if len(found) != 1:
        raise FileFormatError(
            f"{path}: expected one file with its polygons, {path.stem}.obj or {path.stem}.ply, "
            f"beside it, found {'both' if found else 'neither'}; name it"
        )
    return found[0]


def _meshes_of(topology: Path) -> tuple[Mesh, ...]:
    """Return the meshes of an OBJ or PLY file."""
    kind = TOPOLOGIES.get(topology.suffix.lower())
    if kind is None or topology.is_dir():
        raise FileFormatError(f"{topology}: expected one .obj or .ply file with the polygons")
    return kind(topology).meshes
