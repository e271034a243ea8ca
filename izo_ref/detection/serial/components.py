"""Connected components of a mesh, and the boxes of their paths."""

import numpy as np

from izo_ref.base.arrays import Faces, Flags, Indices, Positions
from izo_ref.base.compile import compiled
from izo_ref.base.serial.components import find_root, join_sets


@compiled
def number_components(n_vertices: int, faces: Faces) -> tuple[Indices, int]:
    """Number the components of a mesh by their lowest vertex.

    Args:
        n_vertices: Number of vertices.
        faces: (m, 3) i4.

    Returns:
        (n_vertices,) i8, the component of each vertex; and the number of components.
    """
    parent, component, count = np.arange(n_vertices), np.empty(n_vertices, np.int64), 0
    for i in range(faces.shape[0]):
        for k in range(1, 3):
            join_sets(parent, np.int64(faces[i, 0]), np.int64(faces[i, k]))
    for vertex in range(n_vertices):
        root = find_root(parent, np.int64(vertex))
        if root == vertex:  # the lowest vertex, so it gets its number before the others
            component[vertex] = count
            count += 1
        else:
            component[vertex] = component[root]
    return component, count


@compiled
def paths_of_components(
    component: Indices, count: int, positions_t0: Positions, positions_t1: Positions
) -> tuple[Flags, Positions, Positions]:
    """Return which components move, and the box that holds the start and the end of each.

    Args:
        component: (n_vertices,) i8, the component of each vertex.
        count: Number of components.
        positions_t0: (n_vertices, 3) f8 [m].
        positions_t1: (n_vertices, 3) f8 [m].

    Returns:
        (count,) b1; and the minima and the maxima of the boxes, (count, 3) f8 [m] each.
    """
    moving = np.zeros(count, np.bool_)
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    for i in range(component.shape[0]):
        own = component[i]
        for axis in range(3):
            a, b = positions_t0[i, axis], positions_t1[i, axis]
            moving[own] |= a != b
            low[own, axis] = min(low[own, axis], min(a, b))
            high[own, axis] = max(high[own, axis], max(a, b))
    return moving, low, high
