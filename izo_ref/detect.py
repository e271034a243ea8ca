"""Detection: every vertex-face and edge-edge pair that meets on a path."""

import numpy as np

from izo_ref.broad import Elements, search
from izo_ref.cpu import advance as kernels
from izo_ref.cpu.contacts import find_contacts
from izo_ref.types import Impacts, Pairs, join_impacts


class Tally:
    """What a detection looked at.

    Attributes:
        pairs: candidate pairs, by kind.
        steps: proofs these took together, and the most for one pair.
    """

    def __init__(self):
        self.pairs = {"vertex_face": 0, "edge_edge": 0}
        self.steps = 0
        self.most_steps = 0

    def add(self, kind, pairs, steps, most_steps):
        self.pairs[kind] += pairs
        self.steps += steps
        self.most_steps = max(self.most_steps, most_steps)


class Detector:
    """Finds the impacts of paths that start at the same positions.

    Args:
        positions_t0: (n_vertices, 3) f8 [m], the start of every path.
        edges: (n_edges, 2) i4.
        faces: (n_faces, 3) i4.
        excluded: `Pairs` that are not looked at, or None.
        start_is_free: the start was found free, exactly; then so are pairs at rest.
    """

    def __init__(
        self,
        positions_t0,
        edges,
        faces,
        excluded=None,
        *,
        start_is_free=True,
    ):
        self.positions_t0 = positions_t0
        self.edges = edges
        self.faces = faces
        self.start_is_free = start_is_free
        self.tally = Tally()
        self._excluded = None if excluded is None else set(_pair_keys(excluded))
        self._elements = None

    def find(self, positions_t1, moved=None) -> Impacts:
        """Impacts of the path from the start to `positions_t1`.

        Args:
            positions_t1: (n_vertices, 3) f8 [m].
            moved: (n_vertices,) b1, look only at pairs with one of these vertices; all if
                None.
        """
        if moved is None:
            moved = np.ones(len(self.positions_t0), bool)
        vertices, edges, faces = self._refit(positions_t1, moved)
        self.tally = Tally()
        return join_impacts(
            (
                self._find_kind(vertices, faces, positions_t1, False),
                self._find_kind(edges, edges, positions_t1, True),
            )
        )

    def _refit(self, positions_t1, moved):
        if self._elements is None:
            vertices = np.arange(len(self.positions_t0), dtype=np.int32)[:, None]
            self._elements = tuple(
                Elements(nodes, self.positions_t0, positions_t1)
                for nodes in (vertices, self.edges, self.faces)
            )
            if moved.all():  # as new trees are
                return self._elements
        for elements in self._elements:
            elements.refit(self.positions_t0, positions_t1, moved)
        return self._elements

    def _find_kind(self, queries, leaves, positions_t1, is_edge_edge):
        elements, nodes, toi, directions = self._contacts(queries, leaves, positions_t1)
        order = np.lexsort((elements[:, 1], elements[:, 0]))
        nodes, toi, directions = nodes[order], toi[order], directions[order]
        kinds = np.full(len(nodes), is_edge_edge)
        kept = np.ones(len(nodes), bool)
        if self.start_is_free:
            kept = (self.positions_t0[nodes] != positions_t1[nodes]).any(axis=(1, 2))
        if self._excluded is not None:
            keys = _pair_keys(Pairs(nodes, kinds))
            kept &= np.array([key not in self._excluded for key in keys], bool)
        nodes, kinds, toi, directions = nodes[kept], kinds[kept], toi[kept], directions[kept]
        weights, normals = np.empty((len(nodes), 4)), np.empty((len(nodes), 3))
        kernels.impact_frames(
            self.positions_t0, positions_t1, nodes, kinds, toi, directions, weights, normals
        )
        return Impacts(nodes, kinds, toi, weights, normals)

    def _contacts(self, queries, leaves, positions_t1):
        """Elements, nodes, times and directions of the pairs not proved apart."""
        (pairs, nodes, toi, directions), tally = search(
            find_contacts,
            ((np.int32, 2), (np.int32, 4), (np.float64,), (np.float64, 3)),
            queries,
            leaves,
            queries is leaves,
            self.positions_t0,
            positions_t1,
        )
        self.tally.add("edge_edge" if queries is leaves else "vertex_face", *tally)
        elements = np.column_stack(
            (queries.tree.order[pairs[:, 0]], leaves.tree.order[pairs[:, 1]])
        )
        if queries is leaves:
            elements.sort(axis=1)
        return elements, nodes, toi, directions


def _pair_keys(pairs: Pairs):
    """One key a pair, the same however its sides are written."""
    nodes = pairs.nodes.astype(np.int32, copy=True)
    ee = pairs.is_edge_edge
    nodes[~ee, 1:] = np.sort(nodes[~ee, 1:], axis=1)
    a, b = np.sort(nodes[ee, :2], axis=1), np.sort(nodes[ee, 2:], axis=1)
    swap = (a[:, 0] > b[:, 0]) | ((a[:, 0] == b[:, 0]) & (a[:, 1] > b[:, 1]))
    nodes[ee] = np.where(swap[:, None], np.hstack((b, a)), np.hstack((a, b)))
    return [row.tobytes() for row in np.column_stack((ee.astype(np.int32), nodes))]


def find_impacts(scene) -> Impacts:
    """Every vertex-face and edge-edge pair that meets on the path of a scene.

    A pair that is only touched, at any time up to t = 1, meets; so does one that comes
    closer than rounding can tell from touching: some 1e-14 of its size, more for slivers.
    None is missed.

    Args:
        scene: `Scene`.

    Returns:
        `Impacts`: vertex-face pairs by vertex and face, then edge-edge pairs by edges.

    Source: SPEC section 1; the proof is in `scalar/advance.py`.
    """
    detector = Detector(scene.positions_t0, scene.edges, scene.faces, scene.excluded)
    return detector.find(scene.positions_t1)
