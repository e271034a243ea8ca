"""Broad phase: which elements have moving boxes that meet."""

from math import frexp, gcd, ldexp

import numpy as np

from izo_ref.base.ranges import ranges
from izo_ref.detection.cpu import tree as kernels
from izo_ref.detection.cpu.contacts import CHUNK, find_pairs
from izo_ref.detection.serial.tree import ROWS, WIDTH, Tree


class Elements:
    """Elements of one kind (vertices, edges or faces), sorted in space, in a tree of boxes.

    The order is made once, from where they start.

    Args:
        nodes: (n, k) i4, vertices of all there are.
        positions_t0: (n_vertices, 3) f8 [m].
        ids: (m,) which of them; all if None.
        dtype: of the boxes.

    Attributes:
        tree: `Tree`.
    """

    def __init__(self, nodes, positions_t0, ids=None, dtype=np.float32):
        chosen = nodes if ids is None else nodes[ids]
        order = np.argsort(morton_codes_of(positions_t0, chosen))
        order = (order if ids is None else ids[order]).astype(np.int32)
        self.tree = Tree(order, np.ascontiguousarray(nodes[order]), *bare_tree(len(order), dtype))

    def refit(self, vertex_boxes, vertex_moved):
        """Boxes of elements with a moved vertex; they are the ones looked at."""
        tree = self.tree
        kernels.flag_moved_lanes(vertex_moved, tree.nodes, tree.lanes)
        kernels.fit_element_blocks(vertex_boxes, tree.nodes, tree.lanes, tree.blocks)
        for first, end in zip(tree.levels[:-2], tree.levels[1:-1], strict=True):
            kernels.fit_parent_blocks(first, end, tree.lanes, tree.blocks)

    def with_vertex(self, marked):
        """(n,) b1, whether the element in each place has a marked vertex."""
        lanes = np.empty(self.tree.levels[1], np.uint8)
        kernels.flag_moved_lanes(marked, self.tree.nodes, lanes)
        return _each(lanes)

    def in_lanes(self):
        """(n,) b1, whether the element in each place has to be looked at."""
        return _each(self.tree.lanes[: self.tree.levels[1]])


def bare_tree(n, dtype):
    """Blocks, lanes and levels of a `Tree` over n elements, without their boxes."""
    sizes = [-(-max(n, 1) // WIDTH)]
    while sizes[-1] > 1 or len(sizes) == 1:
        sizes.append(-(-sizes[-1] // WIDTH))
    levels = np.concatenate(([0], np.cumsum(sizes)))
    blocks = np.empty((levels[-1], ROWS, WIDTH), dtype)
    for last in levels[1:] - 1:  # lanes with nothing in there: apart from all that is
        blocks[last, [0, 1, 2, 6, 7, 8]] = np.inf
        blocks[last, [3, 4, 5, 9, 10, 11]] = -np.inf
    return blocks, np.zeros(levels[-1], np.uint8), levels


def _each(lanes):
    return np.unpackbits(lanes, bitorder="little").view(bool)


def morton_codes_of(positions, nodes):
    """(n,) i8, where on a Morton curve the mean of each row of nodes lies."""
    codes = np.zeros(len(nodes), np.int64)
    if len(nodes):
        kernels.compute_morton_codes(positions, nodes, *morton_grid(positions), codes)
    return codes


def morton_grid(positions):
    """Origin (3,) [m] and cells per metre of 2^21 cells over the widest extent."""
    low, high = _bounds(positions)
    extent = float((high - low).max())
    return low, 2.0**21 / extent if extent > 0.0 else 0.0


def _bounds(positions):
    """Lowest and highest coordinates, (3,) each; along axis 0 numpy takes 14 times as long."""
    columns = positions.T
    return np.array([c.min() for c in columns]), np.array([c.max() for c in columns])


def vertex_boxes(positions_t0, low_t1, high_t1, dtype=np.float32):
    """(n_vertices, 9), where each vertex starts, and between what it ends."""
    boxes = np.empty((len(positions_t0), 9), dtype)
    if len(boxes):
        kernels.compute_vertex_boxes(positions_t0, low_t1, high_t1, *box_frame(positions_t0), boxes)
    return boxes


def box_frame(positions_t0):
    """Origin (3,) [m] and scale [1/m] of boxes: the centre of the start, and a power of two of
    its extent, so that float32 says most."""
    low, high = _bounds(positions_t0)
    exponent = frexp(float((0.5 * high - 0.5 * low).max()))[1]
    return 0.5 * low + 0.5 * high, ldexp(1.0, min(-exponent, 1000))


# Pairs that each chunk of queries has room for at first: eight for each. Memory that is not
# written to is not taken.
ROOM = 8 * CHUNK


def meeting_pairs(queries: Elements, leaves: Elements):
    """(n, 2) i4, places of a query and a leaf whose boxes meet; no pairs that share a vertex.

    Those that found more than there was room for are searched once more.
    """
    n = -(-len(queries.tree.order) // CHUNK)
    chunks = scattered(n)

    def launch(chunks, starts):
        counts, pairs = np.empty(len(chunks), np.int64), np.empty((starts[-1], 2), np.int32)
        find_pairs(chunks, starts, queries.tree, leaves.tree, queries is leaves, counts, pairs)
        return counts, pairs

    starts = ROOM * np.arange(n + 1)
    counts, pairs = launch(chunks, starts)
    full = counts > ROOM
    pairs = pairs[ranges(starts[:-1], np.where(full, 0, counts))]
    if full.any():
        ends = np.cumsum(counts[full])
        _, more = launch(chunks[full], np.concatenate(([0], ends)))
        pairs = np.concatenate((pairs, more))
    return pairs


def scattered(n):
    """0 ... n - 1 in an order that spreads neighbours over the threads, which take one
    stretch of it each: contacts come in clusters."""
    stride = max(1, round(0.618 * n))
    while gcd(stride, n) > 1:
        stride -= 1
    return np.arange(n) * stride % max(n, 1)
