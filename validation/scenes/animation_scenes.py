"""Write an animation as a scene of meshes: USD, Alembic and glTF."""

from __future__ import annotations

import json
import struct
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from izo_ref.base.arrays import AnyArray
from validation.scenes.animation_files import RATE, coordinates_of
from validation.scenes.moving_garment import Moving, Part

FLOAT, INTEGER = 5126, 5125  # types of components in glTF
KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3"}


def write_usd(path: Path, moving: Moving) -> None:
    """Write a mesh for each part, with texture coordinates, a colour and a material."""
    libraries: list[Any] = [
        import_module(f"pxr.{name}") for name in ("Sdf", "Usd", "UsdGeom", "UsdShade", "Vt")
    ]
    Sdf, Usd, UsdGeom, UsdShade, Vt = libraries
    stage = Usd.Stage.CreateNew(str(path))
    stage.SetStartTimeCode(1)
    stage.SetEndTimeCode(len(moving.positions))
    stage.SetTimeCodesPerSecond(RATE)
    UsdGeom.Xform.Define(stage, "/scene")
    material = UsdShade.Material.Define(stage, "/scene/cloth")
    for part in moving.parts:
        mesh = UsdGeom.Mesh.Define(stage, f"/scene/{part.name}")
        mesh.CreateFaceVertexCountsAttr([3] * len(part.faces))
        mesh.CreateFaceVertexIndicesAttr(part.faces.ravel().tolist())
        mesh.CreateSubdivisionSchemeAttr("none")
        mesh.CreateDisplayColorAttr([(0.5, 0.25, 0.125)])
        mesh.GetPrim().SetCustomDataByKey("note", part.name)
        kind = Sdf.ValueTypeNames.TexCoord2fArray
        primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", kind, UsdGeom.Tokens.vertex)
        primvar.Set(Vt.Vec2fArray.FromNumpy(coordinates_of(part).astype(np.float32)))
        UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)
        points = mesh.CreatePointsAttr()
        for number, own in enumerate(_own(moving, part), 1):
            points.Set(Vt.Vec3fArray.FromNumpy(own), number)
    stage.Save()


def write_alembic(path: Path, moving: Moving) -> None:
    """Write a mesh for each part, below a transform, with a colour and a text of its own."""
    import alembic3d
    import imath

    abc, geometry = alembic3d.Abc, alembic3d.AbcGeom
    sampling = alembic3d.AbcCoreAbstract.TimeSampling(1.0 / RATE, 0.0)
    archive = abc.CreateArchiveWithInfo(str(path), "a study of izo_ref", "an animation")
    group = geometry.OXform(archive.getTop(), "scene")
    for part in moving.parts:
        mesh = geometry.OPolyMesh(group, part.name)
        schema = mesh.getSchema()
        schema.setTimeSampling(archive.addTimeSampling(sampling))
        corners = imath.IntArrayFromBuffer(np.ascontiguousarray(part.faces.ravel(), np.int32))
        counts = imath.IntArrayFromBuffer(np.full(len(part.faces), 3, np.int32))
        for own in _own(moving, part):
            positions = imath.V3fArrayFromBuffer(own)
            schema.set(geometry.OPolyMeshSchemaSample(positions, corners, counts))
        more = schema.getUserProperties()
        abc.OV3fProperty(more, "colour").setValue(imath.V3f(0.5, 0.25, 0.125))
        abc.OStringProperty(more, "note").setValue(part.name)


def write_gltf(path: Path, moving: Moving) -> None:
    """Write a mesh for each part, with texture coordinates, a material, and a target a frame."""
    buffer, n_frames = _Buffer(), len(moving.positions)
    times = buffer.add((np.arange(n_frames) / RATE).astype(np.float32)[:, None], True)
    weights = buffer.add(np.eye(n_frames, dtype=np.float32).reshape(-1, 1))
    nodes, meshes, samplers, channels = [], [], [], []
    for number, part in enumerate(moving.parts):
        frames = _own(moving, part)
        coordinates = buffer.add(coordinates_of(part).astype(np.float32))
        primitive = {
            "attributes": {"POSITION": buffer.add(frames[0], True), "TEXCOORD_0": coordinates},
            "indices": buffer.add(part.faces.astype(np.uint32).reshape(-1, 1)),
            "material": 0,
            "targets": [{"POSITION": buffer.add(own - frames[0], True)} for own in frames],
        }
        meshes.append({"name": f"{part.name}-mesh", "primitives": [primitive]})
        nodes.append({"name": part.name, "mesh": number})
        samplers.append({"input": times, "output": weights, "interpolation": "LINEAR"})
        channels.append({"sampler": number, "target": {"node": number, "path": "weights"}})
    document = {
        "asset": {"version": "2.0", "generator": "a study of izo_ref"},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(nodes)))}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": [{"name": "cloth", "doubleSided": True}],
        "animations": [{"channels": channels, "samplers": samplers}],
        **buffer.described(),
    }
    path.write_bytes(_binary(document, bytes(buffer.content)))


class _Buffer:
    """The bytes of a glTF file, and the accessors that describe them."""

    def __init__(self) -> None:
        """Begin without bytes."""
        self.content, self._views, self._accessors = bytearray(), list[Any](), list[Any]()

    def add(self, array: AnyArray, bounds: bool = False) -> int:
        """Add an array of rows, (n, k); return the number of its accessor."""
        array = np.ascontiguousarray(array)
        view = {"buffer": 0, "byteOffset": len(self.content), "byteLength": array.nbytes}
        accessor: dict[str, Any] = {
            "bufferView": len(self._views),
            "componentType": FLOAT if array.dtype.kind == "f" else INTEGER,
            "count": len(array),
            "type": KINDS[array.shape[1]],
        }
        if bounds:
            least, most = array.min(axis=0), array.max(axis=0)
            accessor |= {"min": least.tolist(), "max": most.tolist()}
        self._views.append(view)
        self._accessors.append(accessor)
        self.content += array.tobytes()
        return len(self._accessors) - 1

    def described(self) -> dict[str, Any]:
        """Return what the document says of the bytes."""
        size = [{"byteLength": len(self.content)}]
        return {"accessors": self._accessors, "bufferViews": self._views, "buffers": size}


def _binary(document: dict[str, Any], content: bytes) -> bytes:
    """Return a .glb file of a document and its buffer, whose size is a multiple of four."""
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(content), b"BIN\0") + content
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def _own(moving: Moving, part: Part) -> AnyArray:
    """Return the positions of a part, (n_frames, n, 3) f4."""
    own = moving.positions[:, part.first : part.first + part.n_vertices]
    return np.ascontiguousarray(own, np.float32)
