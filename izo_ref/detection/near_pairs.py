"""The pairs that are near, and their impacts: what a detector keeps from one path to the next."""

import numpy as np

from izo_ref.base.arrays import Flags, Floats, Indices, Ints, Nodes, Normals, Positions, Times
from izo_ref.base.ranges import ranges
from izo_ref.base.records import Impacts, PairCounts, Pairs, join_impacts, no_impacts
from izo_ref.detection.cpu import frames as kernels
from izo_ref.detection.cpu.contacts import (
    CHUNK,
    FEW_CHUNKS,
    find_contacts,
    gather_contact_nodes,
)
from izo_ref.detection.pair_keys import pair_keys
from izo_ref.detection.trees import Elements, meeting_pairs, scattered


class NearPairs:
    """Pairs of two kinds of elements that are near, and those of them that are impacts.

    The two kinds are vertices and faces, or edges and edges. Each vertex has a centre, about which
    it is expected to end, and a reach. A pair is near if its moving boxes meet, when each of its
    vertices may end anywhere within its reach. A pair that is not near stays apart as long as its
    vertices end there.

    Each near pair has a margin: it stays apart until one of its vertices has moved by more than
    that since its last proof. The margin shrinks with every move, and is -1 for a pair that was not
    proved yet. Contacts have a margin of 0.

    Args:
        kind: `vertex_face` or `edge_edge`, for the counts.
        first: Tree of the vertices, or of the edges.
        second: Tree of the faces, or of the edges; for edges it is the same object as `first`.
        positions_t0: (n_vertices, 3) f8 [m], start of every path.
        start_is_free: Whether the start is known to be free; pairs at rest are then no impacts.
        excluded: Keys of the pairs to ignore, as `pair_keys` makes them, or None.

    Attributes:
        impacts: `Impacts` of the last path, sorted by their elements.
    """

    def __init__(
        self,
        kind: str,
        first: Elements,
        second: Elements,
        positions_t0: Positions,
        start_is_free: bool,
        excluded: set[bytes] | None,
    ) -> None:
        """Begin without any pair; call `find` first."""
        self.impacts = no_impacts()
        self._kind = kind
        self._first, self._second = first, second
        self._positions_t0, self._start_is_free = positions_t0, start_is_free
        self._excluded = excluded
        self._keys: Indices = np.empty(0, np.int64)  # of the impacts, which are sorted by them
        self._near: Ints = np.empty((0, 2), np.int32)  # places in the trees
        self._margins: Floats = np.empty(0)  # (n_near,) [m]

    def find(self, positions_t1: Positions, counts: PairCounts) -> None:
        """Find all impacts; no pair is near yet, because no vertex has a reach.

        Args:
            positions_t1: (n_vertices, 3) f8 [m], ends of the path.
            counts: The counts to add to.
        """
        pairs = meeting_pairs(self._first, self._second)
        _, contacts = self._contacts(pairs, positions_t1, counts)
        self._keys, self.impacts = self._impacts_of(*contacts, positions_t1)

    def update_near(self) -> None:
        """Find the near pairs of the elements that are marked in the trees; keep all others."""
        first = self._first.in_lanes()
        second = first if self._second is self._first else self._second.in_lanes()
        kept = ~(first[self._near[:, 0]] | second[self._near[:, 1]])
        pairs = meeting_pairs(self._first, self._second)
        self._near = np.concatenate((self._near[kept], pairs))
        self._margins = np.concatenate((self._margins[kept], np.full(len(pairs), -1.0)))

    def update_impacts(self, positions_t1: Positions, moves: Floats, counts: PairCounts) -> None:
        """Recheck the near pairs whose margin is used up; keep the impacts that did not move.

        Args:
            positions_t1: (n_vertices, 3) f8 [m], ends of the path.
            moves: (n_vertices,) f8 [m], how far each vertex ends from where it ended on the
                previous path, along the axis on which that is farthest, rounded up.
            counts: The counts to add to.
        """
        first = self._first.largest_moves(moves)
        second = first if self._second is self._first else self._second.largest_moves(moves)
        self._margins -= np.maximum(first[self._near[:, 0]], second[self._near[:, 1]])
        due = np.flatnonzero(self._margins < 0.0)
        self._margins[due], contacts = self._contacts(self._near[due], positions_t1, counts)
        keys, found = self._impacts_of(*contacts, positions_t1)
        still = ~(moves > 0.0)[self.impacts.nodes].any(axis=1)
        keys = np.concatenate((self._keys[still], keys))
        order = np.argsort(keys)
        self._keys = keys[order]
        self.impacts = join_impacts((self.impacts.take(still), found)).take(order)

    def _contacts(
        self, pairs: Ints, positions_t1: Positions, counts: PairCounts
    ) -> tuple[Floats, tuple[Ints, Times, Normals]]:
        """Return the margins of some pairs [m], and the contacts among them.

        The contacts are the pairs that are not proved apart, with their times and their last
        directions.
        """
        n = -(-len(pairs) // CHUNK)
        tallies, index = np.empty((n, 3), np.int64), np.empty(len(pairs), np.int64)
        toi, directions = np.empty(len(pairs)), np.empty((len(pairs), 3))
        margins = np.empty(len(pairs))
        find_contacts.where_it_pays(
            FEW_CHUNKS,
            range(n),
            scattered(n),
            pairs,
            self._first.tree,
            self._second.tree,
            self._positions_t0,
            positions_t1,
            tallies,
            index,
            toi,
            directions,
            margins,
        )
        counts.add(self._kind, len(pairs), tallies[:, 1].sum(), tallies[:, 2].max(initial=0))
        written = ranges(CHUNK * np.arange(n), tallies[:, 0])
        return margins, (pairs[index[written]], toi[written], directions[written])

    def _impacts_of(
        self, pairs: Ints, toi: Times, directions: Normals, positions_t1: Positions
    ) -> tuple[Indices, Impacts]:
        """Return the impacts among the contacts, sorted by their keys, and these keys."""
        if len(pairs) == 0:
            return np.empty(0, np.int64), no_impacts()
        keys, nodes = self._keys_and_nodes(pairs)
        order = np.argsort(keys)
        kinds = np.full(len(nodes), self._first is self._second)
        moving = rows_differ(self._positions_t0, positions_t1)
        if self._start_is_free and not moving.all():
            order = order[moving[nodes[order]].any(axis=1)]
        if self._excluded is not None:
            named = pair_keys(Pairs(nodes[order], kinds[order]))
            order = order[np.array([key not in self._excluded for key in named], bool)]
        nodes, kinds, toi, directions = nodes[order], kinds[order], toi[order], directions[order]
        weights, normals = np.empty((len(nodes), 4)), np.empty((len(nodes), 3))
        kernels.compute_impact_frames(
            self._positions_t0, positions_t1, nodes, kinds, toi, directions, weights, normals
        )
        return keys[order], Impacts(nodes, kinds, toi, weights, normals)

    def _keys_and_nodes(self, pairs: Ints) -> tuple[Indices, Nodes]:
        first, second = self._first.tree, self._second.tree
        keys, nodes = np.empty(len(pairs), np.int64), np.empty((len(pairs), 4), np.int32)
        gather_contact_nodes(
            pairs, first.order, first.nodes, second.order, second.nodes, keys, nodes
        )
        return keys, nodes


def rows_differ(a: Positions, b: Positions) -> Flags:
    """Return which rows of two arrays of points differ, (n,) b1."""
    return (a[:, 0] != b[:, 0]) | (a[:, 1] != b[:, 1]) | (a[:, 2] != b[:, 2])
