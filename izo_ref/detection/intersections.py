"""Find the elements of a mesh that intersect at rest, exactly.

A filter in floats decides almost all pairs; exact arithmetic decides the others.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import Codes, Edges, Faces, Flags, Ints, Positions
from izo_ref.base.deadline import UNLIMITED, Deadline
from izo_ref.base.exact import sides_meet
from izo_ref.base.records import ExcludedPairs, Impacts, Pairs, PairState, TreeOrders
from izo_ref.detection.cpu.contacts import CHUNK, FEW_CHUNKS, find_crossings
from izo_ref.detection.detector import Detector
from izo_ref.detection.formulas.advance import APART, CONTACT, UNDECIDED
from izo_ref.detection.pair_keys import pair_keys
from izo_ref.detection.trees import Elements, meeting_pairs


class Intersections(NamedTuple):
    """The elements of a mesh that intersect at rest.

    Attributes:
        crossing_edges: (n, 2) i4, the vertices of each edge that meets a face.
        crossed_faces: (n, 3) i4, the vertices of that face. Both are sorted by edge and face.
        touching: The vertex-face and edge-edge `Pairs` that touch.
    """

    crossing_edges: Edges
    crossed_faces: Faces
    touching: Pairs

    @property
    def n_found(self) -> int:
        """Number of edges and faces that meet, and of pairs that touch."""
        return len(self.crossing_edges) + len(self.touching.nodes)

    def touching_pairs_of_contacts(self) -> Ints:
        """Return which pairs of each edge and the face that it meets touch.

        Returns:
            (n, 5) i4, indices of pairs among those that touch; -1 for a pair that is apart.
        """
        if len(self.touching.nodes) == 0:  # the keys of 62,655 contacts take 0.25 s
            return np.full((len(self.crossing_edges), 5), -1, np.int32)
        fives = pair_keys(pairs_of_crossings(self.crossing_edges, self.crossed_faces))
        by_key = {key: i for i, key in enumerate(pair_keys(self.touching))}
        return np.array([by_key.get(key, -1) for key in fives], np.int32).reshape(5, -1).T

    def go_through(self) -> Flags:
        """Return which edges go through the inside of the face that they meet, (n,) b1.

        All five pairs of such an edge and its face are apart.
        """
        return np.asarray((self.touching_pairs_of_contacts() < 0).all(axis=1))

    def unprescribed(self, pinned: Flags) -> Intersections:
        """Return the intersections that have a vertex which is not pinned.

        Args:
            pinned: (n_vertices,) b1.
        """
        edges, faces, pairs = self
        free = ~(pinned[edges].all(axis=1) & pinned[faces].all(axis=1))
        kept = ~pinned[pairs.nodes].all(axis=1)
        own = Pairs(pairs.nodes[kept], pairs.is_edge_edge[kept])
        return Intersections(edges[free], faces[free], own)

    def pairs(self) -> Pairs:
        """Return the vertex-face and edge-edge pairs of all intersections, each once, sorted.

        These are the pairs that touch, and the five pairs of each edge and the face that it meets.
        """
        crossings = pairs_of_crossings(self.crossing_edges, self.crossed_faces)
        return unique_pairs([crossings, self.touching])

    def describe(self, most: int) -> str:
        """Return the number of each kind of intersections, and name the first `most` of each."""
        through = self.go_through()
        edges, faces = self.crossing_edges[through], self.crossed_faces[through]
        parts = []
        if len(edges):
            named = [
                f"edge {_ids(edge)} and face {_ids(face)}"
                for edge, face in zip(edges[:most], faces, strict=False)
            ]
            goes = "1 edge that goes" if len(edges) == 1 else f"{len(edges)} edges that go"
            parts.append(f"{goes} through a face, the first: {'; '.join(named)}")
        touching = self.touching
        if len(touching.nodes):
            named = [
                _named(*pair) for pair in zip(*(part[:most] for part in touching), strict=True)
            ]
            n = len(touching.nodes)
            touches = "1 pair that touches" if n == 1 else f"{n} pairs that touch"
            parts.append(f"{touches}, the first: {'; '.join(named)}")
        return ", and ".join(parts)


def find_intersections(
    positions: Positions,
    edges: Edges,
    faces: Faces,
    orders: TreeOrders | None = None,
    deadline: Deadline = UNLIMITED,
) -> Intersections:
    """Find the elements that intersect at rest; touching is intersecting.

    A mesh intersects itself if an edge meets a face with which it shares no vertex, or if a
    vertex-face or edge-edge pair touches. Two faces with the same three vertices lie on each other
    however they move; this is no intersection.

    Args:
        positions: (n_vertices, 3) f8 [m].
        edges: (n_edges, 2) i4.
        faces: (n_faces, 3) i4.
        orders: Orders in which vertices, edges and faces enter trees; from the positions if None.
        deadline: When the search has to end.
    """
    named = {"start_is_free": False, "orders": orders, "deadline": deadline}
    detector = Detector(positions, edges, faces, **named)
    touching = _touching_pairs(positions, detector.find(positions), deadline)
    _, edge_tree, face_tree = detector.elements
    crossing = _crossing_edges(positions, (edges, faces), edge_tree, face_tree, deadline)
    return Intersections(edges[crossing[:, 0]], faces[crossing[:, 1]], touching)


def states_of_pairs(
    pairs: ExcludedPairs,
    positions: Positions,
    edges: Edges,
    faces: Faces,
    orders: TreeOrders | None = None,
    deadline: Deadline = UNLIMITED,
) -> Codes:
    """Return where the sides of each pair are at rest, (n,) i1, values of `PairState`.

    Args:
        pairs: Vertex-face and edge-edge pairs of a mesh.
        positions: (n_vertices, 3) f8 [m].
        edges: (n_edges, 2) i4.
        faces: (n_faces, 3) i4.
        orders: Orders in which vertices, edges and faces enter trees; from the positions if None.
        deadline: When the search has to end.
    """
    found = find_intersections(positions, edges, faces, orders, deadline)
    through = found.go_through()
    fives = pairs_of_crossings(found.crossing_edges[through], found.crossed_faces[through])
    states = dict.fromkeys(pair_keys(found.touching), PairState.TOUCHING)
    states |= dict.fromkeys(pair_keys(fives), PairState.CROSSING)
    return np.array([states.get(key, PairState.APART) for key in pair_keys(pairs)], np.int8)


def _named(nodes: Ints, is_edge_edge: bool) -> str:
    if is_edge_edge:
        return f"edge {_ids(nodes[:2])} and edge {_ids(nodes[2:])}"
    return f"vertex {int(nodes[0])} and face {_ids(nodes[1:])}"


def _ids(nodes: Ints) -> tuple[int, ...]:
    return tuple(int(node) for node in nodes)


def _crossing_edges(
    positions: Positions,
    mesh: tuple[Edges, Faces],
    edge_tree: Elements,
    face_tree: Elements,
    deadline: Deadline,
) -> Ints:
    """Return the edge and the face of each edge that meets a face, (n, 2), sorted."""
    first, second = edge_tree.tree, face_tree.tree
    edges, faces = mesh
    pairs = meeting_pairs(edge_tree, face_tree, deadline)
    statuses = np.empty(len(pairs), np.int8)
    chunks = range(-(-len(pairs) // CHUNK))
    nodes = first.nodes, second.nodes
    for part in deadline.slices(chunks):
        find_crossings.where_it_pays(FEW_CHUNKS, part, pairs, *nodes, positions, statuses)
    near = (statuses != APART).nonzero()[0]
    pairs, statuses = pairs.take(near, axis=0), statuses.take(near)
    found = np.column_stack((first.order[pairs[:, 0]], second.order[pairs[:, 1]]))
    unsure = np.flatnonzero(statuses == UNDECIDED)
    edge, face = found[unsure].T
    meet = sides_meet(positions[edges[edge]], positions[faces[face]], deadline)
    statuses[unsure[meet]] = CONTACT
    found = found[statuses == CONTACT]
    return found[np.lexsort((found[:, 1], found[:, 0]))]


def _touching_pairs(positions: Positions, near: Impacts, deadline: Deadline) -> Pairs:
    """Return the vertex-face and edge-edge pairs that touch, decided in exact arithmetic.

    Args:
        positions: (n_vertices, 3) f8 [m].
        near: The pairs that may touch, as far as rounding can tell.
        deadline: When the decisions have to end.
    """
    touch = np.empty(len(near.toi), bool)
    for kind, split in ((False, 1), (True, 2)):
        own = near.is_edge_edge == kind
        points = positions[near.nodes[own]]
        touch[own] = sides_meet(points[:, :split], points[:, split:], deadline)
    return Pairs(near.nodes[touch], near.is_edge_edge[touch])


def pairs_of_crossings(edge: Edges, face: Faces) -> Pairs:
    """Return the five vertex-face and edge-edge pairs of each edge and the face that it meets.

    The first pair of each edge and face comes first, then the second one of each, and so on.
    """
    parts = [np.column_stack((edge[:, k], face)) for k in range(2)]
    for k in range(3):
        side = np.sort(face[:, [k, (k + 1) % 3]], axis=1)
        swap = (side[:, 0] < edge[:, 0]) | ((side[:, 0] == edge[:, 0]) & (side[:, 1] < edge[:, 1]))
        parts.append(np.where(swap[:, None], np.hstack((side, edge)), np.hstack((edge, side))))
    kinds = np.repeat([False, True], [2 * len(edge), 3 * len(edge)])
    return Pairs(np.concatenate(parts).astype(np.int32), kinds)


def unique_pairs(parts: Sequence[Pairs]) -> Pairs:
    """Return the pairs of several records, each once, sorted by kind and nodes."""
    nodes = np.concatenate([part.nodes for part in parts])
    kinds = np.concatenate([part.is_edge_edge for part in parts])
    # two vertices in one number, because sorting rows takes longer
    a, b, c, d = nodes.T.astype(np.int64)
    keys = a << 32 | b, c << 32 | d
    order = np.lexsort((keys[1], keys[0], kinds))
    columns = [column[order] for column in (kinds, *keys)]
    first = np.ones(len(order), bool)
    first[1:] = np.logical_or.reduce([column[1:] != column[:-1] for column in columns])
    order = order[first]
    return Pairs(nodes[order], kinds[order])
