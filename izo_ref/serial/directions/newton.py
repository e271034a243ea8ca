"""Semismooth Newton: H p = -g with H = diag(w) + mu sum_active a a^T.

Solved by conjugate gradients without a matrix, so the size of a zone does not matter and
neither does the target. From p = 0 every iterate is a direction of descent, so an inexact
solve is safe. They are preconditioned with w: what is left is the identity and as many other
eigenvalues as rows are active, which the diagonal of H would spread.

Source: J. Nocedal, S. Wright, Numerical Optimization (2006), algorithm 7.1; L. Qi, J. Sun,
A nonsmooth version of Newton's method (1993).
"""

from izo_ref._jit import compiled


@compiled
def newton_direction(zone, penalty, tolerance, limit):
    """Solve until the residual, in the norm of 1 / w, fell by `tolerance`.

    Returns the number of products with H.
    """
    n, memory, p = zone.x.size, zone.memory, zone.direction
    mu = p.dtype.type(penalty)
    # memory: residual r in [0, n), search direction d in [n, 2 n), H d in [2 n, 3 n)
    norm = 0.0
    for i in range(n):
        p[i] = 0
        memory[i] = -zone.gradient[i]
        memory[n + i] = memory[i] / zone.curvatures[i]
        norm += memory[i] * memory[n + i]
    goal = tolerance * tolerance * norm
    for product in range(limit):
        if not norm > goal:
            return product
        for i in range(n):
            memory[2 * n + i] = zone.curvatures[i] * memory[n + i]
        for j in range(zone.pushed.size):
            if zone.pushed[j] > 0:
                along = p.dtype.type(0)
                for k in range(4):
                    i = n + zone.nodes[j, k]
                    point = zone.normals[j, 0] * memory[i] + zone.normals[j, 1] * memory[i + 1]
                    point += zone.normals[j, 2] * memory[i + 2]
                    along += zone.coefficients[j, k] * point
                along *= mu
                for k in range(4):
                    i, pull = 2 * n + zone.nodes[j, k], along * zone.coefficients[j, k]
                    memory[i] += pull * zone.normals[j, 0]
                    memory[i + 1] += pull * zone.normals[j, 1]
                    memory[i + 2] += pull * zone.normals[j, 2]
        curvature = 0.0
        for i in range(n):
            curvature += memory[n + i] * memory[2 * n + i]
        if not curvature > 0.0:
            return product
        step, before = p.dtype.type(norm / curvature), norm
        norm = 0.0
        for i in range(n):
            p[i] += step * memory[n + i]
            memory[i] -= step * memory[2 * n + i]
            norm += memory[i] * memory[i] / zone.curvatures[i]
        beta = p.dtype.type(norm / before)
        for i in range(n):
            memory[n + i] = memory[i] / zone.curvatures[i] + beta * memory[n + i]
    return limit
