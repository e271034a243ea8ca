"""Arrays of a detection by a thread group, on the CPU."""

import numpy as np

from izo_ref.base.records import Impacts
from izo_ref.detection.serial.found_counts import LEAST_TOI, N_COUNTS
from izo_ref.detection.serial.group_boxes import fit_boxes
from izo_ref.detection.serial.group_contacts import (
    append_contacts,
    append_open_pairs,
    count_open_crossings,
    sort_impacts,
)
from izo_ref.detection.serial.query import append_edge_faces, append_pairs
from izo_ref.detection.serial.records import ContactList, PathArrays, SortSpace
from izo_ref.detection.trees import Elements, box_frame


class GroupDetection:
    """The arrays of a detection, and its five parts.

    Args:
        scene: The scene.
        n_pairs: Pairs for which there is room.
        n_contacts: Contacts for which there is room.
        view: Called with each array; returns what the parts get instead.
    """

    def __init__(self, scene, n_pairs=2000, n_contacts=500, view=lambda array: array):
        """Make all arrays; what is not an input is filled with numbers that must not matter."""
        n = len(scene.masses)
        origin, scale = box_frame(scene.positions_t0, scene.edges)
        start, end = scene.positions_t0.copy(), scene.positions_t1.copy()
        path = start, end, np.full((n, 3), np.nan), np.append(origin, scale)
        self.path = PathArrays._make(map(view, path))
        vertices = np.arange(n, dtype=np.int32)[:, None]
        self.trees = []
        for nodes, order in zip(
            (vertices, scene.edges, scene.faces), scene.tree_orders, strict=True
        ):
            tree = Elements(nodes, order).tree
            lanes = np.full_like(tree.lanes, 255)
            own = (*tree[:2], tree.blocks, lanes, tree.levels.copy())
            self.trees.append(type(tree)._make(map(view, own)))
        self.boxes, self.moved = view(np.full((n, 9), 9e9, np.float32)), view(np.ones(n, bool))
        counts = np.full(N_COUNTS, -7)
        self.counts, least = view(counts), counts[LEAST_TOI : LEAST_TOI + 1].view(np.float64)
        self._least = view(least)
        self.pairs, self.open = (view(np.full((n_pairs, 2), -7, np.int32)) for _ in range(2))
        self._ignored, self._pinned = view(np.empty(0, np.int64)), view(scene.pinned.copy())
        shapes = (), (4,), (), (3,), (4,), (3,)
        types = np.int64, np.int32, np.float64, np.float64, np.float64, np.float64
        columns = (
            np.full((n_contacts, *shape), -7, dtype)
            for shape, dtype in zip(shapes, types, strict=True)
        )
        self.contacts = ContactList._make(map(view, columns))
        self._sort_space = SortSpace._make(view(np.full(n_contacts, -7)) for _ in range(4))
        shapes, types = ((4,), (), (), (4,), (3,)), (np.int32, bool, *3 * (np.float64,))
        columns = (
            np.zeros((n_contacts, *shape), dtype)
            for shape, dtype in zip(shapes, types, strict=True)
        )
        self.found = Impacts._make(map(view, columns))

    def fit(self, group, at_rest=False):
        """Fit the boxes."""
        fit_boxes(group, self.path, at_rest, *self.trees, self.boxes, self.moved, self.counts)

    def fit_at_rest(self, group):
        """Fit the boxes, and mark all elements."""
        self.fit(group, True)

    def list_pairs(self, group):
        """List the pairs; return the number of vertex-face pairs."""
        return append_pairs(group, *self.trees, self.counts, self.pairs)

    def list_open_pairs(self, group):
        """List the pairs that float32 leaves open."""
        append_open_pairs(group, self.boxes, *self.trees, self.pairs, self.counts, self.open)

    def list_contacts(self, group):
        """List the contacts; return the steps of all proofs, and of the longest."""
        known = self.open, self._ignored, self.counts
        return append_contacts(group, self.path, *self.trees, *known, self.contacts)

    def list_edge_faces(self, group):
        """List the edges and faces whose boxes meet, in place of the pairs."""
        append_edge_faces(group, *self.trees[1:], self.counts, self.pairs)

    def count_crossings(self, group):
        """Count the edges and faces that may meet at the start."""
        own = self.path.start, *self.trees[1:], self.pairs, self.counts
        count_open_crossings(group, *own)

    def list_impacts(self, group, to_solve=False):
        """List the impacts."""
        n_room, rest = self.pairs.shape[0], (self._least, self.counts, self.found)
        own = self._pinned, to_solve, self.contacts, self._sort_space
        sort_impacts(group, self.path, n_room, *own, *rest)
