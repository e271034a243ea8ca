"""Boxes of elements, and trees over them."""

from numba import prange

from izo_ref.base.compile import light_kernel
from izo_ref.detection.serial.boxes import (
    element_block,
    morton_code,
    moved_lanes_of,
    parent_block,
    vertex_box,
)
from izo_ref.detection.serial.tree import WIDTH


@light_kernel
def compute_vertex_boxes(
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
        vertex_box(i, positions_t0, low_t1, high_t1, origin, scale, boxes_out)


@light_kernel
def compute_morton_codes(
    # In:
    positions,  # (n_vertices, 3) f8  [m]
    nodes,  # (n, k) i4
    origin,  # (3,) f8  [m]
    cells_per_m,  # f8  [1/m], 2^21 cells over the widest extent
    # Out:
    codes_out,  # (n,) i8, of the mean of the nodes: 21 bits an axis, interleaved
):
    for i in prange(nodes.shape[0]):
        codes_out[i] = morton_code(i, positions, nodes, origin, cells_per_m)


@light_kernel
def flag_moved_lanes(
    # In:
    vertex_moved,  # (n_vertices,) b1
    nodes,  # (n_elements, k) i4
    # Out:
    lanes_out,  # (>= n_blocks,) u1, bit k: a vertex of element k of the block moved
):
    for block in prange((nodes.shape[0] + WIDTH - 1) // WIDTH):
        lanes_out[block] = moved_lanes_of(block, vertex_moved, nodes)


@light_kernel
def fit_element_blocks(
    # In:
    vertex_boxes,  # (n_vertices, 9) f4
    nodes,  # (n_elements, k) i4
    lanes,  # (>= n_blocks,) u1
    # Out:
    blocks_out,  # (>= n_blocks, ROWS, WIDTH) f4, blocks that have lanes are written
):
    for block in prange((nodes.shape[0] + WIDTH - 1) // WIDTH):
        if lanes[block] != 0:
            element_block(block, vertex_boxes, nodes, blocks_out)


@light_kernel
def fit_parent_blocks(
    # In:
    first,  # i8, the first block of the level
    end,  # i8, behind its last one; the level above begins there
    # Out:
    lanes_out,  # (m,) u1
    blocks_out,  # (m, ROWS, WIDTH) f4
):
    for parent in prange((end - first + WIDTH - 1) // WIDTH):
        parent_block(parent, first, end, False, lanes_out, blocks_out)
