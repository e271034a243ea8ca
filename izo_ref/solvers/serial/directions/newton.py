"""Semismooth Newton method: H p = -g with the generalised Hessian H of L.

H = diag(w) + mu sum_active A_j A_j^T and g is the gradient (`solvers/serial/lagrangian.py`).
Conjugate gradients solve the system without forming H, so that neither the size of a zone nor the
kind of machine matters. They begin at p = 0, and every iterate is then a direction of descent, so
the system need not be solved accurately.

The preconditioner is w. It leaves the identity plus one term for each active constraint, so there
are at most as many other eigenvalues as active constraints. The diagonal of H would spread them.

Source: J. Nocedal, S. Wright, Numerical Optimization (2006), algorithm 7.1; L. Qi, J. Sun, A
nonsmooth version of Newton's method (1993).
"""

from izo_ref.base.arrays import AnyFloat, AnyInt
from izo_ref.base.compile import compiled
from izo_ref.base.serial.thread_group import group_sum
from izo_ref.solvers.serial.lagrangian import Zone, gather_at_vertex


@compiled
def multiply_by_hessian(zone: Zone, mu: AnyFloat, at: int, to: int) -> None:
    """Compute H v, with v from `memory[at]` on and the product from `memory[to]` on.

    Afterwards `zone.along` holds A v, with 0 for inactive constraints. On entry all threads must
    have written their numbers of v. Afterwards every thread may read the whole product.
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
        pulls, i = gather_at_vertex(zone, vertex, mu, zone.along), 3 * vertex
        memory[to + i] = zone.curvatures[i] * memory[at + i] + pulls[0]
        memory[to + i + 1] = zone.curvatures[i + 1] * memory[at + i + 1] + pulls[1]
        memory[to + i + 2] = zone.curvatures[i + 2] * memory[at + i + 2] + pulls[2]
    group.wait()


@compiled
def newton_direction(zone: Zone, penalty: float, tolerance: float, limit: AnyInt) -> AnyInt:
    """Compute p with H p = -g, until the residual has fallen by the factor `tolerance`.

    The residual is measured in the norm of 1 / w. At most `limit` products with H are computed.

    Returns:
        The number of products with H.
    """
    n, memory, p, group = zone.x.size, zone.memory, zone.direction, zone.group
    mu = p.dtype.type(penalty)
    # memory: the residual r in [0, n), the search direction d in [n, 2 n), H d in [2 n, 3 n)
    norm = 0.0
    for i in range(group.rank(), n, group.size()):
        p[i] = 0
        memory[i] = -zone.gradient[i]
        memory[n + i] = memory[i] / zone.curvatures[i]
        norm += memory[i] * memory[n + i]
    norm = group_sum(group, norm)
    goal = tolerance * tolerance * norm
    for product in range(limit):
        if not norm > goal or zone.stop[0]:
            return product
        multiply_by_hessian(zone, mu, n, 2 * n)
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
