"""An animation: meshes whose positions change from frame to frame, in any format.

Each format is a module with a class that implements `Animation`. `open_animation` chooses it by the
suffix of the path. An animation is written as a copy of the one that was read, with other
positions, so names, order, materials, texture coordinates and polygons stay as they are.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from importlib import import_module
from pathlib import Path
from typing import NamedTuple, Protocol, TypeAlias

import numpy as np

from izo_ref.base.arrays import Faces, Indices, Positions
from izo_ref.base.errors import FileFormatError

FilePath: TypeAlias = str | os.PathLike[str]


class Mesh(NamedTuple):
    """One mesh of an animation.

    Attributes:
        name: Its name in the file.
        first: Number of its first vertex among the vertices of all meshes.
        n_vertices: Number of its vertices.
        counts: (k,) i8, corners of each polygon.
        corners: (sum of counts,) i8, vertices of the polygons, one after the other, from 0 in each
            mesh.
    """

    name: str
    first: int
    n_vertices: int
    counts: Indices
    corners: Indices


class Animation(Protocol):
    """An animation in a file, or in a folder of files.

    Attributes:
        path: Where it is.
        meshes: Its meshes; their vertices are numbered one mesh after the other.
        n_frames: Number of frames, at least 1.
        precision: `float32` or `float64`: the floats that hold positions in this format.
        up: The axis that points up, `y` or `z`: as the file says, or as is usual in its format.
    """

    path: Path
    meshes: tuple[Mesh, ...]
    n_frames: int
    precision: str
    up: str

    def frame(self, number: int) -> Positions:
        """Read the positions of a frame, (n_vertices, 3) f8 [m as written].

        Args:
            number: From 0 to n_frames - 1.

        Raises:
            FileFormatError: The frame cannot be read, has another number of vertices, or holds a
                number that is not finite; the message names path, frame and mesh.
        """
        ...

    def write(self, path: FilePath, frames: Iterable[Positions]) -> None:
        """Write the same animation with other positions; all of it appears, or nothing.

        A vertex whose position is the one that was read is written bit for bit as it was.

        Args:
            path: Where to write; its suffix is that of the animation. What is there is replaced.
            frames: (n_vertices, 3) f8 each, floats of `precision`; as many as `n_frames`, or fewer
                if the animation is to end sooner.

        Raises:
            FileFormatError: It cannot be written there.
        """
        ...


# The module and the class of each suffix; the empty one is a folder of files.
FORMATS = {
    ".npz": "npz:NpzAnimation",
    ".obj": "obj:ObjAnimation",
    ".ply": "ply:PlyAnimation",
    ".pc2": "caches:PointCache2",
    ".mdd": "caches:Mdd",
    ".gltf": "gltf:GltfAnimation",
    ".glb": "gltf:GltfAnimation",
    ".usd": "usd:UsdAnimation",
    ".usda": "usd:UsdAnimation",
    ".usdc": "usd:UsdAnimation",
    ".abc": "alembic:AlembicAnimation",
}


CACHES = (".pc2", ".mdd")


def open_animation(path: FilePath, topology: FilePath | None = None) -> Animation:
    """Open an animation; its format is that of the suffix.

    Args:
        path: A file, or a folder of OBJ or PLY files, one for each frame, in the order of the
            numbers in their names.
        topology: For a point cache, which holds positions alone: an OBJ or PLY file with the
            polygons of the same vertices. None takes the file of the same name beside it.

    Raises:
        FileFormatError: It cannot be read, or its suffix is that of no format; names the path, and
            says what is wrong.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if path.is_dir():
        suffix = _suffix_of_folder(path)
    if suffix not in FORMATS:
        raise FileFormatError(
            f"{path}: expected a file with one of the suffixes {', '.join(FORMATS)}, or a folder "
            f"of .obj or .ply files; found {path.suffix!r}"
        )
    module, name = FORMATS[suffix].split(":")
    kind = getattr(import_module(f"izo_ref.formats.{module}"), name)
    opened: Animation = kind(path, topology) if suffix in CACHES else kind(path)
    return opened


def _suffix_of_folder(path: Path) -> str:
    found = sorted({entry.suffix.lower() for entry in path.iterdir()} & {".obj", ".ply"})
    if len(found) != 1:
        raise FileFormatError(
            f"{path}: expected a folder with .obj files or with .ply files, found "
            f"{' and '.join(found) or 'neither'}"
        )
    return found[0]


def triangles(meshes: Iterable[Mesh]) -> Faces:
    """Cut all polygons into triangles, as fans from their first corner.

    Args:
        meshes: The meshes.

    Returns:
        (m, 3) i4, vertices among those of all meshes. Polygons of fewer than three corners have no
        triangle.
    """
    parts = [np.empty((0, 3), np.int32)]
    for mesh in meshes:
        begins = np.cumsum(mesh.counts) - mesh.counts
        n_own = np.maximum(mesh.counts - 2, 0)
        first = begins.repeat(n_own)
        ends = np.cumsum(n_own)
        second = np.arange(ends[-1] if len(ends) else 0) - (ends - n_own).repeat(n_own)
        places = np.column_stack((first, first + second + 1, first + second + 2))
        parts.append((mesh.first + mesh.corners[places]).astype(np.int32))
    return np.concatenate(parts)
