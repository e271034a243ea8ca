"""Detection: every vertex-face and edge-edge pair that meets on a path."""

import numpy as np

from izo_ref.base.mesh import median_length
from izo_ref.base.options import RULES
from izo_ref.base.ranges import ranges
from izo_ref.base.records import Impacts, PairCounts, Pairs, join_impacts, no_impacts
from izo_ref.detection.components import MeshComponents
from izo_ref.detection.cpu import frames as kernels
from izo_ref.detection.cpu.contacts import CHUNK, find_contacts, gather_contact_nodes
from izo_ref.detection.formulas.advance import MAX_STEPS
from izo_ref.detection.trees import Elements, meeting_pairs, scattered, vertex_boxes

# A vertex that left its reach gets as much reach as it came since the last detection: the loop
# converges, so it is not to come as far again soon. One that came farther than this share of an
# edge gets none, for too much would be near it: on armadillo-rollers and cloth-ball-clean the
# detections together take 8.3 and 13.5 CPU s; with as much reach as it likes up to a tenth of an
# edge 9.0 and 15.3, with none ever 11.1 and 21.9.
FAR_REACH = 0.03
# Proofs before a pair counts as near: with 1 those two take 1.3 and 3.1 s more, with 6 as long.
NEAR_STEPS = 4


class Detector:
    """Finds the impacts of paths that start at the same positions.

    It keeps the pairs that are near. Every vertex has a reach about the end of its path:
    pairs that are not near stay apart as long as both sides end within theirs. So a later
    detection looks for pairs anew only where a vertex left its reach, and of the near ones
    looks again at those with a vertex that moved.

    Args:
        positions_t0: (n_vertices, 3) f8 [m], the start of every path.
        edges: (n_edges, 2) i4.
        faces: (n_faces, 3) i4.
        excluded: `Pairs` that are not looked at, or None.
        rules: names of `options.RULES` that are applied; those that say nothing of detection
            are not looked at.
        start_is_free: the start was found free, exactly; then so are pairs at rest.

    Attributes:
        counts: `PairCounts` of the last detection.
    """

    def __init__(
        self,
        positions_t0,
        edges,
        faces,
        excluded=None,
        rules=frozenset(RULES),
        *,
        start_is_free=True,
    ):
        vertices = np.arange(len(positions_t0), dtype=np.int32)[:, None]
        self.counts = PairCounts()
        self._nodes = vertices, edges, faces
        self._positions_t0 = positions_t0
        self._excluded = None if excluded is None else set(_pair_keys(excluded))
        self._rules = rules
        self._start_is_free = start_is_free
        self._seen = None  # the ends of the last detection
        self._parts, self._far = None, None  # and (n_parts,) b1, those that are in no tree
        self._far_reach = None  # [m]
        self._elements = None

    def find(self, positions_t1) -> Impacts:
        """Impacts of the path from the start to `positions_t1`.

        Args:
            positions_t1: (n_vertices, 3) f8 [m].

        Returns:
            `Impacts`: vertex-face pairs by vertex and face, then edge-edge pairs by edges.
        """
        if self._seen is None:
            moved = np.ones(len(positions_t1), bool)
        else:
            moved = _differ(positions_t1, self._seen)
        self.counts = PairCounts(int(np.count_nonzero(moved)))
        if self._seen is None or "incremental" not in self._rules or self._is_reached(positions_t1):
            self._begin(positions_t1)
        else:
            self._follow(positions_t1)
            for kind in self._kinds:
                kind.look_again(positions_t1, moved, self.counts)
        self._seen = positions_t1.copy()
        return join_impacts(kind.impacts for kind in self._kinds)

    def _is_reached(self, positions_t1):
        """Whether something that moves got to a part that is in no tree."""
        if self._far is None:
            return False
        far = self._parts.out_of_reach(self._positions_t0, positions_t1)
        return bool((self._far & ~far).any())

    def _begin(self, positions_t1):
        """Look at all pairs, or those that a rule leaves."""
        self._make_trees(positions_t1)
        self._centres, self._reach = positions_t1.copy(), np.zeros(len(positions_t1))
        moving = np.ones(len(positions_t1), bool)
        self._refit(moving)
        if "still" in self._rules and self._start_is_free:
            moving = _differ(self._positions_t0, positions_t1)
            if not moving.all():
                self._refit(moving)
        for kind in self._kinds:
            kind.begin(positions_t1, self._reach, self.counts)

    def _make_trees(self, positions_t1):
        chosen, self._far = (None, None, None), None
        may_rest = "one-box" in self._rules and self._start_is_free
        if may_rest and not _differ(self._positions_t0, positions_t1).all():
            if self._parts is None:
                self._parts = MeshComponents(len(positions_t1), self._nodes[2])
            far = self._parts.out_of_reach(self._positions_t0, positions_t1)
            if far.any():
                self._far, near = far, ~far[self._parts.part]
                chosen = [np.flatnonzero(near[nodes[:, 0]]) for nodes in self._nodes]
        dtype = np.float32 if "float32-boxes" in self._rules else np.float64
        vertices, edges, faces = (
            Elements(nodes, self._positions_t0, ids, dtype)
            for nodes, ids in zip(self._nodes, chosen, strict=True)
        )
        self._elements = vertices, edges, faces
        known = self._positions_t0, self._start_is_free, self._excluded
        self._kinds = (
            _Kind("vertex_face", vertices, faces, *known),
            _Kind("edge_edge", edges, edges, *known),
        )

    def _follow(self, positions_t1):
        """Give a new reach to vertices that left theirs, and look for what is then near."""
        left = _largest(positions_t1 - self._centres) > self._reach
        if not left.any():
            return
        if self._far_reach is None:
            self._far_reach = FAR_REACH * median_length(self._positions_t0, self._nodes[1])
        self._centres[left] = positions_t1[left]
        reach = _largest(positions_t1[left] - self._seen[left])
        self._reach[left] = np.where(reach > self._far_reach, 0.0, reach)
        self._refit(left)
        for kind in self._kinds:
            kind.look_for_pairs(self._centres, self._reach, self.counts)

    def _refit(self, moved):
        # up to rounding, a vertex within its reach is that much farther away at most
        reach = (self._reach * (1.0 + 2.0**-50))[:, None]
        boxes = vertex_boxes(
            self._positions_t0,
            self._centres - reach,
            self._centres + reach,
            self._elements[0].tree.blocks.dtype,
        )
        for elements in self._elements:
            elements.refit(boxes, moved)


class _Kind:
    """Vertices against faces, or edges against edges: pairs that are near, and impacts.

    Attributes:
        impacts: `Impacts` of the last path, by elements.
    """

    def __init__(self, name, first: Elements, second: Elements, positions_t0, is_free, excluded):
        self.impacts = no_impacts()
        self._name = name
        self._first, self._second = first, second
        self._positions_t0, self._start_is_free = positions_t0, is_free
        self._excluded = excluded  # keys of pairs, or None
        self._keys = np.empty(0, np.int64)  # of the impacts: what they are sorted by
        self._near = np.empty((0, 2), np.int32)  # places

    def begin(self, positions_t1, reach, counts):
        """Look for pairs and impacts."""
        pairs = meeting_pairs(self._first, self._second)
        contacts = self._contacts(pairs, positions_t1, reach, MAX_STEPS, counts)
        self._near = contacts[0]
        self._keys, self.impacts = self._impacts_of(*contacts, positions_t1)

    def look_for_pairs(self, centres, reach, counts):
        """Near pairs anew where elements are in the lanes of the trees."""
        first, second = self._first.in_lanes(), self._second.in_lanes()
        old = first[self._near[:, 0]] | second[self._near[:, 1]]
        pairs = meeting_pairs(self._first, self._second)
        pairs, _, _ = self._contacts(pairs, centres, reach, NEAR_STEPS, counts)
        self._near = np.concatenate((self._near[~old], pairs))

    def look_again(self, positions_t1, moved, counts):
        """At the near pairs that have a moved vertex; of others, those that met meet."""
        first, second = self._first.with_vertex(moved), self._second.with_vertex(moved)
        pairs = self._near[first[self._near[:, 0]] | second[self._near[:, 1]]]
        no_reach = np.zeros(len(positions_t1))
        contacts = self._contacts(pairs, positions_t1, no_reach, MAX_STEPS, counts)
        keys, found = self._impacts_of(*contacts, positions_t1)
        still = ~moved[self.impacts.nodes].any(axis=1)
        keys = np.concatenate((self._keys[still], keys))
        order = np.argsort(keys)
        self._keys = keys[order]
        self.impacts = join_impacts((self.impacts.take(still), found)).take(order)

    def _contacts(self, pairs, positions_t1, reach, max_steps, counts):
        """Those of some pairs that are not proved apart, their times and directions."""
        n = -(-len(pairs) // CHUNK)
        tallies, index = np.empty((n, 3), np.int64), np.empty(len(pairs), np.int64)
        toi, directions = np.empty(len(pairs)), np.empty((len(pairs), 3))
        first, second = self._first.tree, self._second.tree
        find_contacts(
            scattered(n),
            pairs,
            first.order,
            first.nodes,
            second.order,
            second.nodes,
            self._positions_t0,
            positions_t1,
            reach,
            max_steps,
            tallies,
            index,
            toi,
            directions,
        )
        counts.add(self._name, len(pairs), tallies[:, 1].sum(), tallies[:, 2].max(initial=0))
        written = ranges(CHUNK * np.arange(n), tallies[:, 0])
        return pairs[index[written]], toi[written], directions[written]

    def _impacts_of(self, pairs, toi, directions, positions_t1):
        """What they are sorted by, and `Impacts`, sorted."""
        keys, nodes = self._keys_and_nodes(pairs)
        order = np.argsort(keys)
        kinds = np.full(len(nodes), self._first is self._second)
        moving = _differ(self._positions_t0, positions_t1)
        if self._start_is_free and not moving.all():
            order = order[moving[nodes[order]].any(axis=1)]
        if self._excluded is not None:
            named = _pair_keys(Pairs(nodes[order], kinds[order]))
            order = order[np.array([key not in self._excluded for key in named], bool)]
        nodes, kinds, toi, directions = nodes[order], kinds[order], toi[order], directions[order]
        weights, normals = np.empty((len(nodes), 4)), np.empty((len(nodes), 3))
        kernels.compute_impact_frames(
            self._positions_t0, positions_t1, nodes, kinds, toi, directions, weights, normals
        )
        return keys[order], Impacts(nodes, kinds, toi, weights, normals)

    def _keys_and_nodes(self, pairs):
        first, second = self._first.tree, self._second.tree
        keys, nodes = np.empty(len(pairs), np.int64), np.empty((len(pairs), 4), np.int32)
        gather_contact_nodes(
            pairs, first.order, first.nodes, second.order, second.nodes, keys, nodes
        )
        return keys, nodes


def _differ(a, b):
    """(n,) b1, rows that differ."""
    return (a[:, 0] != b[:, 0]) | (a[:, 1] != b[:, 1]) | (a[:, 2] != b[:, 2])


def _largest(vectors):
    """(n,) largest absolute value of each row."""
    x, y, z = np.abs(vectors).T
    return np.maximum(np.maximum(x, y), z)


def _pair_keys(pairs: Pairs):
    """One key a pair, the same however its sides are written."""
    nodes = pairs.nodes.astype(np.int32, copy=True)
    ee = pairs.is_edge_edge
    nodes[~ee, 1:] = np.sort(nodes[~ee, 1:], axis=1)
    a, b = np.sort(nodes[ee, :2], axis=1), np.sort(nodes[ee, 2:], axis=1)
    swap = (a[:, 0] > b[:, 0]) | ((a[:, 0] == b[:, 0]) & (a[:, 1] > b[:, 1]))
    nodes[ee] = np.where(swap[:, None], np.hstack((b, a)), np.hstack((a, b)))
    return [row.tobytes() for row in np.column_stack((ee.astype(np.int32), nodes))]
