"""Find meshes, their numbers and their animation in the JSON of glTF."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np

from izo_ref.base.arrays import AnyArray, Floats
from izo_ref.formats.gltf_file import GltfFile
from izo_ref.formats.gltf_json import item, many, numbers, whole

WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
KINDS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
FLOAT = 5126
TRIANGLES, STRIP, FAN = 4, 5, 6
IDENTITY = np.eye(4)


class Accessor(NamedTuple):
    """Where numbers lie in a buffer.

    Attributes:
        number: Its number in the JSON.
        buffer: Number of the buffer.
        begin: Where it begins in the buffer.
        stride: Bytes from one element to the next.
        n_elements: Number of elements.
        kind: Type of each number, in the words of numpy.
        width: Numbers of an element.
    """

    number: int
    buffer: int
    begin: int
    stride: int
    n_elements: int
    kind: str
    width: int

    @property
    def extent(self) -> int:
        """Bytes from the first element to the end of the last one."""
        size = np.dtype(self.kind).itemsize * self.width
        return self.stride * (self.n_elements - 1) + size if self.n_elements else 0

    def part(self, begin: int, count: int) -> Accessor:
        """Return some of its elements, which are within it."""
        return self._replace(begin=self.begin + self.stride * begin, n_elements=count)

    def view(self, content: Any) -> AnyArray:
        """Return the numbers in the bytes of its extent, (n_elements, width), not copied."""
        size = np.dtype(self.kind).itemsize
        shape, strides = (self.n_elements, self.width), (self.stride, size)
        return np.ndarray(shape, self.kind, content, strides=strides)


class Shape(NamedTuple):
    """A mesh of a node: the primitives with the same positions.

    Attributes:
        name: Name of the node, with a number if it has several shapes.
        chain: Numbers of the nodes from the root to the one with the mesh.
        positions: Accessor of the positions.
        targets: Accessors of the offsets of each morph target; None where it has no positions.
        weights: (n_targets,) f8, weights without an animation.
        triangles: (k, 3) i8, vertices.
        matrix: (4, 4) f8; a row vector times it is in the world.
    """

    name: str
    chain: tuple[int, ...]
    positions: Accessor
    targets: tuple[Accessor | None, ...]
    weights: Floats
    triangles: AnyArray
    matrix: Floats


def accessor(file: GltfFile, number: Any, kind: str, *components: int) -> Accessor:
    """Return an accessor of a kind.

    Args:
        file: The file.
        number: Its number.
        kind: Such as `VEC3`.
        components: The types of numbers that it may have.

    Raises:
        ValueError: It is of another kind, or not within its buffer.
    """
    own = item(file.document, "accessors", number)
    if "sparse" in own:
        raise ValueError(f"accessor {number}: is sparse; export without sparse accessors")
    component, count = own.get("componentType"), whole(own, "count")
    if own.get("type") != kind or component not in components:
        raise ValueError(
            f"accessor {number}: expected {kind} of component type "
            f"{' or '.join(map(str, components))}, found {own.get('type')!r:.40} of "
            f"{component!r:.40}"
        )
    view = item(file.document, "bufferViews", own.get("bufferView"))
    if "EXT_meshopt_compression" in view.get("extensions", {}):
        raise ValueError(f"accessor {number}: is compressed; export without compression")
    size = np.dtype(KINDS[component]).itemsize * WIDTHS[kind]
    stride = whole(view, "byteStride", size)
    buffer = view.get("buffer")
    item(file.document, "buffers", buffer)
    begin = whole(own, "byteOffset", 0)
    found = Accessor(
        number,
        buffer,
        begin + whole(view, "byteOffset", 0),
        stride,
        count,
        KINDS[component],
        WIDTHS[kind],
    )
    declared = whole(view, "byteLength")
    end = found.begin - begin + declared
    if stride < size or begin + found.extent > declared or end > file.buffers[buffer].size:
        raise ValueError(
            f"accessor {number}: expected {found.extent} bytes, found {max(0, declared - begin)} "
            f"in a buffer of {file.buffers[buffer].size}"
        )
    return found


def read(file: GltfFile, own: Accessor) -> AnyArray:
    """Return the numbers of an accessor, (n_elements, width)."""
    return own.view(file.read(own.buffer, own.begin, own.extent)).copy()


def shapes(file: GltfFile) -> Iterator[Shape]:
    """Yield the meshes of the scene, in the order of its nodes.

    Raises:
        ValueError: The file is damaged, or a mesh is skinned, compressed or used twice.
    """
    used: set[int] = set()
    for chain, matrix in _nodes(file.document):
        node = item(file.document, "nodes", chain[-1])
        if "mesh" not in node:
            continue
        name = str(node.get("name", f"node {chain[-1]}"))
        if "skin" in node or "EXT_mesh_gpu_instancing" in node.get("extensions", {}):
            raise ValueError(f"mesh {name}: is skinned or instanced; bake it first")
        mesh = item(file.document, "meshes", node["mesh"])
        groups = _groups(mesh, name)
        for k, (positions, primitives) in enumerate(groups.items()):
            if positions in used:
                raise ValueError(f"mesh {name}: shares its vertices with another one")
            used.add(positions)
            label = name if len(groups) == 1 else f"{name}/{k}"
            yield _shape(file, label, chain, primitives, matrix, node, mesh)


def _nodes(document: Any) -> Iterator[tuple[tuple[int, ...], Floats]]:
    """Yield the chains of nodes of the scene and their transforms, parents first."""
    nodes = many(document, "nodes")
    if many(document, "scenes"):
        roots = many(item(document, "scenes", document.get("scene", 0)), "nodes")
    else:
        below = {child for node in nodes for child in many(node, "children")}
        roots = [number for number in range(len(nodes)) if number not in below]
    waiting: list[tuple[tuple[Any, ...], Floats]] = [
        ((root,), IDENTITY) for root in reversed(roots)
    ]
    seen = set()
    while waiting:
        chain, above = waiting.pop()
        number = chain[-1]
        node = item(document, "nodes", number)
        if number in seen:
            raise ValueError(f"node {number}: is below two nodes")
        seen.add(number)
        with np.errstate(all="ignore"):  # callers look at what is not finite
            matrix = _own_matrix(node) @ above
        yield chain, matrix
        waiting += [((*chain, child), matrix) for child in reversed(many(node, "children"))]


def shared(file: GltfFile) -> set[int]:
    """Return the accessors whose bytes belong to other accessors too.

    Args:
        file: The file.
    """
    spans = sorted(_spans(file), key=lambda own: own.begin)
    found = set()
    for k, own in enumerate(spans):
        for other in spans[k + 1 :]:
            if other.begin >= own.begin + own.extent:
                break
            if own.buffer == other.buffer and not _are_interleaved(own, other):
                found |= {own.number, other.number}
    return found


def _spans(file: GltfFile) -> Iterator[Accessor]:
    for number, own in enumerate(many(file.document, "accessors")):
        if own.get("type") in WIDTHS and own.get("componentType") in KINDS:
            with suppress(ValueError):  # it is never read
                yield accessor(file, number, own["type"], own["componentType"])


def _are_interleaved(own: Accessor, other: Accessor) -> bool:
    size, other_size = own.part(0, 1).extent, other.part(0, 1).extent
    gap = (other.begin - own.begin) % own.stride
    return own.stride == other.stride and size <= gap <= own.stride - other_size


def _own_matrix(node: Any) -> Floats:
    if "matrix" in node:
        return numbers(node, "matrix", 16, ()).reshape(4, 4)  # by columns, so for row vectors
    x, y, z, w = numbers(node, "rotation", 4, (0, 0, 0, 1))
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)],
            [2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)],
            [2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix = np.eye(4)
    matrix[:3, :3] = numbers(node, "scale", 3, (1, 1, 1))[:, None] * turn
    matrix[3, :3] = numbers(node, "translation", 3, (0, 0, 0))
    return matrix


def _groups(mesh: Any, name: str) -> dict[int, list[Any]]:
    """Return the primitives with faces by the accessor of their positions."""
    groups: dict[int, list[Any]] = {}
    for primitive in many(mesh, "primitives"):
        if "KHR_draco_mesh_compression" in primitive.get("extensions", {}):
            raise ValueError(f"mesh {name}: is compressed; export without compression")
        if whole(primitive, "mode", TRIANGLES) in (TRIANGLES, STRIP, FAN):
            groups.setdefault(whole(primitive["attributes"], "POSITION"), []).append(primitive)
    return groups


def _shape(
    file: GltfFile,
    name: str,
    chain: tuple[int, ...],
    primitives: list[Any],
    matrix: Floats,
    holder: Any,
    mesh: Any,
) -> Shape:
    first = primitives[0]
    positions = accessor(file, first["attributes"]["POSITION"], "VEC3", FLOAT)
    targets = []
    for k, target in enumerate(many(first, "targets")):
        offsets = target.get("POSITION")
        if any(many(other, "targets")[k].get("POSITION") != offsets for other in primitives):
            raise ValueError(f"mesh {name}: shares vertices between different targets")
        own = None if offsets is None else accessor(file, offsets, "VEC3", FLOAT)
        if own is not None and own.n_elements != positions.n_elements:
            raise ValueError(
                f"mesh {name}: target {k}: expected {positions.n_elements} vertices, found "
                f"{own.n_elements}"
            )
        targets.append(own)
    zeros = (0.0,) * len(targets)
    source = holder if "weights" in holder else mesh
    weights = numbers(source, "weights", len(targets), zeros)
    faces = np.concatenate([_triangles(file, own, positions.n_elements) for own in primitives])
    return Shape(name, chain, positions, tuple(targets), weights, faces, matrix)


def _triangles(file: GltfFile, primitive: Any, n_vertices: int) -> AnyArray:
    if "indices" in primitive:
        indices = accessor(file, primitive["indices"], "SCALAR", 5121, 5123, 5125)
        corners = read(file, indices)[:, 0].astype(np.int64)
    else:
        corners = np.arange(n_vertices)
    if len(corners) and corners.max() >= n_vertices:
        raise ValueError(
            f"expected vertices from 0 to {n_vertices - 1} in the triangles, found {corners.max()}"
        )
    mode = primitive.get("mode", TRIANGLES)
    if mode == TRIANGLES:
        if len(corners) % 3:
            raise ValueError(f"expected three corners for each triangle, found {len(corners)}")
        return corners.reshape(-1, 3)
    starts = np.arange(max(0, len(corners) - 2))
    if mode == FAN:
        return corners[np.column_stack((starts * 0, starts + 1, starts + 2))]
    odd = starts % 2
    faces = corners[np.column_stack((starts, starts + 1 + odd, starts + 2 - odd))]
    ordered = np.sort(faces, axis=1)
    # strips go from one part to the next by triangles that have no area
    return faces[(ordered[:, 0] < ordered[:, 1]) & (ordered[:, 1] < ordered[:, 2])]
