"""Find the contours along which a mesh goes through itself, and the directions that shorten them.

Where two surfaces go through each other, they share a contour: a chain of segments, each in two
faces. A segment ends where an edge of one surface goes through a face of the other one, which is a
crossing. Each crossing gets a direction, in which its edge should move relative to its face. It is
a sum of four terms, each no longer than 1.

**The gradient of the length** (Volino and Magnenat-Thalmann). An edge from a to b, with the unit
vector E along it, goes through a face with the unit normal N, at the point P = (1 - s) a + s b. If
the point of the edge that is at P moves by u, and the point of the face by v, then P moves by
u - E (N . (u - v)) / (N . E). The contour leaves P in each face around the edge, in the plane of
both, along a unit vector R into that face. Its length changes by -R . dP for each of them:

    dL = sum -R . u + (R . E) / (N . E) N . (u - v)

For an edge that moves relative to a face at rest, v = 0, so the direction of descent is

    sum R - (R . E) / (N . E) N

It is orthogonal to E, since moving an edge along itself changes nothing. Where an edge is nearly
parallel to its face, N . E is taken as `LEAST_SLOPE`, and the sum is cut off at the length 1, so
nothing overflows. At a boundary, there is one face, and so the contour gets shorter at its end; no
inside is needed.

**The region** (after Baraff, Witkin and Kass). Take away all edges that go through a face. If the
two ends of such an edge are then in different regions, the contour cuts the surface in two, and the
region with less area should go back through the face: the end in it moves along the normal of the
face to the side of the other end. That is a direction of two surfaces relative to each other, so it
does not matter which vertices are pinned.

**Their means over the contour.** In a flat surface, the gradient is zero inside a contour, and a
noisy mesh has a noisy gradient. So the mean of each of the two over the contour is added, stretched
to a unit vector. The sides of a contour are its two surfaces: directions are those of the first
relative to the second. A contour on which the two change places has no such mean.

Source: P. Volino, N. Magnenat-Thalmann, Resolving Surface Collisions through Intersection Contour
Minimization, ACM Transactions on Graphics 25 (2006); D. Baraff, A. Witkin, M. Kass, Untangling
Cloth, ACM Transactions on Graphics 22 (2003).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import AnyInts, Edges, Faces, Floats, Indices, Positions
from izo_ref.detection.serial.components import number_components

# Cosine of the angle of an edge and the normal of its face, below which it is taken as this number.
LEAST_SLOPE = 0.01
# A mean over a contour that is shorter than this tells little, so it is not stretched to a unit
# vector, but divided by this number.
LEAST_MEAN = 0.05


class Contours(NamedTuple):
    """The crossings of a mesh, and what their contours tell.

    Attributes:
        edges: (n, 2) i4, the vertices of each edge that goes through a face.
        faces: (n, 3) i4, the vertices of that face.
        edge_weights: (n, 2) f8, of the point of crossing, from 0 to 1.
        face_weights: (n, 3) f8, of the same point, from 0 to 1.
        directions: (n, 3) f8, in which the edge should move relative to the face; no longer than 1.
        contour: (n,) i8, number of the contour that the crossing is on.
    """

    edges: Edges
    faces: Faces
    edge_weights: Floats
    face_weights: Floats
    directions: Floats
    contour: Indices


class ContourFinder:
    """Finds the contours of a mesh, whose tables it keeps.

    Args:
        edges: (k, 2) i4, each edge once, the lower vertex first.
        faces: (m, 3) i4.
        n_vertices: Number of vertices of the mesh.
    """

    def __init__(self, edges: Edges, faces: Faces, n_vertices: int) -> None:
        """Sort the sides of the faces by their vertices."""
        self._edges, self._faces, self._n = edges, faces, n_vertices
        keys = np.concatenate([self._keys(faces[:, [k, (k + 1) % 3]]) for k in range(3)])
        order = np.argsort(keys, kind="stable")
        self._side_keys, self._side_faces = keys[order], order % max(len(faces), 1)

    def find(self, positions: Positions, edges: Edges, faces: Faces) -> Contours:
        """Return the contours of the crossings.

        Args:
            positions: (n_vertices, 3) f8 [m].
            edges: (n, 2) i4, the edges of the mesh that go through a face.
            faces: (n, 3) i4, that face of each of them, its corners as in the mesh.
        """
        start, along = positions[edges[:, 0]], positions[edges[:, 1]] - positions[edges[:, 0]]
        corners = positions[faces]
        normals = _unit(_area_vectors(corners))
        edge_weights, face_weights = _weights(start, along, corners)
        row, around = self._faces_around(edges)
        gradient = self._gradient(positions, edges, normals, row, around)
        inward = self._region_signs(positions, edges)[:, None] * normals
        inward *= np.sign(_dot(normals, along))[:, None]
        sides = self._sides(faces, row, around, len(edges))
        means = _mean_direction(gradient, sides) + _mean_direction(inward, sides)
        directions = _no_longer_than_1(gradient + inward + means)
        contour = np.minimum(sides[0::2], sides[1::2])
        weights = edge_weights, face_weights
        return Contours(edges, faces, *weights, directions, contour)

    def _keys(self, edges: Edges) -> Indices:
        """Return one number for each edge, whatever the order of its vertices."""
        ends = np.sort(edges.astype(np.int64), axis=1)
        return ends[:, 0] * self._n + ends[:, 1]

    def _faces_around(self, edges: Edges) -> tuple[Indices, Indices]:
        """Return a row of `edges` and a face around that edge, for each such face."""
        keys = self._keys(edges)
        first, behind = (np.searchsorted(self._side_keys, keys, side) for side in ("left", "right"))
        count = behind - first
        row = np.repeat(np.arange(len(edges)), count)
        begin = np.repeat(np.cumsum(count) - count, count)
        place = np.repeat(first, count) + np.arange(len(row)) - begin
        return row, self._side_faces[place]

    def _gradient(
        self, positions: Positions, edges: Edges, normals: Floats, row: Indices, around: Indices
    ) -> Floats:
        """Return the descent of the length of the contour at each crossing, no longer than 1."""
        ends, corners = edges[row], self._faces[around]
        is_end = (corners == ends[:, :1]) | (corners == ends[:, 1:])
        tip = np.where(is_end, 0, corners).sum(axis=1)  # the corner that is no end
        along = _unit(positions[ends[:, 1]] - positions[ends[:, 0]])
        inside = positions[tip] - positions[ends[:, 0]]
        inside = _unit(inside - _dot(inside, along)[:, None] * along)
        normal = normals[row]
        leaves = _unit(np.cross(np.cross(along, inside), normal))
        leaves *= np.sign(_dot(leaves, inside))[:, None]
        slope = _dot(normal, along)
        slope = np.copysign(np.maximum(np.abs(slope), LEAST_SLOPE), slope)
        descent = leaves - (_dot(leaves, along) / slope)[:, None] * normal
        return _no_longer_than_1(_sums(row, descent, len(edges)))

    def _region_signs(self, positions: Positions, edges: Edges) -> Floats:
        """Return 1 if the first end of an edge is in the smaller region, -1 if the second is."""
        kept = self._edges[~np.isin(self._keys(self._edges), self._keys(edges))]
        area = np.repeat(np.linalg.norm(_area_vectors(positions[self._faces]), axis=1), 3)
        areas = np.bincount(self._faces.ravel(), area, self._n)
        region, count = number_components(self._n, _links(kept))
        size = np.bincount(region, areas, count)
        first, second = size[region[edges]].T
        return np.asarray(np.sign(second - first), np.float64)

    def _sides(self, faces: Faces, row: Indices, around: Indices, n: int) -> Indices:
        """Return the surface of the edge and of the face of each crossing, (2 n,) i8, in turn.

        Two crossings are neighbours if they end the same segment, which is that of two faces. A
        surface of a contour is then all that is on the same side along the chain. If the two
        surfaces of a crossing are one, then they change places along the contour.
        """
        crossed = self._numbers(faces)[row]
        low, high = np.minimum(around, crossed), np.maximum(around, crossed)
        swapped = (around > crossed).astype(np.int64)
        keys = low.astype(np.int64) * max(len(self._faces), 1) + high
        order = np.argsort(keys, kind="stable")
        same = np.flatnonzero(keys[order[1:]] == keys[order[:-1]])
        one, other = order[same], order[same + 1]
        turns = swapped[one] ^ swapped[other]
        pairs = [
            np.column_stack((2 * row[one] + side, 2 * row[other] + (side ^ turns)))
            for side in range(2)
        ]
        return number_components(2 * n, _links(np.concatenate(pairs)))[0]

    def _numbers(self, faces: Faces) -> Indices:
        """Return the number of each face in the mesh."""
        row, around = self._faces_around(faces[:, :2])
        same = (np.sort(self._faces[around], axis=1) == np.sort(faces, axis=1)[row]).all(axis=1)
        number = np.zeros(len(faces), np.int64)
        number[row[same][::-1]] = around[same][::-1]
        return number


def _weights(start: Positions, along: Floats, corners: Floats) -> tuple[Floats, Floats]:
    """Return the weights of the points of crossing in edges and faces; 1/2 or 1/3 if degenerate."""
    normals = _area_vectors(corners)
    height, rise = _dot(start - corners[:, 0], normals), _dot(along, normals)
    share = np.divide(-height, rise, out=np.full(len(rise), 0.5), where=np.abs(rise) > 0.0)
    share = np.clip(share, 0.0, 1.0)
    to = corners - (start + share[:, None] * along)[:, None]
    parts = [_dot(normals, np.cross(to[:, (k + 1) % 3], to[:, (k + 2) % 3])) for k in range(3)]
    areas = np.maximum(np.column_stack(parts), 0.0)
    whole = areas.sum(axis=1, keepdims=True)
    inside = np.divide(areas, whole, out=np.full_like(areas, 1.0 / 3.0), where=whole > 0.0)
    return np.column_stack((1.0 - share, share)), inside


def _mean_direction(directions: Floats, sides: Indices) -> Floats:
    """Return the direction of the mean over each contour, in the sense of each crossing's edge."""
    n = int(sides.max(initial=-1)) + 1
    sums = _sums(sides[0::2], directions, n) - _sums(sides[1::2], directions, n)
    counts = np.bincount(sides, minlength=n)
    mean = sums[sides[0::2]] / counts[sides[0::2]][:, None]
    mean[sides[0::2] == sides[1::2]] = 0.0
    return mean / np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), LEAST_MEAN)


def _links(pairs: AnyInts) -> Faces:
    """Return pairs as faces with a corner twice, which `number_components` takes as links."""
    return np.column_stack((pairs, pairs[:, 1])).astype(np.int32)


def _sums(rows: Indices, vectors: Floats, n: int) -> Floats:
    """Return the sum of the vectors of each row, (n, 3), added in their order."""
    sums = [np.bincount(rows, vectors[:, k], n) for k in range(3)]
    return np.column_stack(sums).astype(np.float64)


def _dot(a: Floats, b: Floats) -> Floats:
    return np.asarray(np.einsum("...k,...k->...", a, b))


def _area_vectors(corners: Floats) -> Floats:
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def _unit(vectors: Floats) -> Floats:
    """Return unit vectors; zero stays zero."""
    x, y, z = np.abs(vectors).T  # reducing along a short axis takes several times as long
    scale = np.maximum(np.maximum(x, y), z)[:, None]
    scaled = vectors / np.where(scale > 0.0, scale, 1.0)
    length = np.sqrt(_dot(scaled, scaled))[:, None]
    return np.asarray(scaled / np.where(length > 0.0, length, 1.0))


def _no_longer_than_1(vectors: Floats) -> Floats:
    return vectors / np.maximum(np.sqrt(_dot(vectors, vectors))[:, None], 1.0)
