"""The sums of the objective of a step."""

from izo_ref.base.arrays import Flags, Masses, Positions
from izo_ref.base.compile import compiled


@compiled
def weighted_squares(
    positions: Positions, proposed: Positions, masses: Masses, pinned: Flags
) -> tuple[float, float]:
    """Return sum m |x - y|^2 [kg m^2] and sum m [kg] over the unpinned vertices.

    Args:
        positions: (n_vertices, 3) f8 [m], the end positions x.
        proposed: (n_vertices, 3) f8 [m], the proposed positions y.
        masses: (n_vertices,) f8 [kg].
        pinned: (n_vertices,) b1.
    """
    squares, mass = 0.0, 0.0
    for i in range(masses.shape[0]):
        if not pinned[i]:
            x = positions[i, 0] - proposed[i, 0]
            y = positions[i, 1] - proposed[i, 1]
            z = positions[i, 2] - proposed[i, 2]
            squares += masses[i] * (x * x + y * y + z * z)
            mass += masses[i]
    return squares, mass
