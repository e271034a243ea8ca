"""Nonlinear conjugate gradient, with the beta of Dai and Yuan held up to Hestenes-Stiefel's.

    beta = max(0, min(g . y, g . g) / (p . y)),  y = g - g_before

Not preconditioned: in scaled variables the Hessian is the identity and a term for each
active row, and dividing by its diagonal spreads those few eigenvalues; with it, updates of
the multipliers after inner solves took 3 to 8 times as many steps.

It restarts by itself (beta = 0) where the active set has changed much; the loop restarts
it after as many steps as there are unknowns, and where p is no descent.

Source: J. Nocedal, S. Wright, Numerical Optimization (2006), eqs. 5.46, 5.49 and the notes
of chapter 5; Y. Dai, Y. Yuan, An efficient hybrid conjugate gradient method (2001).
"""

from izo_ref.base.compile import compiled
from izo_ref.base.serial.thread_group import group_sums


@compiled
def cg_direction(zone, restart):
    """p = -g + beta p; takes y from `zone.previous` and leaves g there."""
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
