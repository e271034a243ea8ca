"""What the file of an animation holds, by other readers than those of `izo_ref`.

Question: which positions does a written file hold, and is all else in it as it was?

Method: the bytes are read by numpy, `struct` and `json`; USD and Alembic by the libraries of those
who made these formats. Each reader returns the positions of all frames, and a description of all
else, which is equal for two files that differ in their positions alone.

Independent of `izo_ref`: no line is shared with `izo_ref/formats`.

Limits: the readers know the files that the study of sequences writes, not each file of a format.
"""

from __future__ import annotations

import json
import re
import struct
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from validation.oracles.answer import Floats

BOUNDS = ("min", "max")  # of an accessor of glTF, which change with positions
MOVED = ("points", "extent")  # properties of a mesh of USD that change with positions
SAMPLED = ("P", ".selfBnds", ".childBnds")  # of Alembic


class Held(NamedTuple):
    """What a file holds.

    Attributes:
        positions: (n_frames, n, 3) f8, those of all meshes, in the order of the file.
        rest: All else, as something that can be compared.
    """

    positions: Floats
    rest: Any


def held(kind: str, path: Path) -> Held:
    """Read a file.

    Args:
        kind: One of READERS.
        path: The file, or the folder of files.
    """
    return READERS[kind](path)


def _npz(path: Path) -> Held:
    with np.load(path) as archive:
        arrays = {name: archive[name] for name in archive.files}
    positions = arrays.pop("positions")
    rest = [(name, array.dtype.str, array.tobytes()) for name, array in arrays.items()]
    return Held(positions.astype(float), (list(archive.files), positions.dtype.str, rest))


def _obj(path: Path) -> Held:
    frames, rest = [], []
    for file in sorted(path.glob("*.obj")):
        lines = file.read_text().split("\n")
        points = [line.split()[1:] for line in lines if line.startswith("v ")]
        frames.append(np.array(points, float))
        rest.append((file.name, ["v" if line.startswith("v ") else line for line in lines]))
    materials = [(file.name, file.read_bytes()) for file in sorted(path.glob("*.mtl"))]
    return Held(np.array(frames), (rest, materials))


def _ply(path: Path) -> Held:
    frames, rest = [], []
    for file in sorted(path.glob("*.ply")):
        content = file.read_bytes()
        head, mark, body = content.partition(b"end_header\n")
        count = re.search(rb"element vertex (\d+)", head)
        assert count is not None
        kind = np.dtype([("age", "<i2"), ("xyz", "<f4", 3), ("red", "u1")])
        rows = np.frombuffer(body, kind, int(count[1]))
        frames.append(rows["xyz"].astype(float))
        others = rows["age"].tobytes() + rows["red"].tobytes() + body[rows.nbytes :]
        rest.append((file.name, head + mark, others))
    return Held(np.array(frames), rest)


def _pc2(path: Path) -> Held:
    content = path.read_bytes()
    n, n_frames = struct.unpack_from("<i", content, 16)[0], struct.unpack_from("<i", content, 28)[0]
    positions = np.frombuffer(content, "<f4", n_frames * n * 3, 32).reshape(n_frames, n, 3)
    return Held(positions.astype(float), (content[:32], len(content)))


def _mdd(path: Path) -> Held:
    content = path.read_bytes()
    n_frames, n = struct.unpack_from(">ii", content, 0)
    begin = 8 + 4 * n_frames
    positions = np.frombuffer(content, ">f4", n_frames * n * 3, begin).reshape(n_frames, n, 3)
    return Held(positions.astype(float), (content[:begin], len(content)))


def _usd(path: Path) -> Held:
    libraries: list[Any] = [import_module(f"pxr.{name}") for name in ("Sdf", "Usd", "UsdGeom")]
    Sdf, Usd, UsdGeom = libraries
    stage = Usd.Stage.Open(Sdf.Layer.OpenAsAnonymous(str(path)))
    times = range(int(stage.GetStartTimeCode()), int(stage.GetEndTimeCode()) + 1)
    meshes: list[Any] = []
    rest: list[Any] = [stage.GetStartTimeCode(), stage.GetEndTimeCode(), stage.GetFramesPerSecond()]
    for prim in stage.Traverse():
        rest.append((str(prim.GetPath()), prim.GetTypeName(), repr(prim.GetCustomData())))
        if prim.IsA(UsdGeom.Mesh):
            points = UsdGeom.Mesh(prim).GetPointsAttr()
            meshes.append([np.array(points.Get(time), float) for time in times])
            rest.append(points.GetTimeSamples())
        for one in prim.GetAttributes():
            if one.GetName() not in MOVED:
                rest.append((one.GetName(), repr(one.Get()), one.GetTimeSamples()))
        for one in prim.GetRelationships():
            rest.append((one.GetName(), [str(target) for target in one.GetTargets()]))
    return Held(np.concatenate(meshes, axis=1), rest)


def _alembic(path: Path) -> Held:
    import alembic3d

    meshes: list[Any] = []
    rest: list[Any] = []

    def look(thing: Any, name: str) -> None:
        rest.append(name)
        for one in (thing.getProperty(k) for k in range(thing.getNumProperties())):
            own = f"{name}.{one.getName()}"
            if one.isCompound():
                look(one, own)
            elif one.getName() == "P":
                meshes.append([np.array(sample, float) for sample in one.samples])
            elif one.getName() not in SAMPLED:
                values = [list(v) if one.isArray() else v for v in one.samples]
                rest.append((own, str(one.getDataType()), repr(values)))

    def walk(thing: Any) -> None:
        look(thing.getProperties(), thing.getFullName())
        for k in range(thing.getNumChildren()):
            walk(thing.getChild(k))

    walk(alembic3d.Abc.IArchive(str(path)).getTop())
    return Held(np.concatenate(meshes, axis=1), rest)


def _gltf(path: Path) -> Held:
    content = path.read_bytes()
    (size,) = struct.unpack_from("<I", content, 12)
    document = json.loads(content[20 : 20 + size])
    numbers = _Numbers(document, content[28 + size :])
    meshes, kept = [], []
    for mesh in document["meshes"]:
        (primitive,) = mesh["primitives"]
        attributes = primitive["attributes"]
        base = numbers.of(attributes["POSITION"])
        meshes.append([base + numbers.of(target["POSITION"]) for target in primitive["targets"]])
        others = [attributes[name] for name in attributes if name != "POSITION"]
        kept += [numbers.of(index).tolist() for index in (*others, primitive["indices"])]
    for sampler in document["animations"][0]["samplers"]:
        kept += [numbers.of(sampler[name]).tolist() for name in ("input", "output")]
    for accessor in document["accessors"]:
        for name in BOUNDS:
            accessor.pop(name, None)
    for name in ("bufferViews", "buffers"):
        document.pop(name)
    joined = np.concatenate([np.array(frames, float) for frames in meshes], axis=1)
    return Held(joined, (document, kept))


class _Numbers:
    """The numbers of the accessors of a glTF file."""

    def __init__(self, document: Any, content: bytes) -> None:
        self._document, self._content = document, content

    def of(self, index: int) -> Any:
        """Return the rows of an accessor."""
        accessor = self._document["accessors"][index]
        view = self._document["bufferViews"][accessor["bufferView"]]
        width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}[accessor["type"]]
        kind = {5126: "<f4", 5125: "<u4"}[accessor["componentType"]]
        begin = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        found = np.frombuffer(self._content, kind, accessor["count"] * width, begin)
        return found.reshape(-1, width)


READERS: dict[str, Callable[[Path], Held]] = {
    "npz": _npz,
    "obj": _obj,
    "ply": _ply,
    "pc2": _pc2,
    "mdd": _mdd,
    "usd": _usd,
    "abc": _alembic,
    "gltf": _gltf,
}
