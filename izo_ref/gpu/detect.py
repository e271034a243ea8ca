"""Detection on the device: the same impacts, in the same order, as `izo_ref/detect.py` finds.

Each path is looked at anew: all pairs whose moving boxes meet, counted and then written, so
that there is no limit; of these the contacts, and of those the impacts, sorted.
"""

from itertools import pairwise

import numpy as np

from izo_ref.broad import bare_tree, box_frame, morton_grid
from izo_ref.cuda import advance as frames
from izo_ref.cuda import contacts, paths, tree
from izo_ref.cuda.arrays import LARGEST, SUM
from izo_ref.gpu.arrays import (
    counted,
    empty,
    filled,
    indices_of,
    joined,
    on_device,
    on_host,
    order_of,
    reduced,
    starts_of,
    take,
    total_of,
)
from izo_ref.scalar.advance import MAX_STEPS
from izo_ref.serial.tree import WIDTH, Tree
from izo_ref.tally import Tally
from izo_ref.types import Impacts

# Pairs that are looked at in one launch: what is kept of each takes 64 bytes until the contacts
# are known.
BATCH = 1 << 22


class Elements:
    """Elements of one kind in a tree of boxes.

    Args:
        nodes: (n, k) i4, on the processor.
        positions_t0: (n_vertices, 3) f8 [m], on the device.
        grid: origin and cells per metre of the curve along which they are sorted.
    """

    def __init__(self, nodes, positions_t0, grid):
        n = len(nodes)
        nodes, codes = on_device(nodes), empty(n, np.int64)
        tree.morton_codes[n](positions_t0, nodes, *grid, codes)
        index = order_of(codes)
        order = take(on_device(np.arange(n, dtype=np.int32)), index)
        blocks, lanes, self._levels = bare_tree(n, np.float32)
        self.tree = Tree(
            order, take(nodes, index), on_device(blocks), on_device(lanes), on_device(self._levels)
        )

    def refit(self, vertex_boxes, vertex_moved):
        """Boxes of elements with a moved vertex; they are the ones looked at."""
        own, levels = self.tree, self._levels
        n_blocks = -(-own.nodes.shape[0] // WIDTH)
        tree.moved_lanes[n_blocks](vertex_moved, own.nodes, own.lanes)
        tree.element_blocks[n_blocks](vertex_boxes, own.nodes, own.lanes, own.blocks)
        for first, end in pairwise(levels[:-1]):
            n_parents = -(-(end - first) // WIDTH)
            tree.parent_blocks[n_parents](int(first), int(end), own.lanes, own.blocks)


class Detector:
    """Finds the impacts of paths that start at the same positions, which are free.

    Args:
        scene: `Scene`.

    Attributes:
        tally: `Tally` of the last detection.
    """

    def __init__(self, scene):
        start = scene.positions_t0
        self.tally = Tally()
        self._n = len(start)
        self._has_faces = len(scene.faces) > 0
        if not self._has_faces:
            return
        self._start = on_device(start)
        origin, scale = box_frame(start)
        self._frame = on_device(origin), scale
        grid_origin, cells_per_m = morton_grid(start)
        grid = on_device(grid_origin), cells_per_m
        vertices = np.arange(self._n, dtype=np.int32).reshape(-1, 1)
        self._vertices, self._edges, self._faces = (
            Elements(nodes, self._start, grid) for nodes in (vertices, scene.edges, scene.faces)
        )
        self._excluded = [on_device(keys) for keys in _excluded_keys(scene)]
        self._no_reach = filled(self._n, 0.0, np.float64)

    def find(self, positions_t1) -> Impacts:
        """Impacts of the path from the start to `positions_t1`.

        Args:
            positions_t1: (n_vertices, 3) f8 [m], on the device.

        Returns:
            `Impacts` on the device: vertex-face pairs by vertex and face, then edge-edge
            pairs by edges.
        """
        self.tally = Tally()
        if not self._has_faces:
            return _joined_impacts([])
        moved = empty(self._n, np.bool_)
        paths.moved_vertices[self._n](self._start, positions_t1, moved)
        self._refit(positions_t1, moved)
        return _joined_impacts(
            [
                self._impacts(self._vertices, self._faces, self._excluded[0], positions_t1, moved),
                self._impacts(self._edges, self._edges, self._excluded[1], positions_t1, moved),
            ]
        )

    def _refit(self, positions_t1, moved):
        """Boxes of all; those that do not move are not looked at, but met."""
        boxes = empty((self._n, 9), np.float32)
        tree.vertex_boxes[self._n](self._start, positions_t1, positions_t1, *self._frame, boxes)
        everything = filled(self._n, True, np.bool_)
        for elements in (self._vertices, self._edges, self._faces):
            elements.refit(boxes, everything)
            elements.refit(boxes, moved)

    def _impacts(self, first, second, excluded, positions_t1, moved):
        pairs = _meeting_pairs(first, second)
        kind = "edge_edge" if first is second else "vertex_face"
        pairs, toi, directions = self._contacts(kind, pairs, first.tree, second.tree, positions_t1)
        n = pairs.shape[0]
        keys, nodes = empty(n, np.int64), empty((n, 4), np.int32)
        trees = first.tree.order, first.tree.nodes, second.tree.order, second.tree.nodes
        contacts.contact_nodes[n](pairs, *trees, keys, nodes)
        kept = empty(n, np.bool_)
        paths.kept_contacts[n](keys, nodes, moved, excluded, kept)
        index = indices_of(kept)
        index = take(index, order_of(take(keys, index)))
        nodes, toi, directions = take(nodes, index), take(toi, index), take(directions, index)
        n = index.shape[0]
        kinds = filled(n, first is second, np.bool_)
        weights, normals = empty((n, 4), np.float64), empty((n, 3), np.float64)
        frames.impact_frames[n](
            self._start, positions_t1, nodes, kinds, toi, directions, weights, normals
        )
        return Impacts(nodes, kinds, toi, weights, normals)

    def _contacts(self, kind, pairs, first, second, positions_t1):
        """Those that are not proved apart, their times and directions; by batches of pairs."""
        found = []
        for begin in range(0, max(pairs.shape[0], 1), BATCH):
            batch = pairs[begin : begin + BATCH]
            n = batch.shape[0]
            tallies, index = empty((n, 3), np.int64), empty(n, np.int64)
            toi, directions = empty(n, np.float64), empty((n, 3), np.float64)
            contacts.find_contacts[n](
                counted(n),
                batch,
                first.order,
                first.nodes,
                second.order,
                second.nodes,
                self._start,
                positions_t1,
                self._no_reach,
                MAX_STEPS,
                tallies,
                index,
                toi,
                directions,
            )
            if n:
                proofs, most = reduced(tallies, SUM, 1), reduced(tallies, LARGEST, 2)
                self.tally.add(kind, n, proofs, most)
            is_contact = empty(n, np.bool_)
            paths.touching[n](tallies, is_contact)
            own = indices_of(is_contact)
            found.append((take(batch, own), take(toi, own), take(directions, own)))
        return tuple(joined(parts) for parts in zip(*found, strict=True))


class HostDetector:
    """A detector for a step on the processor, called as `izo_ref.detect.Detector` is.

    `seen`: (n_vertices, 3) f8 [m] on the processor, where the last path ended, if there was one.
    """

    def __init__(self, detector: Detector, seen=None):
        self._detector, self._seen = detector, seen

    def find(self, positions_t1) -> Impacts:
        moved = len(positions_t1)
        if self._seen is not None:
            moved = np.count_nonzero((positions_t1 != self._seen).any(axis=1))
        self._seen = positions_t1.copy()
        found = self._detector.find(on_device(positions_t1))
        self.tally = self._detector.tally
        self.tally.moved = int(moved)
        return Impacts(*(on_host(column) for column in found))


def impacts_of_scene(scene) -> Impacts:
    """What `izo_ref.find_impacts` finds, on the processor."""
    return HostDetector(Detector(scene)).find(scene.positions_t1)


def _meeting_pairs(queries: Elements, leaves: Elements):
    """(n, 2) i4, places of a query and a leaf whose boxes meet: counted, then written."""
    n = queries.tree.nodes.shape[0]
    chunks, counts = counted(n), empty(n, np.int64)
    same, no_room = queries is leaves, filled(n + 1, 0, np.int64)
    trees = queries.tree, leaves.tree
    contacts.find_pairs[n](chunks, no_room, *trees, same, counts, empty((0, 2), np.int32))
    starts = starts_of(counts)
    pairs = empty((total_of(starts), 2), np.int32)
    contacts.find_pairs[n](chunks, starts, *trees, same, counts, pairs)
    return pairs


def _joined_impacts(parts):
    if not parts:
        return Impacts(
            empty((0, 4), np.int32),
            empty(0, np.bool_),
            empty(0, np.float64),
            empty((0, 4), np.float64),
            empty((0, 3), np.float64),
        )
    return Impacts(*(joined(columns) for columns in zip(*parts, strict=True)))


def _excluded_keys(scene):
    """Keys of the pairs left out, vertex-face and edge-edge, each ascending."""
    if scene.excluded is None:
        return np.empty(0, np.int64), np.empty(0, np.int64)
    nodes, ee = scene.excluded.nodes.astype(np.int64), scene.excluded.is_edge_edge
    faces = _row_numbers(scene.faces, nodes[~ee, 1:])
    one, other = _row_numbers(scene.edges, nodes[ee, :2]), _row_numbers(scene.edges, nodes[ee, 2:])
    low, high = np.minimum(one, other), np.maximum(one, other)
    return np.sort(nodes[~ee, 0] << 32 | faces), np.sort(low << 32 | high)


def _row_numbers(rows, wanted):
    """(n,) i8, which row has the nodes of each row wanted, in any order."""
    numbers = {tuple(sorted(row)): i for i, row in enumerate(rows.tolist())}
    return np.array([numbers[tuple(sorted(row))] for row in wanted.tolist()], np.int64)
