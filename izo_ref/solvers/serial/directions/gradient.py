"""Steepest descent, as it is or divided by the diagonal of the Hessian.

Source: XRTailor documentation, "Descent Methods"; H. Wang, Y. Yang, Descent methods for
elastic body simulation on the GPU (2016), section 4.1, for the diagonal.
"""

from izo_ref.base.compile import compiled


@compiled
def gradient_direction(zone, preconditioned):
    """p = -g, or -g / D with D in `zone.diagonal`."""
    for i in range(zone.group.rank(), zone.x.size, zone.group.size()):
        g = zone.gradient[i]
        zone.direction[i] = -g / zone.diagonal[i] if preconditioned else -g
