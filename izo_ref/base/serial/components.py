"""Connected components of impacts, by disjoint sets with the smallest index as root."""

import numpy as np

from izo_ref.base.compile import compiled


@compiled
def find_root(parent, i):
    """Root of i; every second node on the way is hung one higher."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@compiled
def join_sets(parent, i, j):
    """The smaller root becomes the root of both, so roots depend on nothing but the sets."""
    a = find_root(parent, i)
    b = find_root(parent, j)
    if a < b:
        parent[b] = a
    else:
        parent[a] = b


@compiled
def impact_components(
    nodes,  # (n_impacts, 4) i4
    pinned,  # (n_vertices,) b1
    parent,  # (n_vertices,) i8, work space
    component_out,  # (n_impacts,) i8, the smallest unpinned vertex joined, -1 if all pinned
):
    """Impacts that share an unpinned vertex, directly or through others, get one number."""
    for i in range(len(parent)):
        parent[i] = i
    for j in range(nodes.shape[0]):
        first = np.int64(-1)  # typed, as `vertex`: else each would be compiled for
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
