"""C C^T of the rows of one zone (solvers/serial/constraints.py), where it is not zero."""

import numpy as np

from izo_ref.base.compile import compiled


@compiled
def _rows_of(nodes, n_unknowns):
    """The rows at each unknown, ascending: (starts, 4 * row + its place in the row)."""
    starts = np.zeros(n_unknowns + 1, np.int64)
    for i in range(nodes.shape[0]):
        for k in range(4):
            if nodes[i, k] >= 0:
                starts[nodes[i, k] + 1] += 1
    for i in range(n_unknowns):
        starts[i + 1] += starts[i]
    ends, rows = starts[:n_unknowns].copy(), np.empty(starts[n_unknowns], np.int64)
    for i in range(nodes.shape[0]):
        for k in range(4):
            if nodes[i, k] >= 0:
                rows[ends[nodes[i, k]]] = 4 * i + k
                ends[nodes[i, k]] += 1
    return starts, rows


@compiled
def gram_products(nodes, coefficients, normals, n_unknowns):
    """Scalar products of rows that share an unknown, and of each row with itself.

    Args:
        nodes: (n, 4) i4, unknowns; < 0 for pinned.
        coefficients: (n, 4) f8.
        normals: (n, 3) f8.

    Returns:
        (n_products, 2) i4 pairs i <= j, row by row, and (n_products,) f8.
    """
    n = nodes.shape[0]
    starts, rows = _rows_of(nodes, n_unknowns)
    most = n
    for i in range(n_unknowns):
        shared = starts[i + 1] - starts[i]
        most += shared * (shared + 1) // 2
    pairs, products, count = np.empty((most, 2), np.int32), np.empty(most), 0
    where = np.full(n, -1)  # of the product of a row with the one that is looked at
    for i in range(n):
        begin = count
        pairs[count, 0], pairs[count, 1], products[count] = i, i, 0.0
        where[i] = count
        count += 1
        x, y, z = normals[i, 0], normals[i, 1], normals[i, 2]
        for k in range(4):
            unknown = nodes[i, k]
            if unknown < 0:
                continue
            for e in range(starts[unknown], starts[unknown + 1]):
                j, place = rows[e] >> 2, rows[e] & 3
                if j < i:
                    continue
                if where[j] < begin:
                    pairs[count, 0], pairs[count, 1], products[count] = i, j, 0.0
                    where[j] = count
                    count += 1
                cosine = x * normals[j, 0] + y * normals[j, 1] + z * normals[j, 2]
                products[where[j]] += coefficients[i, k] * coefficients[j, place] * cosine
    return pairs[:count], products[:count]
