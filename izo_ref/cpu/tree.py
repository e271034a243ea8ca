"""Boxes of elements, and trees over them."""

import numpy as np
from numba import prange

from izo_ref._jit import light_kernel
from izo_ref.serial.tree import GROUP


@light_kernel
def element_boxes(
    # In:
    positions_t0,  # (n_vertices, 3) f8  [m]
    positions_t1,  # (n_vertices, 3) f8  [m]
    nodes,  # (n_elements, k) i4
    # Out:
    boxes_out,  # (n_elements, 6) f8  [m], minima then maxima over both ends of the path
):
    for i in prange(nodes.shape[0]):
        for axis in range(3):
            low = np.inf
            high = -np.inf
            for k in range(nodes.shape[1]):
                a = positions_t0[nodes[i, k], axis]
                b = positions_t1[nodes[i, k], axis]
                low = min(low, min(a, b))
                high = max(high, max(a, b))
            boxes_out[i, axis] = low
            boxes_out[i, axis + 3] = high


@light_kernel
def element_moved(
    # In:
    vertex_moved,  # (n_vertices,) b1
    nodes,  # (n_elements, k) i4
    # Out:
    moved_out,  # (n_elements,) b1
):
    for i in prange(nodes.shape[0]):
        moved = False
        for k in range(nodes.shape[1]):
            moved = moved or vertex_moved[nodes[i, k]]
        moved_out[i] = moved


@light_kernel
def morton_codes(
    # In:
    boxes,  # (n, 6) f8  [m]
    origin,  # (3,) f8  [m]
    cells_per_m,  # f8  [1/m], 2^21 cells over the widest extent
    # Out:
    codes_out,  # (n,) i8, 21 bits an axis, interleaved
):
    for i in prange(boxes.shape[0]):
        code = np.int64(0)
        for axis in range(3):
            centre = 0.5 * boxes[i, axis] + 0.5 * boxes[i, axis + 3]
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
def leaf_groups(
    # In:
    leaf_boxes,  # (n_leaves, 6) f8  [m]
    leaf_moved,  # (n_leaves,) b1
    # Out:
    boxes_out,  # (2 P, 6) f8  [m], rows P.. are written; an empty group meets nothing
    moved_out,  # (2 P,) b1
):
    first = boxes_out.shape[0] // 2
    for group in prange(first):
        for axis in range(3):
            boxes_out[first + group, axis] = np.inf
            boxes_out[first + group, axis + 3] = -np.inf
        moved_out[first + group] = False
        for leaf in range(group * GROUP, min((group + 1) * GROUP, leaf_boxes.shape[0])):
            moved_out[first + group] = moved_out[first + group] or leaf_moved[leaf]
            for axis in range(3):
                low = min(boxes_out[first + group, axis], leaf_boxes[leaf, axis])
                high = max(boxes_out[first + group, axis + 3], leaf_boxes[leaf, axis + 3])
                boxes_out[first + group, axis] = low
                boxes_out[first + group, axis + 3] = high


@light_kernel
def parent_nodes(
    # In:
    begin,  # i8, first node of the level; the level ends at 2 * begin
    # Out:
    boxes_out,  # (2 P, 6) f8  [m], rows of the level are written from those of the next
    moved_out,  # (2 P,) b1
):
    for k in prange(begin):
        node = begin + k
        moved_out[node] = moved_out[2 * node] or moved_out[2 * node + 1]
        for axis in range(3):
            boxes_out[node, axis] = min(boxes_out[2 * node, axis], boxes_out[2 * node + 1, axis])
            boxes_out[node, axis + 3] = max(
                boxes_out[2 * node, axis + 3], boxes_out[2 * node + 1, axis + 3]
            )
