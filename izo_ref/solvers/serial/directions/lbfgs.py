"""Limited-memory BFGS by the two-loop recursion.

`zone.memory` holds `PAIRS` steps s, as many changes y of the gradient, and for each pair
1 / (s . y) and the coefficient of the recursion.

Source: J. Nocedal, S. Wright, Numerical Optimization (2006), algorithm 7.4, eq. 7.20.
"""

from izo_ref.base.compile import compiled
from izo_ref.base.serial.thread_group import group_sum, group_sums

PAIRS = 8  # 3 to 20 are usual (Nocedal and Wright, section 7.2)


@compiled
def remember_pair(zone, stored, rounding):
    """Store s and y, held by `direction` and `previous`, if s . y > 0; the number stored."""
    n, slot, group = zone.x.size, stored % PAIRS, zone.group
    product, s_sq, y_sq = 0.0, 0.0, 0.0
    for i in range(group.rank(), n, group.size()):
        s, y = zone.direction[i], zone.previous[i]
        product += s * y
        s_sq += s * s
        y_sq += y * y
    product, s_sq, y_sq = group_sums(group, product, s_sq, y_sq)
    # y is a difference of gradients: below this it is rounding, and so is its direction
    if not product > rounding * (s_sq * y_sq) ** 0.5:
        return stored
    # only now: the slot may hold the oldest pair in use
    for i in range(group.rank(), n, group.size()):
        zone.memory[slot * n + i] = zone.direction[i]
        zone.memory[(PAIRS + slot) * n + i] = zone.previous[i]
    zone.memory[2 * PAIRS * n + slot] = 1.0 / product
    return stored + 1


@compiled
def lbfgs_direction(zone, stored):
    """p = -H g with H from the pairs stored; -g if there are none."""
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
