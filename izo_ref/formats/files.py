"""Animations of one file for each frame, in a folder; one single file is one frame."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path
from typing import ClassVar, Protocol

import numpy as np

from izo_ref.base.arrays import AnyFloats, Positions
from izo_ref.base.errors import FileFormatError
from izo_ref.base.input_files import read_bytes
from izo_ref.base.values import shown
from izo_ref.base.whole_files import replace_whole
from izo_ref.formats.animation import FilePath, Mesh
from izo_ref.formats.frames import (
    LARGEST_FRAME,
    check_finite,
    check_number,
    check_suffix,
    checked_frames,
    same_meshes,
    whole_folder,
    whole_output,
)

# The last number in a name. More digits than these are no number of a frame.
NUMBER = re.compile(r"^(.*?)([0-9]{1,18})([^0-9]*)$")
NAMED_GAPS = 5  # missing numbers that a message names


class FileFrame(Protocol):
    """What one file of an animation holds.

    Attributes:
        meshes: Its meshes.
        positions: (n, 3) of the floats of the file [m], which may be NaN or infinite.
    """

    @property
    def meshes(self) -> tuple[Mesh, ...]:
        """The meshes."""
        ...

    @property
    def positions(self) -> AnyFloats:
        """The positions."""
        ...

    def replaced(self, positions: Positions) -> bytes:
        """Return the bytes of the file with other positions; what is equal keeps its bytes."""
        ...


class FilesAnimation:
    """An animation of one file for each frame; the base of the formats that have such files.

    Each frame is read when it is asked for. Its meshes and polygons have to be those of the first
    frame.

    Attributes:
        path: The folder, or the single file.
        meshes: The meshes of the first frame.
        n_frames: Number of files.
        precision: `float32` or `float64`.
        up: Axis that points up by the custom of the format, `y` or `z`.
        suffix: Suffix of the files.
        copied: Suffixes of other files of a folder, which are copied when it is written.
    """

    suffix: ClassVar[str] = ""
    up = "y"
    copied: ClassVar[tuple[str, ...]] = ()

    def __init__(self, path: FilePath) -> None:
        """Open a folder of files, or a single file, and read the first frame.

        Args:
            path: The folder or the file.

        Raises:
            FileFormatError: It cannot be read, or a number is missing among the names in it.
        """
        self.path = Path(path)
        self._is_folder = self.path.is_dir()
        self._files = numbered_files(self.path, self.suffix) if self._is_folder else [self.path]
        self.n_frames = len(self._files)
        self._first: FileFrame | None = None
        self._last: tuple[int, FileFrame] | None = None
        self._first = self._file(0)
        self.meshes = self._first.meshes
        self.precision = self._first.positions.dtype.name

    def frame(self, number: int) -> Positions:
        """Read the positions of a frame; `Animation.frame` has the contract.

        Args:
            number: From 0 to n_frames - 1.

        Returns:
            (n, 3) f8 [m].

        Raises:
            FileFormatError: There is no such frame, its file is damaged, its meshes are not those
                of the first frame, or a position is not finite.
        """
        check_number(self, number)
        return self._file(number).positions.astype(np.float64)

    def write(self, path: FilePath, frames: Iterable[Positions]) -> None:
        """Write copies of the files with other positions; `Animation.write` has the contract.

        Args:
            path: The folder or the file to write; a folder if a folder was read. A folder that
                exists is replaced if it has such files alone.
            frames: (n, 3) f8 each, floats of `precision`.

        Raises:
            FileFormatError: It cannot be written there, or the frames do not fit.
        """
        if not self._is_folder:
            check_suffix(path, self.suffix)
            with whole_output(path, self._files) as file:
                for number, positions in checked_frames(self, frames):
                    file.write(self._file(number).replaced(positions))
            return
        with whole_folder(path, self._files, (self.suffix, *self.copied)) as new:
            for number, positions in checked_frames(self, frames):
                name = os.path.join(new, self._files[number].name)
                replace_whole(name, self._file(number).replaced(positions), None)
            for other in self.path.iterdir():
                if other.suffix.lower() in self.copied and other.is_file():
                    shutil.copyfile(other, new / other.name)

    def _file(self, number: int) -> FileFrame:
        """Read the file of a frame, and check that it fits the first one.

        The last one is kept, because a frame is written soon after it was read.
        """
        if self._last is not None and self._last[0] == number:
            return self._last[1]
        self._last = None  # before the memory for the next one is taken
        file, where = self._files[number], f"{self._files[number]}: frame {number}"
        try:
            read = self._parse(read_bytes(file, LARGEST_FRAME), where, self._first)
        except MemoryError:
            raise FileFormatError(f"{where}: needs more memory than is free") from None
        if self._first is not None and read.meshes is not self._first.meshes:
            different = same_meshes(self._first.meshes, read.meshes)
            if different is not None:
                raise FileFormatError(f"{where}: {different}")
        if self._first is not None and read.positions.dtype.name != self.precision:
            raise FileFormatError(
                f"{where}: expected {self.precision}, as in the first frame, found "
                f"{read.positions.dtype.name}"
            )
        check_finite(where, read.positions, read.meshes)
        self._last = number, read
        return read

    def _parse(self, content: bytes, where: str, first: FileFrame | None) -> FileFrame:
        """Return what a file holds.

        Args:
            content: The bytes of the file.
            where: Path and frame, which begin a message.
            first: The first frame, whose meshes may be returned if they are the same; None if this
                is the first one.

        Raises:
            FileFormatError: The file is damaged.
        """
        raise NotImplementedError


def numbered_files(folder: Path, suffix: str) -> list[Path]:
    """Return the files of a folder in the order of the numbers in their names.

    The number of a name is the last one in it. Names that begin with a full stop are hidden files,
    and are left out.

    Args:
        folder: The folder.
        suffix: Suffix of the files, in small letters.

    Raises:
        FileFormatError: There is no file, a name has no number or another text around it, or a
            number is missing or there twice.
    """
    try:
        names = sorted(os.listdir(folder))
    except OSError as error:
        raise FileFormatError(f"{folder}: cannot be read: {error.strerror or error}") from None
    names = [name for name in names if not name.startswith(".")]
    files = [folder / name for name in names if Path(name).suffix.lower() == suffix]
    if len(files) == 1:
        return files
    if not files:
        raise FileFormatError(f"{folder}: expected files {suffix}, found none")
    by_number: dict[int, Path] = {}
    texts = set[tuple[str, str]]()
    for file in files:
        parts = NUMBER.match(file.stem)
        if parts is None:
            raise FileFormatError(f"{file}: expected a number of the frame in the name, found none")
        number = int(parts[2])
        if number in by_number:
            raise FileFormatError(
                f"{folder}: expected each number once, found {shown(by_number[number].name)} and "
                f"{shown(file.name)}"
            )
        by_number[number] = file
        texts.add((parts[1], parts[3]))
    if len(texts) > 1:
        one, other = sorted(texts)[:2]
        raise FileFormatError(
            f"{folder}: expected names that differ in their number alone, found "
            f"{shown('N'.join(one))} and {shown('N'.join(other))}, where N is the number"
        )
    return _without_gaps(folder, by_number)


def _without_gaps(folder: Path, by_number: dict[int, Path]) -> list[Path]:
    """Return the files in the order of their numbers, of which none may be missing."""
    numbers = sorted(by_number)
    missing, n_missing = list[int](), numbers[-1] - numbers[0] + 1 - len(numbers)
    for before, after in pairwise(numbers):
        missing += range(before + 1, min(after, before + 1 + NAMED_GAPS))
    if n_missing:
        named = ", ".join(map(str, missing[:NAMED_GAPS]))
        rest = f" and {n_missing - NAMED_GAPS} more" if n_missing > NAMED_GAPS else ""
        raise FileFormatError(
            f"{folder}: expected all frames from {numbers[0]} to {numbers[-1]}; missing: "
            f"{named}{rest}"
        )
    return [by_number[number] for number in numbers]
