"""Zone problems solved by trying every active set: slow, and obviously right."""

from itertools import combinations

import numpy as np


def solve_qp(rows, b, masses, proposed, tolerance=1e-9):
    """Minimise 1/2 sum m |x - y|^2 subject to rows x >= b by trying every active set.

    Args:
        rows: (m, 3 n) constraints.
        b: (m,) right-hand sides.
        masses: (n,).
        proposed: (n, 3) proposed positions y.
        tolerance: violation of a constraint that is accepted, relative to the largest of all.

    Returns:
        x (n, 3), or None if no x satisfies the constraints.
    """
    y = proposed.ravel()
    inverse = np.repeat(1.0 / masses, 3)
    scale = np.abs(b - rows @ y).max() + 1e-300
    best, best_value = None, np.inf
    for size in range(len(rows) + 1):
        for active in combinations(range(len(rows)), size):
            a = rows[list(active)]
            gram = (a * inverse) @ a.T
            if size and np.linalg.matrix_rank(gram, tol=1e-10 * np.abs(gram).max()) < size:
                continue
            multipliers = np.linalg.solve(gram, b[list(active)] - a @ y) if size else np.empty(0)
            x = y + inverse * (a.T @ multipliers)
            if (multipliers < 0.0).any() or (rows @ x < b - tolerance * scale).any():
                continue
            value = 0.5 * np.sum((x - y) ** 2 / inverse)
            if value < best_value:
                best, best_value = x, value
    return None if best is None else best.reshape(proposed.shape)


def dense_rows(nodes, weights, normals, n):
    """Return the constraints as dense rows, (m, 3 n)."""
    rows = np.zeros((len(nodes), n, 3))
    for j in range(len(nodes)):
        for k in range(4):
            rows[j, nodes[j, k]] += weights[j, k] * normals[j]
    return rows.reshape(len(nodes), 3 * n)
