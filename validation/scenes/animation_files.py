"""Write an animation in each format of files, with attributes that a program has to keep."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple, TypeAlias

import numpy as np

from izo_ref.base.arrays import Floats
from validation.scenes.moving_garment import Moving, Part

RATE = 24.0  # frames a second
Writer: TypeAlias = Callable[[Path, Moving], None]


class Written(NamedTuple):
    """An animation in files.

    Attributes:
        path: The file, or the folder of files.
        flags: Words of the command line that say which meshes are pinned.
        parts: The parts that are in the file; the others are in the file of an obstacle.
    """

    path: Path
    flags: tuple[str, ...]
    parts: tuple[Part, ...]


def write_animation(folder: Path, kind: str, moving: Moving) -> Written:
    """Write an animation.

    Parts that are pinned are in the same file where the format has names of meshes. Otherwise they
    are in a second file, as an obstacle.

    Args:
        folder: An empty folder.
        kind: One of FORMATS.
        moving: The animation.

    Returns:
        Where it is, and the words that the command takes for it.
    """
    has_names, suffix, write = FORMATS[kind]
    path = folder / f"animation{suffix}"
    if has_names:
        write(path, moving)
        flags = tuple(word for name in moving.pinned for word in ("--pin", name_in(kind, name)))
        return Written(path, flags, moving.parts)
    own = only(moving, [part for part in moving.parts if part.name not in moving.pinned])
    write(path, own)
    kept = tuple(part for part in moving.parts if part.name not in moving.pinned)
    if not moving.pinned:
        return Written(path, (), kept)
    obstacle = only(moving, [part for part in moving.parts if part.name in moving.pinned])
    write_npz(folder / "obstacle.npz", obstacle)
    return Written(path, ("--obstacle", str(folder / "obstacle.npz")), kept)


def only(moving: Moving, parts: list[Part]) -> Moving:
    """Return an animation of some of the parts."""
    columns = [moving.positions[:, part.first : part.first + part.n_vertices] for part in parts]
    firsts = np.cumsum([0, *(part.n_vertices for part in parts)])
    moved = [part._replace(first=int(first)) for part, first in zip(parts, firsts, strict=False)]
    pinned = tuple(part.name for part in parts if part.name in moving.pinned)
    return Moving(np.concatenate(columns, axis=1), tuple(moved), pinned)


def name_in(kind: str, name: str) -> str:
    """Return the name that a part has in a format."""
    return {"usd": f"/scene/{name}", "abc": f"/scene/{name}"}.get(kind, name)


def coordinates_of(part: Part) -> Floats:
    """Return texture coordinates of a part, (n, 2) f8, multiples of 2^-10."""
    i = np.arange(part.n_vertices)
    return np.column_stack((i % 1024, (7 * i) % 1024)) / 1024.0


def write_npz(path: Path, moving: Moving) -> None:
    """Write an archive, with an array before and arrays behind those that are read."""
    coordinates = np.concatenate([coordinates_of(part) for part in moving.parts])
    np.savez_compressed(
        path,
        rate=np.array(RATE),
        positions=moving.positions,
        uv=coordinates.astype(np.float32),
        faces=moving.faces,
        names=np.array([part.name for part in moving.parts]),
    )


def write_obj(path: Path, moving: Moving) -> None:
    """Write a folder of OBJ files, each with objects, materials and texture coordinates."""
    path.mkdir()
    for number, frame in enumerate(moving.positions):
        (path / f"frame_{number:04d}.obj").write_text(obj_text(moving, frame))
    (path / "cloth.mtl").write_text("newmtl cloth\nKd 0.5 0.25 0.125\n")


def obj_text(moving: Moving, frame: Floats) -> str:
    """Return a frame as an OBJ file."""
    lines = ["# a study of izo_ref", "mtllib cloth.mtl"]
    for part in moving.parts:
        own = frame[part.first : part.first + part.n_vertices]
        lines += [f"o {part.name}", "usemtl cloth"]
        lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in own.tolist()]
        lines += [f"vt {u!r} {v!r}" for u, v in coordinates_of(part).tolist()]
        corners = (part.faces + part.first + 1).tolist()
        lines += ["f " + " ".join(f"{i}/{i}" for i in face) for face in corners]
    return "\n".join(lines) + "\n"


def write_ply(path: Path, moving: Moving) -> None:
    """Write a folder of binary PLY files, whose vertices and faces have further properties."""
    path.mkdir()
    n = moving.positions.shape[1]
    head = ["ply", "format binary_little_endian 1.0", "comment a study", f"element vertex {n}"]
    head += ["property short age", *(f"property float {axis}" for axis in "xyz")]
    head += ["property uchar red", f"element face {len(moving.faces)}"]
    head += ["property list uchar int vertex_indices", "property uchar flag", "end_header", ""]
    rows = np.zeros(n, [("age", "<i2"), ("xyz", "<f4", 3), ("red", "u1")])
    rows["age"], rows["red"] = np.arange(n) % 1000 - 500, np.arange(n) % 251
    faces = np.zeros(len(moving.faces), [("n", "u1"), ("corners", "<i4", 3), ("flag", "u1")])
    faces["n"], faces["corners"], faces["flag"] = 3, moving.faces, np.arange(len(faces)) % 7
    for number, frame in enumerate(moving.positions):
        rows["xyz"] = frame
        content = "\n".join(head).encode() + rows.tobytes() + faces.tobytes()
        (path / f"frame_{number:04d}.ply").write_bytes(content)


def write_pc2(path: Path, moving: Moving) -> None:
    """Write a point cache of Blender, and an OBJ file with its polygons beside it."""
    n_frames, n = moving.positions.shape[:2]
    path.with_suffix(".obj").write_text(obj_text(moving, moving.positions[0]))
    header = b"POINTCACHE2\0" + struct.pack("<iiffi", 1, n, 1.0, 0.5, n_frames)
    path.write_bytes(header + moving.positions.astype("<f4").tobytes())


def write_mdd(path: Path, moving: Moving) -> None:
    """Write a point cache of LightWave, and an OBJ file with its polygons beside it."""
    n_frames, n = moving.positions.shape[:2]
    path.with_suffix(".obj").write_text(obj_text(moving, moving.positions[0]))
    times = (np.arange(n_frames) / RATE).astype(">f4")
    content = struct.pack(">ii", n_frames, n) + times.tobytes()
    path.write_bytes(content + moving.positions.astype(">f4").tobytes())


def _write_usd(path: Path, moving: Moving) -> None:
    from validation.scenes import animation_scenes

    animation_scenes.write_usd(path, moving)


def _write_alembic(path: Path, moving: Moving) -> None:
    from validation.scenes import animation_scenes

    animation_scenes.write_alembic(path, moving)


def _write_gltf(path: Path, moving: Moving) -> None:
    from validation.scenes import animation_scenes

    animation_scenes.write_gltf(path, moving)


# Of each format: whether its meshes have names, the suffix of a file, and what writes it.
FORMATS: dict[str, tuple[bool, str, Writer]] = {
    "npz": (False, ".npz", write_npz),
    "obj": (True, "", write_obj),
    "ply": (False, "", write_ply),
    "pc2": (True, ".pc2", write_pc2),
    "mdd": (True, ".mdd", write_mdd),
    "usd": (True, ".usdc", _write_usd),
    "abc": (True, ".abc", _write_alembic),
    "gltf": (True, ".glb", _write_gltf),
}
