"""Broad phase: which elements have swept boxes that meet."""

import numpy as np

from izo_ref.cpu import tree as kernels
from izo_ref.serial.tree import GROUP


class Elements:
    """Elements of one kind (vertices, edges or faces), sorted in space, in a tree of boxes.

    The order is made once, from the first positions; `refit` follows later positions.

    Attributes:
        order: (n,) i8, element of each sorted place.
        nodes: (n, k) i4, vertices of each sorted element.
        boxes: (n, 6) f8 [m], minima then maxima over the path, sorted.
        moved: (n,) b1, whether the element has to be looked at, sorted.
    """

    def __init__(self, nodes, positions_t0, positions_t1):
        boxes = np.empty((len(nodes), 6))
        kernels.element_boxes(positions_t0, positions_t1, nodes, boxes)
        self.order = np.argsort(morton_codes_of(boxes), kind="stable")
        self.nodes = np.ascontiguousarray(nodes[self.order])
        self.boxes = np.ascontiguousarray(boxes[self.order])
        self.moved = np.ones(len(nodes), bool)
        groups = max(1, -(-len(nodes) // GROUP))
        n_nodes = 2 << (groups - 1).bit_length()
        self.node_boxes = np.empty((n_nodes, 6))
        self.node_moved = np.zeros(n_nodes, bool)
        self._fill_nodes()

    def refit(self, positions_t0, positions_t1, vertex_moved):
        """Boxes of new positions; elements with a moved vertex are the ones looked at."""
        kernels.element_boxes(positions_t0, positions_t1, self.nodes, self.boxes)
        kernels.element_moved(vertex_moved, self.nodes, self.moved)
        self._fill_nodes()

    def _fill_nodes(self):
        kernels.leaf_groups(self.boxes, self.moved, self.node_boxes, self.node_moved)
        begin = len(self.node_boxes) // 4
        while begin >= 1:
            kernels.parent_nodes(begin, self.node_boxes, self.node_moved)
            begin //= 2


def morton_codes_of(boxes):
    """(n,) i8, where on a Morton curve the centre of each box lies."""
    codes = np.zeros(len(boxes), np.int64)
    if len(boxes):
        origin = boxes[:, :3].min(axis=0)
        extent = float((boxes[:, 3:].max(axis=0) - origin).max())
        kernels.morton_codes(boxes, origin, 2.0**21 / extent if extent > 0.0 else 0.0, codes)
    return codes


def candidate_batches(queries: Elements, leaves: Elements, batch_pairs: int):
    """Pairs of elements whose boxes meet, of which one moved, and that share no vertex.

    Each pair comes once, also when `queries` and `leaves` are the same. Pairs are counted
    first and then written, at most `batch_pairs` at a time (or those of one query).

    Yields:
        (n, 2) i4 arrays, places in the orders of `queries` and `leaves`.
    """
    n = len(queries.order)
    trees = (
        queries.boxes,
        queries.nodes,
        queries.moved,
        leaves.boxes,
        leaves.nodes,
        leaves.moved,
        leaves.node_boxes,
        leaves.node_moved,
        queries is leaves,
    )
    counts = np.empty(n, np.int64)
    kernels.meeting_boxes(
        0, *trees, np.zeros(n, np.int64), False, counts, np.empty((0, 2), np.int32)
    )
    ends = np.cumsum(counts)
    first = 0
    while first < n:
        before = ends[first - 1] if first else 0
        last = max(first + 1, int(np.searchsorted(ends, before + batch_pairs, side="right")))
        pairs = np.empty((ends[last - 1] - before, 2), np.int32)
        starts = ends[first:last] - counts[first:last] - before
        kernels.meeting_boxes(first, *trees, starts, True, counts[first:last], pairs)
        if len(pairs):
            yield pairs
        first = last
