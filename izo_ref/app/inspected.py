"""What `izo inspect` reads: a step or an animation, an obstacle, and the names of their parts."""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from izo_ref.app.animation_input import AnimationInput
from izo_ref.base import checks
from izo_ref.base.archives import names_in, read_archive
from izo_ref.base.arrays import Faces, Flags, Indices, Positions
from izo_ref.base.errors import FileFormatError, IzoError
from izo_ref.base.values import plain_text
from izo_ref.detection.components import MeshComponents
from izo_ref.formats.animation import Animation, Mesh, open_animation, triangles

MOST_PIECES = 8  # a mesh of more pieces is one part


class Part(NamedTuple):
    """A part of the input, by which crossings are named.

    Attributes:
        name: Name of the mesh, or `piece` and its number if there is one mesh of several pieces.
        n_vertices: Number of its vertices.
        n_pinned: How many of them are pinned.
    """

    name: str
    n_vertices: int
    n_pinned: int


class _Step:
    """A step in an .npz archive, as an animation of two frames."""

    precision, up = "float64", "z"

    def __init__(self, path: Path) -> None:
        names = ("positions_t0", "positions_t1", "faces")
        missing = sorted({*names} - {*names_in(path)})
        if missing:
            raise FileFormatError(
                f"{path}: expected the arrays {', '.join(names)} of a step; {missing[0]} is missing"
            )
        arrays = read_archive(path, {*names, "pinned"})
        self.path, self.n_frames = path, 2
        try:
            start = checks.floats("positions_t0", arrays["positions_t0"], (None, 3))
            n = len(start)
            self._ends = start, checks.floats("positions_t1", arrays["positions_t1"], (n, 3))
            corners = checks.indices("faces", arrays["faces"], 3, n).astype(np.int64)
            self.pinned: Flags = np.zeros(n, bool)
            if "pinned" in arrays:
                self.pinned = checks.flags("pinned", arrays["pinned"], n)
        except IzoError as error:
            raise FileFormatError(f"{path}: {error}") from None
        self.meshes = (Mesh(path.stem, 0, n, np.full(len(corners), 3), corners.ravel()),)

    def frame(self, number: int) -> Positions:
        """Return the start or the proposed end, (n, 3) f8 [m]."""
        return self._ends[number]


class Inspected:
    """What is inspected.

    Args:
        args: What the parser found.

    Attributes:
        path: The step or the animation.
        is_step: Whether it is a step.
        first: Number of the first frame that is inspected.
        last: Number of the last one.
        precision: `float32` or `float64`: the floats that hold its positions.
        faces: (m, 3) i4, the triangles of input and obstacle; a face may name a vertex twice.
        pinned: (n,) b1.
        parts: The parts.
        part_of: (n,) i8, the part that each vertex is in.

    Raises:
        FileFormatError: A file cannot be read.
        OptionError: A mesh to pin or a frame does not exist.
        ShapeError: The obstacle has another number of frames.
    """

    def __init__(self, args: argparse.Namespace) -> None:
        """Open the files."""
        self.path = Path(args.input)
        own: Any = _opened(self.path, args.topology)
        self._read = read = AnimationInput(own, args.obstacle, args.pin, args.start, args.stop)
        self.is_step, self.precision = isinstance(own, _Step), own.precision
        self.first, self.last = read.first, read.last
        self.faces: Faces = read.faces()
        self.pinned: Flags = read.pinned()
        if isinstance(own, _Step):
            self.pinned[: read.n_own] |= own.pinned
        groups, names = _named_parts(own, self.faces[: len(triangles(own.meshes))])
        if read.obstacle is not None:
            others, more = _named_parts(read.obstacle, triangles(read.obstacle.meshes))
            groups = np.concatenate((groups, others + len(names)))
            clashes = {*names} & {*more}
            names += [f"{name} (obstacle)" if name in clashes else name for name in more]
        self.part_of: Indices = groups
        self.parts = _parts(names, groups, self.pinned)

    def frame(self, number: int) -> Positions:
        """Read a frame with the obstacle, (n, 3) f8 [m].

        Args:
            number: From 0 on.
        """
        return self._read.frame(number)

    def frames(self) -> Iterator[Positions]:
        """Read the frames that are inspected, one after the other."""
        return self._read.frames()


def _opened(path: Path, topology: str | None) -> Animation | _Step:
    """Open a step or an animation."""
    if path.suffix.lower() == ".npz" and path.is_file():
        names = names_in(path)
        if "positions" not in names and {"positions_t0", "positions_t1"} & {*names}:
            return _Step(path)
    return open_animation(path, topology)


def _named_parts(animation: Animation | _Step, faces: Faces) -> tuple[Indices, list[str]]:
    """Return the part of each vertex, (n,) i8, and the names of the parts.

    Parts are the meshes. If there is one mesh of a few pieces, the pieces are the parts: exporters
    and steps often have all in one mesh.
    """
    meshes = animation.meshes
    names = [plain_text(mesh.name) for mesh in meshes]
    group = np.arange(len(meshes)).repeat([mesh.n_vertices for mesh in meshes])
    if len(meshes) == 1 and len(faces):
        pieces, n = MeshComponents(len(group), faces), len(group)
        is_used = np.zeros(n, bool)
        is_used[faces] = True
        numbers = np.unique(pieces.component[is_used])
        if 1 < len(numbers) <= MOST_PIECES:
            group = np.searchsorted(numbers, pieces.component).clip(0, len(numbers) - 1)
            names = [f"piece {k + 1}" for k in range(len(numbers))]
    counts, seen = Counter(names), Counter[str]()
    for i, name in enumerate(names):
        seen[name] += 1
        if counts[name] > 1:
            names[i] = f"{name} number {seen[name]}"
    return group.astype(np.int64), names


def _parts(names: list[str], groups: Indices, pinned: Flags) -> tuple[Part, ...]:
    sizes = np.bincount(groups, minlength=len(names)).tolist()
    fixed = np.bincount(groups[pinned], minlength=len(names)).tolist()
    return tuple(Part(*row) for row in zip(names, sizes, fixed, strict=True))
