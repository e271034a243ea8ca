"""Moving boxes of vertices, elements and blocks of a tree; `serial/tree.py` explains the tree."""

import numpy as np

from izo_ref.base.arrays import (
    AnyFloats,
    AnyInt,
    Bits,
    Edges,
    Flags,
    Floats,
    Ints,
    Positions,
    Vec3,
)
from izo_ref.base.compile import compiled
from izo_ref.detection.serial.tree import WIDTH

LARGEST_F4 = 3.0e38  # coordinates are clamped to it, so that float32 does not overflow
CELLS = 2097152  # 2^21 cells along an axis: 63 bits for all three


@compiled
def vertex_box(
    i: int,
    positions_t0: Positions,
    centres: Positions,
    reach: float,
    origin: Floats,
    scale: float,
    boxes_out: AnyFloats,
) -> None:
    """Write the start, the lowest end and the highest end of vertex i to row i of `boxes_out`.

    The vertex ends within its reach about its centre. The bounds are rounded, but a position is a
    float, and rounding keeps the order: so the box holds the position.
    """
    for axis in range(3):
        # each operation rounds monotonically: values in strict order after it were so before it
        a = (positions_t0[i, axis] - origin[axis]) * scale
        b = ((centres[i, axis] - reach) - origin[axis]) * scale
        c = ((centres[i, axis] + reach) - origin[axis]) * scale
        boxes_out[i, axis] = min(max(a, -LARGEST_F4), LARGEST_F4)
        boxes_out[i, axis + 3] = min(max(b, -LARGEST_F4), LARGEST_F4)
        boxes_out[i, axis + 6] = min(max(c, -LARGEST_F4), LARGEST_F4)


@compiled
def bounds(positions: Positions) -> tuple[Vec3, Vec3]:
    """Return the lowest and the highest coordinates of points, of which there is at least one."""
    low, high = positions[0].copy(), positions[0].copy()
    for i in range(positions.shape[0]):
        for axis in range(3):
            low[axis] = min(low[axis], positions[i, axis])
            high[axis] = max(high[axis], positions[i, axis])
    return (low[0], low[1], low[2]), (high[0], high[1], high[2])


@compiled
def bounds_of_edges(positions: Positions, edges: Edges) -> tuple[Vec3, Vec3]:
    """Return the lowest and the highest coordinates of edges, of which there is at least one."""
    low, high = positions[edges[0, 0]].copy(), positions[edges[0, 0]].copy()
    for i in range(edges.shape[0]):
        for k in range(2):
            for axis in range(3):
                low[axis] = min(low[axis], positions[edges[i, k], axis])
                high[axis] = max(high[axis], positions[edges[i, k], axis])
    return (low[0], low[1], low[2]), (high[0], high[1], high[2])


@compiled
def morton_code(
    i: int, positions: Positions, nodes: Ints, origin: Floats, cells_per_m: float
) -> AnyInt:
    """Return the Morton code of the mean of element i's nodes: 21 bits an axis, interleaved."""
    code = np.int64(0)
    for axis in range(3):
        centre = 0.0
        for k in range(nodes.shape[1]):
            centre += positions[nodes[i, k], axis] / nodes.shape[1]
        cell = np.int64((centre - origin[axis]) * cells_per_m)
        cell = min(max(cell, np.int64(0)), np.int64(CELLS - 1))
        # spread the 21 bits, with two zeros before each
        cell = (cell | (cell << 32)) & 0x1F00000000FFFF
        cell = (cell | (cell << 16)) & 0x1F0000FF0000FF
        cell = (cell | (cell << 8)) & 0x100F00F00F00F00F
        cell = (cell | (cell << 4)) & 0x10C30C30C30C30C3
        cell = (cell | (cell << 2)) & 0x1249249249249249
        code = code | (cell << axis)
    return code


@compiled
def moved_lanes_of(block: int, vertex_moved: Flags, nodes: Ints) -> int:
    """Return a mask of the elements of a block that have a moved vertex."""
    first = WIDTH * block
    moved = 0
    for i in range(first, min(first + WIDTH, nodes.shape[0])):
        for k in range(nodes.shape[1]):
            if vertex_moved[nodes[i, k]]:
                moved |= 1 << (i - first)
    return moved


@compiled
def element_block(block: int, vertex_boxes: AnyFloats, nodes: Ints, blocks_out: AnyFloats) -> None:
    """Write the boxes of the elements of a block."""
    first = WIDTH * block
    for i in range(first, min(first + WIDTH, nodes.shape[0])):
        for axis in range(3):
            low_t0, high_t0 = np.inf, -np.inf
            low_t1, high_t1 = np.inf, -np.inf
            for k in range(nodes.shape[1]):
                node = nodes[i, k]
                low_t0 = min(low_t0, vertex_boxes[node, axis])
                high_t0 = max(high_t0, vertex_boxes[node, axis])
                low_t1 = min(low_t1, vertex_boxes[node, axis + 3])
                high_t1 = max(high_t1, vertex_boxes[node, axis + 6])
            blocks_out[block, axis, i - first] = low_t0
            blocks_out[block, axis + 3, i - first] = high_t0
            blocks_out[block, axis + 6, i - first] = low_t1
            blocks_out[block, axis + 9, i - first] = high_t1


@compiled
def parent_block(
    parent: int, first: int, end: int, everything: bool, lanes_out: Bits, blocks_out: AnyFloats
) -> None:
    """Write one block of the level above.

    The level below has the blocks `first` to `end` - 1. Every mark of the block is written. The
    boxes of all its lanes are written if `everything` is set, else those of its marked lanes.
    """
    moved = 0
    for lane in range(min(WIDTH, end - first - WIDTH * parent)):
        child = first + WIDTH * parent + lane
        if lanes_out[child] != 0:
            moved |= 1 << lane
        elif not everything:
            continue
        for row in range(12):
            value = blocks_out[child, row, 0]
            for k in range(1, WIDTH):
                other = blocks_out[child, row, k]
                value = min(value, other) if row % 6 < 3 else max(value, other)
            blocks_out[end + parent, row, lane] = value
    lanes_out[end + parent] = moved
