"""Which of the impacts found enter the zones, in rounds of all at once.

In each round the impacts that are first of those left at all of their free vertices are taken,
and those that share a vertex with one taken are dropped: the ones that `zones/serial/selection.py`
takes one by one. Vertices are claimed by integer minima, so the order of threads does not matter.
"""

from numba import cuda

from izo_ref.base.cuda.compile import cuda_kernel

UNDECIDED, TAKEN, DROPPED = 0, 1, 2


@cuda_kernel
def rank_impacts(
    # In:
    order,  # (n_impacts,) i8, by time of impact
    # Out:
    ranks_out,  # (n_impacts,) i8
):
    i = cuda.grid(1)
    if i < order.shape[0]:
        ranks_out[order[i]] = i


@cuda_kernel
def claim_vertices(
    # In:
    nodes,  # (n_impacts, 4) i4
    pinned,  # (n_vertices,) b1
    ranks,  # (n_impacts,) i8
    states,  # (n_impacts,) i1
    # Out:
    owners_out,  # (n_vertices,) i8, the lowest rank of the undecided at each; n_impacts before
):
    j = cuda.grid(1)
    if j < nodes.shape[0] and states[j] == UNDECIDED:
        for k in range(4):
            if not pinned[nodes[j, k]]:
                cuda.atomic.min(owners_out, nodes[j, k], ranks[j])


@cuda_kernel
def take_owners(
    # In:
    nodes,  # (n_impacts, 4) i4
    pinned,  # (n_vertices,) b1
    ranks,  # (n_impacts,) i8
    owners,  # (n_vertices,) i8
    all_new,  # b1: each free vertex has to be its own (`independent`), or one (`first-of-any`)
    # Out:
    states_out,  # (n_impacts,) i1
    seen_out,  # (n_vertices,) b1, those of impacts taken
):
    j = cuda.grid(1)
    if j < nodes.shape[0] and states_out[j] == UNDECIDED:
        n_free, n_own = 0, 0
        for k in range(4):
            if not pinned[nodes[j, k]]:
                n_free += 1
                n_own += owners[nodes[j, k]] == ranks[j]
        if (n_own == n_free) if all_new else (n_own > 0):
            states_out[j] = TAKEN
            for k in range(4):
                seen_out[nodes[j, k]] = True


@cuda_kernel
def drop_others(
    # In:
    nodes,  # (n_impacts, 4) i4
    pinned,  # (n_vertices,) b1
    seen,  # (n_vertices,) b1
    # Out:
    states_out,  # (n_impacts,) i1
    undecided_out,  # (n_impacts,) b1
):
    j = cuda.grid(1)
    if j < nodes.shape[0]:
        for k in range(4):
            if states_out[j] == UNDECIDED and seen[nodes[j, k]] and not pinned[nodes[j, k]]:
                states_out[j] = DROPPED
        undecided_out[j] = states_out[j] == UNDECIDED


@cuda_kernel
def flag_taken(
    # In:
    states,  # (n_impacts,) i1
    # Out:
    taken_out,  # (n_impacts,) b1
):
    j = cuda.grid(1)
    if j < states.shape[0]:
        taken_out[j] = states[j] == TAKEN
