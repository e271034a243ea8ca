"""Detection on a GPU: finds the same impacts as `detection/detector.py`, in the same order.

Nothing is kept from one path to the next but memory. A detection is five launches without a look
from the host in between: `cuda/tree.py` fits the boxes and lists the pairs whose moving boxes meet,
`cuda/contacts.py` lists those that float32 does not prove apart, lists the contacts among them, and
sorts the impacts. Lists that are too short are counted to their end; the host reads the counts
once, makes longer lists, and detects again.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from izo_ref.base.arrays import GpuArray, Indices
from izo_ref.base.gpu_arrays import empty, overwrite, positions_of, to_cpu, to_gpu
from izo_ref.base.gpu_launch import by_blocks, by_grid
from izo_ref.base.records import Impacts, PairCounts, SceneArrays, empty_impacts, join_impacts
from izo_ref.detection.cuda import contacts, tree
from izo_ref.detection.gpu_found import Found, pair_counts, settled
from izo_ref.detection.gpu_trees import frame_of_boxes, keys_to_ignore, make_trees
from izo_ref.detection.serial import found_counts as places
from izo_ref.detection.serial.prescribed import prescribed_impacts
from izo_ref.detection.serial.records import ContactList, PathArrays, SortSpace
from izo_ref.detection.touching_path import TouchingPath

# Threads of a block whose blocks wait for each other, which fits boxes or lists impacts. One block
# must find enough registers on each multiprocessor.
FIT_THREADS, LIST_THREADS = 512, 256
# Blocks of a multiprocessor, and threads of a block, where the blocks do not wait. More blocks than
# run at the same time share out queries that take long and queries that do not.
BLOCKS, THREADS = 16, 128
# Pairs for which there is room at first, for each query, as on the CPU. A pair takes 16 bytes.
PAIRS_PER_QUERY = 8
# Contacts for which there is room at first, for each vertex, and the least room. A contact and its
# impact take 225 bytes.
CONTACTS_PER_VERTEX, LEAST_CONTACTS = 0.25, 1024


class Detector:
    """Finds the impacts of paths that start at the same positions, which are free.

    Args:
        scene: The scene, which gives the start, the mesh and the pairs to ignore.
        counts: (N_COUNTS,) i8 on the GPU, where `serial/found_counts.py` has its counts; None for
            an array of its own.

    Attributes:
        counts: `PairCounts` of the last detection.
        trees: The trees of the vertices, of the edges and of the faces, on the GPU.
        start: (n_vertices, 3) f8 [m], start of the paths, on the GPU.
        impacts: The impacts that the launches found, on the GPU, with room for more.
        n_arrays_made: How often arrays were made anew. If it has changed, `launches` have to be
            prepared again.
    """

    def __init__(self, scene: SceneArrays, counts: GpuArray = None) -> None:
        """Make all arrays, and the trees with empty boxes."""
        n = len(scene.pinned)
        self.counts, self.n_arrays_made = PairCounts(), 0
        self._counts = empty(places.N_COUNTS, np.int64) if counts is None else counts
        self.start = positions_of(scene, "positions_t0")
        self._end, self._seen = empty((n, 3), np.float64), empty((n, 3), np.float64)
        self._seen.clear(255)  # NaN: every vertex ends elsewhere
        self._frame, self._pinned = to_gpu(frame_of_boxes(scene)), to_gpu(scene.pinned)
        self._boxes, self._moved = empty((n, 9), np.float32), empty(n, np.bool_)
        self._ignored = to_gpu(keys_to_ignore(scene))
        self._touching: TouchingPath | None = None
        if scene.touching is not None:
            self._touching = TouchingPath(scene.positions_t0, scene.touching)
        self.trees = make_trees(scene)
        n_queries = self.trees[0].nodes.shape[0] + self.trees[1].nodes.shape[0]
        self._make_room_for_pairs(PAIRS_PER_QUERY * n_queries)
        self._make_room_for_contacts(max(int(CONTACTS_PER_VERTEX * n), LEAST_CONTACTS))
        self._prepared: list[Callable[..., None]] = []

    def go_on(self, positions: GpuArray) -> None:
        """Take a new start of the same mesh on the GPU, in the same coordinates of boxes.

        The coordinates hold any positions, but keep fewer digits of those far outside the start
        of the scene.

        Args:
            positions: (n_vertices, 3) f8 [m], on the GPU.
        """
        self.start.copy_to_device(positions)
        self._seen.clear(255)  # NaN: every vertex ends elsewhere

    def _forget_launches(self) -> None:
        """Let launches be prepared again, because an array was made anew."""
        self._prepared.clear()
        self.n_arrays_made += 1

    def _make_room_for_pairs(self, n: int) -> None:
        """Make the lists of n pairs, and of those among them that float32 leaves open."""
        self._pairs, self._open = empty((n, 2), np.int32), empty((n, 2), np.int32)

    def _make_room_for_contacts(self, n: int) -> None:
        """Make the arrays of n contacts and their impacts."""
        sort_space = SortSpace._make(empty(n, np.int64) for _ in range(4))
        impacts = empty_impacts(n, empty)
        # kernels ask this list how much room there is, so it comes when everything has room
        new_list = ContactList(
            empty(n, np.int64),
            empty((n, 4), np.int32),
            empty(n, np.float64),
            empty((n, 3), np.float64),
            empty((n, 4), np.float64),
            empty((n, 3), np.float64),
        )
        self._contacts, self._sort_space, self.impacts = new_list, sort_space, impacts

    def launches(self, positions_t1: GpuArray, to_solve: bool) -> list[Callable[..., None]]:
        """Return the launches of a detection, for a `Program`.

        Args:
            positions_t1: (n_vertices, 3) f8 [m], on the GPU; its numbers may change from one
                detection to the next.
            to_solve: Whether to leave out the impacts between pinned points.
        """
        path = PathArrays(self.start, positions_t1, self._seen, self._frame)
        to_list = self._list_contacts(path, False, self._counts)
        return [*to_list, self._list_impacts(path, to_solve)]

    def launches_at_rest(self, positions: GpuArray, counts: GpuArray) -> list[Callable[..., None]]:
        """Return launches that count what is not certainly apart at rest, for a `Program`.

        They use the lists of a detection, of which nothing is needed any more.

        Args:
            positions: (n_vertices, 3) f8 [m], on the GPU; its numbers may change.
            counts: (2 N_COUNTS,) i8, on the GPU. The first N_COUNTS are those of a detection, whose
                CONTACTS are vertex-face and edge-edge pairs that may touch. The last N_COUNTS are
                those of edges and faces, of which OPEN may meet.
        """
        path = PathArrays(positions, positions, self._seen, self._frame)
        (_, edges, faces), own, many = self.trees, counts[places.N_COUNTS :], (BLOCKS, THREADS)
        to_count = positions, edges, faces, self._pairs, own
        return [
            *self._list_contacts(path, True, counts),
            by_blocks(tree.list_edge_faces, *many, edges, faces, own, self._pairs),
            by_blocks(contacts.count_crossings, *many, *to_count),
        ]

    def _list_contacts(
        self, path: PathArrays, at_rest: bool, counts: GpuArray
    ) -> list[Callable[..., None]]:
        """Return the launches that list the contacts of a path; `at_rest` as for `fit_trees`."""
        trees, many, fitted = self.trees, (BLOCKS, THREADS), (self._boxes, self._moved, counts)
        to_filter = self._pairs, counts, self._open
        to_prove = self._open, self._ignored, counts, self._contacts
        return [
            by_grid(tree.fit_trees, path, at_rest, *trees, *fitted, n_threads=FIT_THREADS),
            by_blocks(tree.list_pairs, *many, *trees, counts, self._pairs),
            by_blocks(contacts.list_open_pairs, *many, self._boxes, *trees, *to_filter),
            by_blocks(contacts.list_contacts, *many, path, *trees, *to_prove),
        ]

    def _list_impacts(self, path: PathArrays, to_solve: bool) -> Callable[..., None]:
        """Return the last launch of a detection."""
        at = places.LEAST_TOI
        return by_grid(
            contacts.list_impacts,
            path,
            self._pairs.shape[0],
            self._pinned,
            to_solve,
            self._contacts,
            self._sort_space,
            self._counts[at : at + 1].view(np.float64),
            self._counts,
            self.impacts,
            n_threads=LIST_THREADS,
        )

    def grow(self, counts: Indices) -> bool:
        """Make room for all pairs and contacts of a detection.

        Args:
            counts: (N_COUNTS,) i8, the counts of the detection, on the CPU.

        Returns:
            Whether there was too little room. Then `launches` have to be prepared and run again.
        """
        n_pairs, n_contacts = int(counts[places.PAIRS]), int(counts[places.CONTACTS])
        room, contact_room = self._pairs.shape[0], self._contacts.keys.shape[0]
        if n_pairs <= room and n_contacts <= contact_room:
            return False
        self._forget_launches()
        if n_pairs > room:
            self._make_room_for_pairs(max(n_pairs, 2 * room))
        if n_contacts > contact_room:
            self._make_room_for_contacts(max(n_contacts, 2 * contact_room))
        return True

    def find(self, positions_t1: Any) -> Impacts:
        """Find the impacts of the path from the start to `positions_t1`.

        Args:
            positions_t1: (n_vertices, 3) f8 [m], on the CPU or on the GPU.

        Returns:
            `Impacts`, on the CPU if the positions are there: first the vertex-face pairs, sorted by
            vertex and face, then the edge-edge pairs, sorted by their edges, and last the pairs
            that touch at the start. On the GPU, the next detection overwrites the arrays.
        """
        overwrite(self._end, positions_t1)
        while True:
            self._prepared = self._prepared or self.launches(self._end, False)
            for launch in self._prepared:
                launch()
            counts = to_cpu(self._counts)
            if not self.grow(counts):
                found = self.found(counts, self._end, False).impacts
                self.remember(self._end)
                return to_cpu(found) if isinstance(positions_t1, np.ndarray) else found

    def remember(self, positions_t1: GpuArray) -> None:
        """Count the vertices that move from the end of this path on.

        Args:
            positions_t1: (n_vertices, 3) f8 [m], on the GPU.
        """
        self._seen.copy_to_device(positions_t1)

    def found(self, counts: Indices, positions_t1: GpuArray, to_solve: bool) -> Found:
        """Return what the launches of a detection found, and set `counts`.

        The CPU decides by exact arithmetic which contacts at t = 0 are impacts, and which of the
        pairs that touch at the start.

        Args:
            counts: (N_COUNTS,) i8, the counts of the detection, on the CPU.
            positions_t1: (n_vertices, 3) f8 [m], as for the launches.
            to_solve: As for the launches.
        """
        self.counts = pair_counts(counts)
        n, n_blocked = int(counts[places.FOUND]), int(counts[places.BLOCKED])
        found = Impacts._make(column[:n] for column in self.impacts)
        time_free, parts = float(counts[places.LEAST_TOI :].view(np.float64)[0]), []
        if counts[places.AT_START]:
            own = self._all_contacts(int(counts[places.CONTACTS]), positions_t1)
            parts.append(settled(to_cpu(self.start), to_cpu(positions_t1), own))
            found, n_blocked, time_free = empty_impacts(0, empty), 0, 1.0
        if self._touching is not None:
            parts.append(self._touching.find(to_cpu(positions_t1)))
        if not parts:
            return Found(found, n_blocked, time_free, True)
        own = join_impacts(parts)
        if to_solve:
            prescribed = np.empty(len(own.toi), np.bool_)
            prescribed_impacts(own.nodes, own.weights, to_cpu(self._pinned), prescribed)
            own, n_blocked = own.take(~prescribed), n_blocked + int(np.count_nonzero(prescribed))
        time_free = min(time_free, float(own.toi.min(initial=1.0)))
        if len(own.toi) == 0:
            return Found(found, n_blocked, time_free, found.toi.shape[0] > 0)
        impacts = to_gpu(join_impacts([to_cpu(found), own]))
        return Found(impacts, n_blocked, time_free, False)

    def put(self, impacts: Impacts) -> bool:
        """Replace the impacts that the launches found, and their count on the GPU.

        Args:
            impacts: Others, on the GPU.

        Returns:
            Whether there was too little room, so that `impacts` are other arrays now, and
            `launches` have to be prepared again.
        """
        n, room = impacts.toi.shape[0], self.impacts.toi.shape[0]
        is_longer = n > room
        if is_longer:
            self._make_room_for_contacts(max(n, 2 * room))
            self._forget_launches()
        overwrite(self.impacts, impacts)
        at = places.FOUND
        self._counts[at : at + 1].copy_to_device(np.array([n]))
        return is_longer

    def _all_contacts(self, n: int, positions_t1: GpuArray) -> Impacts:
        """Return n contacts as impacts on the CPU, also those between pinned points."""
        path = PathArrays(self.start, positions_t1, self._seen, self._frame)
        self._list_impacts(path, False)()
        return to_cpu(Impacts._make(column[:n] for column in self.impacts))


def find_impacts(scene: SceneArrays) -> Impacts:
    """Find the impacts of a scene on the GPU, and return them on the CPU."""
    return to_cpu(Detector(scene).find(positions_of(scene, "positions_t1")))
