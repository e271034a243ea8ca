"""The Gram matrix C C^T of the constraints of one zone, where it is not zero.

The scalar product of two constraints (`solvers/serial/constraints.py`) is zero unless they share an
unknown. So for each constraint, only the constraints at its own unknowns are visited.
"""

import numpy as np

from izo_ref.base.arrays import Floats, Indices, Ints, Normals, Offsets
from izo_ref.base.compile import compiled


@compiled
def _constraints_at_unknowns(nodes: Ints, n_unknowns: int) -> tuple[Offsets, Indices]:
    """Return the constraints at each unknown, ascending, and where those of each unknown begin.

    Returns:
        (n_unknowns + 1,) i8 starts, and (n_entries,) i8 entries 4 j + k: the unknown is node k of
        constraint j.
    """
    starts = np.zeros(n_unknowns + 1, np.int64)
    for i in range(nodes.shape[0]):
        for k in range(4):
            if nodes[i, k] >= 0:
                starts[nodes[i, k] + 1] += 1
    for i in range(n_unknowns):
        starts[i + 1] += starts[i]
    ends, entries = starts[:n_unknowns].copy(), np.empty(starts[n_unknowns], np.int64)
    for i in range(nodes.shape[0]):
        for k in range(4):
            if nodes[i, k] >= 0:
                entries[ends[nodes[i, k]]] = 4 * i + k
                ends[nodes[i, k]] += 1
    return starts, entries


@compiled
def gram_products(
    nodes: Ints, coefficients: Floats, normals: Normals, n_unknowns: int
) -> tuple[Ints, Floats]:
    """Compute the scalar products of constraints that share an unknown.

    The product of each constraint with itself is among them.

    Args:
        nodes: (n, 4) i4, unknowns from 0 on; < 0 for pinned vertices.
        coefficients: (n, 4) f8.
        normals: (n, 3) f8.
        n_unknowns: Number of unknowns.

    Returns:
        (n_products, 2) i4 pairs of constraints i <= j, in the order of i; and the products,
        (n_products,) f8.
    """
    n = nodes.shape[0]
    starts, entries = _constraints_at_unknowns(nodes, n_unknowns)
    most = n
    for i in range(n_unknowns):
        shared = starts[i + 1] - starts[i]
        most += shared * (shared + 1) // 2
    pairs, products, count = np.empty((most, 2), np.int32), np.empty(most), 0
    where = np.full(n, -1)  # place of the product of constraints i and j
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
                j, place = entries[e] >> 2, entries[e] & 3
                if j < i:
                    continue
                if where[j] < begin:
                    pairs[count, 0], pairs[count, 1], products[count] = i, j, 0.0
                    where[j] = count
                    count += 1
                cosine = x * normals[j, 0] + y * normals[j, 1] + z * normals[j, 2]
                products[where[j]] += coefficients[i, k] * coefficients[j, place] * cosine
    return pairs[:count], products[:count]
