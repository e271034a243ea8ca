"""Which faces of a mesh intersect at rest, by python-fcl and, for neighbours, exactly.

Question: which pairs of faces have a point in common, apart from their common vertices?

Method: python-fcl lists the pairs of faces without a common vertex. Faces with a common vertex or
edge always touch, so python-fcl says nothing about them. They are decided here by the signs of
volumes, with a bound on the rounding, and by rational arithmetic where the bound leaves the sign
open.

Independent of `izo_ref`: python-fcl has its own trees and its own tests of triangles, and the code
for neighbours shares nothing with the package.

Limits: python-fcl works in floating point without a bound. It therefore judges faces that cross
each other, and may miss faces that only touch (`test_touches_are_mostly_found` counts how many).
The answers about neighbours are exact for lengths from 1e-60 to 1e60 m.
"""

from fractions import Fraction
from functools import reduce
from itertools import product
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from validation.oracles.answer import Flags, Floats, Indices

Fractions: TypeAlias = NDArray[np.object_]  # `Fraction`s, of the shape that is stated beside
Numbers: TypeAlias = Any  # Floats or Fractions

EPS = float(np.finfo(float).eps)  # twice the largest relative error of one operation
TINY = float(np.finfo(float).tiny)  # underflow is less, for lengths from 1e-60 to 1e60 m

# Normals of planes that can separate an edge from a face. Each is a product of vectors, which are
# numbered: the sides of the face (0, 1, 2), the edge (3) and the vector from the edge to the face
# (4). Most pairs need the cross products of the first list. The others are needed if everything
# lies in one plane or on one line, or if the face has no area.
NORMALS = [(0, 1), (3, 0), (3, 1), (3, 2)]
NORMALS += [*product((0, 3, 4), range(4), range(4)), *product(range(5))]


def crossing_faces(positions: ArrayLike, faces: ArrayLike, first_cap: int | None = None) -> Indices:
    """Find the pairs of faces with a point in common besides their common vertices.

    Two faces with the same three vertices lie on each other however they move; they are left out.
    Two faces with a common edge are a pair if they lie flat on each other: exactly in one plane
    and on the same side of that edge.

    Args:
        positions: (n_vertices, 3) [m].
        faces: (n_faces, 3) vertex indices, three different ones in each face.
        first_cap: Number of contacts to ask python-fcl for at first. None takes more than most
            meshes have. It changes only how long the call takes.

    Returns:
        (k, 2) int, each pair once, the lower index first, sorted.

    Raises:
        ValueError: A position is not finite, or a face has a vertex twice.
    """
    positions, faces = np.asarray(positions, float), np.asarray(faces, int)
    bad = np.flatnonzero(~np.isfinite(positions).all(axis=1))
    if len(bad):  # python-fcl would find no contact there and raise no error
        raise ValueError(f"positions: expected finite, vertex {bad[0]} is {positions[bad[0]]}")
    bad = np.flatnonzero((faces == np.roll(faces, 1, axis=1)).any(axis=1))
    if len(bad):
        raise ValueError(f"faces: expected three vertices, face {bad[0]} is {faces[bad[0]]}")
    if len(faces) < 2:  # python-fcl ends the process if there is no face at all
        return np.empty((0, 2), int)
    pairs = _listed_by_fcl(positions, faces, first_cap or 40 * len(faces))
    shared = (faces[pairs[:, 0], :, None] == faces[pairs[:, 1], None, :]).sum(axis=(1, 2))
    neighbours, shared_by = _neighbours(faces)
    over_vertex, over_edge = neighbours[shared_by == 1], neighbours[shared_by == 2]
    crossing = _cross_over_vertex(positions, faces[over_vertex])
    folded = _folded_over_edge(positions, faces[over_edge])
    found = np.concatenate((pairs[shared == 0], over_vertex[crossing], over_edge[folded]))
    return np.unique(found, axis=0)


def _listed_by_fcl(positions: Floats, faces: Indices, cap: int) -> Indices:
    """List the pairs of different faces that touch according to python-fcl, with neighbours.

    Args:
        positions: (n_vertices, 3) f8 [m].
        faces: (n_faces, 3) int.
        cap: Number of contacts to ask for at first.

    Returns:
        (k, 2) int, the lower index first.
    """
    import fcl

    model = fcl.BVHModel()
    model.beginModel(len(positions), len(faces))
    model.addSubModel(positions, faces)
    model.endModel()
    while True:
        # by default python-fcl returns one contact and drops all others without a message
        request = fcl.CollisionRequest(num_max_contacts=cap)
        result = fcl.CollisionResult()
        fcl.collide(fcl.CollisionObject(model), fcl.CollisionObject(model), request, result)
        if len(result.contacts) < cap:
            break
        cap *= 8
    pairs = np.array([(c.b1, c.b2) for c in result.contacts], int).reshape(-1, 2)
    # each pair comes in both orders, perhaps with several contacts, and each face with itself
    pairs = np.unique(np.sort(pairs, axis=1), axis=0)
    return pairs[pairs[:, 0] < pairs[:, 1]]


def _neighbours(faces: Indices) -> tuple[Indices, Indices]:
    """Find the pairs of faces with common vertices, and count these vertices.

    Args:
        faces: (n_faces, 3) int.

    Returns:
        (k, 2) int, the lower index first, and (k,) int, the number of common vertices.
    """
    order = np.argsort(faces.ravel(), kind="stable")
    vertex, face = faces.ravel()[order], order // 3
    found, step = [np.empty((0, 2), int)], 1
    # entries `step` apart have the same vertex until the step exceeds the most faces at a vertex
    while (same := vertex[:-step] == vertex[step:]).any():
        found.append(np.column_stack((face[:-step], face[step:]))[same])
        step += 1
    return np.unique(np.concatenate(found), axis=0, return_counts=True)


def _common(pairs: Indices) -> Flags:
    """Mark the corners of two faces that are in the other face too.

    Args:
        pairs: (k, 2, 3) int, vertices of both faces.

    Returns:
        (k, 2, 3) b1.
    """
    same = pairs[:, 0, :, None] == pairs[:, 1, None, :]
    return np.stack((same.any(axis=2), same.any(axis=1)), axis=1)


def _cross_over_vertex(positions: Floats, pairs: Indices) -> Flags:
    """Mark the pairs of faces with one common vertex that also meet anywhere else.

    If two such faces have another common point, follow the ray from the common vertex through that
    point. It leaves one of the faces no later than the other one, across the edge opposite to the
    common vertex. So it is enough to test that edge of each face against the other face.

    Args:
        positions: (n_vertices, 3) f8 [m].
        pairs: (k, 2, 3) int, vertices of both faces.

    Returns:
        (k,) b1.
    """
    turn = (_common(pairs).argmax(axis=2)[:, :, None] + np.arange(3)) % 3
    first, second = np.moveaxis(positions[np.take_along_axis(pairs, turn, axis=2)], 1, 0)
    return edges_meet(first[:, 1:], second) | edges_meet(second[:, 1:], first)


def edges_meet(edges: Floats, faces: Floats) -> Flags:
    """Mark the (k, 2, 3) edges that meet their (k, 3, 3) faces; the answers are exact."""
    (p, q), (a, b, c) = np.moveaxis(edges, 1, 0), np.moveaxis(faces, 1, 0)
    turns = _side(p, q, a, b) + _side(p, q, b, c) + _side(p, q, c, a)
    meet = (_side(a, b, c, p) * _side(a, b, c, q) < 0) & (np.abs(turns) == 3)
    undecided = np.flatnonzero(~meet)
    undecided = undecided[~_apart(edges[undecided], faces[undecided], 5 * EPS, TINY)]
    meet[undecided] = ~_apart(_exact(edges[undecided]), _exact(faces[undecided]), 0, 0)
    return meet


def _exact(points: Floats) -> Fractions:
    """Convert floats to fractions, without rounding."""
    return np.array([Fraction(x) for x in points.ravel()], object).reshape(points.shape)


def _side(a: Floats, b: Floats, c: Floats, d: Floats) -> Floats:
    """Compute the sign of the volume (b - a, c - a, d - a); 0 where rounding leaves it open.

    With u = b - a, v = c - a and w = d - a, the volume is a sum of terms u_i v_j w_k. Each term
    passes 3 differences, 2 products and 3 sums. That is 8 roundings, so its error is at most 4 EPS
    of its size. Since |u_i v_j| + |u_j v_i| <= |u| |v|, all terms together have at most the size
    |u| |v| (|w_1| + |w_2| + |w_3|). The fifth EPS covers the rounding of the computed size.

    Args:
        a: (k, 3) f8 [m].
        b: (k, 3) f8 [m].
        c: (k, 3) f8 [m].
        d: (k, 3) f8 [m].

    Returns:
        (k,) f8, -1, 0 or 1.
    """
    u, v, w = b - a, c - a, d - a
    volume = (w * np.cross(u, v)).sum(axis=1)
    size = np.sqrt((u * u).sum(axis=1) * (v * v).sum(axis=1)) * np.abs(w).sum(axis=1)
    return np.where(np.abs(volume) > 5 * EPS * size + TINY, np.sign(volume), 0.0)


def _apart(edges: Numbers, faces: Numbers, eps: float, tiny: float) -> Flags:
    """Mark the edges and faces that a plane separates by more than rounding.

    Any plane that separates them will do, so its normal may be rounded. If there is such a plane,
    there is one with a normal of NORMALS, so the answers are exact for fractions, with eps = 0.

    For floats, a coordinate along a normal passes 4 roundings: one difference, one product and two
    sums. Its error is at most 2 EPS of its size. Two coordinates are compared, which makes 4 EPS.
    Callers pass 5 EPS; the fifth covers the roundings of the comparison and of the computed size.

    Args:
        edges: (k, 2, 3) f8 or fractions [m].
        faces: (k, 3, 3) f8 or fractions [m].
        eps: Largest error of a difference of two coordinates, over their size.
        tiny: Largest error by underflow.

    Returns:
        (k,) b1.
    """
    (p, q), (a, b, c) = np.moveaxis(edges, 1, 0), np.moveaxis(faces, 1, 0)
    vectors, points = (b - a, c - b, a - c, q - p, a - p), (q - p, a - p, b - p, c - p)
    apart = np.zeros(len(p), bool)
    for factors in NORMALS:
        left = np.flatnonzero(~apart)
        normal = reduce(np.cross, [vectors[i][left] for i in factors])
        of_q, *of_face = [(normal * x[left]).sum(axis=1) for x in points]
        size = np.max([(np.abs(normal) * np.abs(x[left])).sum(axis=1) for x in points], axis=0)
        ahead = np.min(of_face, axis=0) - np.maximum(of_q, 0)
        behind = np.minimum(of_q, 0) - np.max(of_face, axis=0)
        apart[left] = np.maximum(ahead, behind) > eps * size + tiny
    return apart


def _folded_over_edge(positions: Floats, pairs: Indices) -> Flags:
    """Mark the pairs of faces with a common edge that lie on each other; the answers are exact.

    Args:
        positions: (n_vertices, 3) f8 [m].
        pairs: (k, 2, 3) int, vertices of both faces.

    Returns:
        (k,) b1.
    """
    turn = (_common(pairs).argmin(axis=2)[:, :, None] + np.arange(3)) % 3
    tips = np.take_along_axis(pairs, turn, axis=2)
    points = positions[np.column_stack((tips[:, 0, 1:], tips[:, :, 0]))]  # edge, then tips
    a, b, c, d = np.moveaxis(points, 1, 0)
    normal = np.cross(b - a, c - a)
    size = np.sqrt(((b - a) ** 2).sum(axis=1) / ((normal**2).sum(axis=1) + TINY))
    # tips on opposite sides of a plane through the edge do not fold; any such plane will do, and
    # flat sheets are decided here, without fractions
    above = a + normal * size[:, None]
    opposite = _side(a, b, above, c) * _side(a, b, above, d) < 0
    left = np.flatnonzero((_side(a, b, c, d) == 0) & ~opposite)
    a, b, c, d = np.moveaxis(_exact(points[left]), 1, 0)
    one, other = np.cross(b - a, c - a), np.cross(b - a, d - a)
    folded = np.zeros(len(pairs), bool)
    folded[left] = ((one * (d - a)).sum(axis=1) == 0) & ((one * other).sum(axis=1) > 0)
    return folded
