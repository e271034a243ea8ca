"""Broad phase: which elements have swept boxes that meet."""

from math import gcd

import numpy as np

from izo_ref.cpu import tree as kernels
from izo_ref.cpu.contacts import CHUNK
from izo_ref.ranges import ranges
from izo_ref.serial.tree import GROUP, Tree


class Elements:
    """Elements of one kind (vertices, edges or faces), sorted in space, in a tree of boxes.

    The order is made once, from the first positions; `refit` follows later positions.

    Attributes:
        tree: `Tree`.
    """

    def __init__(self, nodes, positions_t0, positions_t1):
        boxes = np.empty((len(nodes), 6))
        kernels.element_boxes(positions_t0, positions_t1, nodes, boxes)
        order = np.argsort(morton_codes_of(boxes), kind="stable")
        groups = max(1, -(-len(nodes) // GROUP))
        n_nodes = 2 << (groups - 1).bit_length()
        self.tree = Tree(
            order,
            np.ascontiguousarray(nodes[order]),
            np.ascontiguousarray(boxes[order]),
            np.ones(len(nodes), bool),
            np.empty((n_nodes, 6)),
            np.zeros(n_nodes, bool),
        )
        self._fill_nodes()

    def refit(self, positions_t0, positions_t1, vertex_moved):
        """Boxes of new positions; elements with a moved vertex are the ones looked at."""
        tree = self.tree
        kernels.element_boxes(positions_t0, positions_t1, tree.nodes, tree.boxes)
        kernels.element_moved(vertex_moved, tree.nodes, tree.moved)
        self._fill_nodes()

    def _fill_nodes(self):
        tree = self.tree
        kernels.leaf_groups(tree.boxes, tree.moved, tree.node_boxes, tree.node_moved)
        begin = len(tree.node_boxes) // 4
        while begin >= 1:
            kernels.parent_nodes(begin, tree.node_boxes, tree.node_moved)
            begin //= 2


def morton_codes_of(boxes):
    """(n,) i8, where on a Morton curve the centre of each box lies."""
    codes = np.zeros(len(boxes), np.int64)
    if len(boxes):
        origin = boxes[:, :3].min(axis=0)
        extent = float((boxes[:, 3:].max(axis=0) - origin).max())
        kernels.morton_codes(boxes, origin, 2.0**21 / extent if extent > 0.0 else 0.0, codes)
    return codes


# Pairs that each chunk of queries has room for at first: four for each. Of 143 chunks of
# edges of armadillo-rollers 29 find more than one for each. Memory that is not written to is
# not taken.
ROOM = 4 * GROUP * CHUNK


def search(kernel, columns, queries: Elements, leaves: Elements, *arguments):
    """Launch a search over all queries, and once more for those that found more than there
    was room for.

    Args:
        kernel: of cpu/contacts.py.
        columns: what it writes for each pair: a dtype and the numbers of it.
        arguments: of the kernel, after the trees.

    Returns:
        The columns of what was found, in any order; candidates, proofs, most proofs for one.
    """
    n = -(-len(queries.tree.order) // (GROUP * CHUNK))
    chunks = _scattered(n)

    def launch(chunks, starts):
        counts, tallies = np.empty(len(chunks), np.int64), np.empty((len(chunks), 3), np.int64)
        found = [np.empty((starts[-1], *width), dtype) for dtype, *width in columns]
        trees = queries.tree, leaves.tree
        kernel(chunks, starts, *trees, *arguments, counts, tallies, *found)
        return counts, tallies, found

    starts = ROOM * np.arange(n + 1)
    counts, tallies, found = launch(chunks, starts)
    full = counts > ROOM
    written = np.where(full, 0, counts)
    index = ranges(starts[:-1], written)
    found = [column[index] for column in found]
    if full.any():
        ends = np.cumsum(counts[full])
        _, _, more = launch(chunks[full], np.concatenate(([0], ends)))
        found = [np.concatenate(both) for both in zip(found, more, strict=True)]
    candidates, proofs = tallies[:, :2].sum(axis=0)
    return found, (int(candidates), int(proofs), int(tallies[:, 2].max(initial=0)))


def _scattered(n):
    """0 ... n - 1 in an order that spreads neighbours over the threads, which take one
    stretch of it each: contacts come in clusters."""
    stride = max(1, round(0.618 * n))
    while gcd(stride, n) > 1:
        stride -= 1
    return np.arange(n) * stride % max(n, 1)
