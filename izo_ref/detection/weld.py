"""Weld vertices that coincide: many exporters write one vertex of a surface several times.

Vertices that are one vertex form a group. The lowest of them represents the group, and the others
are its copies. Faces and edges name representatives alone, so copies take no part in anything. They
keep their numbers, and start and end where their representative does.
"""

from __future__ import annotations

import numpy as np

from izo_ref.base.arrays import Faces, Flags, Floats, Indices, Masses, Positions
from izo_ref.base.errors import DegenerateFaceError, NonFiniteError, WeldError
from izo_ref.base.records import TreeOrders
from izo_ref.base.units import largest
from izo_ref.detection.mesh import edges_of
from izo_ref.detection.rows import equal_rows, first_of_each

# Vertices that may be near each vertex, on average. Searching 100,000 vertices with 60 neighbours
# each takes 1.5 CPU s. A tolerance that finds more joins whole faces.
MOST_NEAR = 64
# The factor covers the rounding of two distances of the same vertices that are computed in two
# ways: each has less than 8 operations with an error of 2^-53.
ROUNDING = 1.0 + 2.0**-49
LARGE = 2.0**1022  # differences of larger coordinates may overflow


def find_copies(
    positions_t0: Positions, positions_t1: Positions, pinned: Flags, tolerance: float
) -> Indices | None:
    """Find the vertices that are one vertex.

    Two vertices are one if they are at most `tolerance` apart at the start and at the end. So are
    vertices that are joined by a chain of such pairs.

    Args:
        positions_t0: (n, 3) f8 [m].
        positions_t1: (n, 3) f8 [m].
        pinned: (n,) b1.
        tolerance: [m], not negative. With 0 the coordinates must be equal; -0 and 0 are.

    Returns:
        (n,) i8, the lowest vertex of the group of each vertex. None if no two vertices are one.

    Raises:
        WeldError: A chain leads farther than the tolerance from the path of the group, or so many
            vertices are near each other that the tolerance must be wrong.
    """
    n = len(pinned)
    group = equal_rows(np.hstack((positions_t0, positions_t1)))
    if tolerance > 0.0 and n:
        group = _joined(group, positions_t0, positions_t1, tolerance)
    _, lowest = np.unique(group, return_index=True)
    if len(lowest) == n:
        return None
    copies = lowest[group]
    leaders = leaders_of(copies, pinned)
    for positions, when in ((positions_t0, "start"), (positions_t1, "end")):
        apart = _distances(positions, positions[leaders])
        _require_near(apart, leaders, tolerance, when)
    return copies


def leaders_of(copies: Indices, pinned: Flags) -> Indices:
    """Return the vertex whose path the group of each vertex takes, (n,) i8.

    It is the lowest pinned vertex of the group, so that this one follows its path exactly, or the
    lowest vertex if none is pinned.

    Args:
        copies: (n,) i8, the lowest vertex of the group of each vertex.
        pinned: (n,) b1.
    """
    leaders = np.arange(len(copies))
    from_last = np.flatnonzero(pinned)[::-1]
    leaders[copies[from_last]] = from_last  # of equal indices, the last one assigns
    return leaders[copies]


def welded_faces(faces: Faces, copies: Indices) -> Faces:
    """Return faces of representatives, without those that welding makes superfluous.

    A face that gets the same vertex twice becomes an edge or a point, and is left out if another
    face has that edge. Of faces that get the same three vertices, the first is kept.

    Args:
        faces: (m, 3) i4.
        copies: (n,) i8, the representative of each vertex.

    Returns:
        (k, 3) i4, in the order of `faces`.

    Raises:
        DegenerateFaceError: A face becomes an edge that no other face has.
    """
    named = copies[faces].astype(np.int32)
    a, b, c = named.T
    flat = (a == b) | (b == c) | (c == a)
    kept = np.flatnonzero(~flat)[first_of_each(named[~flat], len(copies))]
    _require_harmless(faces, named, np.flatnonzero(flat), kept)
    return named[kept]


def pinned_groups(pinned: Flags, copies: Indices) -> Flags:
    """Return which vertices are in a group with a pinned vertex, (n,) b1."""
    result = np.zeros(len(pinned), bool)
    result[copies[pinned]] = True
    return result[copies]


def summed_masses(masses: Masses, copies: Indices) -> Masses:
    """Return the mass of each group at its representative, and 0 at its copies, (n,) f8 [kg].

    Raises:
        NonFiniteError: A sum is too large for a float.
    """
    with np.errstate(over="ignore"):
        sums: Masses = np.bincount(copies, masses, len(masses)).astype(np.float64)
    infinite = np.flatnonzero(np.isinf(sums))
    if len(infinite):
        raise NonFiniteError(
            "masses: expected masses whose sum over the vertices that are one vertex is finite, "
            f"found {len(infinite)} sums that are not, the first is that of vertex {infinite[0]}"
        )
    return sums


def without_copies(orders: TreeOrders, copies: Indices | None) -> TreeOrders:
    """Return the orders in which elements enter trees, without the vertices that are copies."""
    if copies is None:
        return orders
    vertices, edges, faces = orders
    return vertices[copies[vertices] == vertices], edges, faces


def joined_faces(faces: Faces, copies: Indices | None) -> Faces:
    """Return faces for finding components, with a row that joins each copy with its vertex."""
    if copies is None:
        return faces
    own = np.flatnonzero(copies != np.arange(len(copies)))
    rows = np.column_stack((own, copies[own], copies[own]))
    return np.concatenate((faces, rows.astype(np.int32)))


def require_together(name: str, positions: Positions, others: Indices, tolerance: float) -> None:
    """Check that the vertices of each group are at one place.

    Args:
        name: The name of the array in the message.
        positions: (n, 3) f8 [m].
        others: (n,) i8, a vertex of the group of each vertex.
        tolerance: [m], how far a vertex may be from that one.

    Raises:
        WeldError: A vertex is farther away; names the first one.
    """
    apart = _distances(positions, positions[others])
    away = np.flatnonzero(apart > tolerance * ROUNDING)
    if len(away):
        v = away[0]
        raise WeldError(
            f"{name}: expected welded vertices at one place, found {len(away)} elsewhere, the "
            f"first is vertex {v}, {apart[v]:.3g} m away from vertex {others[v]}. Pass "
            f"`{name}[scene.copies]`, or make a new Scene, which decides anew what is one vertex"
        )


def _joined(
    group: Indices, positions_t0: Positions, positions_t1: Positions, tolerance: float
) -> Indices:
    """Join the groups that are within the tolerance of each other, directly or by a chain."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import KDTree

    _, one = np.unique(group, return_index=True)  # a vertex of each group
    k, start, end = len(one), positions_t0[one], positions_t1[one]
    # The tree looks at the largest difference of coordinates, because squares of very large or very
    # small lengths overflow or underflow; it takes halves where even a difference may overflow.
    unit = 0.5 if largest(start) > LARGE else 1.0
    tree, reach = KDTree(unit * start), unit * tolerance
    n_near = (tree.count_neighbors(tree, reach, p=np.inf) - k) / k
    if n_near > MOST_NEAR:
        raise WeldError(
            f"weld: expected a tolerance that joins copies alone, got {tolerance:g} m, within "
            f"which each vertex has {n_near:.0f} others on average. Pass a distance [m] much less "
            "than the length of an edge"
        )
    a, b = tree.query_pairs(reach, p=np.inf, output_type="ndarray").T
    near = _distances(start[a], start[b]) <= tolerance
    near &= _distances(end[a], end[b]) <= tolerance
    a, b = a[near], b[near]
    graph = coo_array((np.ones(len(a), np.int8), (a, b)), (k, k))
    return connected_components(graph, directed=False)[1].astype(np.int64)[group]


def _distances(a: Positions, b: Positions) -> Floats:
    """Return the distance of each point of one array from that of another, (n,) f8 [m]."""
    with np.errstate(over="ignore"):  # infinitely far is far
        x, y, z = (a - b).T
        return np.hypot(np.hypot(x, y), z)


def _require_near(apart: Floats, leaders: Indices, tolerance: float, when: str) -> None:
    """Raise an error if a chain of near vertices led farther than the tolerance."""
    far = np.flatnonzero(apart > tolerance * ROUNDING)
    if len(far):
        v = far[0]
        raise WeldError(
            f"weld: expected vertices within {tolerance:g} m of the vertex whose path they take, "
            f"found {len(far)} that only a chain of others joins to it, the first is vertex {v}, "
            f"at the {when} {apart[v]:.3g} m from vertex {leaders[v]}. Pass a smaller tolerance, "
            "or one that is larger than each cluster of copies"
        )


def _require_harmless(faces: Faces, named: Faces, flat: Indices, kept: Indices) -> None:
    """Raise an error if what is left of a flat face is an edge that no kept face has."""
    own = np.sort(named[flat], axis=1).astype(np.int64)
    lowest, highest = own[:, 0], own[:, 2]  # the ends of the edge; equal if a point is left
    a, b = edges_of(named[kept]).astype(np.int64).T
    alone = (lowest != highest) & ~np.isin(lowest << 32 | highest, a << 32 | b)
    if alone.any():
        first = flat[alone][0]
        edge = int(lowest[alone][0]), int(highest[alone][0])
        raise DegenerateFaceError(
            f"faces: expected no face that welding turns into an edge of its own, found "
            f"{np.count_nonzero(alone)}, the first face {first}: {faces[first].tolist()}, of which "
            f"the edge {edge} is left. Remove these faces, or weld less"
        )
