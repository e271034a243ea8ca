"""Fit the boxes of a path and of the trees above them, and query them.

A wait of all blocks takes 1.3 us on an H200, and most levels of a tree have few blocks. So one
launch fits all levels of all trees.
"""

# The types of numba-cuda say that `cuda.grid` takes other arguments than it does.
# pyright: reportCallIssue=false

from numba import cuda

from izo_ref.base.arrays import AnyFloats, Flags, Floats, Indices, Ints
from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.base.cuda.thread_group import block, grid
from izo_ref.base.serial.thread_group import group_sum
from izo_ref.detection.serial.found_counts import VERTEX_FACE_PAIRS
from izo_ref.detection.serial.group_boxes import fit_boxes
from izo_ref.detection.serial.query import append_edge_faces, append_pairs
from izo_ref.detection.serial.records import PathArrays
from izo_ref.detection.serial.tree import Tree


@cuda_kernel
def fit_trees(
    # In:
    path: PathArrays,  # PathArrays
    at_rest: bool,  # b1, mark all elements, because pairs at rest are wanted too
    # Out:
    vertices_out: Tree,  # Tree, boxes of the elements, and marks of those with a moved vertex
    edges_out: Tree,  # Tree
    faces_out: Tree,  # Tree
    boxes_out: AnyFloats,  # (n_vertices, 9) f4, start, lowest end, highest end; without unit
    moved_out: Flags,  # (n_vertices,) b1, start and end differ, or pairs at rest are wanted
    counts_out: Indices,  # (n_counts,) i8, 0 but for the vertices that ended elsewhere before
    parts_out: Floats,  # (n_blocks, 7) f8, zeros at first, work space
) -> None:
    """Fit all boxes of a path, mark the elements that move, and begin the counts of a detection."""
    trees = vertices_out, edges_out, faces_out
    fit_boxes(grid(parts_out), path, at_rest, *trees, boxes_out, moved_out, counts_out)


@cuda_kernel
def list_pairs(
    # In:
    vertices: Tree,  # Tree
    edges: Tree,  # Tree
    faces: Tree,  # Tree
    # Out:
    counts_out: Indices,  # (n_counts,) i8, the counts of pairs are added to
    pairs_out: Ints,  # (n, 2) i4, places of the elements of each pair, of detection/serial/query.py
) -> None:
    """List the vertex-face and edge-edge pairs whose moving boxes meet, as far as there is room."""
    # the threads of all blocks append to the list, and never wait for each other
    own = append_pairs(grid(None), vertices, edges, faces, counts_out, pairs_out)
    count = group_sum(block(), float(own))
    if cuda.threadIdx.x == 0:
        cuda.atomic.add(counts_out, VERTEX_FACE_PAIRS, int(count))


@cuda_kernel
def list_edge_faces(
    # In:
    edges: Tree,  # Tree
    faces: Tree,  # Tree
    # Out:
    counts_out: Indices,  # (n_counts,) i8, the count of pairs is added to
    pairs_out: Ints,  # (n, 2) i4, places of the edge and the face of each pair
) -> None:
    """List the edges and faces whose moving boxes meet, as far as there is room."""
    append_edge_faces(grid(None), edges, faces, counts_out, pairs_out)
