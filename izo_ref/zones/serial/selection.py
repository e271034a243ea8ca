"""Select the impacts that enter the zones, and those that stay there for the next round."""

from izo_ref.base.arrays import Flags, Indices, Nodes, Normals, Positions, Weights
from izo_ref.base.compile import compiled


@compiled
def select_in_order(
    order: Indices,  # (n_impacts,) i8, impacts by time of impact
    nodes: Nodes,  # (n_impacts, 4) i4
    pinned: Flags,  # (n_vertices,) b1
    all_new: bool,  # b1, whether every unpinned vertex has to be new (`independent`), or only one
    seen: Flags,  # (n_vertices,) b1, work space, all false
    selected_out: Flags,  # (n_impacts,) b1
) -> None:
    """Select an impact if its unpinned vertices were not seen before, then mark them as seen.

    With `all_new`, the vertices of an impact that is not selected stay unseen: an impact has to
    wait only for impacts that were selected.
    """
    for i in range(len(order)):
        j = order[i]
        n_unpinned = 0
        n_new = 0
        for k in range(4):
            if not pinned[nodes[j, k]]:
                n_unpinned += 1
                if not seen[nodes[j, k]]:
                    n_new += 1
        if all_new:
            selected_out[j] = n_new == n_unpinned
        else:
            selected_out[j] = n_new > 0
        if selected_out[j] or not all_new:
            for k in range(4):
                seen[nodes[j, k]] = True


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


@compiled
def tight_impacts(
    positions: Positions,  # (n_vertices, 3) f8 [m]
    nodes: Nodes,  # (n_impacts, 4) i4
    weights: Weights,  # (n_impacts, 4) f8
    normals: Normals,  # (n_impacts, 3) f8
    thickness: float,  # f8 [m]
    tight_out: Flags,  # (n_impacts,) b1
) -> None:
    """Mark the impacts whose gap is no more than the thickness."""
    for j in range(nodes.shape[0]):
        tight_out[j] = is_tight(j, positions, nodes, weights, normals, thickness)
