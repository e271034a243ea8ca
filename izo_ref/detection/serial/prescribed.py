"""Decide which impacts are between pinned points, so that no solver can mend them."""

from izo_ref.base.arrays import Flags, Nodes, Weights
from izo_ref.base.compile import compiled

# If the unpinned vertices of an impact have less absolute weight than this in all, the impact is
# between pinned points: an unpinned vertex would have to move a billion times the gap to open it.
NO_WEIGHT = 1e-9


@compiled
def is_prescribed(j: int, nodes: Nodes, weights: Weights, pinned: Flags) -> bool:
    """Return whether impact j is between pinned points.

    Args:
        j: Index of the impact.
        nodes: (n_impacts, 4) i4.
        weights: (n_impacts, 4) f8.
        pinned: (n_vertices,) b1.
    """
    weight = 0.0
    for k in range(4):
        if not pinned[nodes[j, k]]:
            weight += abs(weights[j, k])
    return weight < NO_WEIGHT


@compiled
def prescribed_impacts(
    nodes: Nodes,  # (n_impacts, 4) i4
    weights: Weights,  # (n_impacts, 4) f8
    pinned: Flags,  # (n_vertices,) b1
    prescribed_out: Flags,  # (n_impacts,) b1
) -> None:
    """Mark the impacts that are between pinned points."""
    for j in range(nodes.shape[0]):
        prescribed_out[j] = is_prescribed(j, nodes, weights, pinned)
