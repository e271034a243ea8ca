"""Read and write animations of glTF by morph targets: .gltf and .glb."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from izo_ref.base.arrays import AnyArray, Floats, Positions
from izo_ref.base.errors import FileFormatError
from izo_ref.formats import own_space
from izo_ref.formats.animation import FilePath, Mesh
from izo_ref.formats.gltf_edit import Edit, offsets_from
from izo_ref.formats.gltf_file import GltfFile
from izo_ref.formats.gltf_json import errors, item, many
from izo_ref.formats.gltf_scene import FLOAT, Accessor, Shape, accessor, read, shapes
from izo_ref.formats.whole_output import checked_frames, named_output, split

MOVES = ("translation", "rotation", "scale", "pointer")
CUBIC = "CUBICSPLINE"


class Track(NamedTuple):
    """The animation of the weights of a node.

    Attributes:
        times: Accessor of the key times.
        weights: Accessor of the weights, all targets of a key time one after the other.
        is_cubic: Whether each key time has two tangents too.
        sampler: Number of the animation and of the sampler.
    """

    times: Accessor
    weights: Accessor
    is_cubic: bool
    sampler: tuple[int, int]


class GltfAnimation:
    """The triangles of a glTF scene, moved by the weights of morph targets.

    Frames are the key times of the weights; a file without an animation of weights has one frame.
    A position is the float32 sum of the base and of what the targets add. A frame can be changed if
    it is the base and one target with weight 1, and if that target is of no other frame with other
    positions; a mesh without targets can be changed where there is one frame. Other changes are
    refused. Positions are in the world. An offset from the base is a float32 number, so not every
    position can be written: `as_written` returns the one that is.

    Written is a copy with other offsets and their bounds. Names, materials, texture coordinates,
    normals and their offsets, and key times are as they were. Files of textures are not copied,
    and their paths stay. Each .bin file is copied under a new name, `NAME.XXXXXXXX.bin`, with a
    checksum of its content; one that an older copy had stays. If the animation ends sooner, that of
    the weights does; targets that are not used any more stay.

    Vertices that an exporter split, for different normals or texture coordinates at one place, are
    vertices of their own. Several primitives with the same positions are one mesh; points and lines
    are none. Sparse and compressed accessors, skins, instances and animated transforms of meshes
    are refused.

    Attributes:
        path: The file.
        meshes: Its meshes, in the order of the nodes.
        n_frames: Number of key times, 1 without an animation.
        precision: `float32`.
        up: `y`, as glTF has it.
        times: (n_frames,) f8 [s], key times; one zero without an animation.
        is_exact: Whether the file holds positions in the world, so that what is written is what
            `frame` reads; else `as_written` tells what it reads.
    """

    precision, up = "float32", "y"

    def __init__(self, path: FilePath) -> None:
        """Open a file with its buffers.

        Args:
            path: A .gltf or .glb file.

        Raises:
            FileFormatError: It cannot be read, or it holds what is refused.
        """
        self.path = Path(path)
        with errors(self.path):
            self._file = GltfFile(self.path)
            self._shapes = tuple(shapes(self._file))
            if not self._shapes:
                raise FileFormatError(f"{self.path}: expected meshes, found none")
            self._tracks = [self._track(shape) for shape in self._shapes]
            self.times = self._find_times()
            self.n_frames = len(self.times)
            self.meshes = tuple(self._meshes())
        for shape in self._shapes:
            own_space.check_matrix(shape.matrix, f"{self.path}: mesh {shape.name}")
        self.is_exact = all(
            not shape.targets and np.array_equal(shape.matrix, own_space.IDENTITY)
            for shape in self._shapes
        )

    def frame(self, number: int) -> Positions:
        """Read the positions of a frame in the world, (n_vertices, 3) f8.

        Args:
            number: From 0 to n_frames - 1.

        Raises:
            FileFormatError: A number is not finite, or a file is shorter than it was.
        """
        parts = []
        for k, shape in enumerate(self._shapes):
            parts.append(own_space.to_world(self._own(number, k), shape.matrix))
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
        parts = []
        for k, new in enumerate(split(positions, self._sizes())):
            change = self._change(number, k, new)
            own = self._own(number, k)
            if change is not None:
                target, values = change
                own = values if target is self._shapes[k].positions else _sum(self._base(k), values)
            parts.append(own_space.to_world(own, self._shapes[k].matrix))
        return np.concatenate(parts)

    def write(self, path: FilePath, frames: Iterable[Positions]) -> None:
        """Write a copy of the file with other positions.

        Args:
            path: The file to write, of the same suffix; none of those that were read.
            frames: (n_vertices, 3) f8 each.

        Raises:
            FileFormatError: It cannot be written, the frames do not fit, or a change is refused.
        """
        real = Path(os.path.realpath(path))
        last = 0
        with named_output(path, self.path.suffix.lower(), self._file.paths) as new:
            with errors(path):
                edit = Edit(self._file, new)
            checked = checked_frames(frames, sum(self._sizes()), self.n_frames, path)
            for number, positions in checked:
                for k, world in enumerate(split(positions, self._sizes())):
                    self._put(edit, number, k, world)
                last = number
            samplers = [track.sampler for track in self._tracks if track is not None]
            if last + 1 < self.n_frames:
                edit.cut(samplers, last + 1, self.n_frames)
                edit.set_last_time(samplers, float(self.times[last]))
            with errors(path):
                names = edit.finish(real.stem)
            for name in names:
                os.replace(os.path.join(os.path.dirname(new), name), real.parent / name)

    def _put(self, edit: Edit, number: int, k: int, world: Positions) -> None:
        """Put the positions of a mesh in one frame into the copy."""
        where = self._where(number, k)
        change = self._change(number, k, world)
        if change is not None:
            edit.put(*change, where)
            return
        weights = self._weights(number, k)
        targets = self._shapes[k].targets
        used = [own for own, weight in zip(targets, weights, strict=True) if own and weight]
        edit.lock([self._shapes[k].positions, *used], where)

    def _change(self, number: int, k: int, world: Positions) -> tuple[Accessor, AnyArray] | None:
        """Return where to write a mesh in a frame, and the numbers; None if nothing changes."""
        shape, where = self._shapes[k], self._where(number, k)
        old = self._own(number, k)
        new = own_space.to_own(world, shape.matrix, old)
        own_space.check_finite(new, where)
        if np.array_equal(new, old):
            return None
        if not shape.targets and self.n_frames == 1:
            return shape.positions, new
        target = _only(shape, self._weights(number, k))
        if target is None:
            raise FileFormatError(
                f"{where}: cannot be changed: expected the base and one morph target with weight 1"
            )
        offsets = offsets_from(self._base(k), world, shape.matrix, old)
        own_space.check_finite(offsets, where)
        stays = (new == old).all(axis=1)
        return target, np.where(stays[:, None], read(self._file, target), offsets)

    def _own(self, number: int, k: int) -> AnyArray:
        """Return the positions of a mesh in its own space, (n, 3) f4."""
        shape, weights = self._shapes[k], self._weights(number, k)
        target = _only(shape, weights)
        if target is not None:
            return _sum(self._base(k), read(self._file, target))
        with np.errstate(all="ignore"):  # callers look at what is not finite
            total = self._base(k).astype(np.float64)
            for own, weight in zip(shape.targets, weights, strict=True):
                if own is not None and weight:
                    total += weight * read(self._file, own)
            return total.astype(np.float32)

    def _base(self, k: int) -> AnyArray:
        return read(self._file, self._shapes[k].positions)

    def _weights(self, number: int, k: int) -> Floats:
        track, n_targets = self._tracks[k], len(self._shapes[k].targets)
        if track is None:
            return self._shapes[k].weights
        row = 3 * number + 1 if track.is_cubic else number
        found = read(self._file, track.weights.part(row * n_targets, n_targets))
        with np.errstate(invalid="ignore"):
            return found[:, 0].astype(np.float64)

    def _track(self, shape: Shape) -> Track | None:
        """Return the animation of the weights of a mesh; None if it has none."""
        found = []
        for number, animation in enumerate(many(self._file.document, "animations")):
            for channel in many(animation, "channels"):
                target = channel["target"]
                if target.get("path") in MOVES and target.get("node", None) in (None, *shape.chain):
                    raise ValueError(f"mesh {shape.name}: its transform is animated; bake it first")
                if target.get("path") == "weights" and target.get("node") == shape.chain[-1]:
                    found.append((number, channel["sampler"]))
        if not found or not shape.targets:
            return None
        if len(found) > 1:
            raise ValueError(f"mesh {shape.name}: expected one animation, found {len(found)}")
        number, index = found[0]
        sampler: Any = item(self._file.document["animations"][number], "samplers", index)
        times = accessor(self._file, sampler["input"], "SCALAR", FLOAT)
        weights = accessor(self._file, sampler["output"], "SCALAR", FLOAT)
        is_cubic = sampler.get("interpolation") == CUBIC
        expected = times.n_elements * len(shape.targets) * (3 if is_cubic else 1)
        if weights.n_elements != expected:
            raise ValueError(
                f"mesh {shape.name}: expected {expected} weights, found {weights.n_elements}"
            )
        return Track(times, weights, is_cubic, (number, index))

    def _find_times(self) -> Floats:
        tracks = [track for track in self._tracks if track is not None]
        if not tracks:
            return np.zeros(1)
        found = read(self._file, tracks[0].times)[:, 0].astype(np.float64)
        if not (len(found) and np.isfinite(found).all() and (np.diff(found) > 0).all()):
            raise ValueError("expected key times that increase")
        for shape, track in zip(self._shapes, self._tracks, strict=True):
            if track is not None and not np.array_equal(read(self._file, track.times)[:, 0], found):
                raise ValueError(f"mesh {shape.name}: expected the key times of the first mesh")
        return found

    def _meshes(self) -> Iterator[Mesh]:
        first = 0
        for shape in self._shapes:
            counts = np.full(len(shape.triangles), 3, np.int64)
            n_vertices = shape.positions.n_elements
            yield Mesh(shape.name, first, n_vertices, counts, shape.triangles.reshape(-1))
            first += n_vertices

    def _sizes(self) -> list[int]:
        return [mesh.n_vertices for mesh in self.meshes]

    def _where(self, number: int, k: int) -> str:
        return f"{self.path}: frame {number}: mesh {self._shapes[k].name}"


def _only(shape: Shape, weights: Floats) -> Accessor | None:
    """Return the target that has weight 1 if all others have none; None otherwise."""
    used = np.flatnonzero(weights)
    return shape.targets[used[0]] if len(used) == 1 and weights[used[0]] == 1 else None


def _sum(base: AnyArray, offsets: AnyArray) -> AnyArray:
    with np.errstate(all="ignore"):  # callers look at what is not finite
        return base + offsets
