"""Copy an Alembic archive, property by property and sample by sample, with other positions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from izo_ref.base.arrays import AnyArray, Floats
from izo_ref.base.errors import FileFormatError
from izo_ref.formats.alembic_library import at, library, objects, properties, times

CHILD_BOUNDS = ".childBnds"  # would be wrong; readers can do without
POINTS, BOUNDS = "P", ".selfBnds"


class Copy:
    """An archive that is being written.

    All objects and properties are there from the start; the samples of each follow in their order.
    """

    def __init__(self, archive: Any, path: Path, new: str, meshes: Sequence[str]) -> None:
        """Create an archive with the objects and the properties of another one.

        Args:
            archive: The one that is copied.
            path: Its file.
            new: The file to write.
            meshes: Full names of the meshes.
        """
        abc = library().Abc
        top = archive.getTop().getMetaData()
        # what it says of itself, such as the frame rate, is in this metadata too
        words = [str(top.get(f"_ai_{name}")) for name in ("Application", "Description")]
        self._archive: Any = abc.CreateArchiveWithInfo(new, *words, abc.Argument(top))
        for k in range(1, archive.getNumTimeSamplings()):
            self._archive.addTimeSampling(archive.getTimeSampling(k))
        self._points: dict[int, tuple[Any, Any]] = {}
        self._bounds: dict[int, tuple[Any, Any]] = {}
        self._others: list[tuple[Any, Any]] = []
        self._changed: set[int] = set()
        copies = {}
        for found in objects(archive, path):
            name = found.getFullName()
            if name == "/":
                copies[name] = self._archive.getTop()
            else:
                parent = copies[found.getParent().getFullName()]
                argument = abc.Argument(found.getMetaData())
                copies[name] = abc.OObject(parent, found.getName(), argument)
            mesh = meshes.index(name) if name in meshes else None
            self._add(found.getProperties(), copies[name].getProperties(), mesh)

    def put(
        self, k: int, number: int, points: AnyArray, old: Callable[[int], AnyArray], frames: Any
    ) -> None:
        """Write the points of a mesh in a frame, once they differ from those that were read.

        Args:
            k: Number of the mesh.
            number: Number of the frame; they come in their order.
            points: (n, 3) f4, in the space of the mesh.
            old: Returns the points that were read in a frame, (n, 3) f4.
            frames: Time sampling of the frames.
        """
        if k not in self._changed:
            if np.array_equal(points, old(number)):
                return
            self._changed.add(k)
            for pair in (self._points[k], self._bounds.get(k)):
                if pair is not None and pair[0].getNumSamples() == 1:
                    pair[1].setTimeSampling(self._archive.addTimeSampling(frames))
            for before in range(number):
                self._write(k, old(before))
        self._write(k, points)

    def finish(self, n_written: int, ends: Floats) -> None:
        """Write all samples that are as they were, and close the archive.

        Args:
            n_written: Number of frames that were written.
            ends: (n_frames,) f8, times of all frames.
        """
        for old, new in self._others:
            _write_samples(old, new, 1, kept_samples(old, n_written, ends))
        for k in self._points.keys() - self._changed:
            for pair in (self._points[k], self._bounds.get(k)):
                if pair is not None:
                    _write_samples(*pair, 0, kept_samples(pair[0], n_written, ends))
        # the library writes the rest when nothing refers to the archive any more
        self._points, self._bounds, self._others, self._archive = {}, {}, [], None

    def _add(self, old: Any, new: Any, mesh: int | None) -> None:
        abc = library().Abc
        for own in properties(old):
            name, meta = own.getName(), abc.Argument(own.getMetaData())
            if name == CHILD_BOUNDS:
                continue
            if own.isCompound():
                self._add(own, abc.OCompoundProperty(new, name, meta), mesh)
                continue
            kind = abc.OArrayProperty if own.isArray() else abc.OScalarProperty
            index = self._archive.addTimeSampling(own.getTimeSampling())
            copy = kind(new, name, own.getDataType(), meta, abc.Argument(index))
            if mesh is None or old.getName() != ".geom" or name not in (POINTS, BOUNDS):
                # the first sample now, so that what cannot be written fails before the frames come
                _write_samples(own, copy, 0, min(1, own.getNumSamples()))
                self._others.append((own, copy))
            elif name == POINTS:
                self._points[mesh] = own, copy
            else:
                self._bounds[mesh] = own, copy

    def _write(self, k: int, points: AnyArray) -> None:
        imath = library().imath
        value = imath.V3fArrayFromBuffer(np.ascontiguousarray(points, np.float32))
        self._points[k][1].setValue(value)
        if k in self._bounds and len(points):
            low, high = (imath.V3d(*map(float, end(points, axis=0))) for end in (np.min, np.max))
            self._bounds[k][1].setValue(imath.Box3d(low, high))


def _write_samples(old: Any, new: Any, begin: int, end: int) -> None:
    for number in range(begin, end):
        new.setValue(old.getValue(at(number)))


def kept_samples(old: Any, n_written: int, ends: Floats) -> int:
    """Return how many samples of a property are left when an animation ends sooner.

    Args:
        old: The property.
        n_written: Number of frames that are left.
        ends: (n_frames,) f8, times of all frames.
    """
    n_samples = old.getNumSamples()
    if n_samples <= 1 or n_written == len(ends):
        return n_samples
    if n_samples == len(ends):  # some parts of a transform have a sampling without times
        return n_written
    return max(1, int((times(old) <= ends[n_written - 1]).sum()))


def check_copy(old: Any, new: Any, where: str, n_written: int, ends: Floats, is_mesh: bool) -> None:
    """Check that a copy has all that the original has, but for the positions.

    Args:
        old: Compound of the original.
        new: The same of the copy.
        where: Path and name of the object, for the message.
        n_written: Number of frames that were written.
        ends: (n_frames,) f8, times of all frames.
        is_mesh: Whether the positions of this object may differ.

    Raises:
        FileFormatError: The library cannot write a property as it was.
    """
    copies = {own.getName(): own for own in properties(new)}
    for own in properties(old):
        name = own.getName()
        if name == CHILD_BOUNDS:
            continue
        copy = copies.get(name)
        if copy is not None and own.isCompound():
            check_copy(own, copy, f"{where}: {name}", n_written, ends, is_mesh)
            continue
        is_free = is_mesh and old.getName() == ".geom" and name in (POINTS, BOUNDS)
        n_samples = kept_samples(own, n_written, ends)
        if copy is None or not (is_free or _same_samples(own, copy, n_samples)):
            raise FileFormatError(f"{where}: the package alembic3d cannot write {name} as it was")


def _same_samples(own: Any, copy: Any, n_samples: int) -> bool:
    if copy.getNumSamples() != n_samples or own.getDataType() != copy.getDataType():
        return False
    if own.isArray():
        return all(own.getKey(at(k)) == copy.getKey(at(k)) for k in range(n_samples))
    return all(_words(own, k) == _words(copy, k) for k in range(n_samples))


def _words(scalar: Any, number: int) -> str:
    value = scalar.getValue(at(number))
    return repr(list(value) if type(value).__name__.endswith("Array") else value)
