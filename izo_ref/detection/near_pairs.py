"""The pairs that are near: what a detector keeps from one path to the next."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from izo_ref.base.arrays import Floats, Indices, Ints, Nodes, Positions, Times
from izo_ref.base.deadline import UNLIMITED, Deadline
from izo_ref.base.records import PairCounts, take_rows
from izo_ref.detection.cpu.contacts import CHUNK, FEW_CHUNKS, find_contacts
from izo_ref.detection.serial.near import collect_contacts, replace_marked, use_up_margins
from izo_ref.detection.trees import Elements, meeting_pairs, scattered


class Contacts(NamedTuple):
    """Pairs that are not proved apart on a path."""

    keys: Indices  # (n,) i8, by kind and elements: those of edge-edge pairs are not negative
    nodes: Nodes  # (n, 4) i4, vertex then face, or edge then edge
    toi: Times  # (n,) f8, time until which the pair is proved apart
    directions: Floats  # (n, 3) f8, the last ones that separated the sides

    def take(self, index: Any) -> Contacts:
        """Return the contacts of an index array or a mask."""
        return Contacts._make(take_rows(self, index))


class NearPairs:
    """Pairs of two kinds of elements that are near, with their margins.

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
        deadline: When each search has to end.
    """

    def __init__(
        self,
        kind: str,
        first: Elements,
        second: Elements,
        positions_t0: Positions,
        deadline: Deadline = UNLIMITED,
    ) -> None:
        """Begin without any pair; call `find_contacts` first."""
        self._kind = kind
        self._first, self._second = first, second
        self._positions_t0, self._deadline = positions_t0, deadline
        self._near: Ints = np.empty((0, 2), np.int32)  # places in the trees
        self._margins: Floats = np.empty(0)  # (n_near,) [m]

    def find_contacts(self, positions_t1: Positions, counts: PairCounts) -> Contacts:
        """Find all contacts; no pair is near yet, because no vertex has a reach.

        Args:
            positions_t1: (n_vertices, 3) f8 [m], ends of the path.
            counts: The counts to add to.
        """
        pairs = meeting_pairs(self._first, self._second, self._deadline)
        return self._prove(pairs, positions_t1, counts)[1]

    def update_near(self) -> None:
        """Find the near pairs of the elements that are marked in the trees; keep all others."""
        pairs = meeting_pairs(self._first, self._second, self._deadline)
        lanes = self._first.tree.lanes, self._second.tree.lanes
        self._near, self._margins = replace_marked(self._near, self._margins, *lanes, pairs)

    def recheck(self, positions_t1: Positions, moves: Floats, counts: PairCounts) -> Contacts:
        """Find the contacts among the near pairs whose margin is used up.

        Args:
            positions_t1: (n_vertices, 3) f8 [m], ends of the path.
            moves: (n_vertices,) f8 [m], how far each vertex ends from where it ended on the
                previous path, along the axis on which that is farthest, rounded up.
            counts: The counts to add to.
        """
        nodes = self._first.tree.nodes, self._second.tree.nodes
        due = use_up_margins(self._near, *nodes, moves, self._margins)
        pairs = self._near.take(due, axis=0)
        self._margins[due], contacts = self._prove(pairs, positions_t1, counts)
        return contacts

    def _prove(
        self, pairs: Ints, positions_t1: Positions, counts: PairCounts
    ) -> tuple[Floats, Contacts]:
        """Return the margins of some pairs [m], and the contacts among them."""
        first, second = self._first.tree, self._second.tree
        trees = first.order, first.nodes, second.order, second.nodes
        n_pairs, n = len(pairs), -(-len(pairs) // CHUNK)
        tallies, index = np.empty((n, 3), np.int64), np.empty(n_pairs, np.int64)
        toi, directions, margins = np.empty(n_pairs), np.empty((n_pairs, 3)), np.empty(n_pairs)
        for part in self._deadline.slices(range(n)):
            find_contacts.where_it_pays(
                FEW_CHUNKS,
                part,
                scattered(n),
                pairs,
                *trees,
                self._positions_t0,
                positions_t1,
                tallies,
                index,
                toi,
                directions,
                margins,
            )
        contacts, steps, most = collect_contacts(
            CHUNK, tallies, index, pairs, toi, directions, *trees
        )
        counts.add(self._kind, n_pairs, steps, most)
        return margins, Contacts(*contacts)
