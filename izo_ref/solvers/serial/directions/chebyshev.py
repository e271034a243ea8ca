"""Chebyshev acceleration of steps along the preconditioned gradient.

Step k extrapolates from the two points before it. Here p is the direction and rho estimates the
spectral radius of the iteration without acceleration:

    x_{k+1} = omega (x_k + step p - x_{k-1}) + x_{k-1}
    omega   = 1 for k < delay;  2 / (2 - rho^2) for k = delay;  then 4 / (4 - rho^2 omega)

Source: H. Wang, Y. Yang, Descent methods for elastic body simulation on the GPU (2016), section
4.2; for delay and rho of that system, M. Tang et al., I-Cloth (2018).
"""

from izo_ref.base.compile import compiled
from izo_ref.base.serial.thread_group import group_sum
from izo_ref.solvers.serial.lagrangian import Zone


@compiled
def next_omega(omega: float, k: float, delay: int, rho: float) -> float:
    """Return omega of step k, where `omega` is that of step k - 1."""
    if k < delay:
        return 1.0
    if k == delay:
        return 2.0 / (2.0 - rho * rho)
    return 4.0 / (4.0 - rho * rho * omega)


@compiled
def accelerate(zone: Zone, omega: float) -> None:
    """Extrapolate a step that has been made: x <- omega (x - x_{k-1}) + x_{k-1}.

    `zone.direction` holds the step, so x_k is x minus the step. `zone.previous` holds x_{k-1} on
    entry, and x_k afterwards.
    """
    factor = zone.x.dtype.type(omega)
    for i in range(zone.group.rank(), zone.x.size, zone.group.size()):
        here, before = zone.x[i], zone.previous[i]
        zone.previous[i] = here - zone.direction[i]
        zone.x[i] = factor * (here - before) + before


@compiled
def goes_uphill(zone: Zone) -> bool:
    """Return whether L rises along the last step, momentum included; then it is time to restart.

    Source: B. O'Donoghue, E. Candes, Adaptive restart for accelerated gradient schemes (2015).
    """
    slope = 0.0
    for i in range(zone.group.rank(), zone.x.size, zone.group.size()):
        slope += zone.gradient[i] * (zone.x[i] - zone.previous[i])
    return group_sum(zone.group, slope) > 0.0
