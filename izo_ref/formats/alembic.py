"""Read and write the polygon meshes of Alembic files (.abc); needs the package alembic3d."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from izo_ref.base.arrays import AnyArray, Floats, Positions
from izo_ref.base.errors import FileFormatError
from izo_ref.base.input_files import open_input
from izo_ref.formats import own_space
from izo_ref.formats.alembic_copy import Copy, check_copy
from izo_ref.formats.alembic_library import (
    MESHES,
    Transform,
    at,
    errors,
    library,
    objects,
    schema,
    times,
)
from izo_ref.formats.animation import FilePath, Mesh
from izo_ref.formats.trial import try_in_child
from izo_ref.formats.whole_output import checked_frames, named_output, split

SAME_TIME = 1e-6  # [s]; exporters add up times in different ways


class AlembicAnimation:
    """The polygon meshes and subdivision cages of an Alembic archive.

    Frames are the samples of the positions, or of the transforms if those alone have samples. All
    meshes and transforms that have more than one sample have to have them at the same times.
    Positions are in the world. Where a transform is not the identity, `frame` of the written file
    may differ from what was written by the rounding of float32 numbers in the space of the mesh;
    `as_written` tells it before.

    All objects, properties, metadata and time samplings are copied: names, texture coordinates,
    normals and velocities as they were, face sets, transforms, curves and cameras. Bounds of meshes
    that change are computed anew. Bounds of children (`.childBnds`) are left out, as they would be
    wrong. The date of writing and the version of Alembic become those of the copy. The copy is
    compared with the original before it takes its name; a property that the package cannot write as
    it was is an error. Instances are refused. Files of the old HDF5 kind cannot be read.

    The library reads a sample when it is asked for, and writes each one at once.

    Attributes:
        path: The file.
        meshes: Its meshes, in the order of the archive; names are those of the objects, with those
            above.
        n_frames: Number of samples, 1 if nothing has several.
        precision: `float32`.
        up: `y`, the custom of programs that write Alembic.
        times: (n_frames,) f8 [s], times of the frames.
        is_exact: Whether the file holds positions in the world, so that what is written is what
            `frame` reads; else `as_written` tells what it reads.
    """

    precision, up = "float32", "y"

    def __init__(self, path: FilePath) -> None:
        """Open an archive.

        Args:
            path: An .abc file of the Ogawa kind.

        Raises:
            FileFormatError: It cannot be read, or it holds what is refused.
        """
        self.path = Path(path)
        library()
        open_input(self.path).close()
        try_in_child(__name__, "AlembicAnimation", self.path)
        with errors(self.path):
            self._archive = library().Abc.IArchive(str(self.path))
            found = [o for o in objects(self._archive, self.path) if schema(o).startswith(MESHES)]
            if not found:
                raise FileFormatError(f"{self.path}: expected meshes, found none")
            self._names = [own.getFullName() for own in found]
            self._parts = [_parts(own, self.path) for own in found]
            self._transforms = [Transform(own) for own in found]
            self.times = self._find_times()
            self.n_frames = len(self.times)
            self.meshes = tuple(self._meshes())
            self.is_exact = all(
                np.array_equal(self._matrix(number, k), own_space.IDENTITY)
                for k, transform in enumerate(self._transforms)
                for number in range(1 if transform.is_constant else self.n_frames)
            )

    def frame(self, number: int) -> Positions:
        """Read the positions of a frame in the world, (n_vertices, 3) f8.

        Args:
            number: From 0 to n_frames - 1.

        Raises:
            FileFormatError: A mesh has other polygons than in the first frame, another number of
                vertices, or a number that is not finite.
        """
        parts = []
        with errors(self.path):
            for k in range(len(self.meshes)):
                parts.append(own_space.to_world(self._own(number, k), self._matrix(number, k)))
                own_space.check_finite(parts[-1], self._where(number, k))
        return np.concatenate(parts)

    def as_written(self, number: int, positions: Positions) -> Positions:
        """Return what `frame` reads after `write` wrote these positions, (n_vertices, 3) f8.

        Args:
            number: Number of the frame.
            positions: (n_vertices, 3) f8.

        Raises:
            FileFormatError: As `frame` and `write`.
        """
        with errors(self.path):
            return np.concatenate(
                [
                    own_space.to_world(self._new_own(number, k, new), self._matrix(number, k))
                    for k, new in enumerate(split(positions, self._sizes()))
                ]
            )

    def write(self, path: FilePath, frames: Iterable[Positions]) -> None:
        """Write a copy of the archive with other positions.

        Args:
            path: The .abc file to write, not the one that was read.
            frames: (n_vertices, 3) f8 each.

        Raises:
            FileFormatError: It cannot be written, the frames do not fit, or the package cannot
                write a property as it was.
        """
        n_written = 0
        with named_output(path, ".abc", [self.path]) as new:
            with errors(path):
                copy = Copy(self._archive, self.path, new, self._names)
            checked = checked_frames(frames, sum(self._sizes()), self.n_frames, path)
            for number, positions in checked:
                with errors(path):
                    self._put(copy, number, positions)
                n_written += 1
            with errors(path):
                copy.finish(n_written, self.times)
                self._check(library().Abc.IArchive(new), path, n_written)

    def _put(self, copy: Copy, number: int, positions: Positions) -> None:
        """Put the positions of all meshes in one frame into the copy."""
        for k, world in enumerate(split(positions, self._sizes())):
            copy.put(
                k,
                number,
                self._new_own(number, k, world),
                lambda before, k=k: self._own(before, k),
                self._sampling,
            )

    def _check(self, archive: Any, path: FilePath, n_written: int) -> None:
        copies = {own.getFullName(): own for own in objects(archive, Path(path))}
        for old in objects(self._archive, self.path):
            name = old.getFullName()
            if name not in copies:
                raise FileFormatError(f"{path}: {name}: the package alembic3d cannot write it")
            compounds = (old.getProperties(), copies[name].getProperties())
            where = f"{path}: {name}"
            check_copy(*compounds, where, n_written, self.times, name in self._names)

    def _find_times(self) -> Floats:
        sampled: list[tuple[str, Any]] = []
        for name, (points, *_), transform in zip(
            self._names, self._parts, self._transforms, strict=True
        ):
            sampled += [(name, own) for own in (points, *transform.schemas)]
        many = [(name, own) for name, own in sampled if own.getNumSamples() > 1]
        first, own = (many or sampled)[0]
        found = times(own)
        self._sampling = own.getTimeSampling()
        for name, other in many:
            if len(times(other)) != len(found) or np.abs(times(other) - found).max() > SAME_TIME:
                raise FileFormatError(
                    f"{self.path}: mesh {name}: expected samples at the {len(found)} times of mesh "
                    f"{first}, found {len(times(other))} samples at other times"
                )
        return found

    def _meshes(self) -> Iterator[Mesh]:
        first = 0
        for name, (points, *faces) in zip(self._names, self._parts, strict=True):
            n_vertices = len(_array(points, 0))
            counts, corners = (_array(part, 0).astype(np.int64) for part in faces)
            own_space.check_polygons(counts, corners, n_vertices, f"{self.path}: mesh {name}")
            yield Mesh(name, first, n_vertices, counts, corners)
            first += n_vertices

    def _own(self, number: int, k: int) -> AnyArray:
        """Return the points of a mesh in its own space, (n, 3) f4."""
        mesh, (part, *faces) = self.meshes[k], self._parts[k]
        points = _array(part, number)
        if len(points) != mesh.n_vertices:
            raise FileFormatError(
                f"{self._where(number, k)}: expected {mesh.n_vertices} vertices, as in frame 0, "
                f"found {len(points)}"
            )
        for part, first in zip(faces, (mesh.counts, mesh.corners), strict=True):
            if part.getNumSamples() > 1 and part.getKey(at(number)) != part.getKey(at(0)):
                if np.array_equal(_array(part, number), first):
                    continue
                raise FileFormatError(
                    f"{self._where(number, k)}: expected the polygons of frame 0, found others"
                )
        return points

    def _matrix(self, number: int, k: int) -> Floats:
        matrix = self._transforms[k].matrix(number)
        return own_space.check_matrix(matrix, self._where(number, k))

    def _new_own(self, number: int, k: int, world: Positions) -> AnyArray:
        own = own_space.to_own(world, self._matrix(number, k), self._own(number, k))
        own_space.check_finite(own, self._where(number, k))
        return own

    def _sizes(self) -> list[int]:
        return [mesh.n_vertices for mesh in self.meshes]

    def _where(self, number: int, k: int) -> str:
        return f"{self.path}: frame {number}: mesh {self._names[k]}"


def _parts(mesh: Any, path: Path) -> tuple[Any, Any, Any]:
    """Return the properties with the points, the counts and the corners of a mesh."""
    where = f"{path}: mesh {mesh.getFullName()}"
    geometry = mesh.getProperties().getProperty(".geom")
    found = []
    for name, kind in (
        ("P", "float32_t[3]"),
        (".faceCounts", "int32_t"),
        (".faceIndices", "int32_t"),
    ):
        part = geometry.getProperty(name)
        if not (part.isArray() and str(part.getDataType()) == kind and part.getNumSamples()):
            raise FileFormatError(f"{where}: expected samples of {name}, an array of {kind}")
        found.append(part)
    return found[0], found[1], found[2]


def _array(part: Any, number: int) -> AnyArray:
    # a copy, as the library frees its memory
    return np.array(part.getValue(at(number if part.getNumSamples() > 1 else 0)))
