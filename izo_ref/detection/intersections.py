"""Find the elements of a mesh that intersect at rest, exactly.

A filter in floats decides almost all pairs; exact arithmetic decides the others.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import Edges, Faces, Ints, Positions
from izo_ref.base.exact import sides_meet
from izo_ref.base.records import Impacts, Pairs, TreeOrders
from izo_ref.detection.cpu.contacts import CHUNK, FEW_CHUNKS, find_crossings
from izo_ref.detection.detector import Detector
from izo_ref.detection.formulas.advance import APART, CONTACT, UNDECIDED
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
        """Number of intersections."""
        return len(self.crossing_edges) + len(self.touching.nodes)

    def describe(self, most: int) -> list[tuple[str, str]]:
        """Return the two elements of the first intersections, `most` of them at most.

        An intersection is, for example, ("edge (0, 1)", "face (2, 3, 4)").
        """
        found = [
            (f"edge {_ids(edge)}", f"face {_ids(face)}")
            for edge, face in zip(self.crossing_edges[:most], self.crossed_faces, strict=False)
        ]
        for nodes, is_edge_edge in zip(*(column[:most] for column in self.touching), strict=True):
            split = 2 if is_edge_edge else 1
            names = ("edge", "edge") if is_edge_edge else ("vertex", "face")
            found.append((f"{names[0]} {_ids(nodes[:split])}", f"{names[1]} {_ids(nodes[split:])}"))
        return found[:most]

    def pairs(self) -> Pairs:
        """Return the vertex-face and edge-edge pairs of all intersections, each once, sorted.

        Where an edge meets a face, each of the five pairs of the two may start on the wrong side,
        so all five are returned.
        """
        crossings = _pairs_of_crossings(self.crossing_edges, self.crossed_faces)
        return _unique_pairs([crossings, self.touching])


def find_intersections(
    positions: Positions, edges: Edges, faces: Faces, orders: TreeOrders | None = None
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
    """
    detector = Detector(positions, edges, faces, start_is_free=False, orders=orders)
    touching = _touching_pairs(positions, detector.find(positions))
    _, *trees = detector.elements
    crossing = _crossing_edges(positions, edges, faces, *trees)
    return Intersections(edges[crossing[:, 0]], faces[crossing[:, 1]], touching)


def _ids(nodes: Ints) -> tuple[int, ...]:
    return tuple(int(node) for node in nodes)


def _crossing_edges(
    positions: Positions, edges: Edges, faces: Faces, edge_tree: Elements, face_tree: Elements
) -> Ints:
    """Return the edge and the face of each edge that meets a face, (n, 2), sorted."""
    first, second = edge_tree.tree, face_tree.tree
    pairs = meeting_pairs(edge_tree, face_tree)
    statuses = np.empty(len(pairs), np.int8)
    chunks = range(-(-len(pairs) // CHUNK))
    nodes = first.nodes, second.nodes
    find_crossings.where_it_pays(FEW_CHUNKS, chunks, pairs, *nodes, positions, statuses)
    near = (statuses != APART).nonzero()[0]
    pairs, statuses = pairs.take(near, axis=0), statuses.take(near)
    found = np.column_stack((first.order[pairs[:, 0]], second.order[pairs[:, 1]]))
    unsure = np.flatnonzero(statuses == UNDECIDED)
    edge, face = found[unsure].T
    meet = sides_meet(positions[edges[edge]], positions[faces[face]])
    statuses[unsure[meet]] = CONTACT
    found = found[statuses == CONTACT]
    return found[np.lexsort((found[:, 1], found[:, 0]))]


def _touching_pairs(positions: Positions, near: Impacts) -> Pairs:
    """Return the vertex-face and edge-edge pairs that touch, decided in exact arithmetic.

    Args:
        positions: (n_vertices, 3) f8 [m].
        near: The pairs that may touch, as far as rounding can tell.
    """
    touch = np.empty(len(near.toi), bool)
    for kind, split in ((False, 1), (True, 2)):
        own = near.is_edge_edge == kind
        points = positions[near.nodes[own]]
        touch[own] = sides_meet(points[:, :split], points[:, split:])
    return Pairs(near.nodes[touch], near.is_edge_edge[touch])


def _pairs_of_crossings(edge: Edges, face: Faces) -> Pairs:
    """Return the five vertex-face and edge-edge pairs of each edge and the face that it meets."""
    parts = [np.column_stack((edge[:, k], face)) for k in range(2)]
    for k in range(3):
        side = np.sort(face[:, [k, (k + 1) % 3]], axis=1)
        swap = (side[:, 0] < edge[:, 0]) | ((side[:, 0] == edge[:, 0]) & (side[:, 1] < edge[:, 1]))
        parts.append(np.where(swap[:, None], np.hstack((side, edge)), np.hstack((edge, side))))
    kinds = np.repeat([False, True], [2 * len(edge), 3 * len(edge)])
    return Pairs(np.concatenate(parts).astype(np.int32), kinds)


def _unique_pairs(parts: Sequence[Pairs]) -> Pairs:
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
