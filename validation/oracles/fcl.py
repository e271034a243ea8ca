"""Which faces of a mesh intersect at rest, by python-fcl and, for neighbours, exactly.

python-fcl finds the pairs without a common vertex, in floating point: so it
judges crossings, and a mere touch it may miss (`test_touches_are_mostly_found` counts). About
neighbours it says nothing, as they always touch; for them there are signed volumes with a
bound on their rounding and, where that does not decide, rational arithmetic.
"""

from fractions import Fraction
from functools import reduce
from itertools import product

import numpy as np

EPS = np.finfo(float).eps  # twice the largest relative error of one operation
TINY = np.finfo(float).tiny  # underflow is less, for lengths from 1e-60 to 1e60 m

# Normals of the planes that can separate an edge from a face, as products of the sides of
# the face (0, 1, 2), the edge (3) and the way from one to the other (4). If all is in one
# plane or on one line, also if the face has no area, it takes the later ones.
NORMALS = [(0, 1), (3, 0), (3, 1), (3, 2)]
NORMALS += [*product((0, 3, 4), range(4), range(4)), *product(range(5))]


def crossing_faces(positions, faces, first_cap=None):
    """Pairs of faces with a point in common besides their common vertices.

    Two faces with the same three vertices lie on each other however they move; they are
    left out. Two faces with a common edge are a pair if they lie flat on each other: in
    one plane and on the same side of that edge, exactly.

    Args:
        positions: (n_vertices, 3) [m].
        faces: (n_faces, 3) vertex indices, three different ones each.
        first_cap: contacts to ask python-fcl for at first; more than most meshes have if
            None. Changes only how long it takes.

    Returns:
        (k, 2) int, each pair once, lower index first, sorted.

    Raises:
        ValueError: a position is not finite, or a face has a vertex twice.
    """
    positions, faces = np.asarray(positions, float), np.asarray(faces, int)
    bad = np.flatnonzero(~np.isfinite(positions).all(axis=1))
    if len(bad):  # python-fcl finds no contact with it, and says nothing
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


def _listed_by_fcl(positions, faces, cap):
    """Pairs of different faces that python-fcl says touch, neighbours among them."""
    import fcl

    model = fcl.BVHModel()
    model.beginModel(len(positions), len(faces))
    model.addSubModel(positions, faces)
    model.endModel()
    while True:
        # the default cap is one contact, and what is over the cap is dropped in silence
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


def _neighbours(faces):
    """Pairs of faces with common vertices, lower index first, and how many of these."""
    order = np.argsort(faces.ravel(), kind="stable")
    vertex, face = faces.ravel()[order], order // 3
    found, step = [np.empty((0, 2), int)], 1
    while (same := vertex[:-step] == vertex[step:]).any():  # until past the most faces at one
        found.append(np.column_stack((face[:-step], face[step:]))[same])
        step += 1
    return np.unique(np.concatenate(found), axis=0, return_counts=True)


def _common(pairs):
    """(k, 2, 3) b1: which corners of two faces are in the other one too."""
    same = pairs[:, 0, :, None] == pairs[:, 1, None, :]
    return np.stack((same.any(axis=2), same.any(axis=1)), axis=1)


def _cross_over_vertex(positions, pairs):
    """Which of the (k, 2, 3) faces with one common vertex meet anywhere else.

    If they do, the ray from the common vertex through such a point leaves one of the faces, no
    later than the other one, over the edge opposite to that vertex.
    """
    turn = (_common(pairs).argmax(axis=2)[:, :, None] + np.arange(3)) % 3
    first, second = np.moveaxis(positions[np.take_along_axis(pairs, turn, axis=2)], 1, 0)
    return _edges_meet(first[:, 1:], second) | _edges_meet(second[:, 1:], first)


def _edges_meet(edges, faces):
    """Which (k, 2, 3) edges meet their (k, 3, 3) faces."""
    (p, q), (a, b, c) = np.moveaxis(edges, 1, 0), np.moveaxis(faces, 1, 0)
    turns = _side(p, q, a, b) + _side(p, q, b, c) + _side(p, q, c, a)
    meet = (_side(a, b, c, p) * _side(a, b, c, q) < 0) & (np.abs(turns) == 3)
    left = np.flatnonzero(~meet)
    left = left[~_apart(edges[left], faces[left], 5 * EPS, TINY)]
    meet[left] = ~_apart(_exact(edges[left]), _exact(faces[left]), 0, 0)
    return meet


def _exact(points):
    return np.array([Fraction(x) for x in points.ravel()], object).reshape(points.shape)


def _side(a, b, c, d):
    """Sign of the volume (b - a, c - a, d - a); 0 where rounding leaves it open.

    Each term takes 3 differences, 2 products and 3 sums on its way: 8 roundings, 4 EPS of
    its size; u_i v_j + u_j v_i <= |u| |v|. The fifth EPS is for rounding in the size.
    """
    u, v, w = b - a, c - a, d - a
    volume = (w * np.cross(u, v)).sum(axis=1)
    size = np.sqrt((u * u).sum(axis=1) * (v * v).sum(axis=1)) * np.abs(w).sum(axis=1)
    return np.where(np.abs(volume) > 5 * EPS * size + TINY, np.sign(volume), 0.0)


def _apart(edges, faces, eps, tiny):
    """Which edges and faces a plane separates, by more than rounding.

    Any plane will do, so its normal may be rounded. If there is one, there is one with a
    normal of NORMALS, which is why this is exact for fractions and no rounding (0, 0). A
    coordinate along a normal takes 4 roundings, 2 EPS of its size; two are compared.
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


def _folded_over_edge(positions, pairs):
    """Which of the (k, 2, 3) faces with a common edge lie on each other."""
    turn = (_common(pairs).argmin(axis=2)[:, :, None] + np.arange(3)) % 3
    tips = np.take_along_axis(pairs, turn, axis=2)
    points = positions[np.column_stack((tips[:, 0, 1:], tips[:, :, 0]))]  # edge, then tips
    a, b, c, d = np.moveaxis(points, 1, 0)
    normal = np.cross(b - a, c - a)
    size = np.sqrt(((b - a) ** 2).sum(axis=1) / ((normal**2).sum(axis=1) + TINY))
    above = a + normal * size[:, None]  # for flat sheets: any point out of the plane will do
    opposite = _side(a, b, above, c) * _side(a, b, above, d) < 0
    left = np.flatnonzero((_side(a, b, c, d) == 0) & ~opposite)
    a, b, c, d = np.moveaxis(_exact(points[left]), 1, 0)
    one, other = np.cross(b - a, c - a), np.cross(b - a, d - a)
    folded = np.zeros(len(pairs), bool)
    folded[left] = ((one * (d - a)).sum(axis=1) == 0) & ((one * other).sum(axis=1) > 0)
    return folded
