"""Steepest descent, plain or divided by the diagonal of the generalised Hessian.

Source: XRTailor documentation, "Descent Methods"; for the diagonal, H. Wang, Y. Yang, Descent
methods for elastic body simulation on the GPU (2016), section 4.1.
"""

from izo_ref.base.compile import compiled
from izo_ref.solvers.serial.lagrangian import Zone


@compiled
def gradient_direction(zone: Zone, preconditioned: bool) -> None:
    """Compute p = -g, or p = -g / D if `preconditioned`, with D in `zone.diagonal`."""
    for i in range(zone.group.rank(), zone.x.size, zone.group.size()):
        g = zone.gradient[i]
        zone.direction[i] = -g / zone.diagonal[i] if preconditioned else -g
