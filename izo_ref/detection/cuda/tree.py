"""Fit the boxes of vertices, edges and faces and of the trees over them, in one launch a level.

Every path has new boxes, so all boxes are written. Most levels of a tree have few blocks, so a
launch for each tree would mean many launches with little work (`reports/cuda/` counts them). On the
CPU (`detection/cpu/tree.py`) boxes that did not change are kept, and each tree has its own launch.
"""

# The types of numba-cuda say that `cuda.grid` takes other arguments than it does.
# pyright: reportCallIssue=false

from numba import cuda

from izo_ref.base.arrays import AnyFloats, Flags, Floats, Indices, Ints, Offsets, Positions
from izo_ref.base.cuda.compile import cuda_kernel, device_function
from izo_ref.detection.serial.boxes import (
    element_block,
    morton_code,
    moved_lanes_of,
    parent_block,
    vertex_box,
)
from izo_ref.detection.serial.tree import Tree


@cuda_kernel
def compute_morton_codes(
    # In:
    positions: Positions,  # (n_vertices, 3) f8  [m]
    nodes: Ints,  # (n, k) i4
    origin: Floats,  # (3,) f8  [m]
    cells_per_m: float,  # f8  [1/m], 2^21 cells over the widest extent
    # Out:
    codes_out: Indices,  # (n,) i8, of the mean of the nodes: 21 bits an axis, interleaved
) -> None:
    """Compute the Morton code of each element."""
    i = cuda.grid(1)
    if i < nodes.shape[0]:
        codes_out[i] = morton_code(i, positions, nodes, origin, cells_per_m)


@cuda_kernel
def compute_path_boxes(
    # In:
    positions_t0: Positions,  # (n_vertices, 3) f8  [m]
    positions_t1: Positions,  # (n_vertices, 3) f8  [m]
    origin: Floats,  # (3,) f8  [m]
    scale: float,  # f8  [1/m], a power of two
    # Out:
    boxes_out: AnyFloats,  # (n_vertices, 9) f4, start, lowest end, highest end; without unit
    moved_out: Flags,  # (n_vertices,) b1, start and end differ
) -> None:
    """Compute the start and the end of each vertex in the coordinates of boxes."""
    i = cuda.grid(1)
    if i < positions_t0.shape[0]:
        vertex_box(i, positions_t0, positions_t1, 0.0, origin, scale, boxes_out)
        moved_out[i] = differs(positions_t0, positions_t1, i)


@device_function
def differs(a: Positions, b: Positions, i: int) -> bool:
    """Return whether row i of two arrays of points differs."""
    return a[i, 0] != b[i, 0] or a[i, 1] != b[i, 1] or a[i, 2] != b[i, 2]


@cuda_kernel
def fit_element_boxes(
    # In:
    vertex_boxes: AnyFloats,  # (n_vertices, 9) f4
    vertex_moved: Flags,  # (n_vertices,) b1
    # Out:
    vertices_out: Tree,  # Tree, boxes of the elements, and marks of those with a moved vertex
    edges_out: Tree,  # Tree
    faces_out: Tree,  # Tree
) -> None:
    """Fit the boxes of all elements of three trees, and mark the elements that moved."""
    tree, block = block_of_trees(cuda.grid(1), 0, vertices_out, edges_out, faces_out)
    if block >= 0:
        tree.lanes[block] = moved_lanes_of(block, vertex_moved, tree.nodes)
        element_block(block, vertex_boxes, tree.nodes, tree.blocks)


@cuda_kernel
def fit_parent_boxes(
    # In:
    level: int,  # i8, 1 or higher
    # Out:
    vertices_out: Tree,  # Tree, boxes and marks of the blocks of the level
    edges_out: Tree,  # Tree
    faces_out: Tree,  # Tree
) -> None:
    """Fit the boxes of one level of three trees, and pass the marks up."""
    tree, parent = block_of_trees(cuda.grid(1), level, vertices_out, edges_out, faces_out)
    if parent >= 0:
        first, end = tree.levels[level - 1], tree.levels[level]
        parent_block(parent, first, end, True, tree.lanes, tree.blocks)


@device_function
def block_of_trees(k: int, level: int, first: Tree, second: Tree, third: Tree) -> tuple[Tree, int]:
    """Return the tree of the k-th block in a level of three trees, and its number in that tree.

    The number is -1 if there is no such block.
    """
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
def size_of_level(levels: Offsets, level: int) -> int:
    """Return the number of blocks in a level of a tree; 0 if the tree has no such level."""
    return levels[level + 1] - levels[level] if level + 1 < levels.shape[0] else 0
