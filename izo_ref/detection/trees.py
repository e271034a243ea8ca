"""Broad phase on the CPU: trees of elements, and the pairs of elements whose moving boxes meet."""

from functools import lru_cache
from math import frexp, gcd, ldexp
from typing import TypeAlias

import numpy as np
from numpy.typing import DTypeLike

from izo_ref.base.arrays import (
    AnyFloats,
    Bits,
    Edges,
    Faces,
    Flags,
    Floats,
    Indices,
    Ints,
    Offsets,
    Positions,
)
from izo_ref.base.deadline import UNLIMITED, Deadline
from izo_ref.base.records import TreeOrders
from izo_ref.detection.cpu import tree as kernels
from izo_ref.detection.cpu.contacts import CHUNK, FEW_CHUNKS, find_pairs
from izo_ref.detection.serial.boxes import bounds, bounds_of_edges
from izo_ref.detection.serial.mesh import renumbered_rows, sort_rows
from izo_ref.detection.serial.near import pack_pairs
from izo_ref.detection.serial.tree import ROWS, WIDTH, Tree

# Pairs for which each chunk of queries has room at first: eight for each query. Memory that is
# never written to is not taken.
ROOM = 8 * CHUNK

# A block of boxes whose minima are infinite and whose maxima are minus infinity.
NOTHING = np.repeat([np.inf, -np.inf, np.inf, -np.inf], ROWS // 4)[:, None]

# The origin (3,) [m] and the scale [1/m] of the coordinates of boxes.
BoxFrame: TypeAlias = tuple[Floats, float]


class Elements:
    """Elements of one kind (vertices, edges or faces), sorted in space, in a tree of boxes.

    Each element has a place in the tree.

    Args:
        nodes: (n, k) i4, vertices of all elements of this kind.
        order: (m,) i4, the elements that enter the tree, sorted in space (`tree_orders`).
        dtype: Type of the boxes, f4 or f8.

    Attributes:
        tree: `Tree`.
    """

    def __init__(self, nodes: Ints, order: Ints, dtype: DTypeLike = np.float32) -> None:
        """Make the tree with empty boxes."""
        self.tree = Tree(order, nodes.take(order, axis=0), *bare_tree(len(order), dtype))

    def refit(self, vertex_boxes: AnyFloats, vertex_moved: Flags, everything: bool) -> None:
        """Mark the elements with a moved vertex, and fit boxes and those above them.

        Args:
            vertex_boxes: (n_vertices, 9), of `VertexBoxes`.
            vertex_moved: (n_vertices,) b1.
            everything: Whether to fit the boxes of all elements, or only of those that are marked.
        """
        tree = self.tree
        kernels.fit_tree(
            vertex_moved, vertex_boxes, everything, tree.nodes, tree.levels, tree.lanes, tree.blocks
        )


def tree_orders(positions: Positions, edges: Edges, faces: Faces) -> TreeOrders:
    """Sort the vertices of a mesh along a Morton curve, and its edges and faces by their vertices.

    Args:
        positions: (n_vertices, 3) f8 [m].
        edges: (n_edges, 2) i4.
        faces: (n_faces, 3) i4.
    """
    vertices = np.arange(len(positions), dtype=np.int32)[:, None]
    order = np.argsort(morton_codes_of(positions, vertices)).astype(np.int32)
    place = np.empty(len(order), np.int32)
    place[order] = vertices[:, 0]
    edge_rows, face_rows = (
        renumbered_rows(place, nodes, np.arange(len(nodes), dtype=np.int32))
        for nodes in (edges, faces)
    )
    return order, sort_rows(edge_rows, len(order)), sort_rows(face_rows, len(order))


def bare_tree(n: int, dtype: DTypeLike) -> tuple[AnyFloats, Bits, Offsets]:
    """Return the blocks, lanes and levels of a `Tree` over n elements; the boxes are not set."""
    levels = _levels(n)
    blocks = np.empty((levels[-1], ROWS, WIDTH), dtype)
    blocks[levels[1:] - 1] = NOTHING  # so empty lanes hold boxes that meet nothing
    return blocks, np.zeros(levels[-1], np.uint8), levels


@lru_cache(maxsize=64)
def _levels(n: int) -> Offsets:
    """Return the levels of a `Tree` over n elements; the result is kept, so it must not be changed.

    In small steps, making it takes longer than fitting the boxes.
    """
    sizes = [-(-max(n, 1) // WIDTH)]
    while sizes[-1] > 1 or len(sizes) == 1:
        sizes.append(-(-sizes[-1] // WIDTH))
    return np.concatenate(([0], np.cumsum(sizes)))


def morton_codes_of(positions: Positions, nodes: Ints) -> Indices:
    """Return the place on a Morton curve of the mean of the nodes in each row, (n,) i8."""
    codes = np.zeros(len(nodes), np.int64)
    if len(nodes):
        kernels.compute_morton_codes(positions, nodes, *morton_grid(positions), codes)
    return codes


def morton_grid(positions: Positions) -> tuple[Floats, float]:
    """Return the origin (3,) [m] and the cells per metre of the grid of a Morton curve.

    The grid has 2^21 cells over the widest extent.
    """
    low, high = bounds(positions)
    extent = max(b - a for a, b in zip(low, high, strict=True))
    return np.array(low), 2.0**21 / extent if extent > 0.0 else 0.0


class VertexBoxes:
    """The start of each vertex and the box in which it ends, without unit.

    Args:
        positions_t0: (n_vertices, 3) f8 [m], start.
        centres: (n_vertices, 3) f8 [m], about which the vertices end.
        reach: (n_vertices,) f8 [m], how far from their centres they may end, along each axis.
        dtype: f4 or f8.
        edges: (n_edges, 2) i4, of the mesh whose extent sets the scale; None for all vertices.

    Attributes:
        boxes: (n_vertices, 9): start, lowest end, highest end.
    """

    def __init__(
        self,
        positions_t0: Positions,
        centres: Positions,
        reach: Floats,
        dtype: DTypeLike = np.float32,
        edges: Edges | None = None,
    ) -> None:
        """Compute all boxes."""
        self.boxes: AnyFloats = np.empty((len(positions_t0), 9), dtype)
        self._known = positions_t0, centres, reach
        if len(positions_t0):
            self._frame = box_frame(positions_t0, edges)
            self.refit(np.ones(len(positions_t0), bool))

    def refit(self, moved: Flags) -> None:
        """Compute the boxes of some vertices again, whose centre or reach was changed in place.

        Args:
            moved: (n_vertices,) b1.
        """
        kernels.compute_vertex_boxes(moved, *self._known, *self._frame, self.boxes)


def box_frame(positions_t0: Positions, edges: Edges | None = None) -> BoxFrame:
    """Return the origin (3,) [m] and the scale [1/m] of the coordinates of boxes.

    The origin is the centre of the start of the mesh, and the scale is a power of two that brings
    its extent near 1. So float32 keeps as much of the coordinates as it can. Vertices without an
    edge have no say: one far out would make all others fall together, and all pairs candidates.
    """
    if edges is None or len(edges) == 0:
        low, high = bounds(positions_t0)
    else:
        low, high = bounds_of_edges(positions_t0, edges)
    exponent = frexp(max(0.5 * b - 0.5 * a for a, b in zip(low, high, strict=True)))[1]
    origin = [0.5 * a + 0.5 * b for a, b in zip(low, high, strict=True)]
    return np.array(origin), ldexp(1.0, min(-exponent, 1000))


def meeting_pairs(queries: Elements, leaves: Elements, deadline: Deadline = UNLIMITED) -> Ints:
    """Find the pairs of a query and a leaf whose moving boxes meet, one of them marked.

    Pairs that share a vertex are left out. A chunk of queries that finds more pairs than it has
    room for is searched once more.

    Args:
        queries: Vertices or edges.
        leaves: Faces or edges; for edges the same object as `queries`, and each pair comes once.
        deadline: When the search has to end.

    Returns:
        (n, 2) i4, places of the query and the leaf.
    """
    n = -(-len(queries.tree.order) // CHUNK)
    chunks, starts = scattered(n), _rooms(n)

    def launch(chunks: Indices, starts: Offsets) -> tuple[Indices, Ints]:
        counts, pairs = np.empty(len(chunks), np.int64), np.empty((starts[-1], 2), np.int32)
        for part in deadline.slices(range(len(chunks))):
            find_pairs.where_it_pays(
                FEW_CHUNKS,
                part,
                chunks,
                starts,
                queries.tree,
                leaves.tree,
                queries is leaves,
                counts,
                pairs,
            )
        return counts, pairs

    counts, pairs = launch(chunks, starts)
    pairs, n_full = pack_pairs(ROOM, counts, pairs)
    if n_full:
        full = counts > ROOM
        _, more = launch(chunks[full], np.concatenate(([0], np.cumsum(counts[full]))))
        pairs = np.concatenate((pairs, more))
    return pairs


@lru_cache(maxsize=64)
def _rooms(n: int) -> Offsets:
    """Return where the room of each of n chunks begins, and where the last one ends.

    The result is kept, so it must not be changed.
    """
    return ROOM * np.arange(n + 1)


@lru_cache(maxsize=64)
def scattered(n: int) -> Indices:
    """Return 0 to n - 1 in an order that spreads neighbours over the threads.

    Each thread takes a contiguous part of the result. Contacts come in clusters, so neighbours in
    one part would make that thread finish last. The result is kept, so it must not be changed: in
    small steps, making it takes as long as a launch.
    """
    stride = max(1, round(0.618 * n))
    while gcd(stride, n) > 1:
        stride -= 1
    return np.arange(n) * stride % max(n, 1)
