"""Find which pairs that touch at the start meet again, or go through each other.

A pair that touches at t = 0 is apart on (0, 1] if exact arithmetic finds no later time at which it
meets. That is not enough: a vertex may leave its face on the wrong side. Then the edges that begin
at the vertex go through the face. If no pair of an edge and a face meets right after t = 0, the
two are apart then, or the edge goes through the inside of the face. So the mesh is free right
after t = 0 if no pair meets then, and no edge goes through a face with which it touched at t = 0.
Later, an edge can go through a face only at a time at which one of their pairs meets.
"""

from __future__ import annotations

import numpy as np

from izo_ref.base.arrays import Codes, Flags, Indices, Positions, Times
from izo_ref.base.deadline import UNLIMITED, Deadline
from izo_ref.base.exact import volume_signs
from izo_ref.base.exact_path import crosses_after_start, first_meeting_after_start
from izo_ref.base.records import Impacts, TouchingPairs
from izo_ref.detection.cpu import frames
from izo_ref.detection.cpu import touching as kernels
from izo_ref.detection.formulas.touching import UNKNOWN

NEVER = 2.0  # a time that is not on the path
# Places in (p, q, a, b, c), the ends of an edge and the corners of a face, of the nodes of five
# volumes. The signs of two say on which side of the face each end is. Those of the other three say
# on which side of each edge of the face the line of the edge passes.
VOLUMES = np.array([[0, 2, 3, 4], [1, 2, 3, 4], [0, 1, 2, 3], [0, 1, 3, 4], [0, 1, 4, 2]])


class TouchingPath:
    """Finds the impacts among the pairs that touch at the start of all paths.

    A path is compared with the one before, and only what moved since then is decided. The first one
    is compared with the path at rest, on which each pair goes on touching and no edge goes through
    a face.

    Args:
        positions_t0: (n_vertices, 3) f8 [m], start of every path.
        touching: The pairs.
        deadline: When each search has to end. After one that was ended, the next one begins anew.
    """

    def __init__(
        self, positions_t0: Positions, touching: TouchingPairs, deadline: Deadline = UNLIMITED
    ) -> None:
        """Keep the pairs; nothing is decided yet."""
        self._start, self._touching, self._deadline = positions_t0, touching, deadline
        self._toi: Times = np.zeros(len(touching.nodes))
        self._crosses: Flags = np.zeros(len(touching.edge_faces), bool)
        self._signs_t0: Codes | None = None  # (n, 5) i1, when they are first needed
        self._previous_t1: Positions | None = None  # ends for which the two hold

    def find(self, positions_t1: Positions) -> Impacts:
        """Find the impacts of the path from the start to `positions_t1`.

        An impact at t = 0 has the normal of the side that the mesh tells.

        Args:
            positions_t1: (n_vertices, 3) f8 [m].

        Returns:
            `Impacts`, sorted as the pairs.
        """
        own = self._touching
        self._renew(positions_t1)
        toi = self._toi.copy()
        toi[own.pair[self._crosses[own.contact]]] = 0.0
        meets = np.flatnonzero(toi < NEVER)
        nodes, kinds, toi = own.nodes[meets], own.is_edge_edge[meets], toi[meets]
        weights, normals = own.weights[meets].copy(), own.normals[meets].copy()
        later = np.flatnonzero(toi > 0.0)
        if len(later):
            frame = np.empty((len(later), 4)), np.empty((len(later), 3))
            pairs = nodes[later], kinds[later], toi[later], normals[later]
            frames.compute_impact_frames(self._start, positions_t1, *pairs, *frame)
            weights[later], normals[later] = frame
        return Impacts(nodes, kinds, toi, weights, normals)

    def _renew(self, positions_t1: Positions) -> None:
        """Decide about the pairs, edges and faces of which a vertex moved since the last path."""
        own, start = self._touching, self._start
        previous_t1, self._previous_t1 = self._previous_t1, None  # until all is decided
        if previous_t1 is None:
            self._toi[:], self._crosses[:], previous_t1 = 0.0, False, start
        moved = (positions_t1 != previous_t1).any(axis=1)
        pairs = np.flatnonzero(moved[own.nodes].any(axis=1))
        self._toi[pairs] = self._first_meetings(pairs, positions_t1)
        contacts = np.flatnonzero(moved[own.edge_faces].any(axis=1))
        self._crosses[contacts] = self._go_through(contacts, positions_t1)
        self._previous_t1 = positions_t1.copy()

    def _first_meetings(self, pairs: Indices, positions_t1: Positions) -> Times:
        """Return when each of some pairs first meets after t = 0, or NEVER."""
        nodes, kinds = self._touching.nodes[pairs], self._touching.is_edge_edge[pairs]
        apart, toi = np.empty(len(pairs), bool), np.full(len(pairs), NEVER)
        kernels.find_pairs_apart(self._start, positions_t1, nodes, apart)
        for i in self._deadline.checked(np.flatnonzero(~apart)):
            ends = self._start[nodes[i]], positions_t1[nodes[i]]
            time = first_meeting_after_start(bool(kinds[i]), *ends)
            toi[i] = NEVER if time is None else time
        return toi

    def _go_through(self, contacts: Indices, positions_t1: Positions) -> Flags:
        """Return which of some edges go through their faces right after t = 0."""
        if len(contacts) == 0:
            return np.empty(0, bool)
        if self._signs_t0 is None:
            corners = self._start[self._touching.edge_faces[:, VOLUMES]].reshape(-1, 4, 3)
            self._signs_t0 = volume_signs(corners, self._deadline).reshape(-1, 5)
        edge_faces = self._touching.edge_faces[contacts]
        nodes = edge_faces[:, VOLUMES].reshape(-1, 4)
        signs_t0, signs = self._signs_t0[contacts].ravel(), np.empty(len(nodes), np.int8)
        kernels.compute_volume_signs(self._start, positions_t1, nodes, signs_t0, signs)
        signs = signs.reshape(-1, 5)
        from_ends, turns = signs[:, :2], signs[:, 2:]
        known = signs != UNKNOWN
        same_side = known[:, :2].all(axis=1) & (from_ends.prod(axis=1) >= 0)
        passes_by = (turns == 0).any(axis=1) | (
            (turns == 1).any(axis=1) & (turns == -1).any(axis=1)
        )
        through = ~same_side & ~passes_by
        for i in self._deadline.checked(np.flatnonzero(through & ~known.all(axis=1))):
            own = edge_faces[i]
            through[i] = crosses_after_start(self._start[own], positions_t1[own])
        return through
