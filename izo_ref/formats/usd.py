"""Read and write the meshes of USD files: .usd, .usda and .usdc; needs the package usd-core.

A file that stands alone is written as a copy of its layer with other points. A stage that is
composed (of sublayers, references, payloads, variants, inherited prims or clips) is written
flattened into one layer, because its points may come from a place that others use too; the paths of
its textures become absolute by that.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from izo_ref.base.arrays import AnyArray, Floats, Positions
from izo_ref.base.errors import FileFormatError
from izo_ref.base.input_files import open_input
from izo_ref.formats import own_space
from izo_ref.formats.animation import FilePath, Mesh
from izo_ref.formats.trial import try_in_child
from izo_ref.formats.usd_edit import Edit
from izo_ref.formats.usd_library import (
    errors,
    open_stage,
    points_at,
    pxr,
    topology,
    topology_might_change,
)
from izo_ref.formats.whole_output import checked_frames, named_output, split

CRATE = b"PXR-USDC"  # how binary layers begin
SKIPPED = ("guide", "proxy")  # purposes of stand-ins, which would meet what they stand for
SKINNING = ("skel:skeleton", "skel:blendShapes", "primvars:skel:jointIndices")


class UsdAnimation:
    """The meshes of a USD stage: all polygon meshes but those of purpose `guide` and `proxy`.

    Frames are the time codes at which a mesh has a sample of its points, or a transform of it or of
    a prim above has one; a stage without samples has one frame. A mesh without a sample at a time
    code has there what USD interpolates. Positions are in the world. Where a transform is not the
    identity, `frame` of the written file may differ from what was written by the rounding of
    float32 numbers in the space of the mesh; `as_written` tells it before.

    Written are points, the extents of meshes that changed, and the last time code if the animation
    ends sooner. Hints of extents above changed meshes are deleted, as they would be wrong. Normals,
    velocities and all else stay as they were. A mesh that changes in no frame keeps its samples;
    another one has a sample at each time code. The text of a .usda file is that of the library,
    with the same numbers. USD keeps the whole layer in memory while it is edited; reading maps the
    file.

    Instances, point instancers and skinned meshes are refused.

    Attributes:
        path: The file.
        meshes: Its meshes, in the order of the stage; names are paths of prims.
        n_frames: Number of time codes, 1 if nothing has samples.
        precision: `float32`.
        up: `y` or `z`, as the stage says.
        times: (n_frames,) f8, time codes; one NaN, USD's default time, if nothing has samples.
        is_exact: Whether the file holds positions in the world, so that what is written is what
            `frame` reads; else `as_written` tells what it reads.
    """

    precision = "float32"

    def __init__(self, path: FilePath) -> None:
        """Open a stage with all its layers.

        Args:
            path: A .usd, .usda or .usdc file.

        Raises:
            FileFormatError: It cannot be read, a layer is missing, or it holds what is refused.
        """
        self.path = Path(path)
        pxr()
        with open_input(self.path) as file:
            self._is_crate = file.read(len(CRATE)) == CRATE
        try_in_child(__name__, "UsdAnimation", self.path)
        with errors(self.path):
            self._stage = open_stage(self.path)
            self.up = str(pxr().UsdGeom.GetStageUpAxis(self._stage)).lower()
            self._prims = _mesh_prims(self._stage, self.path)
            self.times = _times(self._prims, self.path)
            self.n_frames = len(self.times)
            self.meshes = tuple(self._meshes())
            self._might_change = [topology_might_change(prim) for prim in self._prims]
            self.is_exact = all(
                np.array_equal(self._matrix(number, k), own_space.IDENTITY)
                for number in (range(self.n_frames) if _has_moving_transform(self._prims) else (0,))
                for k in range(len(self.meshes))
            )

    def frame(self, number: int) -> Positions:
        """Read the positions of a frame in the world, (n_vertices, 3) f8.

        Args:
            number: From 0 to n_frames - 1.

        Raises:
            FileFormatError: A mesh has other polygons than in the first frame, another number of
                vertices, or a number that is not finite.
        """
        with errors(self.path):
            parts = []
            for k in range(len(self.meshes)):
                own, matrix = self._own(number, k)
                parts.append(own_space.to_world(own, matrix))
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
            parts = []
            for k, new in enumerate(split(positions, [mesh.n_vertices for mesh in self.meshes])):
                parts.append(own_space.to_world(*self._new_own(number, k, new)[::2]))
        return np.concatenate(parts)

    def write(self, path: FilePath, frames: Iterable[Positions]) -> None:
        """Write a copy of the stage with other points.

        Args:
            path: The file to write, of the same suffix; none of the layers that were read.
            frames: (n_vertices, 3) f8 each.

        Raises:
            FileFormatError: It cannot be written, or the frames do not fit.
        """
        layers = [layer.realPath for layer in self._stage.GetUsedLayers() if layer.realPath]
        n_vertices = sum(mesh.n_vertices for mesh in self.meshes)
        last = 0
        with named_output(path, self.path.suffix.lower(), layers) as new:
            with errors(path):
                edit = Edit(self._stage, [mesh.name for mesh in self.meshes], self.times)
            for number, positions in checked_frames(frames, n_vertices, self.n_frames, path):
                with errors(path):
                    self._put(edit, number, positions)
                last = number
            with errors(path):
                edit.end_at(last)
                edit.export(new, "usdc" if self._is_crate else "usda")

    def _put(self, edit: Edit, number: int, positions: Positions) -> None:
        """Put the positions of all meshes in one frame into a copy of the stage."""
        for k, world in enumerate(split(positions, [mesh.n_vertices for mesh in self.meshes])):
            own, old, _ = self._new_own(number, k, world)
            if not np.array_equal(own, old):
                edit.begin(k, number, lambda before, k=k: self._own(before, k)[0])
            edit.put(k, number, own)

    def _meshes(self) -> Iterator[Mesh]:
        first = 0
        for prim in self._prims:
            name = str(prim.GetPath())
            counts, corners = topology(prim, self._time(0))
            points = points_at(prim, self._time(0), f"{self.path}: frame 0: mesh {name}")
            own_space.check_polygons(counts, corners, len(points), f"{self.path}: mesh {name}")
            yield Mesh(name, first, len(points), counts.astype(np.int64), corners.astype(np.int64))
            first += len(points)

    def _own(self, number: int, k: int) -> tuple[AnyArray, Floats]:
        """Return the points of a mesh in its own space, (n, 3) f4, and its transform."""
        prim, mesh, where = self._prims[k], self.meshes[k], self._where(number, k)
        points = points_at(prim, self._time(number), where)
        if len(points) != mesh.n_vertices:
            raise FileFormatError(
                f"{where}: expected {mesh.n_vertices} vertices, as in frame 0, found {len(points)}"
            )
        if self._might_change[k]:
            counts, corners = topology(prim, self._time(number))
            same = np.array_equal(counts, mesh.counts) and np.array_equal(corners, mesh.corners)
            if not same:
                raise FileFormatError(f"{where}: expected the polygons of frame 0, found others")
        return points, self._matrix(number, k)

    def _matrix(self, number: int, k: int) -> Floats:
        cache = pxr().UsdGeom.XformCache(self._time(number))
        matrix = np.array(cache.GetLocalToWorldTransform(self._prims[k]), np.float64)
        return own_space.check_matrix(matrix, self._where(number, k))

    def _new_own(self, number: int, k: int, world: Positions) -> tuple[AnyArray, AnyArray, Floats]:
        """Return the points to write, those that were read, and the transform."""
        old, matrix = self._own(number, k)
        own = own_space.to_own(world, matrix, old)
        own_space.check_finite(own, self._where(number, k))
        return own, old, matrix

    def _time(self, number: int) -> Any:
        time = self.times[number]
        return pxr().Usd.TimeCode.Default() if np.isnan(time) else pxr().Usd.TimeCode(time)

    def _where(self, number: int, k: int) -> str:
        return f"{self.path}: frame {number}: mesh {self.meshes[k].name}"


def _mesh_prims(stage: Any, path: Path) -> list[Any]:
    meshes = []
    for prim in stage.Traverse():
        if prim.IsInstance() or prim.IsA(pxr().UsdGeom.PointInstancer):
            raise FileFormatError(
                f"{path}: {prim.GetPath()}: is an instance, or has some; make them real first"
            )
        if not prim.IsA(pxr().UsdGeom.Mesh):
            continue
        if any(prim.GetAttribute(name).HasAuthoredValue() for name in SKINNING[1:]) or (
            prim.GetRelationship(SKINNING[0]).HasAuthoredTargets()
        ):
            raise FileFormatError(f"{path}: mesh {prim.GetPath()}: is skinned; bake it first")
        if pxr().UsdGeom.Imageable(prim).ComputePurpose() not in SKIPPED:
            meshes.append(prim)
    if not meshes:
        raise FileFormatError(f"{path}: expected meshes, found none")
    return meshes


def _with_parents(prim: Any) -> Iterator[Any]:
    while not prim.IsPseudoRoot():
        yield prim
        prim = prim.GetParent()


def _has_moving_transform(prims: Iterable[Any]) -> bool:
    return any(
        pxr().UsdGeom.Xformable(above)
        and pxr().UsdGeom.Xformable(above).TransformMightBeTimeVarying()
        for prim in prims
        for above in _with_parents(prim)
    )


def _times(prims: Iterable[Any], path: Path) -> Floats:
    times: set[float] = set()
    for prim in prims:
        times.update(pxr().UsdGeom.Mesh(prim).GetPointsAttr().GetTimeSamples())
        for above in _with_parents(prim):
            if pxr().UsdGeom.Xformable(above):
                times.update(pxr().UsdGeom.Xformable(above).GetTimeSamples())
    if not np.isfinite(list(times)).all():
        raise FileFormatError(f"{path}: expected finite time codes")
    return np.array(sorted(times) or [np.nan])
