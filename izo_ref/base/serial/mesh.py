"""Sort the elements of a mesh by their vertices, find its edges, and measure them."""

import numpy as np

from izo_ref.base.arrays import Edges, Faces, Floats, Ints, Positions
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
def edges_of_faces(faces: Faces) -> Edges:
    """Return the edges of faces, each edge once, the lower vertex first, sorted, (k, 2) i4."""
    sides, n_vertices = np.empty((3 * faces.shape[0], 2), np.int32), 0
    for i in range(faces.shape[0]):
        for k in range(3):
            a, b = faces[i, k], faces[i, (k + 1) % 3]
            sides[3 * i + k, 0], sides[3 * i + k, 1] = min(a, b), max(a, b)
            n_vertices = max(n_vertices, a + 1)
    order, n_edges = sort_rows(sides, n_vertices), 0
    for i in range(order.shape[0]):
        a, b = sides[order[i], 0], sides[order[i], 1]
        if i == 0 or a != sides[order[i - 1], 0] or b != sides[order[i - 1], 1]:
            order[n_edges] = order[i]
            n_edges += 1
    edges = np.empty((n_edges, 2), np.int32)
    for i in range(n_edges):
        edges[i, 0], edges[i, 1] = sides[order[i], 0], sides[order[i], 1]
    return edges


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
