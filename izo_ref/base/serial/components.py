"""Connected components of impacts, by disjoint sets whose root is their smallest member."""

import numpy as np

from izo_ref.base.arrays import Flags, Indices, Nodes
from izo_ref.base.compile import compiled


@compiled
def find_root(parent: Indices, i: np.int64) -> np.int64:
    """Return the root of i, and shorten the way there: every second node skips its parent."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@compiled
def join_sets(parent: Indices, i: np.int64, j: np.int64) -> None:
    """Join the sets of i and j; the smaller root becomes the root of both.

    So a root depends on the members of its set only, and not on the order in which they joined.
    """
    a = find_root(parent, i)
    b = find_root(parent, j)
    if a < b:
        parent[b] = a
    else:
        parent[a] = b


@compiled
def impact_components(
    nodes: Nodes,  # (n_impacts, 4) i4
    pinned: Flags,  # (n_vertices,) b1
    parent: Indices,  # (n_vertices,) i8, work space
    component_out: Indices,  # (n_impacts,) i8, smallest unpinned vertex of it; -1 if all are pinned
) -> None:
    """Give one number to impacts that share an unpinned vertex, directly or through others."""
    for i in range(len(parent)):
        parent[i] = i
    for j in range(nodes.shape[0]):
        # `first` and `vertex` have one type, so that the functions are compiled only once
        first = np.int64(-1)
        for k in range(4):
            vertex = np.int64(nodes[j, k])
            if not pinned[vertex]:
                if first >= 0:
                    join_sets(parent, first, vertex)
                first = vertex
    for j in range(nodes.shape[0]):
        component_out[j] = -1
        for k in range(4):
            if not pinned[nodes[j, k]]:
                component_out[j] = find_root(parent, np.int64(nodes[j, k]))
