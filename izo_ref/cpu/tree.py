"""Boxes of elements, and trees over them."""

import numpy as np
from numba import prange

from izo_ref._jit import light_kernel
from izo_ref.serial.tree import WIDTH

LARGEST_F4 = 3.0e38


@light_kernel
def vertex_boxes(
    # In:
    positions_t0,  # (n_vertices, 3) f8  [m]
    low_t1,  # (n_vertices, 3) f8  [m], between these the vertex ends
    high_t1,  # (n_vertices, 3) f8  [m]
    origin,  # (3,) f8  [m]
    scale,  # f8  [1/m], a power of two
    # Out:
    boxes_out,  # (n_vertices, 9) f4, start, then lowest and highest end; without unit
):
    for i in prange(positions_t0.shape[0]):
        for axis in range(3):
            # each step rounds monotonically: what is in strict order after it was before
            a = (positions_t0[i, axis] - origin[axis]) * scale
            b = (low_t1[i, axis] - origin[axis]) * scale
            c = (high_t1[i, axis] - origin[axis]) * scale
            boxes_out[i, axis] = min(max(a, -LARGEST_F4), LARGEST_F4)
            boxes_out[i, axis + 3] = min(max(b, -LARGEST_F4), LARGEST_F4)
            boxes_out[i, axis + 6] = min(max(c, -LARGEST_F4), LARGEST_F4)


@light_kernel
def morton_codes(
    # In:
    positions,  # (n_vertices, 3) f8  [m]
    nodes,  # (n, k) i4
    origin,  # (3,) f8  [m]
    cells_per_m,  # f8  [1/m], 2^21 cells over the widest extent
    # Out:
    codes_out,  # (n,) i8, of the mean of the nodes: 21 bits an axis, interleaved
):
    for i in prange(nodes.shape[0]):
        code = np.int64(0)
        for axis in range(3):
            centre = 0.0
            for k in range(nodes.shape[1]):
                centre += positions[nodes[i, k], axis] / nodes.shape[1]
            cell = np.int64((centre - origin[axis]) * cells_per_m)
            cell = min(max(cell, np.int64(0)), np.int64(2097151))
            # spread the 21 bits so that two zeros stand before each
            cell = (cell | (cell << 32)) & 0x1F00000000FFFF
            cell = (cell | (cell << 16)) & 0x1F0000FF0000FF
            cell = (cell | (cell << 8)) & 0x100F00F00F00F00F
            cell = (cell | (cell << 4)) & 0x10C30C30C30C30C3
            cell = (cell | (cell << 2)) & 0x1249249249249249
            code = code | (cell << axis)
        codes_out[i] = code


@light_kernel
def moved_lanes(
    # In:
    vertex_moved,  # (n_vertices,) b1
    nodes,  # (n_elements, k) i4
    # Out:
    lanes_out,  # (>= n_blocks,) u1, bit k: a vertex of element k of the block moved
):
    for block in prange((nodes.shape[0] + WIDTH - 1) // WIDTH):
        first = WIDTH * block
        moved = 0
        for i in range(first, min(first + WIDTH, nodes.shape[0])):
            for k in range(nodes.shape[1]):
                if vertex_moved[nodes[i, k]]:
                    moved |= 1 << (i - first)
        lanes_out[block] = moved


@light_kernel
def element_blocks(
    # In:
    vertex_boxes,  # (n_vertices, 9) f4
    nodes,  # (n_elements, k) i4
    lanes,  # (>= n_blocks,) u1
    # Out:
    blocks_out,  # (>= n_blocks, ROWS, WIDTH) f4, blocks that have lanes are written
):
    for block in prange((nodes.shape[0] + WIDTH - 1) // WIDTH):
        if lanes[block] == 0:
            continue
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


@light_kernel
def parent_blocks(
    # In:
    first,  # i8, the first block of the level
    end,  # i8, behind its last one; the level above begins there
    # Out:
    lanes_out,  # (m,) u1
    blocks_out,  # (m, ROWS, WIDTH) f4
):
    for parent in prange((end - first + WIDTH - 1) // WIDTH):
        moved = 0
        for lane in range(min(WIDTH, end - first - WIDTH * parent)):
            child = first + WIDTH * parent + lane
            if lanes_out[child] == 0:
                continue
            moved |= 1 << lane
            for row in range(12):
                value = blocks_out[child, row, 0]
                for k in range(1, WIDTH):
                    other = blocks_out[child, row, k]
                    value = min(value, other) if row % 6 < 3 else max(value, other)
                blocks_out[end + parent, row, lane] = value
        lanes_out[end + parent] = moved
