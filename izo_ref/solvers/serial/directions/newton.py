"""Semismooth Newton: H p = -g with H = diag(w) + mu sum_active a a^T.

Solved by conjugate gradients without a matrix, so the size of a zone does not matter and
neither does the target. From p = 0 every iterate is a direction of descent, so an inexact
solve is safe. They are preconditioned with w: what is left is the identity and as many other
eigenvalues as rows are active, which the diagonal of H would spread.

Source: J. Nocedal, S. Wright, Numerical Optimization (2006), algorithm 7.1; L. Qi, J. Sun,
A nonsmooth version of Newton's method (1993).
"""

from izo_ref.base.compile import compiled
from izo_ref.base.serial.thread_group import group_sum
from izo_ref.solvers.serial.lagrangian import gathered


@compiled
def multiply(zone, mu, at, to):
    """H v, with v from `memory[at]` on and the product from `memory[to]` on.

    `zone.along` then holds A v, 0 for rows that are not active. All may read v, and all then may
    read the product.
    """
    memory, group = zone.memory, zone.group
    for j in range(group.rank(), zone.pushed.size, group.size()):
        along = memory.dtype.type(0)
        if zone.pushed[j] > 0:
            for k in range(4):
                i = at + zone.nodes[j, k]
                point = zone.normals[j, 0] * memory[i] + zone.normals[j, 1] * memory[i + 1]
                point += zone.normals[j, 2] * memory[i + 2]
                along += zone.coefficients[j, k] * point
        zone.along[j] = along
    group.wait()
    for vertex in range(group.rank(), zone.x.size // 3, group.size()):
        pulls, i = gathered(zone, vertex, mu, zone.along), 3 * vertex
        memory[to + i] = zone.curvatures[i] * memory[at + i] + pulls[0]
        memory[to + i + 1] = zone.curvatures[i + 1] * memory[at + i + 1] + pulls[1]
        memory[to + i + 2] = zone.curvatures[i + 2] * memory[at + i + 2] + pulls[2]
    group.wait()


@compiled
def newton_direction(zone, penalty, tolerance, limit):
    """Solve until the residual, in the norm of 1 / w, fell by `tolerance`.

    Returns the number of products with H.
    """
    n, memory, p, group = zone.x.size, zone.memory, zone.direction, zone.group
    mu = p.dtype.type(penalty)
    # memory: residual r in [0, n), search direction d in [n, 2 n), H d in [2 n, 3 n)
    norm = 0.0
    for i in range(group.rank(), n, group.size()):
        p[i] = 0
        memory[i] = -zone.gradient[i]
        memory[n + i] = memory[i] / zone.curvatures[i]
        norm += memory[i] * memory[n + i]
    norm = group_sum(group, norm)
    goal = tolerance * tolerance * norm
    for product in range(limit):
        if not norm > goal:
            return product
        multiply(zone, mu, n, 2 * n)
        curvature = 0.0
        for i in range(group.rank(), n, group.size()):
            curvature += memory[n + i] * memory[2 * n + i]
        curvature = group_sum(group, curvature)
        if not curvature > 0.0:
            return product
        step, before = p.dtype.type(norm / curvature), norm
        norm = 0.0
        for i in range(group.rank(), n, group.size()):
            p[i] += step * memory[n + i]
            memory[i] -= step * memory[2 * n + i]
            norm += memory[i] * memory[i] / zone.curvatures[i]
        norm = group_sum(group, norm)
        beta = p.dtype.type(norm / before)
        for i in range(group.rank(), n, group.size()):
            memory[n + i] = memory[i] / zone.curvatures[i] + beta * memory[n + i]
        group.wait()
    return limit
