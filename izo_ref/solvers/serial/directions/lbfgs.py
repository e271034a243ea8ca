"""Limited-memory BFGS by the two-loop recursion.

The direction is p = -H g, with g the gradient of L. H approximates the inverse of the Hessian by
the last `PAIRS` pairs of a step s and the change y of the gradient over that step.

`zone.memory` holds `PAIRS` steps s, as many changes y, and then 1 / (s . y) of each pair and the
coefficient alpha of each pair in the recursion. Pair number i is in slot i % PAIRS.

Source: J. Nocedal, S. Wright, Numerical Optimization (2006), algorithm 7.4, eq. 7.20.
"""

from izo_ref.base.compile import compiled
from izo_ref.base.serial.thread_group import group_sum, group_sums
from izo_ref.solvers.serial.lagrangian import Zone

PAIRS = 8  # 3 to 20 are usual (Nocedal and Wright, section 7.2)


@compiled
def remember_pair(zone: Zone, stored: int, rounding: float) -> int:
    """Store the pair s, y if s . y > 0 beyond rounding, and return how many pairs were stored.

    `zone.direction` holds s and `zone.previous` holds y. `stored` counts the pairs so far, those
    that were overwritten since included.
    """
    n, slot, group = zone.x.size, stored % PAIRS, zone.group
    product, s_sq, y_sq = 0.0, 0.0, 0.0
    for i in range(group.rank(), n, group.size()):
        s, y = zone.direction[i], zone.previous[i]
        product += s * y
        s_sq += s * s
        y_sq += y * y
    product, s_sq, y_sq = group_sums(group, product, s_sq, y_sq)
    # y is a difference of gradients: if s . y is below this, it is rounding
    if not product > rounding * (s_sq * y_sq) ** 0.5:
        return stored
    # the slot may hold the oldest pair in use, so it is overwritten only now
    for i in range(group.rank(), n, group.size()):
        zone.memory[slot * n + i] = zone.direction[i]
        zone.memory[(PAIRS + slot) * n + i] = zone.previous[i]
    zone.memory[2 * PAIRS * n + slot] = 1.0 / product
    return stored + 1


@compiled
def lbfgs_direction(zone: Zone, stored: int) -> None:
    """Compute p = -H g with H from the stored pairs, or p = -g if there are none.

    `zone.previous` holds g afterwards.
    """
    n, memory, p, group = zone.x.size, zone.memory, zone.direction, zone.group
    rho, alpha = 2 * PAIRS * n, 2 * PAIRS * n + PAIRS
    for i in range(group.rank(), n, group.size()):
        p[i] = -zone.gradient[i]
        zone.previous[i] = zone.gradient[i]
    oldest = max(0, stored - PAIRS)
    for pair in range(stored - 1, oldest - 1, -1):
        slot = pair % PAIRS
        total = 0.0
        for i in range(group.rank(), n, group.size()):
            total += memory[slot * n + i] * p[i]
        total = group_sum(group, total)
        memory[alpha + slot] = total * memory[rho + slot]
        for i in range(group.rank(), n, group.size()):
            p[i] -= memory[alpha + slot] * memory[(PAIRS + slot) * n + i]
    if stored > 0:
        begin = (PAIRS + (stored - 1) % PAIRS) * n
        y_sq = 0.0
        for i in range(group.rank(), n, group.size()):
            y_sq += memory[begin + i] * memory[begin + i]
        y_sq = group_sum(group, y_sq)
        gamma = p.dtype.type(1.0 / (memory[rho + (stored - 1) % PAIRS] * y_sq))
        for i in range(group.rank(), n, group.size()):
            p[i] *= gamma
    for pair in range(oldest, stored):
        slot = pair % PAIRS
        total = 0.0
        for i in range(group.rank(), n, group.size()):
            total += memory[(PAIRS + slot) * n + i] * p[i]
        total = group_sum(group, total)
        rest = p.dtype.type(memory[alpha + slot] - total * memory[rho + slot])
        for i in range(group.rank(), n, group.size()):
            p[i] += rest * memory[slot * n + i]
