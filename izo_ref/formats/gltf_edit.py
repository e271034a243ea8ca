"""Change positions and offsets of morph targets in a copy of a glTF file."""

from __future__ import annotations

import copy
import os
from collections.abc import Sequence

import numpy as np

from izo_ref.base.arrays import AnyArray, Floats, Positions
from izo_ref.base.errors import FileFormatError
from izo_ref.formats import own_space
from izo_ref.formats.gltf_file import GltfFile
from izo_ref.formats.gltf_scene import Accessor, shared

DROPPED = range(4, 24, 4)  # bits


def offsets_from(base: AnyArray, world: Positions, matrix: Floats, old: AnyArray) -> AnyArray:
    """Return offsets from a base, as float32 numbers, for positions in the world.

    The sum of base and offset is rounded too. So a few sums in a million, beside a transform, would
    become another position when they are written again. These drop bits until they stay.

    Args:
        base: (n, 3) f4.
        world: (n, 3) f8.
        matrix: (4, 4) f8, from `check_matrix`.
        old: (n, 3) f4, positions that were read, in the space of the mesh.

    Returns:
        (n, 3) f4, infinite where a number is too large for float32.
    """

    def rounded(positions: Positions, coarser: int) -> AnyArray:
        own = own_space.to_own(positions, matrix, old, coarser)
        return (own.astype(np.float64) - base).astype(np.float32)

    with np.errstate(all="ignore"):
        offsets = rounded(world, 0)
        for coarser in DROPPED:
            own = base + offsets
            again = base + rounded(own_space.to_world(own, matrix), 0)
            wrong = (again != own).any(axis=1)
            if not wrong.any():
                break
            offsets[wrong] = rounded(world, coarser)[wrong]
    return offsets


class Edit:
    """A copy of a file: its document, and a file for each buffer that changes."""

    def __init__(self, file: GltfFile, new: str) -> None:
        """Start a copy without changes.

        Args:
            file: The original.
            new: The file to write; buffers are kept beside it meanwhile.
        """
        self._file = file
        self._new = new
        self._document = copy.deepcopy(file.document)
        self._copies: dict[int, str] = {}
        self._shared = shared(file)
        self._locked: set[int] = set()
        for number, own in enumerate(file.buffers):
            if own.path is not None and own.path != file.path:
                self._copy_of(number)  # so that the copy needs no file of the original

    def lock(self, accessors: Sequence[Accessor], where: str) -> None:
        """Keep numbers as they are in the copy, because a frame needs them so.

        Args:
            accessors: Where they are; they must not have changed yet.
            where: Path, frame and mesh, for the message.

        Raises:
            FileFormatError: Some have changed.
        """
        for own in accessors:
            if not np.array_equal(self.read(own), own.view(self._original(own))):
                raise FileFormatError(f"{where}: needs numbers that another frame has changed")
            self._locked.add(own.number)

    def put(self, own: Accessor, values: AnyArray, where: str) -> None:
        """Write numbers, once for each accessor.

        Args:
            own: Where they go.
            values: (n_elements, 3) f4.
            where: Path, frame and mesh, for the message.

        Raises:
            FileFormatError: Another frame needs other numbers there, or they belong to another
                accessor too.
        """
        is_same = np.array_equal(self.read(own), values)
        if own.number in self._locked and not is_same:
            raise FileFormatError(
                f"{where}: has the same target as another frame, which needs other positions"
            )
        self._locked.add(own.number)
        if is_same:
            return
        if own.number in self._shared:
            raise FileFormatError(
                f"{where}: accessor {own.number} has bytes that belong to another one too"
            )
        with open(self._copy_of(own.buffer), "r+b") as file:
            file.seek(own.begin)
            content = bytearray(file.read(own.extent))
            own.view(content)[:] = values
            file.seek(own.begin)
            file.write(content)
        entry = self._document["accessors"][own.number]
        for key, bound in (("min", np.min), ("max", np.max)):
            if key in entry:
                entry[key] = bound(values, axis=0).astype(np.float64).tolist()

    def read(self, own: Accessor) -> AnyArray:
        """Return the numbers that the copy has now, (n_elements, width)."""
        if own.buffer not in self._copies:
            return own.view(self._original(own))
        with open(self._copies[own.buffer], "rb") as file:
            file.seek(own.begin)
            return own.view(file.read(own.extent))

    def cut(self, samplers: Sequence[tuple[int, int]], n_written: int, n_frames: int) -> None:
        """Let animations end sooner.

        Args:
            samplers: Number of the animation and of the sampler of each.
            n_written: Number of key times that are left.
            n_frames: Number of key times that there are.
        """
        accessors = self._document["accessors"]
        for animation, number in set(samplers):
            sampler = self._document["animations"][animation]["samplers"][number]
            for key in ("input", "output"):
                # other samplers may use the same accessor
                entry = copy.deepcopy(accessors[sampler[key]])
                entry["count"] = entry["count"] // n_frames * n_written
                sampler[key] = len(accessors)
                accessors.append(entry)

    def set_last_time(self, samplers: Sequence[tuple[int, int]], last: float) -> None:
        """Set the largest key time, which the document repeats."""
        for animation, number in set(samplers):
            sampler = self._document["animations"][animation]["samplers"][number]
            entry = self._document["accessors"][sampler["input"]]
            if "max" in entry:
                entry["max"] = [last]

    def finish(self, stem: str) -> list[str]:
        """Write the copy.

        Args:
            stem: How the names of .bin files begin.

        Returns:
            Names of the .bin files, beside the copy.
        """
        return self._file.write(self._new, stem, self._document, self._copies)

    def _original(self, own: Accessor) -> bytes:
        return self._file.read(own.buffer, own.begin, own.extent)

    def _copy_of(self, buffer: int) -> str:
        if buffer not in self._copies:
            name = os.path.join(os.path.dirname(self._new), f"buffer{buffer}")
            self._file.copy_buffer(buffer, name)
            self._copies[buffer] = name
        return self._copies[buffer]
