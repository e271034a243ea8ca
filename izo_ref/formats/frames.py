"""What all formats do with frames: check the numbers, keep what did not change, write it whole."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

import numpy as np

from izo_ref.base.arrays import AnyArray, AnyFloats, Positions
from izo_ref.base.errors import FileFormatError
from izo_ref.base.values import as_array, shown
from izo_ref.base.whole_files import open_whole
from izo_ref.base.whole_folder import open_folder
from izo_ref.formats.animation import Animation, FilePath, Mesh

LARGEST_FRAME = (2 << 30) - 1  # bytes of one file of a folder, which is in memory as a whole


def check_number(animation: Animation, number: int) -> None:
    """Raise an error if an animation has no such frame.

    Args:
        animation: The animation.
        number: Number of the frame.

    Raises:
        FileFormatError: There is no such frame.
    """
    if not 0 <= number < animation.n_frames:
        raise FileFormatError(
            f"{animation.path}: expected a frame from 0 to {animation.n_frames - 1}, got {number}"
        )


def check_finite(where: str, positions: AnyFloats, meshes: Iterable[Mesh]) -> None:
    """Raise an error if a coordinate that was read is NaN or infinite.

    Args:
        where: Path and frame, which begin the message.
        positions: (n, 3), positions of all meshes.
        meshes: The meshes.

    Raises:
        FileFormatError: A coordinate is not finite; names the mesh and the first such vertex.
    """
    bad = ~np.isfinite(positions).all(axis=1)
    if not bad.any():
        return
    vertex = int(bad.argmax())
    name, own = _mesh_of(meshes, vertex)
    raise FileFormatError(
        f"{where}: mesh {shown(name)}: expected finite coordinates, found "
        f"{positions[vertex].tolist()} at vertex {own}"
    )


def _mesh_of(meshes: Iterable[Mesh], vertex: int) -> tuple[str, int]:
    """Return the name of the mesh that has a vertex, and the number of the vertex in it."""
    for mesh in meshes:
        if mesh.first <= vertex < mesh.first + mesh.n_vertices:
            return mesh.name, vertex - mesh.first
    return "", vertex


def checked_frames(
    animation: Animation, frames: Iterable[Positions]
) -> Iterator[tuple[int, Positions]]:
    """Check frames before they are written.

    Args:
        animation: The animation that is written with other positions.
        frames: (n, 3) f8 each, floats of the animation's precision.

    Yields:
        Number and positions of each frame.

    Raises:
        FileFormatError: There is no frame or one too many, or a frame has another shape, or a
            number that is not finite or no float of the precision.
    """
    count, shape = 0, (sum(mesh.n_vertices for mesh in animation.meshes), 3)
    for number, frame in enumerate(frames):
        where = f"{animation.path}: frame {number} to write"
        if number == animation.n_frames:
            raise FileFormatError(f"{where}: expected at most {animation.n_frames} frames")
        try:
            array = as_array(frame)
        except ValueError as error:
            raise FileFormatError(f"{where}: expected an array, got {error}") from None
        if array.shape != shape or array.dtype.kind not in "fiu":
            raise FileFormatError(f"{where}: expected floats of shape {shape}, got {shown(frame)}")
        positions = array.astype(np.float64)
        check_finite(where, positions, animation.meshes)
        with np.errstate(over="ignore"):
            rounded = positions.astype(animation.precision)
        if not np.array_equal(rounded, positions):
            raise FileFormatError(
                f"{where}: expected positions rounded to {animation.precision}, which the file "
                "holds; found others"
            )
        yield number, positions
        count += 1
    if count == 0:
        raise FileFormatError(f"{animation.path}: expected at least one frame to write, got none")


def kept_bits(old: AnyArray, new: Positions) -> AnyArray:
    """Return new coordinates, with the bits of the old ones where they are equal.

    A zero keeps its sign, which equal numbers need not have in common.

    Args:
        old: (n, 3) f4 or f8 of any byte order, as the file has it.
        new: (n, 3) f8 [m].

    Returns:
        (n, 3) of the type of `old`.
    """
    changed = old.copy()
    np.copyto(changed, new.astype(old.dtype), where=old.astype(np.float64) != new)
    return changed


def count_that_fits(path: FilePath, count: int, each: int, room: int, what: str) -> int:
    """Return a count that a file declares, if there are bytes for so many.

    Args:
        path: The file.
        count: The count.
        each: Least number of bytes that each takes.
        room: Bytes that are there.
        what: What is counted, for the message.

    Raises:
        FileFormatError: The file has fewer bytes.
    """
    if count < 0 or count * each > room:
        raise FileFormatError(
            f"{path}: it declares {count} {what} of at least {each} bytes each, but there are "
            f"{room} bytes"
        )
    return count


def same_meshes(one: Sequence[Mesh], other: Sequence[Mesh]) -> str | None:
    """Compare the meshes of two frames.

    Returns:
        What differs, as the end of a message; None if names, vertices and polygons are the same.
    """
    if len(one) != len(other):
        return f"expected {len(one)} meshes, as in the first frame, found {len(other)}"
    for a, b in zip(one, other, strict=True):
        if a.name != b.name:
            return f"expected a mesh {shown(a.name)}, as in the first frame, found {shown(b.name)}"
        if a.n_vertices != b.n_vertices:
            return (
                f"mesh {shown(a.name)}: expected {a.n_vertices} vertices, as in the first frame, "
                f"found {b.n_vertices}"
            )
        if not np.array_equal(a.counts, b.counts) or not np.array_equal(a.corners, b.corners):
            return f"mesh {shown(a.name)}: expected the polygons of the first frame, found others"
    return None


@contextmanager
def whole_output(path: FilePath, inputs: Iterable[Path]) -> Iterator[BinaryIO]:
    """Open the file to write, which appears when the block ends without an error.

    Args:
        path: The file. A link is followed.
        inputs: The files that are read meanwhile.

    Yields:
        The file, to write bytes to.

    Raises:
        FileFormatError: The file is one of the inputs, or cannot be written.
    """
    target = _without_links(path)
    refuse_inputs(target, inputs)
    if target.exists() and not target.is_file():
        raise FileFormatError(f"{path}: cannot be written: expected a file or nothing there")
    if target.exists() and not os.access(target, os.W_OK):
        raise FileFormatError(f"{path}: cannot be written: the file there is read-only")
    with _errors_of(path), open_whole(target) as file:
        if target.exists() and hasattr(os, "fchmod"):  # it keeps its permissions
            os.fchmod(file.fileno(), stat.S_IMODE(os.stat(target).st_mode))
        yield file


@contextmanager
def whole_folder(path: FilePath, inputs: Sequence[Path], kinds: Iterable[str]) -> Iterator[Path]:
    """Make the folder to write, which appears when the block ends without an error.

    Args:
        path: The folder. A link is followed. One that exists is replaced, if all that is in it are
            files of the kinds that are written.
        inputs: The files that are read meanwhile.
        kinds: Suffixes of the files that are written.

    Yields:
        The new folder, to write files into.

    Raises:
        FileFormatError: An input is in the folder, something else is in it, or it cannot be
            written.
    """
    target = _without_links(path)
    for file in inputs:
        if target in Path(os.path.realpath(file)).parents:
            raise FileFormatError(f"{path}: expected another folder than that of {file}")
    with _errors_of(path):
        if target.exists() and not target.is_dir():
            raise FileFormatError(f"{path}: cannot be written: expected a folder or nothing there")
        for entry in target.iterdir() if target.exists() else ():
            if entry.suffix.lower() not in kinds or not entry.is_file():
                raise FileFormatError(
                    f"{path}: cannot be replaced: expected files {' and '.join(kinds)} alone, "
                    f"found {shown(entry.name)}, which would be deleted; write to a new folder"
                )
        with open_folder(target) as new:
            yield new


def _without_links(path: FilePath) -> Path:
    try:
        return Path(os.path.realpath(path))
    except ValueError as error:  # a NUL in the name
        raise FileFormatError(f"{shown(path)}: cannot be written: {error}") from None


@contextmanager
def _errors_of(path: FilePath) -> Iterator[None]:
    """Turn errors of writing into one that names the file."""
    try:
        yield
    except OSError as error:
        raise FileFormatError(f"{path}: cannot be written: {error.strerror or error}") from None


def refuse_inputs(target: Path, inputs: Iterable[Path]) -> None:
    """Raise an error if a file to write is one that is read, by the same name or by a link.

    Args:
        target: The file to write.
        inputs: The files that are read.

    Raises:
        FileFormatError: It is one of them.
    """
    for file in inputs:
        try:
            is_same = os.path.samefile(target, file)
        except (OSError, ValueError):
            is_same = False
        if is_same:
            raise FileFormatError(
                f"{target}: cannot be written: it is the file {file}, which is read; write to "
                "another name"
            )


def check_suffix(path: FilePath, suffix: str) -> None:
    """Raise an error if a file to write has another suffix than the animation that was read.

    Args:
        path: The file to write.
        suffix: The suffix that it has to have, in small letters.

    Raises:
        FileFormatError: It has another one.
    """
    if Path(path).suffix.lower() != suffix:
        raise FileFormatError(
            f"{path}: expected the suffix {suffix} of the animation that was read, found "
            f"{Path(path).suffix!r}"
        )
