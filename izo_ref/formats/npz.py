"""Animations in an .npz archive of numpy: `positions` of all frames, and `faces`."""

from __future__ import annotations

import os
import shutil
import tempfile
import weakref
import zipfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from izo_ref.base.archives import PIECE, Archive, damage_named
from izo_ref.base.arrays import AnyArray, Positions
from izo_ref.base.input_files import open_input
from izo_ref.base.npy_header import Header, HeaderError
from izo_ref.base.values import shown
from izo_ref.formats.animation import FilePath, Mesh
from izo_ref.formats.frames import (
    check_finite,
    check_number,
    check_suffix,
    checked_frames,
    kept_bits,
    whole_output,
)

POSITIONS, FACES = "positions", "faces"


class NpzAnimation:
    """An animation in an .npz archive.

    The archive has the arrays `positions`, (n_frames, n, 3) f4 or f8 [m], and `faces`, (m, 3) of
    integers. All other arrays and files in it are copied when it is written; they are not looked
    into, so arrays of objects are kept but never unpickled.

    Opening the archive reads it once from end to end to compare the checksum. Frames are read one
    at a time; a compressed archive is read fastest in the order of its frames.

    Attributes:
        path: The archive.
        meshes: One mesh with the name of the file.
        n_frames: Number of frames.
        precision: `float32` or `float64`, the type of `positions`.
        up: `z`, the custom of simulators.
    """

    up = "z"

    def __init__(self, path: FilePath) -> None:
        """Open an archive.

        Args:
            path: The archive.

        Raises:
            FileFormatError: It cannot be read, is damaged, or lacks one of the two arrays.
        """
        self.path = Path(path)
        file = open_input(path)
        # The file stays open for as long as somebody may ask for a frame.
        weakref.finalize(self, file.close)
        with damage_named(path) as name_part:
            self._archive = Archive(path, file)
            for name in (POSITIONS, FACES):
                if name not in self._archive.names:
                    found = shown(self._archive.names)
                    raise HeaderError(f"expected an array {name!r}, found {found}")
            for name in self._archive.names:
                name_part(f"the array {shown(name)}: ")
                self._archive.check(name)
            name_part("the array 'positions': ")
            self._reader = _FrameReader(self._archive)
            self._reader.check_sum()
            self.n_frames, n_vertices, _ = self._reader.header.shape
            name_part("the array 'faces': ")
            corners = _checked_faces(self._archive.read(FACES), n_vertices)
        self.precision = self._reader.header.dtype.name
        counts = np.full(len(corners) // 3, 3)
        self.meshes = (Mesh(self.path.stem, 0, n_vertices, counts, corners),)

    def frame(self, number: int) -> Positions:
        """Read the positions of a frame; `Animation.frame` has the contract.

        Args:
            number: From 0 to n_frames - 1.

        Returns:
            (n, 3) f8 [m].

        Raises:
            FileFormatError: There is no such frame, or it holds a number that is not finite.
        """
        return self._read(self._reader, number).astype(np.float64)

    def _read(self, reader: _FrameReader, number: int) -> AnyArray:
        """Return the positions of a frame as the file has them."""
        check_number(self, number)
        where = f"{self.path}: frame {number}"
        with damage_named(self.path) as name_part:
            name_part(f"frame {number}: ")
            array = reader.read(number)
        check_finite(where, array, self.meshes)
        return array

    def write(self, path: FilePath, frames: Iterable[Positions]) -> None:
        """Write a copy of the archive with other positions; `Animation.write` has the contract.

        Arrays keep their names, order, bytes and compression.

        Args:
            path: The .npz file to write.
            frames: (n, 3) f8 each, floats of `precision`.

        Raises:
            FileFormatError: It cannot be written there, or the frames do not fit.
        """
        check_suffix(path, ".npz")
        reader, count = _FrameReader(self._archive), 0
        with (
            whole_output(path, [self.path]) as file,
            # The header is in front and says how many frames follow, so they wait on the disk.
            tempfile.TemporaryFile(dir=os.path.dirname(os.path.realpath(path))) as waiting,
        ):
            for number, positions in checked_frames(self, frames):
                waiting.write(kept_bits(self._read(reader, number), positions).tobytes())
                count += 1
            waiting.seek(0)
            with zipfile.ZipFile(file, "w") as archive:
                for name in self._archive.names:
                    with _new_member(archive, self._archive.member(name)) as new:
                        if name == POSITIONS:
                            _write_header(new, reader.header, count)
                            shutil.copyfileobj(waiting, new, PIECE)
                        else:
                            new.writelines(self._pieces(name))

    def _pieces(self, name: str) -> Iterator[bytes]:
        """Yield the bytes of another array, piece by piece."""
        with damage_named(self.path) as name_part:
            name_part(f"the array {shown(name)}: ")
            with self._archive.open_member(name) as old:
                yield from iter(lambda: old.read(PIECE), b"")


class _FrameReader:
    """Reads the frames of an archive, best one after the other.

    Attributes:
        header: The header of `positions`.
    """

    def __init__(self, archive: Archive) -> None:
        self._archive = archive
        self.header, self._file = archive.open_array(POSITIONS)
        self._next = 0  # number of the frame that the file is at
        shape, dtype = self.header.shape, self.header.dtype
        if len(shape) != 3 or shape[2] != 3 or 0 in shape:
            raise HeaderError(f"expected the shape (n_frames, n_vertices, 3), found {shape}")
        if dtype.kind != "f" or dtype.itemsize not in (4, 8):
            raise HeaderError(f"expected float32 or float64, found {dtype}")
        if self.header.is_fortran:
            raise HeaderError(
                "expected one frame after the other, found the order of Fortran; save it with "
                "numpy.ascontiguousarray(positions)"
            )

    def check_sum(self) -> None:
        """Read all frames, so that a wrong checksum is noticed at once."""
        self._skip(self.header.n_bytes)
        if self._file.read(1):
            raise HeaderError("expected no more bytes than the shape asks for, found more")
        self._next = self.header.shape[0]

    def read(self, number: int) -> AnyArray:
        """Return a frame, (n, 3) of the type of the file."""
        _, n_vertices, _ = self.header.shape
        size = n_vertices * 3 * self.header.dtype.itemsize
        if number < self._next:
            self._file.close()
            _, self._file = self._archive.open_array(POSITIONS)
            self._next = 0
        self._skip((number - self._next) * size)
        self._next = self.header.shape[0]  # in case that the next line fails
        content = self._piece(size)
        self._next = number + 1
        return np.frombuffer(content, self.header.dtype).reshape(n_vertices, 3)

    def _skip(self, size: int) -> None:
        while size > 0:
            size -= len(self._piece(min(PIECE, size)))

    def _piece(self, size: int) -> bytearray:
        """Return the next bytes, as many as asked for."""
        content = bytearray()
        while len(content) < size:
            piece = self._file.read(min(PIECE, size - len(content)))
            if not piece:
                raise HeaderError(f"expected {self.header.n_bytes} bytes of numbers, found fewer")
            content += piece
        return content


def _checked_faces(faces: AnyArray, n_vertices: int) -> Any:
    """Return the vertices of the faces one after the other, (3 m,) i8."""
    if faces.ndim != 2 or faces.shape[1] != 3 or faces.dtype.kind not in "iu":
        raise HeaderError(
            f"expected integers of shape (n_faces, 3), found {faces.dtype} of shape {faces.shape}"
        )
    bad = (faces < 0) | (faces >= n_vertices)
    if bad.any():
        row = int(bad.any(axis=1).argmax())
        raise HeaderError(
            f"expected vertices from 0 to {n_vertices - 1}, found {faces[row].tolist()} in face "
            f"{row}"
        )
    return faces.astype(np.int64).ravel()


def _new_member(archive: zipfile.ZipFile, old: zipfile.ZipInfo) -> Any:
    """Begin a file of the new archive that has name, date and compression of the old one."""
    info = zipfile.ZipInfo(old.filename, old.date_time)
    info.compress_type, info.external_attr = old.compress_type, old.external_attr
    info.comment = old.comment
    return archive.open(info, "w", force_zip64=True)


def _write_header(file: BinaryIO, header: Header, n_frames: int) -> None:
    """Write the header of `positions` for another number of frames."""
    fields = {
        "descr": header.dtype.str,
        "fortran_order": False,
        "shape": (n_frames, *header.shape[1:]),
    }
    np.lib.format.write_array_header_1_0(file, fields)
