"""Sort and renumber the elements of a mesh, and measure its edges."""

import numpy as np

from izo_ref.base.arrays import Edges, Floats, Ints, Positions
from izo_ref.base.compile import compiled


@compiled
def sort_rows(rows: Ints, n_values: int) -> Ints:
    """Sort rows of small numbers by their first numbers, then by the second ones, and so on.

    Each column is sorted by counting, the last one first. So the time is proportional to the number
    of rows, and equal rows keep their order.

    Args:
        rows: (n, k) i4, from 0 to n_values - 1.
        n_values: Number of different values.

    Returns:
        (n,) i4, the row at each place.
    """
    n = rows.shape[0]
    order, other = np.empty(n, np.int32), np.empty(n, np.int32)
    for i in range(n):
        order[i] = i
    for column in range(rows.shape[1] - 1, -1, -1):
        places = np.zeros(n_values + 1, np.int64)
        for i in range(n):
            places[rows[i, column] + 1] += 1
        for value in range(n_values):
            places[value + 1] += places[value]
        for i in range(n):
            value = rows[order[i], column]
            other[places[value]] = order[i]
            places[value] += 1
        order, other = other, order
    return order


@compiled
def renumbered_rows(place: Ints, nodes: Ints, order: Ints) -> Ints:
    """Return elements with other numbers, each rotated until its lowest number is first.

    A rotation keeps the orientation of a face.

    Args:
        place: (n_vertices,) i4, the number of each vertex.
        nodes: (n, k) i4, the vertices of each element.
        order: (n,) i4, the order in which the elements are gathered.

    Returns:
        (n, k) i4.
    """
    rows, k = np.empty(nodes.shape, np.int32), nodes.shape[1]
    for i in range(order.shape[0]):
        element, first = order[i], 0
        for m in range(1, k):
            if place[nodes[element, m]] < place[nodes[element, first]]:
                first = m
        for m in range(k):
            rows[i, m] = place[nodes[element, (first + m) % k]]
    return rows


@compiled
def squared_lengths(positions: Positions, edges: Edges) -> Floats:
    """Return the squared length of each edge, (n,) f8 [m^2]."""
    lengths_sq = np.empty(edges.shape[0])
    for i in range(edges.shape[0]):
        a, b = edges[i, 0], edges[i, 1]
        x, y = positions[a, 0] - positions[b, 0], positions[a, 1] - positions[b, 1]
        z = positions[a, 2] - positions[b, 2]
        lengths_sq[i] = x * x + y * y + z * z
    return lengths_sq
