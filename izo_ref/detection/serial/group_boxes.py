"""Fit the boxes of a path and of three trees above them by the threads of a group.

Every path has new boxes, so all boxes are written. On the CPU (`cpu/tree.py`) boxes that did not
change are kept, and each tree is fitted by itself.
"""

import numpy as np

from izo_ref.base.arrays import AnyFloats, Flags, Indices, Offsets, Positions
from izo_ref.base.compile import compiled
from izo_ref.base.serial.thread_group import ThreadGroup, group_sum
from izo_ref.detection.serial.boxes import (
    element_block,
    moved_lanes_of,
    parent_block,
    vertex_box,
)
from izo_ref.detection.serial.found_counts import MOVED
from izo_ref.detection.serial.records import PathArrays
from izo_ref.detection.serial.tree import Tree


@compiled
def differs(a: Positions, b: Positions, i: int) -> bool:
    """Return whether row i of two arrays of points differs."""
    return a[i, 0] != b[i, 0] or a[i, 1] != b[i, 1] or a[i, 2] != b[i, 2]


@compiled
def _size_of_level(levels: Offsets, level: int) -> int:
    """Return the number of blocks in a level of a tree; 0 if the tree has no such level."""
    return levels[level + 1] - levels[level] if level + 1 < levels.shape[0] else 0


@compiled
def _size_of_levels(level: int, first: Tree, second: Tree, third: Tree) -> int:
    """Return the number of blocks in a level of three trees."""
    return (
        _size_of_level(first.levels, level)
        + _size_of_level(second.levels, level)
        + _size_of_level(third.levels, level)
    )


@compiled
def _block_of_trees(k: int, level: int, first: Tree, second: Tree, third: Tree) -> tuple[Tree, int]:
    """Return the tree of the k-th block in a level of three trees, and its number in that level."""
    size = _size_of_level(first.levels, level)
    if k < size:
        return first, k
    k -= size
    size = _size_of_level(second.levels, level)
    return (second, k) if k < size else (third, k - size)


@compiled
def _count_and_box_vertices(
    group: ThreadGroup, path: PathArrays, at_rest: bool, boxes_out: AnyFloats, moved_out: Flags
) -> int:
    """Write the boxes and marks of vertices; count those that end elsewhere than before."""
    n_new = 0
    for i in range(group.rank(), moved_out.shape[0], group.size()):
        vertex_box(i, path.start, path.end, 0.0, path.frame, path.frame[3], boxes_out)
        moved_out[i] = at_rest or differs(path.start, path.end, i)
        n_new += differs(path.seen, path.end, i)
    return n_new


@compiled
def fit_boxes(
    group: ThreadGroup,
    path: PathArrays,
    at_rest: bool,
    vertices_out: Tree,
    edges_out: Tree,
    faces_out: Tree,
    boxes_out: AnyFloats,
    moved_out: Flags,
    counts_out: Indices,
) -> None:
    """Fit all boxes, mark the elements with a moved vertex, and begin the counts of a detection.

    The group waits once a level. It does not wait at the end.

    Args:
        group: The threads.
        path: The path.
        at_rest: Whether pairs at rest are wanted too; then all vertices are marked as moved.
        vertices_out: Tree of the vertices; its blocks and lanes are written.
        edges_out: Tree of the edges.
        faces_out: Tree of the faces.
        boxes_out: (n_vertices, 9) f4: start, lowest end, highest end; without unit.
        moved_out: (n_vertices,) b1, start and end differ, or pairs at rest are wanted.
        counts_out: (N_COUNTS,) i8; MOVED is counted, and the other counts become 0.
    """
    first = group.rank() == 0
    for k in range(group.rank(), counts_out.shape[0], group.size()):
        counts_out[k] = 0
    own = path, at_rest, boxes_out, moved_out
    n_new = group_sum(group, float(_count_and_box_vertices(group, *own)))
    if first:
        counts_out[MOVED] = np.int64(n_new)
    trees = vertices_out, edges_out, faces_out
    for k in range(group.rank(), _size_of_levels(0, *trees), group.size()):
        tree, block = _block_of_trees(k, 0, *trees)
        tree.lanes[block] = moved_lanes_of(block, moved_out, tree.nodes)
        element_block(block, boxes_out, tree.nodes, tree.blocks)
    level, size = 1, _size_of_levels(1, *trees)
    while size > 0:
        group.wait()
        for k in range(group.rank(), size, group.size()):
            tree, parent = _block_of_trees(k, level, *trees)
            begin, end = tree.levels[level - 1], tree.levels[level]
            parent_block(parent, begin, end, True, tree.lanes, tree.blocks)
        level += 1
        size = _size_of_levels(level, *trees)
