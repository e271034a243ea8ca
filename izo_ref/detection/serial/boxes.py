"""Moving boxes of vertices, elements and blocks of a tree; `tree.py` says what they are."""

import numpy as np

from izo_ref.base.compile import compiled
from izo_ref.detection.serial.tree import WIDTH

LARGEST_F4 = 3.0e38
CELLS = 2097152  # 2^21 along an axis: 63 bits in all


@compiled
def vertex_box(i, positions_t0, low_t1, high_t1, origin, scale, boxes_out):
    """Start, and lowest and highest end, of vertex i: row i of `boxes_out`."""
    for axis in range(3):
        # each step rounds monotonically: what is in strict order after it was before
        a = (positions_t0[i, axis] - origin[axis]) * scale
        b = (low_t1[i, axis] - origin[axis]) * scale
        c = (high_t1[i, axis] - origin[axis]) * scale
        boxes_out[i, axis] = min(max(a, -LARGEST_F4), LARGEST_F4)
        boxes_out[i, axis + 3] = min(max(b, -LARGEST_F4), LARGEST_F4)
        boxes_out[i, axis + 6] = min(max(c, -LARGEST_F4), LARGEST_F4)


@compiled
def morton_code(i, positions, nodes, origin, cells_per_m):
    """Of the mean of the nodes of element i: 21 bits an axis, interleaved."""
    code = np.int64(0)
    for axis in range(3):
        centre = 0.0
        for k in range(nodes.shape[1]):
            centre += positions[nodes[i, k], axis] / nodes.shape[1]
        cell = np.int64((centre - origin[axis]) * cells_per_m)
        cell = min(max(cell, np.int64(0)), np.int64(CELLS - 1))
        # spread the 21 bits so that two zeros stand before each
        cell = (cell | (cell << 32)) & 0x1F00000000FFFF
        cell = (cell | (cell << 16)) & 0x1F0000FF0000FF
        cell = (cell | (cell << 8)) & 0x100F00F00F00F00F
        cell = (cell | (cell << 4)) & 0x10C30C30C30C30C3
        cell = (cell | (cell << 2)) & 0x1249249249249249
        code = code | (cell << axis)
    return code


@compiled
def moved_lanes_of(block, vertex_moved, nodes):
    """Bit k: a vertex of element k of the block moved."""
    first = WIDTH * block
    moved = 0
    for i in range(first, min(first + WIDTH, nodes.shape[0])):
        for k in range(nodes.shape[1]):
            if vertex_moved[nodes[i, k]]:
                moved |= 1 << (i - first)
    return moved


@compiled
def element_block(block, vertex_boxes, nodes, blocks_out):
    """Boxes of the elements of a block."""
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
def parent_block(parent, first, end, everything, lanes_out, blocks_out):
    """Lanes of a block of the level above that of blocks first..end, and boxes of these or all."""
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
