"""Guess the active constraints of one zone by a thread group.

Accelerated projected gradient steps on the dual problem take two waits each and use all threads,
where sweeps of Gauss-Seidel change one multiplier after the other. The gradient is divided by the
sums |K_j1| + |K_j2| + ..., which majorise K = C C^T.

Source: Y. Nesterov, A method of solving a convex programming problem with convergence rate
O(1/k^2) (1983).
"""

from izo_ref.base.compile import compiled
from izo_ref.base.serial.views import place
from izo_ref.solvers.serial.group_memory import Memory
from izo_ref.solvers.serial.group_zone import Zone, product, pull, row_sum

# Measured on all 366 zones of 33 to 512 impacts of armadillo-rollers, cloth-ball-clean and
# sphere-10k. With 30 steps, they take 4.1, 5.6 and 21 solves on average, and 5 of the 22 zones of
# sphere-10k are not solved. All are solved with 100 steps (2.3, 3.4 and 12 solves), with 200 (2.0,
# 2.4 and 9.0) and with 400 (1.7, 2.0 and 9.4). A step waits twice, as two columns of a factor do.
# Of the 237 zones with more than 512 impacts of these steps and of stack-6k, sheets-10k and
# sheets-50k, 229 are solved after 200 steps from the last solution, in 4.7 solves on average, and
# 227 after 200 steps from 0, in 7.9.
GUESS_STEPS = 200


@compiled
def guess_active(zone: Zone, memory: Memory) -> None:
    """Guess u, from `earlier` on, and take the constraints with u > 0 as active."""
    group, n = zone.group, zone.rhs.shape[0]
    u, ahead = memory.u, memory.right
    for j in range(group.rank(), n, group.size()):
        total = row_sum(zone, j)
        memory.scales[j] = 1.0 / total if total > 0.0 else 0.0
        u[j] = ahead[j] = memory.earlier[j]
    group.wait()
    for step in range(GUESS_STEPS):
        pull(zone, ahead, memory.z)
        group.wait()
        momentum, j = step / (step + 3.0), place(group.rank())
        while j < n:
            missing = zone.rhs[j] - product(zone, j, memory.z)
            value = max(ahead[j] + memory.scales[j] * missing, 0.0)
            ahead[j] = value + momentum * (value - u[j])
            u[j] = value
            j = place(j + group.size())
        group.wait()
    for j in range(group.rank(), n, group.size()):
        memory.earlier[j] = u[j]
        memory.is_active[j] = 1 if u[j] > 0.0 else 0
    group.wait()
