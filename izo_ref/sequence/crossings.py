"""What crosses in a mesh at rest: which edges and faces, along which contours, and how deep."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import Edges, Faces, Floats, Indices, Positions
from izo_ref.base.records import Pairs, TreeOrders
from izo_ref.detection.components import MeshComponents
from izo_ref.detection.intersections import Intersections, find_intersections
from izo_ref.detection.sides import Side
from izo_ref.detection.touching import Told, contacts_through, tell_sides
from izo_ref.sequence.reach import reaches_of


class Crossings(NamedTuple):
    """Edges that go through faces of a mesh, and pairs that touch.

    Attributes:
        edges: (n, 2) i4, the vertices of each edge that goes through a face.
        faces: (n, 3) i4, the vertices of that face. Both are sorted by edge and face.
        keys: (n,) i8, a number of each edge and face that is the same in all frames.
        contours: (n,) i8, the contour that each of them is a point of, from 0 on.
        touching: The pairs that touch where nothing goes through.
        found: All that intersects, as detection found it.
    """

    edges: Edges
    faces: Faces
    keys: Indices
    contours: Indices
    touching: Pairs
    found: Intersections


class CrossingMesh:
    """The triangles of a mesh, of which crossings are found in any number of frames.

    Args:
        edges: (k, 2) i4, each edge once, the lower vertex first, sorted.
        faces: (m, 3) i4.
    """

    def __init__(self, edges: Edges, faces: Faces) -> None:
        """Prepare to look up edges and faces by their vertices."""
        self.edges, self.faces = edges, faces
        n_vertices = int(faces.max(initial=-1)) + 1
        self._component = MeshComponents(n_vertices, faces).component
        self._edge_keys = _joined(edges[:, 0], edges[:, 1])
        self._side_keys = np.unique(_joined(faces[:, 0], faces[:, 1]))
        face_keys = self._keys_of_faces(faces)
        self._face_order = np.argsort(face_keys, kind="stable")
        self._face_keys = face_keys[self._face_order]
        ends = np.sort(np.stack((faces, faces[:, [1, 2, 0]]), axis=-1), axis=-1)
        around = self._numbers_of_edges(ends.reshape(-1, 2))
        self._around = np.argsort(around, kind="stable") // 3  # the faces of each edge
        self._begins = np.searchsorted(np.sort(around), np.arange(len(edges) + 1))

    def crossings(self, positions: Positions, orders: TreeOrders | None = None) -> Crossings:
        """Find what crosses and what touches, exactly.

        An edge crosses a face if it goes through the inside of it, or if the two touch at a place
        at which the surfaces go through each other.

        Args:
            positions: (n_vertices, 3) f8 [m].
            orders: Orders in which vertices, edges and faces enter trees; from the positions if
                None.
        """
        found = find_intersections(positions, self.edges, self.faces, orders)
        told = _told_sides(positions, self.faces, found.touching)
        _, through, lost = contacts_through(found, told)
        edges, faces = found.crossing_edges[through], found.crossed_faces[through]
        numbers = self._numbers_of_edges(edges), self._numbers_of_faces(faces)
        rest = Pairs(found.touching.nodes[~lost], found.touching.is_edge_edge[~lost])
        keys = numbers[0] * len(self.faces) + numbers[1]
        return Crossings(edges, faces, keys, self._contours(*numbers), rest, found)

    def reaches(self, positions: Positions, crossings: Crossings) -> Floats:
        """Return how far the vertices behind each crossing have gone through, see `reaches_of`.

        Args:
            positions: (n_vertices, 3) f8 [m].
            crossings: What crosses at these positions.
        """
        if len(crossings.keys) == 0:
            return np.empty(0)
        mesh = self.edges, self.faces, self._component
        return reaches_of(positions, mesh, (crossings.keys // len(self.faces), crossings.faces))

    def _keys_of_faces(self, faces: Faces) -> Indices:
        """Return a number of the three vertices of each face, in their order, (n,) i8."""
        sides = np.searchsorted(self._side_keys, _joined(faces[:, 0], faces[:, 1]))
        return _joined(sides, faces[:, 2])

    def _numbers_of_edges(self, edges: Edges) -> Indices:
        return np.searchsorted(self._edge_keys, _joined(edges[:, 0], edges[:, 1]))

    def _numbers_of_faces(self, faces: Faces) -> Indices:
        return self._face_order[np.searchsorted(self._face_keys, self._keys_of_faces(faces))]

    def _contours(self, edges: Indices, faces: Indices) -> Indices:
        """Number the contours: two crossings are on one if they are of the same two faces.

        The part of a contour in two faces goes from one crossing of them to another one. So
        crossings of the same two faces are neighbours on a contour.

        Args:
            edges: (n,) i8, number of the edge of each crossing.
            faces: (n,) i8, number of its face.
        """
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

        n = len(edges)
        if n == 0:
            return np.empty(0, np.int64)
        counts = self._begins[edges + 1] - self._begins[edges]
        row = np.arange(n).repeat(counts)
        place = np.arange(len(row)) - (np.cumsum(counts) - counts).repeat(counts)
        own, other = self._around[self._begins[edges].repeat(counts) + place], faces[row]
        pairs = np.minimum(own, other) * len(self.faces) + np.maximum(own, other)
        _, pair = np.unique(pairs, return_inverse=True)
        size = n + int(pair.max()) + 1
        graph = coo_array((np.ones(len(row), np.int8), (row, n + pair)), (size, size))
        label = connected_components(graph, directed=False)[1][:n]
        return np.unique(label, return_inverse=True)[1].astype(np.int64)


def _told_sides(positions: Positions, faces: Faces, touching: Pairs) -> Told:
    """Return what the mesh tells about the pairs that touch, without asking where it tells nothing.

    Surfaces never go through each other at a place where both sides of a pair have a vertex: no
    plane is determined there (`detection/sides.py`). A mesh whose faces have vertices of their own
    has many such pairs, and asking about each of them takes 0.1 ms.
    """
    nodes, is_edge_edge = touching
    share = np.zeros(len(nodes), bool)
    for first, second in ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3)):
        same = (positions[nodes[:, first]] == positions[nodes[:, second]]).all(axis=1)
        # Vertices 0 and 1 of two edges are one side; so are vertices 1 to 3 of a face.
        is_across = ~is_edge_edge if first == 0 and second == 1 else is_edge_edge | (first == 0)
        share |= same & is_across
    rest = Pairs(nodes[~share], is_edge_edge[~share])
    found = tell_sides(positions, faces, rest)
    n = len(nodes)
    told = Told(np.full(n, Side.UNTOLD, np.int8), np.zeros((n, 4)), np.zeros((n, 3)))
    for all_pairs, own in zip(told, found, strict=True):
        all_pairs[~share] = own
    return told


def depths_of(positions: Positions, edges: Edges, faces: Faces) -> Floats:
    """Return how deep each edge is in the face that it goes through, (n,) f8 [m].

    The depth is the distance of the nearer end of the edge from the plane of the face. This end has
    to move at least so far before the edge is on one side of the plane. It is at most half the
    length of the edge, so it says nothing about parts behind the edge. A face without area has no
    plane, and the depth is 0.

    Args:
        positions: (n_vertices, 3) f8 [m].
        edges: (n, 2) i4.
        faces: (n, 3) i4.
    """
    return np.abs(_heights(positions, edges, faces)).min(axis=1)


def widths_of(positions: Positions, edges: Edges, faces: Faces, contours: Indices) -> Floats:
    """Return the diagonal of the box about the crossings of each contour, (k,) f8 [m].

    Args:
        positions: (n_vertices, 3) f8 [m].
        edges: (n, 2) i4.
        faces: (n, 3) i4.
        contours: (n,) i8, the contour of each edge and face.
    """
    if len(contours) == 0:
        return np.empty(0)
    points = places_of(positions, edges, faces)
    order = np.argsort(contours, kind="stable")
    begins = np.searchsorted(contours[order], np.arange(int(contours.max()) + 1))
    low, high = (f.reduceat(points[order], begins) for f in (np.minimum, np.maximum))
    return np.linalg.norm(high - low, axis=1)


def places_of(positions: Positions, edges: Edges, faces: Faces) -> Positions:
    """Return where each edge goes through its face, (n, 3) f8 [m]; its middle if they are flat.

    Args:
        positions: (n_vertices, 3) f8 [m].
        edges: (n, 2) i4.
        faces: (n, 3) i4.
    """
    first, second = np.abs(_heights(positions, edges, faces)).T
    whole = first + second
    along = np.divide(first, whole, out=np.full(len(edges), 0.5), where=whole > 0.0)
    start, end = positions[edges[:, 0]], positions[edges[:, 1]]
    return start + along[:, None] * (end - start)


def _heights(positions: Positions, edges: Edges, faces: Faces) -> Floats:
    """Return the signed distance of both ends of each edge from the plane of its face, (n, 2)."""
    a, b, c = (positions[faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    units = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0.0)
    ends = positions[edges] - a[:, None]
    return np.asarray((ends * units[:, None]).sum(axis=2))


def _joined(first: Indices | Edges, second: Indices | Edges) -> Indices:
    """Return one number for two of up to 2^31 each."""
    return first.astype(np.int64) << 32 | second.astype(np.int64)
