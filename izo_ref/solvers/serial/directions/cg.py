"""Nonlinear conjugate gradients, with the beta of Dai and Yuan bounded by Hestenes-Stiefel's.

With g the gradient of L, and p the last direction, the next one is -g + beta p:

    beta = max(0, min(g . y, g . g) / (p . y)),   y = g - g_before

The method is not preconditioned. In scaled variables the Hessian is the identity plus one term for
each active constraint, so it has few distinct eigenvalues; dividing by its diagonal spreads them.
With the diagonal, updates of the multipliers after inner solves took 3 to 8 times as many steps.

The method restarts by itself (beta = 0) where the active set has changed much. The loop restarts it
after as many steps as there are unknown coordinates, and where p is no direction of descent.

Source: J. Nocedal, S. Wright, Numerical Optimization (2006), eqs. 5.46, 5.49 and the notes of
chapter 5; Y. Dai, Y. Yuan, An efficient hybrid conjugate gradient method (2001).
"""

from izo_ref.base.arrays import AnyBool
from izo_ref.base.compile import compiled
from izo_ref.base.serial.thread_group import group_sums
from izo_ref.solvers.serial.lagrangian import Zone


@compiled
def cg_direction(zone: Zone, restart: AnyBool) -> None:
    """Compute p = -g + beta p, where a restart sets beta to 0.

    `zone.previous` holds y on entry, and g afterwards.
    """
    hestenes, dai, curvature = 0.0, 0.0, 0.0
    for i in range(zone.group.rank(), zone.x.size, zone.group.size()):
        g = zone.gradient[i]
        hestenes += g * zone.previous[i]
        dai += g * g
        curvature += zone.direction[i] * zone.previous[i]
    hestenes, dai, curvature = group_sums(zone.group, hestenes, dai, curvature)
    keep = curvature > 0.0 and not restart
    beta = zone.x.dtype.type(max(0.0, min(hestenes, dai)) / curvature if keep else 0.0)
    for i in range(zone.group.rank(), zone.x.size, zone.group.size()):
        zone.direction[i] = beta * zone.direction[i] - zone.gradient[i]
        zone.previous[i] = zone.gradient[i]
