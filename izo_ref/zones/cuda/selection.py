"""Select which of the impacts found enter the zones, in rounds over all impacts at once.

Each round takes every impact that is the earliest undecided one at all of its unpinned vertices,
and drops the impacts that share an unpinned vertex with an impact that was taken. The result is the
same as in `zones/serial/selection.py`, which takes one impact after the other. Vertices are claimed
by integer minima, so the order in which the threads run does not matter.
"""

from numba import cuda

from izo_ref.base.arrays import Codes, Flags, Indices, Nodes
from izo_ref.base.cuda.compile import cuda_kernel

UNDECIDED, TAKEN, DROPPED = 0, 1, 2


@cuda_kernel
def rank_impacts(
    # In:
    order: Indices,  # (n_impacts,) i8, impacts by time of impact
    # Out:
    ranks_out: Indices,  # (n_impacts,) i8
) -> None:
    """Write the rank of each impact, its place in the order of times."""
    i = cuda.grid(1)
    if i < order.shape[0]:
        ranks_out[order[i]] = i


@cuda_kernel
def claim_vertices(
    # In:
    nodes: Nodes,  # (n_impacts, 4) i4
    pinned: Flags,  # (n_vertices,) b1
    ranks: Indices,  # (n_impacts,) i8
    states: Codes,  # (n_impacts,) i1
    # Out:
    owners_out: Indices,  # (n_vertices,) i8, n_impacts before, and where no impact is undecided
) -> None:
    """Write the lowest rank of the undecided impacts at each unpinned vertex."""
    j = cuda.grid(1)
    if j < nodes.shape[0] and states[j] == UNDECIDED:
        for k in range(4):
            if not pinned[nodes[j, k]]:
                cuda.atomic.min(owners_out, nodes[j, k], ranks[j])


@cuda_kernel
def take_owners(
    # In:
    nodes: Nodes,  # (n_impacts, 4) i4
    pinned: Flags,  # (n_vertices,) b1
    ranks: Indices,  # (n_impacts,) i8
    owners: Indices,  # (n_vertices,) i8
    all_new: bool,  # b1, whether it has to own every unpinned vertex (`independent`), not only one
    # Out:
    states_out: Codes,  # (n_impacts,) i1
    seen_out: Flags,  # (n_vertices,) b1, becomes true for the vertices of impacts that are taken
) -> None:
    """Take the undecided impacts that own their unpinned vertices."""
    j = cuda.grid(1)
    if j < nodes.shape[0] and states_out[j] == UNDECIDED:
        n_unpinned, n_own = 0, 0
        for k in range(4):
            if not pinned[nodes[j, k]]:
                n_unpinned += 1
                n_own += owners[nodes[j, k]] == ranks[j]
        if (n_own == n_unpinned) if all_new else (n_own > 0):
            states_out[j] = TAKEN
            for k in range(4):
                seen_out[nodes[j, k]] = True


@cuda_kernel
def drop_others(
    # In:
    nodes: Nodes,  # (n_impacts, 4) i4
    pinned: Flags,  # (n_vertices,) b1
    seen: Flags,  # (n_vertices,) b1
    # Out:
    states_out: Codes,  # (n_impacts,) i1
    undecided_out: Flags,  # (n_impacts,) b1
) -> None:
    """Drop the undecided impacts at an unpinned vertex that was seen, and mark the others."""
    j = cuda.grid(1)
    if j < nodes.shape[0]:
        for k in range(4):
            if states_out[j] == UNDECIDED and seen[nodes[j, k]] and not pinned[nodes[j, k]]:
                states_out[j] = DROPPED
        undecided_out[j] = states_out[j] == UNDECIDED


@cuda_kernel
def flag_taken(
    # In:
    states: Codes,  # (n_impacts,) i1
    # Out:
    taken_out: Flags,  # (n_impacts,) b1
) -> None:
    """Mark the impacts that were taken."""
    j = cuda.grid(1)
    if j < states.shape[0]:
        taken_out[j] = states[j] == TAKEN
