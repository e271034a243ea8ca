"""Sort the elements of a mesh in space."""

import numpy as np

from izo_ref.base.arrays import Ints
from izo_ref.base.compile import compiled
from izo_ref.base.serial.mesh import sort_rows


@compiled
def sort_elements(place: Ints, nodes: Ints) -> Ints:
    """Sort elements by the place of their first vertex along a curve, then by that of the next.

    Args:
        place: (n_vertices,) i4, the place of each vertex.
        nodes: (n, k) i4, the vertices of each element.

    Returns:
        (n,) i4, the element at each place.
    """
    rows = np.empty(nodes.shape, np.int32)
    for i in range(nodes.shape[0]):
        for k in range(nodes.shape[1]):
            at, own = k, place[nodes[i, k]]
            while at > 0 and rows[i, at - 1] > own:
                rows[i, at] = rows[i, at - 1]
                at -= 1
            rows[i, at] = own
    return sort_rows(rows, place.shape[0])
