"""Boxes of elements, and trees over them: vertices, edges and faces in one launch.

Every path has its boxes anew, so all are written, and a tree has few blocks in most levels, so
that one by one would be many launches of little (`reports/cuda/` counts them). On the processor
(`detection/cpu/tree.py`) boxes that did not change are left, a tree at a time.
"""

from numba import cuda

from izo_ref.base.cuda.compile import cuda_kernel, device_function
from izo_ref.detection.serial.boxes import (
    element_block,
    morton_code,
    moved_lanes_of,
    parent_block,
    vertex_box,
)


@cuda_kernel
def compute_morton_codes(
    # In:
    positions,  # (n_vertices, 3) f8  [m]
    nodes,  # (n, k) i4
    origin,  # (3,) f8  [m]
    cells_per_m,  # f8  [1/m], 2^21 cells over the widest extent
    # Out:
    codes_out,  # (n,) i8, of the mean of the nodes: 21 bits an axis, interleaved
):
    i = cuda.grid(1)
    if i < nodes.shape[0]:
        codes_out[i] = morton_code(i, positions, nodes, origin, cells_per_m)


@cuda_kernel
def compute_path_boxes(
    # In:
    positions_t0,  # (n_vertices, 3) f8  [m]
    positions_t1,  # (n_vertices, 3) f8  [m]
    origin,  # (3,) f8  [m]
    scale,  # f8  [1/m], a power of two
    # Out:
    boxes_out,  # (n_vertices, 9) f4, start, then lowest and highest end; without unit
    moved_out,  # (n_vertices,) b1, the two ends differ
):
    i = cuda.grid(1)
    if i < positions_t0.shape[0]:
        vertex_box(i, positions_t0, positions_t1, positions_t1, origin, scale, boxes_out)
        moved_out[i] = differs(positions_t0, positions_t1, i)


@device_function
def differs(a, b, i):
    """Whether row i of two arrays of points does."""
    return a[i, 0] != b[i, 0] or a[i, 1] != b[i, 1] or a[i, 2] != b[i, 2]


@cuda_kernel
def fit_element_boxes(
    # In:
    vertex_boxes,  # (n_vertices, 9) f4
    vertex_moved,  # (n_vertices,) b1
    # Out:
    vertices_out,  # Tree, boxes of elements, and lanes of those with a vertex that moved
    edges_out,  # Tree
    faces_out,  # Tree
):
    tree, block = block_of_trees(cuda.grid(1), 0, vertices_out, edges_out, faces_out)
    if block >= 0:
        tree.lanes[block] = moved_lanes_of(block, vertex_moved, tree.nodes)
        element_block(block, vertex_boxes, tree.nodes, tree.blocks)


@cuda_kernel
def fit_parent_boxes(
    # In:
    level,  # i8, 1 or higher
    # Out:
    vertices_out,  # Tree, boxes and lanes of the blocks of the level
    edges_out,  # Tree
    faces_out,  # Tree
):
    tree, parent = block_of_trees(cuda.grid(1), level, vertices_out, edges_out, faces_out)
    if parent >= 0:
        first, end = tree.levels[level - 1], tree.levels[level]
        parent_block(parent, first, end, True, tree.lanes, tree.blocks)


@device_function
def block_of_trees(k, level, first, second, third):
    """The tree of the k-th block of a level of the three, and its number there; -1: none."""
    size = size_of_level(first.levels, level)
    if k < size:
        return first, k
    k -= size
    size = size_of_level(second.levels, level)
    if k < size:
        return second, k
    k -= size
    return third, k if k < size_of_level(third.levels, level) else -1


@device_function
def size_of_level(levels, level):
    """Blocks of a level of a tree; 0 if it has none."""
    return levels[level + 1] - levels[level] if level + 1 < levels.shape[0] else 0
