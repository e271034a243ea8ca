"""Select the impacts that enter the zones."""

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


# The gap of an impact in a solved zone may fall short of the thickness by this fraction of it. A
# solver leaves a violation of 1e-9 of the thickness.
SHORTFALL = 1e-6


@compiled
def is_hopeful(
    j: int,
    positions: Positions,
    nodes: Nodes,
    weights: Weights,
    normals: Normals,
    stuck: Flags,
    thickness: float,
) -> bool:
    """Return whether a solver could mend impact j if it entered the zones.

    It cannot if a vertex is in a zone that no positions satisfy. It cannot either if the frozen gap
    of the impact is as large as the thickness already: the new constraint would not change
    anything. That happens if rounding cannot tell whether a pair is apart, and if the impact is in
    the zones.

    Args:
        j: Index of the impact.
        positions: (n_vertices, 3) f8 [m], end positions of the path on which it was found.
        nodes: (n_impacts, 4) i4.
        weights: (n_impacts, 4) f8.
        normals: (n_impacts, 3) f8.
        stuck: (n_vertices,) b1.
        thickness: Distance that impacts keep at the end [m].
    """
    first, gap = nodes[j, 0], 0.0
    for k in range(4):
        node = nodes[j, k]
        if stuck[node]:
            return False
        # the weights add up to zero, so positions relative to a node give the same gap
        along = 0.0
        for axis in range(3):
            along += normals[j, axis] * (positions[node, axis] - positions[first, axis])
        gap += weights[j, k] * along
    return gap < thickness * (1.0 - SHORTFALL)


@compiled
def hopeful_impacts(
    positions: Positions,  # (n_vertices, 3) f8 [m]
    nodes: Nodes,  # (n_impacts, 4) i4
    weights: Weights,  # (n_impacts, 4) f8
    normals: Normals,  # (n_impacts, 3) f8
    stuck: Flags,  # (n_vertices,) b1
    thickness: float,  # f8 [m]
    hopeful_out: Flags,  # (n_impacts,) b1
) -> None:
    """Mark the impacts that a solver could mend."""
    for j in range(nodes.shape[0]):
        hopeful_out[j] = is_hopeful(j, positions, nodes, weights, normals, stuck, thickness)
