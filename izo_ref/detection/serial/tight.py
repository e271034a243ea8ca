"""Decide which impacts are tight."""

from izo_ref.base.arrays import Nodes, Normals, Positions, Weights
from izo_ref.base.compile import compiled

# An impact is tight if its gap exceeds the thickness by at most this fraction of it. A solver
# leaves a violation of 1e-9 of the thickness.
TIGHT = 1e-6


@compiled
def is_tight(
    j: int,
    positions: Positions,
    nodes: Nodes,
    weights: Weights,
    normals: Normals,
    thickness: float,
) -> bool:
    """Return whether the gap of impact j is no more than the thickness.

    Args:
        j: Index of the impact.
        positions: (n_vertices, 3) f8 [m].
        nodes: (n_impacts, 4) i4.
        weights: (n_impacts, 4) f8.
        normals: (n_impacts, 3) f8.
        thickness: Distance that impacts keep at the end [m].
    """
    gap = 0.0
    for axis in range(3):
        between = 0.0
        for k in range(4):
            between += weights[j, k] * positions[nodes[j, k], axis]
        gap += normals[j, axis] * between
    return gap <= thickness * (1.0 + TIGHT)
